//! A map decided again near its seams: banded cuts, tile by tile. `[Lombaert05]`

use selvedge_core::{Bytes, Domain, Exemplars, Grid, Patch, SampleId, SeamCosts, SourceMap, Window, par, try_vec};

use crate::band::keep_far;
use crate::choice::{Choice, Holes, Pin};
use crate::error::Error;
use crate::expand::{Scratch, expand};
use crate::frame::Frame;

/// Sides of tiles. A cut costs more than its share where it is large, and a tile that a seam crosses offers all of its
/// samples to each of its patches; where it is small, seams end at its border too soon. What lies between is a guess of
/// pictures. Of clips 64 took 1.6 to 2 times as long, for prices that were 2 to 9 % lower on five clips.
const fn tile_side<const D: usize>() -> u32 {
    if D == CLIP { 32 } else { 64 }
}

/// Axes of a clip.
const CLIP: usize = 3;

/// Tiles that are decided before any of them is laid: bounds their memory.
const TOGETHER: usize = 512;
/// Bytes of such a tile's frame for each sample: its place, what is there and what is offered, in vectors that double.
const A_SAMPLE: u64 = 24;

/// What must not change.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pins<'a, const D: usize> {
    /// Positions whose sample stays.
    pub fixed: Option<&'a Grid<bool, D>>,
    /// By position, bit `s` says whether source `s` may show.
    pub sources: Option<&'a Grid<u64, D>>,
}

/// Decides a map again within `width` of its seams: every patch that meets a tile is offered to all of its band, of
/// clips to what is near where it shows in the tile already, and taken where seams become cheaper. Answers with how
/// much the price of all seams fell: it never rises. Holes stay. `told` hears from the calling thread how many tiles of
/// how many are done.
///
/// A map that was solved at half the size ([`SourceMap::finer`]) has its seams to within two samples of where they
/// would lie; so they are found for the price of a band, not of a picture.
///
/// # Errors
/// [`Error::Cut`]: no memory, or `cancelled`: the map is whole then; [`Error::Core`]: no memory.
///
/// # Complexity
/// Time: two cuts a patch over each tile of 64 samples a side, of clips 32, that a seam crosses. Tiles that do not
/// touch are decided on the caller's pool.
///
/// # Determinism
/// The map does not depend on the number of threads.
pub fn settle<const D: usize>(
    exemplars: &Exemplars<D>,
    map: &mut SourceMap<D>,
    costs: &SeamCosts<D>,
    kept: Pins<'_, D>,
    width: u32,
    cancelled: &(dyn Fn() -> bool + Sync),
    told: &dyn Fn(u64, u64),
) -> Result<i64, Error> {
    let mut workers: Vec<Scratch<D>> = (0..par::threads()).map(|_| Scratch::default()).collect();
    let mut gain = 0;
    // A seam cannot leave its tile; the second time others do not end where those of the first did.
    let side = tile_side::<D>();
    let passes = [0, side / 2].map(|shift| tiles(map.domain(), side, shift));
    let of = passes.iter().flatten().map(|tiles| tiles.len() as u64).sum();
    let mut done = 0;
    for pass in passes {
        for tiles in pass {
            for some in tiles.chunks(TOGETHER) {
                let sweep = Sweep { exemplars, map, costs, kept, width, cancelled };
                let settled = par::map_with(&mut workers, some.len(), |scratch, i| sweep.tile(&some[i], scratch));
                for settled in settled {
                    let Some((frame, fell)) = settled? else { continue };
                    gain += fell;
                    let ids = map.ids.plane_mut(0);
                    frame.places.iter().zip(&frame.old).for_each(|(&place, &id)| ids[place as usize] = id);
                }
                done += some.len() as u64;
                told(done, of);
            }
        }
    }
    Ok(gain)
}

/// An upper bound of the bytes that [`settle`] holds of tiles that wait to be laid, over an output of these sides.
pub fn estimate_settled<const D: usize>(output: Domain<D>) -> Bytes {
    // The second time there may be one tile more along an axis; of all, those that do not touch are decided together.
    let tile = tile_side::<D>();
    let along = |side: u32| u64::from((side.div_ceil(tile) + 1).div_ceil(2));
    let tiles = output.shape.into_iter().map(along).fold(1, u64::saturating_mul).min(TOGETHER as u64);
    Bytes::of_samples(Domain::open([tile + 2; D]), A_SAMPLE) * tiles
}

struct Sweep<'a, const D: usize> {
    exemplars: &'a Exemplars<D>,
    map: &'a SourceMap<D>,
    costs: &'a SeamCosts<D>,
    kept: Pins<'a, D>,
    width: u32,
    cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<const D: usize> Sweep<'_, D> {
    /// What stands in a tile once its patches were offered, and how much its seams fell; `None` if nothing changed.
    fn tile(&self, tile: &Window<D>, scratch: &mut Scratch<D>) -> Result<Option<(Frame<D>, i64)>, Error> {
        let nothing = std::iter::repeat_n(SampleId::UNASSIGNED, tile.len());
        let mut frame = Frame::new(self.map, tile, nothing)?;
        let is_seam = |axis, s, t| self.is_seam(axis, s, t);
        let seams = frame.seams(is_seam)?;
        if !seams.contains(&true) {
            return Ok(None);
        }
        let mut band = frame.near(seams, self.width)?;
        let mut gain = 0;
        for patch in self.map.patches(&frame.window) {
            let fell = self.offer(&patch, tile, (&mut frame, &band), scratch)?;
            if 0 < fell {
                (gain, band) = (gain + fell, frame.near_seams(self.width, is_seam)?);
            }
        }
        Ok((0 < gain).then_some((frame, gain)))
    }

    /// Offers a patch to what lies near seams, and takes it where it pays; answers with what it brings.
    fn offer(
        &self,
        patch: &Patch<D>,
        tile: &Window<D>,
        (frame, near): (&mut Frame<D>, &[bool]),
        scratch: &mut Scratch<D>,
    ) -> Result<i64, Error> {
        frame.offer(tile, patch.samples(self.exemplars, tile));
        if let Some(sources) = self.kept.sources {
            frame.allow(|place| sources.plane(0)[place] >> patch.source & 1 == 1);
        }
        let fixed = |place: usize| self.kept.fixed.filter(|f| f.samples()[place]).map(|_| Pin::Old);
        // Holes stay: they are offered nothing.
        let holes = frame.old.iter().map(|id| id.is_assigned());
        frame.new.iter_mut().zip(holes).filter(|(_, stands)| !stands).for_each(|(n, _)| *n = SampleId::UNASSIGNED);
        let mut choices = frame.choices(Holes::Fill, fixed)?;
        keep_far(&mut choices, near);
        let mut shown = try_vec(frame.old.len(), false)?;
        let both = frame.old.iter().zip(&frame.new).map(|(old, new)| old.is_assigned() && old == new);
        shown.iter_mut().zip(both).for_each(|(shown, is)| *shown = is);
        // What shows the patch already has no choice: no node for it.
        choices
            .iter_mut()
            .zip(&shown)
            .filter(|(c, shown)| **c == Choice::Free && **shown)
            .for_each(|(c, _)| *c = Choice::New);
        if D == CLIP {
            // A dozen pieces meet in a tile of a clip: each grows from where it is, by no more than seams may move.
            keep_far(&mut choices, &frame.near(shown, self.width)?);
        }
        if !choices.contains(&Choice::Free) {
            return Ok(0);
        }
        let proposal = expand(frame, &choices, self.costs, scratch, &|| (self.cancelled)())?;
        if proposal.gain <= 0 {
            return Ok(0);
        }
        frame.take(&proposal.taken);
        Ok(proposal.gain)
    }

    fn is_seam(&self, axis: usize, here: SampleId, there: SampleId) -> bool {
        self.costs.continued(here, 2 * axis) != Some(there)
    }
}

/// Boxes that cover an output once, in groups of which no two boxes touch. The first of each axis ends, or begins where
/// there is no end, at `shift`.
fn tiles<const D: usize>(output: Domain<D>, side: u32, shift: u32) -> Vec<Vec<Window<D>>> {
    let mut groups = vec![Vec::new(); 3_usize.pow(D as u32)];
    let along: [Vec<(i32, u32)>; D] = std::array::from_fn(|a| pieces(output.shape[a], output.periodic[a], side, shift));
    let counts: Domain<D> = Domain::open(std::array::from_fn(|a| along[a].len() as u32));
    for at in counts.positions() {
        let piece: [(i32, u32); D] = std::array::from_fn(|a| along[a][at[a] as usize]);
        let group = (0..D).fold(0, |group, a| {
            // Around an axis of an odd number of pieces the last meets the first.
            let is_odd_one = output.periodic[a] && 1 < at[a] && at[a] + 1 == counts.shape[a] && at[a].is_multiple_of(2);
            3 * group + if is_odd_one { 2 } else { at[a] as usize % 2 }
        });
        groups[group].push(Window { start: piece.map(|p| p.0), shape: piece.map(|p| p.1) });
    }
    groups
}

/// Starts and lengths along an axis.
fn pieces(side: u32, periodic: bool, tile: u32, shift: u32) -> Vec<(i32, u32)> {
    let shift = shift.min(side);
    let (first, rest) = if periodic { (0, side) } else { (shift, side - shift) };
    let head = (0 < first).then_some((0, first));
    let tail = (0..rest).step_by(tile as usize).map(|from| ((shift + from) as i32, tile.min(rest - from)));
    head.into_iter().chain(tail).collect()
}

#[cfg(test)]
mod tests;
