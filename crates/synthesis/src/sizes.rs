//! At which size drafts are made and candidates compared.

use selvedge_core::{Domain, Exemplars, SourceMap};

use crate::error::Error;

/// The sides that are left of exemplars at least: those of the textures by which preferences were fitted.
const LEAST_SIDE: u32 = 192;

/// Samples a side that are left of the smallest exemplar and of the output at least: twice what can be compared.
const COMPARED: u32 = 2 * selvedge_metrics::LEAST;

/// The shorter side of each source.
pub(crate) fn shortest(exemplars: &Exemplars<2>) -> impl Iterator<Item = u32> {
    exemplars.sources().iter().map(|s| s.domain().shape.into_iter().min().unwrap_or(0))
}

/// Exemplars at halves of their size, from one half on; none if they are small.
#[derive(Default)]
pub(crate) struct Sizes {
    halves: Vec<Exemplars<2>>,
}

impl Sizes {
    pub(crate) fn new(exemplars: &Exemplars<2>, output: Domain<2>) -> Result<Self, Error> {
        let mut halves: Vec<Exemplars<2>> = Vec::new();
        loop {
            let last = halves.last().unwrap_or(exemplars);
            let holds = |side: u32| 2 * COMPARED <= side;
            let large = 2 * LEAST_SIDE <= shortest(last).max().unwrap_or(0);
            let compared = shortest(last).all(holds) && output.shape.iter().all(|n| holds(n >> halves.len()));
            if !(large && compared) {
                return Ok(Self { halves });
            }
            match last.coarser() {
                // A mask leaves no whole block.
                Err(selvedge_core::Error::NothingValid) => return Ok(Self { halves }),
                coarse => halves.push(coarse?),
            }
        }
    }

    /// The exemplars at all of them.
    pub(crate) fn halves(&self) -> &[Exemplars<2>] {
        &self.halves
    }

    /// True if drafts are smaller than what is made of them.
    pub(crate) fn are_several(&self) -> bool {
        !self.halves.is_empty()
    }

    /// The exemplars of drafts.
    pub(crate) fn small<'e>(&'e self, exemplars: &'e Exemplars<2>) -> &'e Exemplars<2> {
        self.halves.last().unwrap_or(exemplars)
    }

    /// The output of drafts.
    pub(crate) fn output(&self, output: Domain<2>) -> Domain<2> {
        self.halves.iter().fold(output, |output, _| output.coarser())
    }

    /// A map of the exemplars at the size of drafts; `None` if that is its own.
    pub(crate) fn reduced(&self, map: &SourceMap<2>) -> Result<Option<SourceMap<2>>, Error> {
        let mut reduced = None;
        for half in &self.halves {
            reduced = Some(reduced.as_ref().unwrap_or(map).coarser(half)?);
        }
        Ok(reduced)
    }

    /// A draft's map at the size of the exemplars and of an output.
    pub(crate) fn raised(
        &self,
        mut map: SourceMap<2>,
        exemplars: &Exemplars<2>,
        output: Domain<2>,
    ) -> Result<SourceMap<2>, Error> {
        let finer = |level: usize| self.halves[..level].last().unwrap_or(exemplars);
        let whole = |level: usize| (0..level).fold(output, |output, _| output.coarser());
        for level in (0..self.halves.len()).rev() {
            map = map.finer(finer(level), whole(level))?;
        }
        Ok(map)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_testkit::simple::noise_rgb;

    #[test]
    fn drafts_are_raised_to_what_is_reduced_to_them() {
        let a = noise_rgb(391, 400, 1);
        let e = Exemplars::of(&[std::slice::from_ref(&a)]).unwrap();
        for output in [Domain::open([500, 631]), Domain { shape: [500, 631], periodic: [true; 2] }] {
            let sizes = Sizes::new(&e, output).unwrap();
            assert!(sizes.are_several());
            let options = selvedge_graphcut_textures::Options { refine: Some(0), ..Default::default() };
            let (small, to) = (sizes.small(&e), sizes.output(output));
            let draft =
                selvedge_graphcut_textures::graphcut(small, to, &options, &selvedge_core::Run::seeded(1)).unwrap();
            let raised = sizes.raised(draft.result.clone(), &e, output).unwrap();
            assert_eq!((raised.domain(), raised.holes()), (output, 0));
            assert_eq!(sizes.reduced(&raised).unwrap().unwrap(), draft.result);
        }
    }

    #[test]
    fn drafts_leave_192_samples_of_exemplars_and_64_of_all_that_is_compared() {
        let halvings = |side: u32, other: u32, output: u32| {
            let [a, b] = [noise_rgb(side, side, 1), noise_rgb(other, other, 2)];
            let e = Exemplars::of(&[std::slice::from_ref(&a), std::slice::from_ref(&b)]).unwrap();
            let sizes = Sizes::new(&e, Domain::open([output, 2000])).unwrap();
            assert_eq!(sizes.output(Domain::open([output, 2000])).shape[1], 2000 >> sizes.halves.len());
            sizes.halves.len()
        };
        assert_eq!([halvings(383, 383, 800), halvings(384, 384, 800), halvings(800, 800, 800)], [0, 1, 2]);
        assert_eq!([halvings(800, 127, 800), halvings(800, 128, 800), halvings(800, 800, 128)], [0, 1, 1]);
    }
}
