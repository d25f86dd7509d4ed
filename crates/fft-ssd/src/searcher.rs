//! The search: every position of every source.

use crate::axes::{Shape, lift};
use crate::fft::{Cache, Keep};
use crate::job::Job;
use crate::kernel::Kernel;
use crate::memory::refill;
use crate::placement::{Positions, Range};
use crate::prepared::{Prepared, Squares};
use crate::source::SourceView;
use crate::template::Checked;
use crate::word::Word;
use crate::{Costs, Cover, Error, Placement, Scratch, Template};
use crate::{cover, direct, fft};
use selvedge_core::{Exemplars, Grid, Guide, SimdLevel, collected};
use std::sync::Arc;

/// How a searcher works. None of it changes a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// The instructions that kernels may use. Default: whatever the machine has.
    pub simd: SimdLevel,
    /// Which engine answers. Default: the one that is expected to be faster.
    pub engine: Engine,
    /// Bytes that tables and spectra of the sources may take; what was not used for longest is dropped and made again
    /// when needed. Default: 1 GiB.
    pub cache: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { simd: SimdLevel::Auto, engine: Engine::Auto, cache: 1 << 30 }
    }
}

/// How errors are computed. All engines give the same integers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Engine {
    /// The one that is expected to be faster.
    #[default]
    Auto,
    /// Sums of products, sample by sample: for small and thin templates.
    Direct,
    /// By Fourier transforms: for large templates.
    Fft,
}

/// Answers where templates fit into a set of sources. Made once, asked many times.
#[derive(Debug)]
pub struct SsdSearcher<'e, const D: usize> {
    sources: Vec<SourceView<'e>>,
    weights: Vec<u8>,
    options: Options,
    kernel: Kernel,
    cache: Cache,
}

impl<'e, const D: usize> SsdSearcher<'e, D> {
    /// A searcher over the features of exemplars, with their weights. One to three axes: the line that asks for a
    /// fourth does not compile.
    ///
    /// ```compile_fail,E0080
    /// # use selvedge_fft_ssd::{SsdSearcher, core::{Exemplars, Plane, Role}};
    /// let exemplars = Exemplars::of(&[&[Plane::of_bytes(Role::Scalar, [1, 1, 1, 2], 1, &[3, 4]).unwrap()]]).unwrap();
    /// let searcher = SsdSearcher::new(&exemplars);
    /// ```
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub fn new(exemplars: &'e Exemplars<D>) -> Result<Self, Error> {
        const { crate::axes::supported(D) };
        Self::with_options(exemplars, Options::default())
    }

    /// Like [`new`](Self::new), with a chosen engine.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub fn with_options(exemplars: &'e Exemplars<D>, options: Options) -> Result<Self, Error> {
        const { crate::axes::supported(D) };
        let sources = exemplars.sources().iter().map(|s| SourceView::new(&s.features, s.valid.as_deref()));
        Self::build(collected(sources)?, exemplars.weights(), options)
    }

    /// A searcher over the maps of a guide, with their weights. Its costs have the same positions as those of a
    /// searcher over the exemplars that the guide was made for, so both can be summed
    /// ([`search_sum`](crate::search_sum), [`Costs::sum_of`]).
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub fn of_guide(guide: &'e Guide<D>, options: Options) -> Result<Self, Error> {
        Self::with_options(guide.exemplars(), options)
    }

    /// A searcher over one grid, its samples valid where they are said to be.
    ///
    /// # Errors
    /// [`Error::Core`] if weights and channels differ, or memory is short.
    pub fn of_grid(
        features: &'e Grid<u8, D>,
        valid: Option<&'e Grid<bool, D>>,
        weights: &[u8],
        options: Options,
    ) -> Result<Self, Error> {
        if weights.len() != features.channels() {
            return Err(selvedge_core::Error::Weights { expected: features.channels(), found: weights.len() }.into());
        }
        Self::build(vec![SourceView::new(features, valid)], weights, options)
    }

    fn build(sources: Vec<SourceView<'e>>, weights: &[u8], options: Options) -> Result<Self, Error> {
        let weights = collected(weights.iter().copied())?;
        Ok(Self { sources, weights, options, kernel: Kernel::new(options.simd), cache: Cache::default() })
    }

    /// Channels that a template must have.
    pub fn channels(&self) -> usize {
        self.weights.len()
    }

    /// The instructions in use: those of [`Options::simd`], or the next lower ones that the machine has.
    pub fn simd(&self) -> SimdLevel {
        self.kernel.level()
    }

    /// The error of the template at every position, into `costs`. After an error `costs` has no meaning.
    ///
    /// A template that fits nowhere, such as one larger than every exemplar, leaves no positions: `best()` is `None`.
    ///
    /// Takes `O(min(samples, log(samples)) * positions)`; see the crate's page for figures.
    ///
    /// # Errors
    /// Those of a template that does not fit the searcher ([`Error::TemplateLength`], [`Error::MaskLength`],
    /// [`Error::EmptyTemplate`]), [`Error::TooLarge`], and [`Error::Core`] if memory is short.
    pub fn search(
        &self,
        template: &Template<'_, D>,
        placement: Placement,
        scratch: &mut Scratch,
        costs: &mut Costs<D>,
    ) -> Result<(), Error> {
        let template = template.check(self.channels())?;
        refill(&mut scratch.ranges, self.ranges(placement.positions, template.shape))?;
        self.search_ranges(&template, placement.cover, scratch, costs)
    }

    /// The error of the template wherever one part of it lies inside: a box that starts at `start`, of shape `part`.
    /// All samples of the part are valid; what else sticks out of a source, or stands on samples that are not, is not
    /// compared, but at least `least` unmasked samples are ([`Cover::AtLeast`]). Along an axis on which a source is
    /// periodic, all `N` shifts are searched.
    ///
    /// Thus a patch is found that covers the part, by all that is known around it: `[Kwatra03 eq. 2]`.
    ///
    /// # Errors
    /// Those of [`search`](Self::search), and [`Error::Part`] if the part is empty or not inside the template.
    pub fn search_part(
        &self,
        template: &Template<'_, D>,
        start: [u32; D],
        part: [u32; D],
        least: u64,
        scratch: &mut Scratch,
        costs: &mut Costs<D>,
    ) -> Result<(), Error> {
        let whole = template.shape;
        let fits = |a: usize| part[a] != 0 && start[a].checked_add(part[a]).is_some_and(|end| end <= whole[a]);
        if !(0..D).all(fits) {
            return Err(Error::Part { start: start.to_vec(), part: part.to_vec(), shape: whole.to_vec() });
        }
        let template = template.check(self.channels())?;
        let [start, part] = [lift(start, 0), lift(part, 1)].map(|axes| axes.map(|n| n as usize));
        let range = |s: &SourceView<'_>| Range::of_part(s.shape, s.periodic, start, part);
        refill(&mut scratch.ranges, self.sources.iter().map(range))?;
        self.search_ranges(&template, Cover::AtLeast(least), scratch, costs)?;
        for (number, source) in self.sources.iter().enumerate().filter(|(_, s)| s.valid.is_some()) {
            let range = scratch.ranges[number];
            let prepared = self.prepared(number, &range, template.shape)?;
            let table = prepared.valid(source)?;
            let map = costs.sources[number].start..costs.sources[number].start + costs.sources[number].len();
            if costs.is_wide {
                cover::require(table, range.count, start, part, &mut costs.wide[map]);
            } else {
                cover::require(table, range.count, start, part, &mut costs.narrow[map]);
            }
        }
        Ok(())
    }

    /// The error of the template at the positions of a box, `count` along each axis from `first` on, of every source.
    /// What sticks out of a source is not compared, also where it is periodic, but at least `least` unmasked samples
    /// are ([`Cover::AtLeast`]).
    ///
    /// Thus a picture is compared with itself under all translations that matter, and no others.
    ///
    /// # Errors
    /// Those of [`search`](Self::search).
    pub fn search_box(
        &self,
        template: &Template<'_, D>,
        first: [i32; D],
        count: [u32; D],
        least: u64,
        scratch: &mut Scratch,
        costs: &mut Costs<D>,
    ) -> Result<(), Error> {
        let template = template.check(self.channels())?;
        let (first, count) = (lift(first, 0).map(|n| n as isize), lift(count, 1).map(|n| n as usize));
        let range = Range { first, count, wraps: [false; 3] };
        refill(&mut scratch.ranges, self.sources.iter().map(|_| range))?;
        self.search_ranges(&template, Cover::AtLeast(least), scratch, costs)
    }

    /// Searches the ranges that lie in `scratch`.
    pub(crate) fn search_ranges(
        &self,
        template: &Checked<'_>,
        cover: Cover,
        scratch: &mut Scratch,
        costs: &mut Costs<D>,
    ) -> Result<(), Error> {
        let counted = matches!(cover, Cover::AtLeast(_));
        costs.kernel = self.kernel;
        costs.reset(&scratch.ranges, template.samples, self.bound(template.samples), counted)?;
        for number in 0..self.sources.len() {
            let map = costs.sources[number].start..costs.sources[number].start + costs.sources[number].len();
            let counts = if counted { &mut costs.counts[map.clone()] } else { &mut [] };
            if costs.is_wide {
                self.search_source(number, template, cover, scratch, &mut costs.wide[map], counts)?;
            } else {
                self.search_source(number, template, cover, scratch, &mut costs.narrow[map], counts)?;
            }
        }
        Ok(())
    }

    /// One source's part of a map.
    fn search_source<W: Word + Squares>(
        &self,
        number: usize,
        template: &Checked<'_>,
        cover: Cover,
        scratch: &mut Scratch,
        map: &mut [W],
        counts: &mut [u32],
    ) -> Result<(), Error> {
        if map.is_empty() {
            return Ok(());
        }
        let range = scratch.ranges[number];
        let prepared = self.prepared(number, &range, template.shape)?;
        let job = self.job(number, range, cover, &prepared, template);
        if prefers_fft(&job, self.options.engine) {
            if fft::search(&job, self.keep(), &mut scratch.fft, map, counts)? {
                return cover::apply(&job, fft::BIAS, true, &mut scratch.cover, map, counts);
            }
            scratch.repeated += 1;
        }
        direct::search(&job, &mut scratch.direct, map)?;
        cover::apply(&job, direct::BIAS, false, &mut scratch.cover, map, counts)
    }

    /// The positions of each source for a template of that shape.
    pub(crate) fn ranges(&self, positions: Positions, template: Shape) -> impl Iterator<Item = Range> {
        self.sources.iter().map(move |s| Range::new(positions, s.shape, s.periodic, template))
    }

    /// What is kept of a source for the positions of a range.
    pub(crate) fn prepared(&self, number: usize, range: &Range, template: Shape) -> Result<Arc<Prepared>, Error> {
        self.cache.tables(number, &self.sources[number], range, template, self.options.cache)
    }

    /// What an engine is told about a source.
    pub(crate) fn job<'j>(
        &'j self,
        number: usize,
        range: Range,
        cover: Cover,
        prepared: &'j Prepared,
        template: &'j Checked<'j>,
    ) -> Job<'j> {
        let (source, weights, kernel) = (&self.sources[number], self.weights.as_slice(), self.kernel);
        Job { source, weights, prepared, template, range, cover, kernel }
    }

    fn keep(&self) -> Keep<'_> {
        Keep { cache: &self.cache, budget: self.options.cache }
    }

    /// True if both have sources of the same shapes.
    pub(crate) fn has_shapes_of(&self, other: &Self) -> bool {
        let shapes = |s: &'_ SourceView<'_>| (s.shape, s.periodic);
        self.sources.iter().map(shapes).eq(other.sources.iter().map(shapes))
    }

    /// True if both look at the same masks.
    pub(crate) fn has_validity_of(&self, other: &Self) -> bool {
        // Two templates of one searcher, and guides, which share their masks, are the frequent cases.
        let is_one = |a: &[bool], b: &[bool]| std::ptr::eq(a, b) || a == b;
        let same = |(a, b): (&SourceView<'_>, &SourceView<'_>)| match (a.valid, b.valid) {
            (Some(a), Some(b)) => is_one(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        self.sources.len() == other.sources.len() && self.sources.iter().zip(&other.sources).all(same)
    }

    /// Sets of spectra that are kept, and bytes of all that is.
    #[cfg(test)]
    pub(crate) fn held(&self) -> (usize, u64) {
        self.cache.held()
    }

    pub(crate) fn engine(&self) -> Engine {
        self.options.engine
    }

    pub(crate) fn source(&self, number: usize) -> SourceView<'e> {
        self.sources[number]
    }

    pub(crate) fn weights(&self) -> &[u8] {
        &self.weights
    }

    pub(crate) fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// No error of so many samples is larger.
    pub(crate) fn bound(&self, samples: u64) -> u128 {
        let weight: u128 = self.weights.iter().map(|&w| u128::from(w)).sum();
        u128::from(samples) * weight * 255 * 255
    }
}

/// Which engine answers. Both give the same, so the choice may depend on the machine.
pub(crate) fn prefers_fft(job: &Job<'_>, engine: Engine) -> bool {
    match engine {
        Engine::Direct => false,
        Engine::Fft => true,
        // No search by transforms takes less than a few nanoseconds a position: planning one would not pay.
        Engine::Auto => {
            let positions: f64 = job.range.count.iter().map(|&n| n as f64).product();
            let direct = direct::cost(job);
            5.0 * positions < direct && fft::cost(job) < direct
        }
    }
}
