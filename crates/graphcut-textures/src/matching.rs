//! Where exemplars fit: every translation that covers the error region, with its cost. `[Kwatra03 4]`

use selvedge_core::{Exemplars, SourceMap};
use selvedge_fft_ssd::{Costs, Placement, Scratch, SsdSearcher, Template};

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
    pub(crate) fn new(exemplars: &'e Exemplars<D>) -> Result<Self, Error> {
        let searcher = SsdSearcher::new(exemplars)?;
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
