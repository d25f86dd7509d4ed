//! Samples over a domain.

use crate::{Domain, Error, Window, try_vec};

/// Samples over a [`Domain`], planar: channel by channel, each in row-major order.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T, const D: usize> {
    domain: Domain<D>,
    channels: usize,
    samples: Vec<T>,
}

impl<T, const D: usize> Grid<T, D> {
    /// Takes `channels * domain.len()` samples, planar.
    ///
    /// # Errors
    /// [`Error::Length`] if there are more or fewer.
    pub fn from_vec(domain: Domain<D>, channels: usize, samples: Vec<T>) -> Result<Self, Error> {
        let expected = domain.checked_len().and_then(|n| n.checked_mul(channels)).unwrap_or(usize::MAX);
        if samples.len() != expected {
            return Err(Error::Length { expected, found: samples.len() });
        }
        Ok(Self { domain, channels, samples })
    }

    /// Shape and topology.
    #[inline]
    pub fn domain(&self) -> Domain<D> {
        self.domain
    }

    /// Number of channels.
    #[inline]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The same samples on another topology; the shape stays.
    #[must_use]
    pub fn with_periodic(mut self, periodic: [bool; D]) -> Self {
        self.domain.periodic = periodic;
        self
    }

    /// One channel, row-major.
    ///
    /// # Panics
    /// If there is no such channel.
    #[inline]
    pub fn plane(&self, channel: usize) -> &[T] {
        let n = self.domain.len();
        &self.samples[channel * n..(channel + 1) * n]
    }

    /// One channel, row-major, to write.
    ///
    /// # Panics
    /// If there is no such channel.
    #[inline]
    pub fn plane_mut(&mut self, channel: usize) -> &mut [T] {
        let n = self.domain.len();
        &mut self.samples[channel * n..(channel + 1) * n]
    }

    /// All channels, one after the other.
    pub fn samples(&self) -> &[T] {
        &self.samples
    }

    /// All channels, one after the other, to write.
    pub fn samples_mut(&mut self) -> &mut [T] {
        &mut self.samples
    }

    /// The planar buffer.
    pub fn into_vec(self) -> Vec<T> {
        self.samples
    }
}

impl<T: Copy, const D: usize> Grid<T, D> {
    /// A grid of one value.
    ///
    /// # Errors
    /// [`Error::Allocation`] if the system has no memory for it.
    pub fn try_filled(domain: Domain<D>, channels: usize, value: T) -> Result<Self, Error> {
        let len = domain.checked_len().and_then(|n| n.checked_mul(channels));
        let len = len.ok_or(Error::Allocation { bytes: u64::MAX })?;
        Ok(Self { domain, channels, samples: try_vec(len, value)? })
    }

    /// One sample. Where many are read, [`plane`](Self::plane) is faster.
    ///
    /// # Panics
    /// If there is no such channel or position; [`Domain::contains`] tells.
    #[inline]
    pub fn get(&self, channel: usize, at: [u32; D]) -> T {
        self.plane(channel)[self.domain.inside(at)]
    }

    /// Sets one sample.
    ///
    /// # Panics
    /// If there is no such channel or position.
    #[inline]
    pub fn set(&mut self, channel: usize, at: [u32; D], value: T) {
        let index = self.domain.inside(at);
        self.plane_mut(channel)[index] = value;
    }

    /// Takes interleaved samples (`channels` values a position, as most files store them).
    ///
    /// # Errors
    /// [`Error::Length`] or [`Error::Allocation`].
    pub fn from_interleaved(domain: Domain<D>, channels: usize, samples: &[T]) -> Result<Self, Error> {
        let n = domain.checked_len().unwrap_or(usize::MAX);
        let expected = n.saturating_mul(channels);
        if samples.len() != expected {
            return Err(Error::Length { expected, found: samples.len() });
        }
        let Some(&first) = samples.first() else { return Self::from_vec(domain, channels, Vec::new()) };
        let mut grid = Self::try_filled(domain, channels, first)?;
        for c in 0..channels {
            for (to, from) in grid.plane_mut(c).iter_mut().zip(samples[c..].iter().step_by(channels)) {
                *to = *from;
            }
        }
        Ok(grid)
    }

    /// Interleaved samples: `channels` values a position.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn to_interleaved(&self) -> Result<Vec<T>, Error> {
        let Some(&first) = self.samples.first() else { return Ok(Vec::new()) };
        let mut out = try_vec(self.samples.len(), first)?;
        for c in 0..self.channels {
            for (to, from) in out[c..].iter_mut().step_by(self.channels).zip(self.plane(c)) {
                *to = *from;
            }
        }
        Ok(out)
    }

    /// The samples in a box, such as a patch to search for: open along axes that the box does not fill.
    ///
    /// ```
    /// use selvedge_core::{Domain, Grid, Window};
    ///
    /// let grid = Grid::from_vec(Domain::open([2, 4]), 1, (0..8).collect())?;
    /// let patch = grid.cropped(&Window { start: [0, 1], shape: [2, 2] })?;
    /// assert_eq!(patch.plane(0), [1, 2, 5, 6]);
    /// # Ok::<(), selvedge_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Allocation`].
    ///
    /// # Panics
    /// If the box reaches beyond the grid.
    pub fn cropped(&self, to: &Window<D>) -> Result<Self, Error> {
        let whole = self.domain;
        let fits = |a| 0 <= to.start[a] && i64::from(to.start[a]) + i64::from(to.shape[a]) <= i64::from(whole.shape[a]);
        assert!((0..D).all(fits), "{to:?} reaches beyond {:?}", whole.shape);
        let periodic = std::array::from_fn(|a| whole.periodic[a] && to.shape[a] == whole.shape[a]);
        let domain = Domain { shape: to.shape, periodic };
        let (Some(&first), false) = (self.samples.first(), domain.is_empty()) else {
            return Self::from_vec(domain, self.channels, Vec::new());
        };
        let mut out = Self::try_filled(domain, self.channels, first)?;
        for (to_place, at) in domain.positions().enumerate() {
            let from = whole.index(std::array::from_fn(|a| at[a] + to.start[a] as u32));
            (0..self.channels).for_each(|c| out.plane_mut(c)[to_place] = self.plane(c)[from]);
        }
        Ok(out)
    }

    /// Each sample changed by `f`.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn map<U: Copy>(&self, f: impl Fn(T) -> U) -> Result<Grid<U, D>, Error> {
        let mut samples = Vec::new();
        let bytes = (self.samples.len() * size_of::<U>()) as u64;
        samples.try_reserve_exact(self.samples.len()).map_err(|_| Error::Allocation { bytes })?;
        samples.extend(self.samples.iter().map(|&v| f(v)));
        Ok(Grid { domain: self.domain, channels: self.channels, samples })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interleaved_round_trip() -> Result<(), Error> {
        let pixels: Vec<u8> = (0..24).collect();
        let grid = Grid::from_interleaved(Domain::open([2, 4]), 3, &pixels)?;
        assert_eq!(grid.plane(1), [1, 4, 7, 10, 13, 16, 19, 22]);
        assert_eq!(grid.to_interleaved()?, pixels);
        Ok(())
    }

    #[test]
    #[should_panic(expected = "[0, 4] lies outside [2, 3]")]
    fn a_sample_outside_is_no_other_one() {
        // In release builds too: its place, 4, is that of [1, 1].
        Grid::from_vec(Domain::open([2, 3]), 1, (0..6).collect()).unwrap().get(0, [0, 4]);
    }

    #[test]
    #[should_panic(expected = "[0, 4] lies outside [2, 3]")]
    fn nothing_is_set_outside() {
        Grid::try_filled(Domain::open([2, 3]), 1, 0).unwrap().set(0, [0, 4], 1);
    }

    #[test]
    #[should_panic(expected = "reaches beyond [2, 3]")]
    fn what_is_cropped_lies_inside() {
        let grid = Grid::try_filled(Domain::open([2, 3]), 1, 0).unwrap();
        grid.cropped(&Window { start: [0, 2], shape: [2, 2] }).unwrap();
    }

    #[test]
    fn wrong_lengths_and_huge_grids_are_errors() {
        let d = Domain::open([2, 2]);
        assert_eq!(Grid::from_vec(d, 1, vec![0_u8; 3]), Err(Error::Length { expected: 4, found: 3 }));
        let huge = Domain::open([1 << 31, 1 << 31]);
        assert!(matches!(Grid::try_filled(huge, 4, 0_u64), Err(Error::Allocation { .. })));
    }
}
