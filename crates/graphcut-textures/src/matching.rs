//! Where exemplars fit: every translation that covers the error region, with its cost. `[Kwatra03 4]`

use std::sync::Arc;

use selvedge_core::{Exemplars, Look, Patch, SimdLevel, Source, SourceMap, Window};
use selvedge_fft_ssd::{Costs, Options as SearchOptions, Placement, Scratch, SsdSearcher, Template};

use crate::candidates::Candidate;
use crate::error::Error;
use crate::few::Few;
use crate::sliding::slide;
use crate::usable::Usable;

/// One source as exemplars of its own, as far as it may be used.
#[derive(Debug)]
pub(crate) struct Single<const D: usize> {
    source: usize,
    /// The first of its positions that are there.
    start: [i32; D],
    exemplars: Exemplars<D>,
}

/// Each source alone, as far as its box goes, so that it can be searched without the others, if that is `wanted` or if
/// masks leave a part of one: a search pays for all that it is shown, and of a mask of few samples hardly any can be
/// laid. Those without a valid sample are left out.
///
/// # Errors
/// [`Error::Core`] if memory is short.
pub(crate) fn singles<const D: usize>(
    exemplars: &Exemplars<D>,
    boxes: &[Window<D>],
    wanted: bool,
) -> Result<Vec<Single<D>>, Error> {
    let whole = |(source, valid): (&Arc<Source<D>>, &Window<D>)| valid.shape == source.domain().shape;
    if !wanted && exemplars.sources().iter().zip(boxes).all(whole) {
        return Ok(Vec::new());
    }
    let single = |(number, valid): (usize, &Window<D>)| {
        let source = &exemplars.sources()[number];
        let exemplars = if whole((source, valid)) {
            exemplars.only([number])?
        } else {
            Exemplars::from_sources(vec![source.cropped(valid)?], exemplars.weights().to_vec())?
        };
        Ok(Single { source: number, start: valid.start, exemplars })
    };
    boxes.iter().enumerate().filter(|(_, valid)| !valid.is_empty()).map(single).collect()
}

/// Finds patches by what they agree with.
#[derive(Debug)]
pub(crate) struct Matcher<'e, const D: usize> {
    exemplars: &'e Exemplars<D>,
    /// None where exemplars are not moved along all axes.
    parts: Vec<Part<'e, D>>,
    pub(crate) few: Few<'e, D>,
    free: [bool; D],
}

/// Sources that are searched together.
#[derive(Debug)]
struct Part<'e, const D: usize> {
    /// The number of the first of them.
    first: usize,
    /// Where in each of them its searcher's positions begin.
    start: [i32; D],
    searcher: SsdSearcher<'e, D>,
}

/// What one search found, and the working memory of the next.
#[derive(Debug)]
pub(crate) struct Matches<const D: usize> {
    look: Look,
    scratch: Scratch,
    /// Of each part of the matcher; `None` where it was left out.
    costs: Vec<Option<Costs<D>>>,
    /// Memory of those left out.
    spare: Vec<Costs<D>>,
    /// Where in the output the template began.
    start: [i32; D],
    /// What was found one by one: where exemplars are not moved along all axes, or masks leave few places.
    single: Vec<Candidate<D>>,
}

impl<'e, const D: usize> Matcher<'e, D> {
    /// Searches all sources together, or, if there are `singles`, one by one those that are asked for; along the `free`
    /// axes. Where masks leave few places for a `region`, or for its halves, these are compared one by one.
    ///
    /// # Errors
    /// [`Error::Search`] if memory is short.
    pub(crate) fn new(
        exemplars: &'e Exemplars<D>,
        singles: &'e [Single<D>],
        (region, free): ([u32; D], [bool; D]),
        simd: SimdLevel,
    ) -> Result<Self, Error> {
        let options = SearchOptions { simd, ..SearchOptions::default() };
        let part = |first, start, exemplars, options| {
            Ok(Part { first, start, searcher: SsdSearcher::with_options(exemplars, options)? })
        };
        let parts = if free.contains(&false) {
            Vec::new()
        } else if singles.is_empty() {
            vec![part(0, [0; D], exemplars, options)?]
        } else {
            let options = SearchOptions { cache: options.cache / singles.len() as u64, ..options };
            singles.iter().map(|s| part(s.source, s.start, &s.exemplars, options)).collect::<Result<_, Error>>()?
        };
        let few = if free.contains(&false) { Few::none(exemplars) } else { Few::new(exemplars, region)? };
        Ok(Self { exemplars, parts, few, free })
    }

    /// False if masks leave a region of this shape no place, which is known without a search.
    pub(crate) fn holds(&self, region: [u32; D], usable: Usable) -> bool {
        self.few.of(region, usable).is_none_or(|mut places| places.next().is_some())
    }

    /// Compares what is known in `window` with the sources, wherever one covers `region`, a part of it. The window may
    /// reach beyond the output: so it keeps its shape, and what is prepared for that shape serves every search. Of
    /// single sources, only those that are `usable` are searched.
    ///
    /// With the region itself as the window this is sub-patch matching `[Kwatra03 eq. 4]`, with a window as large as
    /// patches are it is entire-patch matching `[Kwatra03 eq. 2]`. Both are computed by `[Kwatra03 eq. 6]`.
    ///
    /// # Errors
    /// [`Error::Search`].
    pub(crate) fn search(
        &self,
        map: &SourceMap<D>,
        region: &Window<D>,
        window: &Window<D>,
        usable: Usable,
        to: &mut Matches<D>,
    ) -> Result<(), Error> {
        let mut window = window;
        to.look.at_map(self.exemplars, map, window, |_| true)?;
        if !to.look.known().contains(&true) {
            // Nothing to compare: every translation that covers the region is as good.
            window = region;
            to.look.at_map(self.exemplars, map, region, |_| true)?;
        }
        to.start = window.start;
        if self.free.contains(&false) {
            to.single = slide(self.exemplars, &to.look, (region, window), self.free, usable);
            return Ok(());
        }
        to.spare.extend(to.costs.drain(..).flatten());
        to.single.clear();
        if let Some(places) = self.few.of(region.shape, usable) {
            let (windows, everywhere) = ((region, window), window == region);
            to.single.extend(places.filter_map(|place| self.few.candidate(place, windows, &to.look, everywhere)));
            return Ok(());
        }
        let template = Template::new(window.shape, to.look.features()).masked(to.look.known());
        let start = std::array::from_fn(|a| (region.start[a] - window.start[a]) as u32);
        for Part { first, searcher, .. } in &self.parts {
            let mut costs = usable.has(*first).then(|| to.spare.pop().unwrap_or_default());
            if let Some(costs) = &mut costs {
                if window == region {
                    searcher.search(&template, Placement::INSIDE, &mut to.scratch, costs)?;
                } else {
                    searcher.search_part(&template, start, region.shape, 1, &mut to.scratch, costs)?;
                }
            }
            to.costs.push(costs);
        }
        Ok(())
    }

    /// What a search found.
    pub(crate) fn found(&self, matches: &Matches<D>) -> impl Iterator<Item = Candidate<D>> {
        let searched = self.parts.iter().zip(&matches.costs);
        let found =
            searched.flat_map(|(part, costs)| costs.iter().flat_map(move |costs| costs.iter().map(move |c| (part, c))));
        let moved = found.map(|(part, c)| Candidate {
            patch: Patch {
                source: part.first + c.source,
                offset: std::array::from_fn(|a| matches.start[a] - part.start[a] - c.position[a]),
            },
            cost: c.error as f64 / c.samples.max(1) as f64,
        });
        moved.chain(matches.single.iter().copied())
    }
}

impl<const D: usize> Default for Matches<D> {
    fn default() -> Self {
        let (look, scratch) = (Look::new(), Scratch::new());
        Self { look, scratch, costs: Vec::new(), spare: Vec::new(), start: [0; D], single: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Origin, SampleId, Transform};

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
                let matcher = Matcher::new(&exemplars, &[], ([1; 2], [true; 2]), SimdLevel::Auto).unwrap();
                let mut matches = Matches::default();
                matcher.search(&map, &region, &window, Usable::all(), &mut matches).unwrap();
                let found: Vec<Candidate<2>> = matcher.found(&matches).collect();
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

    #[test]
    fn few_places_of_a_mask_are_those_that_a_search_finds() {
        let mut found = 0;
        for case in 0..60 {
            let mut rng = selvedge_core::Seed(case).rng();
            let mut source = || {
                let domain = Domain::open([12 + rng.below(5), 14]);
                let samples = (0..2 * domain.len()).map(|_| rng.below(256) as u8).collect();
                let valid = |[y, x]: [u32; 2]| (3..6).contains(&y) && (4..8).contains(&x) || rng.below(12) == 0;
                let valid = Grid::from_vec(domain, 1, domain.positions().map(valid).collect()).unwrap();
                let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
                Source { features: Grid::from_vec(domain, 2, samples).unwrap(), valid: Some(valid.into()), origin }
            };
            let e = Exemplars::from_sources(vec![source(), source()], vec![1, 3]).unwrap();
            let output = Domain { shape: [20, 24], periodic: [case % 2 == 0, false] };
            let mut map = SourceMap::unassigned(&e, output).unwrap();
            for id in map.ids.plane_mut(0) {
                let sample = rng.below(e.table().len());
                *id = if rng.below(3) == 0 { SampleId::UNASSIGNED } else { SampleId::new(sample) };
            }
            for shape in [[6, 8], [3, 4], [2, 2]] {
                let region = Window { start: [rng.below(14) as i32, rng.below(16) as i32], shape };
                let around = Window { start: region.start.map(|n| n - 4), shape: shape.map(|n| n + 9) };
                for window in [region, around] {
                    let search = |of: [u32; 2]| {
                        let matcher = Matcher::new(&e, &[], (of, [true; 2]), SimdLevel::Auto).unwrap();
                        let mut matches = Matches::default();
                        matcher.search(&map, &region, &window, Usable::all(), &mut matches).unwrap();
                        let all: Vec<Candidate<2>> = matcher.found(&matches).collect();
                        assert!(
                            of == [1; 2] || matcher.few.of(shape, Usable::all()).is_some(),
                            "{shape:?} has few places"
                        );
                        assert_eq!(of != [1; 2], matches.costs.is_empty(), "few are compared without a search");
                        assert!(matcher.holds(shape, Usable::all()) || all.is_empty());
                        all
                    };
                    let few = search([6, 8]);
                    // Shapes that are no halves of a region are searched.
                    assert_eq!(few, search([1; 2]), "{shape:?} {window:?}");
                    found += few.len();
                }
            }
        }
        assert!(200 < found, "{found}");
    }
}
