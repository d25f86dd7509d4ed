//! The choice of single samples: of its candidates the one whose neighborhood agrees best with what is known around.
//! `[Ding 3.3]`

use std::ops::Range;

use selvedge_core::{Coherence, Error, Exemplars, Grid, SampleId, ValidBoxes, par, reserve};

use crate::canvas::Canvas;
use crate::dilation;
use crate::features::side_by_side;
use crate::followed::{Followed, SampleGuide};
use crate::neighborhood::{AROUND, FALL_OFF, NEIGHBORS, is_inside};
use crate::options::{PixelSearch, Threshold};
use crate::stats::Stats;
use crate::thresholds::{Limit, Of};

/// Candidates continue neighbours up to so far away. A guess: further ones mostly belong to the same patches.
const COHERENT: u32 = 2;
/// About so many samples are looked at together by an exact search: enough that starting a task costs nothing beside
/// them.
const TOGETHER: usize = 1 << 10;

/// One known neighbour of a place.
#[derive(Clone, Copy, Debug)]
struct Neighbor {
    by: [i32; 2],
    weight: u64,
    /// Where its features begin.
    features: usize,
}

/// Chooses samples for places.
pub(crate) struct Pixels<'e> {
    exemplars: &'e Exemplars<2>,
    /// Those that may be chosen, where masks leave some out: an exact search would find that out again for each place.
    listed: Option<Vec<SampleId>>,
    coherence: Coherence<'e, 2>,
    search: PixelSearch,
    /// By source, whether its samples may be chosen.
    allowed: Vec<bool>,
    /// All channels of a sample side by side, sources one after the other.
    features: Vec<u8>,
    weights: Vec<u64>,
    /// What a neighbour costs that a candidate's source does not have: as much as a random sample.
    missing: u64,
    guide: Option<SampleGuide<'e>>,
}

/// What the choice of one sample needs, used again for the next.
#[derive(Debug, Default)]
pub(crate) struct PixelScratch {
    /// The place looked at last, what is known around it, and what that counts together.
    place: usize,
    neighbors: Vec<Neighbor>,
    counts: u64,
    candidates: Vec<SampleId>,
}

/// What was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Choice {
    /// Weighted squared differences of the neighborhoods.
    pub(crate) error: u64,
    pub(crate) id: SampleId,
}

impl<'e> Pixels<'e> {
    /// `allowed` says by source whether its samples may be chosen.
    pub(crate) fn new(
        exemplars: &'e Exemplars<2>,
        allowed: Vec<bool>,
        search: PixelSearch,
        followed: Option<&'e Followed>,
    ) -> Result<Self, Error> {
        let mut pixels = Self {
            exemplars,
            listed: None,
            coherence: Coherence::new(exemplars),
            search,
            allowed,
            features: side_by_side(exemplars)?,
            weights: exemplars.weights().iter().map(|&w| w.into()).collect(),
            missing: Limit::of(Threshold::OfRandom(1.0), Of::Pixel, exemplars).whole(),
            guide: followed.map(|followed| SampleGuide::new(followed, exemplars)).transpose()?,
        };
        if exemplars.is_masked() {
            let may = |id: &SampleId| pixels.is_allowed(*id) && pixels.is_valid(*id);
            let boxes = ValidBoxes::of(exemplars);
            let all = || boxes.samples(0..boxes.len()).filter(may);
            let mut listed = Vec::new();
            reserve(&mut listed, all().count())?;
            listed.extend(all());
            pixels.listed = Some(listed);
        }
        Ok(pixels)
    }

    /// Re-synthesises the waiting samples of `places`, from what is known inwards, and returns how many; those that
    /// nothing known reaches keep what they have.
    pub(crate) fn resynthesize(
        &self,
        canvas: &mut Canvas,
        places: &[usize],
        scratch: &mut PixelScratch,
    ) -> Result<u64, Error> {
        let order = dilation::order(canvas, places)?;
        let mut done = 0;
        for (place, _) in order {
            if let Some(Choice { id, .. }) = self.choose(canvas, place, scratch)? {
                canvas.set(place, id, Stats::CHOSEN);
                done += 1;
            }
        }
        places.iter().for_each(|&place| canvas.accept(place));
        Ok(done)
    }

    /// The best for a place of those that are searched.
    pub(crate) fn choose(
        &self,
        canvas: &Canvas,
        place: usize,
        scratch: &mut PixelScratch,
    ) -> Result<Option<Choice>, Error> {
        let choice = match self.search {
            PixelSearch::Coherent => self.coherent(canvas, place, scratch)?,
            PixelSearch::Exact => None,
        };
        choice.map_or_else(|| self.exact(canvas, place, scratch), |choice| Ok(Some(choice)))
    }

    /// The best of the samples that continue what is known around; `None` if there is none.
    pub(crate) fn coherent(
        &self,
        canvas: &Canvas,
        place: usize,
        scratch: &mut PixelScratch,
    ) -> Result<Option<Choice>, Error> {
        let (at, candidates) = (canvas.domain().position(place), &mut scratch.candidates);
        self.coherence.around(&canvas.map, at, COHERENT, |place| canvas.is_known(place), candidates);
        self.look(canvas, place, scratch)?;
        // Of equal ones the first: it continues a nearer neighbour.
        Ok(self.best(scratch, u64::MAX, scratch.candidates.iter().copied().filter(|&id| self.is_allowed(id))))
    }

    /// The best of all valid samples, the first of equal ones.
    pub(crate) fn exact(
        &self,
        canvas: &Canvas,
        place: usize,
        scratch: &mut PixelScratch,
    ) -> Result<Option<Choice>, Error> {
        // What continues a neighbour is mostly as good as anything: the others need not be looked at to their end.
        let bound = self.coherent(canvas, place, scratch)?.map_or(u64::MAX, |choice| choice.error.saturating_add(1));
        let known = &*scratch;
        let first = |a: Option<Choice>, b: Option<Choice>| match (a, b) {
            (Some(a), Some(b)) => Some(if b.error < a.error { b } else { a }),
            (a, b) => a.or(b),
        };
        let best = match &self.listed {
            Some(listed) => {
                let of = |range: Range<usize>| self.best(known, bound, listed[range].iter().copied());
                par::fold_blocks(listed.len(), TOGETHER, of, first)
            }
            None => {
                let rows = self.exemplars.sources().iter().map(|s| s.domain().shape[0] as usize).sum::<usize>();
                let together = (TOGETHER * rows / self.exemplars.table().len() as usize).max(1);
                par::fold_blocks(rows, together, |rows| self.best_of_rows(known, bound, rows), first)
            }
        };
        Ok(best.flatten())
    }

    /// The best of the samples in some rows of the sources, which are counted through, the first of equal ones, if its
    /// error is below a bound.
    fn best_of_rows(&self, known: &PixelScratch, bound: u64, rows: Range<usize>) -> Option<Choice> {
        let (mut best, mut first_row): (Option<Choice>, usize) = (None, 0);
        for (s, source) in self.exemplars.sources().iter().enumerate() {
            let [h, w] = source.domain().shape.map(|n| n as usize);
            let own = rows.start.max(first_row)..rows.end.min(first_row + h);
            let mut away = [0; NEIGHBORS];
            let places = known.neighbors.iter().map(|n| n.by[0] as isize * w as isize + n.by[1] as isize);
            away.iter_mut().zip(places).for_each(|(away, place)| *away = place);
            for y in own.filter(|_| self.allowed[s]).map(|row| row - first_row) {
                let first = self.exemplars.table().first(s) as usize + y * w;
                for x in 0..w {
                    let (id, bound) = (SampleId::new((first + x) as u32), best.map_or(bound, |b| b.error));
                    let error = if is_inside([y as u32, x as u32], source.domain().shape) {
                        self.error_inside(known, id, &away, bound)
                    } else {
                        self.error(known, id, bound)
                    };
                    best = error.map(|error| Choice { error, id }).or(best);
                }
            }
            first_row += h;
        }
        best
    }

    /// [`Self::error`] of a candidate all of whose neighborhood is there and valid; the neighbours' places by how many
    /// samples they lie ahead.
    fn error_inside(&self, known: &PixelScratch, id: SampleId, away: &[isize], bound: u64) -> Option<u64> {
        let mut sum = self.asked(known, id);
        for (&Neighbor { weight, features, .. }, &away) in known.neighbors.iter().zip(away) {
            if bound <= sum {
                return None;
            }
            let there = (id.get() as usize).wrapping_add_signed(away);
            sum += weight * self.square(features, there);
        }
        (sum < bound).then_some(sum)
    }

    /// What a candidate differs from what is asked for. It stands beside a mean over the neighborhood, so that both
    /// count the same however much is known.
    fn asked(&self, known: &PixelScratch, id: SampleId) -> u64 {
        self.guide.as_ref().map_or(0, |guide| known.counts.max(1) * guide.error(id, known.place))
    }

    /// The weighted squared difference between features that begin somewhere and those of a sample.
    #[inline]
    fn square(&self, features: usize, sample: usize) -> u64 {
        let of = |(a, b): (u8, u8)| u64::from(u32::from(a.abs_diff(b)).pow(2));
        if let [r, g, b] = self.weights[..] {
            // The usual number of channels, known when this is compiled.
            let (here, there) = (&self.features[features..][..3], &self.features[3 * sample..][..3]);
            return r * of((here[0], there[0])) + g * of((here[1], there[1])) + b * of((here[2], there[2]));
        }
        let channels = self.weights.len();
        let (here, there) = (&self.features[features..][..channels], &self.features[sample * channels..]);
        here.iter().zip(there).zip(&self.weights).map(|((&a, &b), &w)| w * of((a, b))).sum()
    }

    /// The best of some samples, the first of equal ones, if its error is below a bound.
    fn best(&self, known: &PixelScratch, bound: u64, ids: impl Iterator<Item = SampleId>) -> Option<Choice> {
        ids.fold(None, |best: Option<Choice>, id| {
            let bound = best.map_or(bound, |b| b.error);
            self.error(known, id, bound).map(|error| Choice { error, id }).or(best)
        })
    }

    /// Notes what is known around a place.
    fn look(&self, canvas: &Canvas, place: usize, scratch: &mut PixelScratch) -> Result<(), Error> {
        let (domain, channels) = (canvas.domain(), self.weights.len());
        let at = domain.position(place);
        scratch.neighbors.clear();
        reserve(&mut scratch.neighbors, NEIGHBORS)?;
        // Most places are far from all borders.
        let (inside, w) = (is_inside(at, domain.shape), domain.shape[1] as isize);
        for by in AROUND {
            let to = if inside {
                Some(place.wrapping_add_signed(by[0] as isize * w + by[1] as isize))
            } else {
                domain.step(at, by).map(|to| domain.index(to))
            };
            let Some(to) = to else { continue };
            if canvas.is_known(to) {
                let features = canvas.id(to).get() as usize * channels;
                let weight = FALL_OFF[(by[0] * by[0] + by[1] * by[1]) as usize];
                scratch.neighbors.push(Neighbor { by, weight, features });
            }
        }
        (scratch.place, scratch.counts) = (place, scratch.neighbors.iter().map(|n| n.weight).sum());
        Ok(())
    }

    /// The error of a candidate at the place looked at last, if it is below a bound.
    fn error(&self, known: &PixelScratch, id: SampleId, bound: u64) -> Option<u64> {
        let (source, at) = self.exemplars.locate(id)?;
        let (first, source) = (self.exemplars.table().first(source) as usize, &self.exemplars.sources()[source]);
        let (domain, valid) = (source.domain(), source.valid.as_deref().map(Grid::samples));
        let w = domain.shape[1] as usize;
        let inside = is_inside(at, domain.shape);
        let mut sum = self.asked(known, id);
        if bound <= sum {
            return None;
        }
        for &Neighbor { by, weight, features } in &known.neighbors {
            let index = if inside {
                Some((at[0] as i32 + by[0]) as usize * w + (at[1] as i32 + by[1]) as usize)
            } else {
                domain.step(at, by).map(|to| domain.index(to))
            };
            sum += match index.filter(|&i| valid.is_none_or(|valid| valid[i])) {
                None => weight * self.missing,
                Some(index) => weight * self.square(features, first + index),
            };
            if bound <= sum {
                return None;
            }
        }
        (sum < bound).then_some(sum)
    }

    fn is_allowed(&self, id: SampleId) -> bool {
        self.exemplars.table().source(id).is_some_and(|source| self.allowed[source])
    }

    fn is_valid(&self, id: SampleId) -> bool {
        self.exemplars.locate(id).is_some_and(|(source, at)| {
            self.exemplars.sources()[source].valid.as_deref().is_none_or(|valid| valid.get(0, at))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighborhood::REACH;
    use selvedge_core::{Domain, Origin, Seed, Source, SourceMap, Start, Transform};

    /// A map of random samples with holes, and its exemplars.
    fn state(valid: bool) -> (Exemplars<2>, Canvas) {
        let mut rng = Seed(3).rng();
        let source = |exemplar, shape: [u32; 2], periodic: bool, rng: &mut selvedge_core::Rng| {
            let domain = Domain { shape, periodic: [periodic; 2] };
            Source {
                features: Grid::from_vec(domain, 2, (0..2 * domain.len()).map(|_| rng.below(256) as u8).collect())
                    .unwrap(),
                valid: valid
                    .then(|| Grid::from_vec(domain, 1, (0..domain.len()).map(|i| i % 5 != 2).collect()).unwrap())
                    .map(Into::into),
                origin: Origin { exemplar, transform: Transform::IDENTITY },
            }
        };
        let sources = vec![source(0, [9, 12], false, &mut rng), source(1, [6, 5], true, &mut rng)];
        let exemplars = Exemplars::from_sources(sources, vec![3, 1]).unwrap();
        let output = Domain { shape: [15, 12], periodic: [true, false] };
        let mut map = SourceMap::unassigned(&exemplars, output).unwrap();
        // Two by two samples that continue each other, so that there is something to continue.
        for at in output.positions() {
            let mut drawn = Seed(7).derive("cell", u64::from(at[0] / 2 * 100 + at[1] / 2)).rng();
            let first = SampleId::new(drawn.below(exemplars.table().len()));
            let id = exemplars.step(first, [at[0] as i32 % 2, at[1] as i32 % 2]);
            if let Some(id) = id.filter(|_| 0 < drawn.below(4)) {
                map.ids.set(0, at, id);
            }
        }
        let mut canvas = Canvas::new(Start { map, fixed: None, sources: None }).unwrap();
        (0..output.len()).filter(|i| i % 7 == 3).for_each(|place| canvas.wait(place));
        (exemplars, canvas)
    }

    /// The definition: neighborhood against neighborhood.
    fn error(exemplars: &Exemplars<2>, canvas: &Canvas, at: [u32; 2], id: SampleId, missing: u64) -> u64 {
        let near = (-REACH..=REACH).flat_map(|y| (-REACH..=REACH).map(move |x| [y, x])).filter(|&by| by != [0, 0]);
        let here = |by| canvas.domain().step(at, by).map(|p| canvas.domain().index(p)).filter(|&p| canvas.is_known(p));
        let is_valid = |id: &SampleId| {
            let (s, at) = exemplars.locate(*id).unwrap();
            exemplars.sources()[s].valid.as_deref().is_none_or(|v| v.get(0, at))
        };
        let feature = |id: SampleId, c: usize| {
            let (s, at) = exemplars.locate(id).unwrap();
            exemplars.sources()[s].features.get(c, at)
        };
        let of = |by: [i32; 2]| {
            let Some(place) = here(by) else { return 0 };
            let weight = FALL_OFF[(by[0] * by[0] + by[1] * by[1]) as usize];
            let Some(to) = exemplars.step(id, by).filter(is_valid) else { return weight * missing };
            let square = |c: usize| u64::from(feature(to, c).abs_diff(feature(canvas.id(place), c))).pow(2);
            weight * (3 * square(0) + square(1))
        };
        near.map(of).sum()
    }

    #[test]
    fn the_exact_search_finds_the_best_by_definition_and_the_coherent_one_is_never_better() {
        for valid in [false, true] {
            let (exemplars, canvas) = state(valid);
            let pixels = Pixels::new(&exemplars, vec![true; 2], PixelSearch::Exact, None).unwrap();
            let mut scratch = PixelScratch::default();
            let (mut coherent, mut worse, missing) = (0, 0, pixels.missing);
            for (place, at) in canvas.domain().positions().enumerate() {
                let exact = pixels.exact(&canvas, place, &mut scratch).unwrap().unwrap();
                let all = (0..exemplars.table().len()).map(SampleId::new).filter(|&id| pixels.is_valid(id));
                let by_definition = |id| Choice { error: error(&exemplars, &canvas, at, id, missing), id };
                assert_eq!(all.map(by_definition).min_by_key(|c| (c.error, c.id)), Some(exact), "{at:?}");
                if let Some(choice) = pixels.coherent(&canvas, place, &mut scratch).unwrap() {
                    assert_eq!(by_definition(choice.id), choice);
                    assert!(exact.error <= choice.error && pixels.is_valid(choice.id));
                    (coherent, worse) = (coherent + 1, worse + u32::from(exact.error < choice.error));
                }
            }
            assert!(100 < coherent && 20 < worse, "{coherent} {worse}");
        }
    }
}
