//! What a run begins with: an output that is partly there, and what must stay.

use crate::{Domain, Error, Exemplars, Grid, SampleId, Source, SourceMap, SourceTable};

/// What is there before the first patch or block.
#[derive(Clone, Debug)]
pub struct Start<const D: usize> {
    /// Samples that stand already; the rest is unassigned. It may name samples that are masked: what is laid will not.
    pub map: SourceMap<D>,
    /// Positions whose sample stays; `None` for none. An unassigned one is filled, and stays from then on.
    pub fixed: Option<Grid<bool, D>>,
    /// By position, bit `s` says whether source `s` may be used there, of at most 64; `None` for all everywhere.
    pub sources: Option<Grid<u64, D>>,
}

impl<const D: usize> Start<D> {
    /// Nothing is there, and every source may be used everywhere.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn empty(exemplars: &Exemplars<D>, output: Domain<D>) -> Result<Self, Error> {
        Ok(Self { map: SourceMap::unassigned(exemplars, output)?, fixed: None, sources: None })
    }

    /// Everything has the output's shape, and every hole a source.
    ///
    /// # Errors
    /// [`Error::ForeignMap`], [`Error::Channels`], [`Error::StartShape`], [`Error::TooManySources`],
    /// [`Error::NoSource`].
    pub fn check(&self, exemplars: &Exemplars<D>) -> Result<(), Error> {
        let output = self.map.domain();
        check_map(exemplars.table(), &self.map)?;
        let grids = [
            ("mask of fixed samples", self.fixed.as_ref().map(|g| (g.domain().shape, g.channels()))),
            ("field of sources", self.sources.as_ref().map(|g| (g.domain().shape, g.channels()))),
        ];
        for (what, found) in grids {
            let Some((shape, channels)) = found else { continue };
            one_channel(what, channels)?;
            if shape != output.shape {
                return Err(Error::StartShape { what, expected: output.shape.to_vec(), found: shape.to_vec() });
            }
        }
        let Some(sources) = &self.sources else { return Ok(()) };
        let (found, most) = (exemplars.sources().len(), u64::BITS as usize);
        if most < found {
            return Err(Error::TooManySources { found, most });
        }
        let usable = |s: &Source<D>| s.valid.as_deref().is_none_or(|v| v.samples().contains(&true));
        let usable = exemplars.sources().iter().enumerate().filter(|(_, s)| usable(s));
        let bits = usable.fold(0_u64, |bits, (s, _)| bits | 1 << s);
        let ids = self.map.ids.plane(0);
        let stuck = (0..ids.len()).find(|&i| !ids[i].is_assigned() && sources.plane(0)[i] & bits == 0);
        match stuck {
            Some(i) => Err(Error::NoSource { at: output.position(i).to_vec() }),
            None => Ok(()),
        }
    }
}

/// A map is of these sources, and names only samples that they hold.
fn check_map<const D: usize>(table: &SourceTable<D>, map: &SourceMap<D>) -> Result<(), Error> {
    one_channel("map", map.ids.channels())?;
    let samples = table.len();
    let known = |id: &SampleId| !id.is_assigned() || id.get() < samples;
    if map.table == *table && map.ids.plane(0).iter().all(known) {
        return Ok(());
    }
    let (found, held) = (map.table.sources().len(), map.table.len());
    Err(Error::ForeignMap { found, held, sources: table.sources().len(), samples })
}

fn one_channel(what: &'static str, found: usize) -> Result<(), Error> {
    if found == 1 { Ok(()) } else { Err(Error::Channels { what, found }) }
}
