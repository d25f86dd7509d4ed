//! Nearest windows that use all of the sources: an error counts less where no window of the picture is near.

use super::comparison::Comparison;
use super::{Field, Neighbor, Windows, check, one_by_one, walk};
use crate::Error;
use crate::kernel::Kernel;
use selvedge_core::{Domain, Grid, SimdLevel, par, try_vec};

/// How near windows of a picture come to each position of some sources: where they do not, the picture lacks something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coverage {
    /// For each source and position the error of the most similar window; all ones where none can stand.
    least: Vec<Vec<u64>>,
}

impl Coverage {
    /// That of all windows of a picture.
    ///
    /// Takes what [`nearest`](super::nearest()) takes, and at most 40 bytes more for each position of a source.
    ///
    /// # Errors
    /// Those of [`nearest`](super::nearest()).
    pub fn of(
        picture: Field<'_>,
        sources: &[Field<'_>],
        weights: &[u8],
        windows: Windows,
        simd: SimdLevel,
    ) -> Result<Self, Error> {
        check(picture, sources, weights, windows)?;
        let least = sources.iter().map(|&source| {
            let comparison = Comparison { picture, source, weights, windows };
            match comparison.is_by_displacement() {
                true => walk::least(comparison, Kernel::new(simd)),
                false => one_by_one::least(comparison, simd),
            }
        });
        Ok(Self { least: least.collect::<Result<_, _>>()? })
    }

    /// One that is told, as [`least`](Self::least) tells it source by source: where errors shall count by something
    /// else than what a picture lacks.
    pub fn told(least: Vec<Vec<u64>>) -> Self {
        Self { least }
    }

    /// That of the windows of both.
    #[must_use]
    pub fn and(mut self, other: &Self) -> Self {
        let (all, others) = (self.least.iter_mut().flatten(), other.least.iter().flatten());
        all.zip(others).for_each(|(a, b)| *a = *b.min(a));
        self
    }

    /// For each window `q` of a picture the window `j` of least `d(q, j) / (a + c(j))`, where `d` is the error of
    /// [`nearest`](super::nearest()), `c` this coverage, and `a` is `alpha` times its mean, at least 1; the lowest
    /// source, row and column of equal ones. (Granot, Feinstein, Shocher, Bagon, Irani 2022.)
    ///
    /// What nothing in the picture is like gets near to what is most like it: so parts of the sources that a picture
    /// lacks come into it, and it is not drawn to a few of them. The smaller `alpha` is, the more so.
    ///
    /// Scores are 32-bit floats, multiplied once: the same for any instructions and threads. Takes what
    /// [`nearest`](super::nearest()) takes.
    ///
    /// # Errors
    /// Those of [`nearest`](super::nearest()).
    ///
    /// # Panics
    /// If this is the coverage of other sources, or of windows of another side.
    pub fn nearest(
        &self,
        picture: Field<'_>,
        sources: &[Field<'_>],
        weights: &[u8],
        windows: Windows,
        alpha: f64,
        simd: SimdLevel,
    ) -> Result<Grid<Option<Neighbor>, 2>, Error> {
        let over = check(picture, sources, weights, windows)?;
        assert_eq!(self.least.len(), sources.len(), "a coverage of these sources");
        let added = self.added(alpha);
        let mut found: Vec<Option<(f32, u32, [u32; 2])>> = try_vec(over.len(), None)?;
        for (number, (&source, least)) in sources.iter().zip(&self.least).enumerate() {
            let comparison = Comparison { picture, source, weights, windows };
            let best = match comparison.is_by_displacement() {
                true => walk::scaled(comparison, (least, added), Kernel::new(simd))?,
                false => one_by_one::scaled(comparison, (least, added), simd)?,
            };
            for (found, best) in found.iter_mut().zip(best) {
                if let Some((score, at)) = best.filter(|b| found.is_none_or(|f| b.0 < f.0)) {
                    *found = Some((score, number as u32, at));
                }
            }
        }
        let neighbor = |i: usize| {
            found[i].map(|(_, source, position)| {
                let at = over.position(i).map(|p| p * windows.step);
                let error = error((picture, at), (sources[source as usize], position), weights, windows.side);
                Neighbor { source, position, error }
            })
        };
        Ok(Grid::from_vec(over, 1, par::map_indexed(over.len(), neighbor))?)
    }

    /// By position of a source, in the order of [`Windows::over`] it at a step of 1, the error of the most similar
    /// window; all ones where none can stand.
    ///
    /// # Panics
    /// If there is no such source.
    pub fn least(&self, source: usize) -> &[u64] {
        &self.least[source]
    }

    /// What [`nearest`](Self::nearest) adds to an error of this coverage before it divides by it.
    pub fn added(&self, alpha: f64) -> f64 {
        (alpha * self.mean()).max(1.0)
    }

    /// The mean over positions where a window can stand.
    fn mean(&self) -> f64 {
        let all = self.least.iter().flatten().filter(|&&error| error != u64::MAX);
        let (sum, n) = all.fold((0_u128, 0_u64), |(sum, n), &error| (sum + u128::from(error), n + 1));
        if n == 0 { 0.0 } else { sum as f64 / n as f64 }
    }
}

/// The error of one window at one position.
fn error((picture, at): (Field<'_>, [u32; 2]), (source, to): (Field<'_>, [u32; 2]), weights: &[u8], side: u32) -> u64 {
    let (here, there) = (picture.features.domain(), source.features.domain());
    let wrapped = |domain: Domain<2>, from: [u32; 2], by: [u32; 2]| {
        domain.index([0, 1].map(|a| (from[a] + by[a]) % domain.shape[a]))
    };
    let mut sum = 0;
    for by in Domain::open([side; 2]).positions() {
        let (p, q) = (wrapped(here, at, by), wrapped(there, to, by));
        if picture.valid.is_some_and(|v| !v.plane(0)[p]) {
            continue;
        }
        for (c, &w) in weights.iter().enumerate() {
            let difference = u64::from(picture.features.plane(c)[p].abs_diff(source.features.plane(c)[q]));
            sum += u64::from(w) * difference * difference;
        }
    }
    sum
}
