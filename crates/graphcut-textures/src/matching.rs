//! Where exemplars fit: every translation that covers the error region, with its cost. `[Kwatra03 4]`

use selvedge_core::{Domain, Exemplars, Grid, Origin, Source, SourceMap, Transform};
use selvedge_fft_ssd::{
    Costs, Cover, Engine, Options, Placement as Positions, Positions as Where, Scratch, SsdSearcher, Template,
};

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
}

impl<'e, const D: usize> Matcher<'e, D> {
    /// # Errors
    /// [`Error::Search`] if memory is short.
    pub(crate) fn new(exemplars: &'e Exemplars<D>) -> Result<Self, Error> {
        let searcher = SsdSearcher::new(exemplars)?;
        Ok(Self { exemplars, searcher, scratch: Scratch::new(), costs: Costs::new() })
    }

    /// Sub-patch matching: only what lies in the region is compared. `[Kwatra03 eq. 4]`
    ///
    /// # Errors
    /// [`Error::Search`].
    pub(crate) fn sub(&mut self, map: &SourceMap<D>, region: &Window<D>) -> Result<Vec<Candidate<D>>, Error> {
        let seen = look(self.exemplars, map, region, region);
        let template = Template::new(region.shape, &seen.features).masked(&seen.known);
        let placement = Positions { positions: Where::Inside, cover: Cover::Box };
        self.searcher.search(&template, placement, &mut self.scratch, &mut self.costs)?;
        let candidate = |c: selvedge_fft_ssd::Candidate<D>| Candidate {
            patch: Patch { source: c.source, offset: std::array::from_fn(|a| region.start[a] - c.position[a]) },
            cost: c.error as f64 / c.samples.max(1) as f64,
        };
        Ok(self.costs.iter().map(candidate).collect())
    }

    /// Entire-patch matching: everything under the patch within `window` is compared. `[Kwatra03 eq. 2]`
    ///
    /// The exemplar slides over a box of the output; the box is just large enough that the exemplar inside it covers the
    /// region. So the costs come from a search for the exemplar in the output.
    ///
    /// # Errors
    /// [`Error::Search`].
    pub(crate) fn entire(
        &mut self,
        map: &SourceMap<D>,
        region: &Window<D>,
        window: &Window<D>,
    ) -> Result<Vec<Candidate<D>>, Error> {
        let mut found = Vec::new();
        for (number, source) in self.exemplars.sources().iter().enumerate() {
            let shape = source.domain().shape;
            if (0..D).any(|a| shape[a] < region.shape[a]) {
                continue;
            }
            let spare: [u32; D] = std::array::from_fn(|a| shape[a] - region.shape[a]);
            let the_box = Window {
                start: std::array::from_fn(|a| region.start[a] - spare[a] as i32),
                shape: std::array::from_fn(|a| region.shape[a] + 2 * spare[a]),
            };
            self.slide(map, number, &the_box, window, &mut found)?;
        }
        Ok(found)
    }

    /// Costs of one source at each place inside a box of the output.
    fn slide(
        &mut self,
        map: &SourceMap<D>,
        number: usize,
        the_box: &Window<D>,
        window: &Window<D>,
        found: &mut Vec<Candidate<D>>,
    ) -> Result<(), Error> {
        let seen = look(self.exemplars, map, the_box, window);
        let offset = |p: [i32; D]| std::array::from_fn(|a| the_box.start[a] + p[a]);
        let source = &self.exemplars.sources()[number];
        if !seen.known.contains(&true) {
            let spare: [u32; D] = std::array::from_fn(|a| the_box.shape[a] - source.domain().shape[a] + 1);
            let all = Domain::open(spare).positions().map(|p| p.map(|v| v as i32));
            found.extend(all.map(|p| Candidate { patch: Patch { source: number, offset: offset(p) }, cost: 0.0 }));
            return Ok(());
        }
        let domain = Domain::open(the_box.shape);
        let output = Source {
            features: Grid::from_vec(domain, self.exemplars.channels(), seen.features)?,
            valid: Some(Grid::from_vec(domain, 1, seen.known)?),
            origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
        };
        let output = Exemplars::from_sources(vec![output], self.exemplars.weights().to_vec())?;
        // What is filled has any shape: transforms sum over it at no extra cost, the direct search sample by sample.
        let engine = Options { engine: Engine::Fft, ..Options::default() };
        let searcher = SsdSearcher::with_options(&output, engine)?;
        let template = Template::of(&source.features);
        let template = source.valid.as_ref().map_or(template, |v| template.masked(v.samples()));
        let placement = Positions { positions: Where::Inside, cover: Cover::AtLeast(1) };
        searcher.search(&template, placement, &mut self.scratch, &mut self.costs)?;
        found.extend(self.costs.iter().map(|c| Candidate {
            patch: Patch { source: number, offset: offset(c.position) },
            cost: c.error as f64 / c.samples.max(1) as f64,
        }));
        Ok(())
    }
}
