//! How often each part of the exemplars was used, so that an output spreads over all of them.

use crate::{Domain, Error, Exemplars, Grid};

/// Most that is added to an error, in thousandths of it: nothing is taken for its rareness that is twice as bad as the
/// best, but for the tolerance.
const MOST: u64 = 1000;

/// Cells along a patch: uses are counted by quarters of it. Finer ones would take patches that overlap by nine tenths
/// for different parts, coarser ones would count a patch as used because its neighbour was.
const CELLS: u32 = 4;

/// How often each part of the exemplars was used, and what an error counts by that.
///
/// The best patch is often the same one again: an output then shows a few places of its exemplar over and over, while
/// others are never seen. So the error of a patch counts more where its place was used more often than the mean. That
/// is the mean of its own source: of several exemplars that are unlike each other, none is forced upon the output.
///
/// Patches are told by their source and first sample.
///
/// ```
/// use selvedge_core::{Domain, Exemplars, Grid, Plane, Role, Samples, Usage};
/// # fn main() -> Result<(), selvedge_core::Error> {
/// let plane = Plane::new(Role::Scalar, Samples::U8(Grid::try_filled(Domain::open([40, 40]), 1, 0)?));
/// let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)])?;
/// let mut usage = Usage::new(&exemplars, [8, 8], 0.5)?;
/// usage.note(0, [10, 10]);
/// // An error where nothing was used yet counts once, one at a place that was used more.
/// assert_eq!(usage.counted(100, 0, [30, 30]), 100_000);
/// assert!(100_000 < usage.counted(100, 0, [10, 10]));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Usage<const D: usize> {
    /// Thousandths that are added to an error where the uses are twice as many as in the mean.
    spread: u64,
    /// Sides of a cell in samples.
    cell: [u32; D],
    /// Of each source.
    sources: Vec<Uses<D>>,
}

/// Uses of patches by the cell of their first sample in one source.
#[derive(Clone, Debug)]
struct Uses<const D: usize> {
    cells: Grid<u32, D>,
    total: u64,
}

impl<const D: usize> Usage<D> {
    /// No uses yet of patches of that shape. `spread` is the fraction that is added to an error where a part was used
    /// twice as often as parts are in the mean, twice as much where three times as often, up to the whole error; 0 adds
    /// nothing.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn new(exemplars: &Exemplars<D>, patch: [u32; D], spread: f64) -> Result<Self, Error> {
        let cell = patch.map(|side| side.div_ceil(CELLS).max(1));
        let uses = |source: [u32; D]| {
            let along = |a: usize| (source[a].saturating_sub(patch[a]) + 1).div_ceil(cell[a]);
            let cells = Grid::try_filled(Domain::open(std::array::from_fn(along)), 1, 0)?;
            Ok(Uses { cells, total: 0 })
        };
        let sources = exemplars.sources().iter().map(|s| uses(s.domain().shape)).collect::<Result<_, Error>>()?;
        Ok(Self { spread: (spread * 1000.0).round() as u64, cell, sources })
    }

    /// True if no part is rarer than another.
    pub fn is_even(&self) -> bool {
        self.spread == 0 || self.sources.iter().all(|s| s.total == 0)
    }

    /// What an error counts at a place, in thousandths of it.
    pub fn counted(&self, error: u64, source: usize, at: [u32; D]) -> u128 {
        if self.spread == 0 {
            return u128::from(error) * 1000;
        }
        // Among perfect ones, too, the rarer are better.
        u128::from(error.max(1)) * u128::from(1000 + self.added(source, at))
    }

    /// The tolerance, in thousandths, within which errors are looked at, for one of `per_mille` on what they count,
    /// where the least error is at this place: none counts less than it is, and the least counts no more than this. So
    /// nothing that could be drawn is left out, but for a least error of 0: no tolerance widens that, and perfect
    /// candidates are drawn among themselves alone.
    pub fn widened(&self, per_mille: u32, source: usize, at: [u32; D]) -> u32 {
        let added = if self.spread == 0 { 0 } else { self.added(source, at) };
        ((1000 + u64::from(per_mille)) * (1000 + added)).div_ceil(1000) as u32 - 1000
    }

    /// Thousandths that are added to an error: the uses of its cell beyond the mean, against the mean. Every cell
    /// counts one use more in the mean, so that it is never 0.
    fn added(&self, source: usize, at: [u32; D]) -> u64 {
        let Uses { cells, total } = &self.sources[source];
        let (n, uses) = (cells.samples().len() as u64, u64::from(cells.get(0, self.cell(source, at))));
        (self.spread * (uses * n).saturating_sub(*total) / (n + total)).min(MOST)
    }

    /// A patch was used. Those about half a patch away share much of it: they count as used, too.
    pub fn note(&mut self, source: usize, at: [u32; D]) {
        if self.spread == 0 {
            return;
        }
        let cell = self.cell(source, at);
        let Uses { cells, total } = &mut self.sources[source];
        let shape = cells.domain().shape;
        let first: [u32; D] = std::array::from_fn(|a| cell[a].saturating_sub(CELLS / 2));
        let end = |a: usize| (cell[a] + CELLS / 2 + 1).min(shape[a]);
        let around = Domain::<D>::open(std::array::from_fn(|a| end(a) - first[a]));
        for by in around.positions() {
            let at = std::array::from_fn(|a| first[a] + by[a]);
            cells.set(0, at, cells.get(0, at) + 1);
            *total += 1;
        }
    }

    fn cell(&self, source: usize, at: [u32; D]) -> [u32; D] {
        let shape = self.sources[source].cells.domain().shape;
        // Patches that are cropped at the output's border may begin beyond the last whole one.
        std::array::from_fn(|a| (at[a] / self.cell[a]).min(shape[a] - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Origin, Rng, Seed, Source, Transform};

    fn usage(spread: f64) -> Usage<2> {
        let source = |exemplar, shape| Source {
            features: Grid::try_filled(Domain::open(shape), 1, 0).unwrap(),
            valid: None,
            origin: Origin { exemplar, transform: Transform::IDENTITY },
        };
        let sources = vec![source(0, [40, 30]), source(1, [20, 5])];
        Usage::new(&Exemplars::from_sources(sources, vec![1]).unwrap(), [8, 8], spread).unwrap()
    }

    /// Of candidates by error and place, one of those that count least.
    fn rarest(usage: &Usage<2>, candidates: &[(u64, [u32; 2])], rng: &mut Rng) -> (u64, [u32; 2]) {
        let counted = |&&(error, at): &&(u64, [u32; 2])| usage.counted(error, 0, at);
        let least = candidates.iter().map(|c| counted(&c)).min().unwrap();
        let rarest: Vec<_> = candidates.iter().filter(|c| counted(c) == least).collect();
        *rarest[rng.below(rarest.len() as u32) as usize]
    }

    /// Which of two candidates is drawn, over many draws.
    fn shares(usage: &mut Usage<2>, errors: [u64; 2]) -> [u32; 2] {
        let mut rng = Seed(1).rng();
        let mut drawn = [0; 2];
        for _ in 0..1000 {
            let (_, at) = rarest(usage, &[(errors[0], [0, 0]), (errors[1], [30, 20])], &mut rng);
            usage.note(0, at);
            drawn[usize::from(at == [30, 20])] += 1;
        }
        drawn
    }

    #[test]
    fn even_use_adds_nothing() {
        let mut usage = usage(0.5);
        let everywhere: Vec<[u32; 2]> = Domain::open([33, 23]).positions().collect();
        everywhere.iter().for_each(|&at| usage.note(0, at));
        // A cell in the middle is counted as often as any that lies as far from the borders.
        let added = |at: [u32; 2]| usage.widened(0, 0, at);
        assert!(everywhere.iter().all(|&at| added(at) < 400), "{:?}", added([16, 11]));
        assert_eq!(added([0, 0]), 0, "corners are used less than the rest");
        assert!(0 < added([16, 11]));
    }

    #[test]
    fn alike_places_take_turns_and_bad_ones_are_never_drawn() {
        for errors in [[0, 0], [100, 100], [100, 105]] {
            let [a, b] = shares(&mut usage(0.1), errors);
            assert!(a.abs_diff(b) < 100, "{errors:?} {a} {b}");
        }
        assert_eq!(shares(&mut usage(10.0), [100, 201])[1], 0, "twice as bad");
        assert_eq!(shares(&mut usage(0.0), [100, 101])[1], 0, "without spread, the best");
    }

    #[test]
    fn above_an_error_of_0_the_widened_tolerance_holds_all_that_may_be_drawn() {
        let mut rng = Seed(3).rng();
        let mut usage = usage(0.3);
        assert_eq!(usage.widened(210, 0, [0, 0]), 210, "nothing was used yet");
        let mut widened = 0;
        for _ in 0..300 {
            let candidates: Vec<_> = (0..20).map(|i| (50 + u64::from(rng.below(100)), [i, rng.below(22)])).collect();
            let &(best, at) = candidates.iter().min().unwrap();
            let limit = u128::from(best) * u128::from(1000 + usage.widened(210, 0, at));
            widened += u32::from(u128::from(1210 * best) < limit);
            let least = candidates.iter().map(|&(error, at)| usage.counted(error, 0, at)).min().unwrap();
            let near = |&&(error, at): &&(u64, [u32; 2])| usage.counted(error, 0, at) * 1000 <= least * 1210;
            assert!(candidates.iter().filter(near).all(|&(error, _)| u128::from(error) * 1000 <= limit));
            usage.note(0, rarest(&usage, &candidates, &mut rng).1);
        }
        assert!(50 < widened, "{widened}");
    }

    #[test]
    fn uses_are_counted_about_the_patch_in_its_own_source() {
        let mut usage = usage(1.0);
        usage.note(0, [20, 9]);
        assert_eq!(usage.sources[0].total, 25);
        let added = |source, at| usage.added(source, at);
        assert!(0 < added(0, [20, 9]) && 0 < added(0, [16, 13]));
        assert_eq!([added(0, [20, 15]), added(0, [27, 9]), added(1, [12, 0])], [0; 3]);
        assert_eq!(added(1, [19, 4]), 0, "a cropped patch");
    }

    #[test]
    fn uses_of_clips_are_counted_along_all_three_axes() {
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let features = Grid::try_filled(Domain::open([20, 40, 30]), 1, 0).unwrap();
        let clip = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        let mut usage = Usage::new(&clip, [4, 8, 8], 1.0).unwrap();
        usage.note(0, [10, 20, 9]);
        assert_eq!(usage.sources[0].total, 125);
        assert!(0 < usage.added(0, [12, 16, 13]));
        assert_eq!(usage.added(0, [13, 20, 9]), 0);
    }
}
