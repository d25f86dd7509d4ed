//! Where exemplars fit: every translation that covers the error region, with its cost. `[Kwatra03 4]`

use selvedge_core::{Exemplars, SimdLevel, SourceMap};
use selvedge_fft_ssd::{Costs, Options as SearchOptions, Placement, Scratch, SsdSearcher, Template};

use crate::candidates::Candidate;
use crate::error::Error;
use crate::patch::Patch;
use crate::region::look;
use crate::window::Window;

/// Finds patches by what they agree with.
#[derive(Debug)]
pub(crate) struct Matcher<'e, const D: usize> {
    exemplars: &'e Exemplars<D>,
    searcher: SsdSearcher<'e, D>,
    scratch: Scratch,
    costs: Costs<D>,
    /// Where in the output the last template began.
    start: [i32; D],
}

impl<'e, const D: usize> Matcher<'e, D> {
    /// # Errors
    /// [`Error::Search`] if memory is short.
    pub(crate) fn new(exemplars: &'e Exemplars<D>, simd: SimdLevel) -> Result<Self, Error> {
        let searcher = SsdSearcher::with_options(exemplars, SearchOptions { simd, ..SearchOptions::default() })?;
        Ok(Self { exemplars, searcher, scratch: Scratch::new(), costs: Costs::new(), start: [0; D] })
    }

    /// Compares what is known in `window` with the sources, wherever one covers `region`, a part of it. The window may
    /// reach beyond the output: so it keeps its shape, and what is prepared for that shape serves every search.
    ///
    /// With the region itself as the window this is sub-patch matching `[Kwatra03 eq. 4]`, with a window as large as
    /// patches are it is entire-patch matching `[Kwatra03 eq. 2]`.
    ///
    /// # Errors
    /// [`Error::Search`].
    pub(crate) fn search(&mut self, map: &SourceMap<D>, region: &Window<D>, window: &Window<D>) -> Result<(), Error> {
        let mut window = window;
        let mut seen = look(self.exemplars, map, window);
        if !seen.known.contains(&true) {
            // Nothing to compare: every translation that covers the region is as good.
            (window, seen) = (region, look(self.exemplars, map, region));
        }
        self.start = window.start;
        let template = Template::new(window.shape, &seen.features).masked(&seen.known);
        if window == region {
            self.searcher.search(&template, Placement::INSIDE, &mut self.scratch, &mut self.costs)?;
        } else {
            let start = std::array::from_fn(|a| (region.start[a] - window.start[a]) as u32);
            self.searcher.search_part(&template, start, region.shape, 1, &mut self.scratch, &mut self.costs)?;
        }
        Ok(())
    }

    /// What the last search found.
    pub(crate) fn found(&self) -> impl Iterator<Item = Candidate<D>> + '_ {
        self.costs.iter().map(|c| Candidate {
            patch: Patch { source: c.source, offset: std::array::from_fn(|a| self.start[a] - c.position[a]) },
            cost: c.error as f64 / c.samples.max(1) as f64,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Origin, SampleId, Source, Transform};

    /// Halves of 10 and of 17, side by side.
    fn exemplars() -> Exemplars<2> {
        let domain = Domain::open([12, 24]);
        let samples = domain.positions().map(|[_, x]| if x < 12 { 10 } else { 17 }).collect();
        let features = Grid::from_vec(domain, 1, samples).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap()
    }

    #[test]
    fn costs_are_means_over_what_is_compared() {
        let exemplars = exemplars();
        let mut map = SourceMap::unassigned(&exemplars, Domain::open([30, 30])).unwrap();
        map.ids.plane_mut(0).fill(SampleId::new(0));
        for side in [3, 6] {
            let region = Window { start: [9, 9], shape: [side; 2] };
            let window = Window { start: [5, 5], shape: [side + 8; 2] };
            for window in [region, window] {
                let mut matcher = Matcher::new(&exemplars, SimdLevel::Auto).unwrap();
                matcher.search(&map, &region, &window).unwrap();
                let found: Vec<Candidate<2>> = matcher.found().collect();
                assert_eq!(found.len(), ((13 - side) * (25 - side)) as usize, "wherever the region is covered");
                for c in found {
                    // What the patch shows of the second half, at 7 levels' difference, out of all that it covers.
                    let (left, right) =
                        (c.patch.offset[1].max(window.start[1]), window.end(1).min(c.patch.offset[1] + 24));
                    let second = (right - (c.patch.offset[1] + 12).max(left)).max(0);
                    let expected = 49.0 * f64::from(second) / f64::from(right - left);
                    assert!((c.cost - expected).abs() < 1e-9, "{c:?} {expected}");
                }
            }
        }
    }
}
