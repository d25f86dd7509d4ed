//! Decisions near seams alone. `[Lombaert05]`

use selvedge_core::{Domain, SampleId, try_vec};

use crate::choice::Choice;
use crate::error::Error;
use crate::frame::Frame;

impl<const D: usize> Frame<D> {
    /// Takes their choice from samples that lie farther than `width` from every seam of what stands: they keep it. A
    /// distance is the greatest along any axis, to the nearer sample of the seam. Of a map that was solved at half the
    /// size, only what lies near its seams is in question. `[Lombaert05]`
    ///
    /// `is_seam` is asked about neighbours along an axis. With a width of `u32::MAX` nothing is taken.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    ///
    /// # Panics
    /// If there is not one choice for each sample of the frame.
    pub fn band(
        &self,
        choices: &mut [Choice],
        width: u32,
        is_seam: impl Fn(usize, SampleId, SampleId) -> bool,
    ) -> Result<(), Error> {
        assert_eq!(choices.len(), self.old.len(), "one choice a sample");
        keep_far(choices, &self.near_seams(width, is_seam)?);
        Ok(())
    }

    /// True for samples up to `width` from a seam of what stands.
    pub(crate) fn near_seams(
        &self,
        width: u32,
        is_seam: impl Fn(usize, SampleId, SampleId) -> bool,
    ) -> Result<Vec<bool>, Error> {
        self.near(self.seams(is_seam)?, width)
    }

    /// True for samples up to `width` from what is marked.
    pub(crate) fn near(&self, mut marked: Vec<bool>, width: u32) -> Result<Vec<bool>, Error> {
        let mut from = try_vec(marked.len(), false)?;
        for axis in 0..D {
            from.copy_from_slice(&marked);
            widen(self.domain, axis, width, &from, &mut marked);
        }
        Ok(marked)
    }

    /// True for samples beside a seam of what stands.
    pub(crate) fn seams(&self, is_seam: impl Fn(usize, SampleId, SampleId) -> bool) -> Result<Vec<bool>, Error> {
        let mut beside = try_vec(self.old.len(), false)?;
        for axis in 0..D {
            for (s, t) in self.pairs(axis) {
                let (here, there) = (self.old[s], self.old[t]);
                if here.is_assigned() && there.is_assigned() && is_seam(axis, here, there) {
                    (beside[s], beside[t]) = (true, true);
                }
            }
        }
        Ok(beside)
    }
}

/// Takes their choice from samples that are not near seams.
pub(crate) fn keep_far(choices: &mut [Choice], near: &[bool]) {
    for (choice, _) in choices.iter_mut().zip(near).filter(|(c, near)| **c == Choice::Free && !**near) {
        *choice = Choice::Old;
    }
}

/// Marks what lies up to `width` from what is marked, along one axis.
fn widen<const D: usize>(domain: Domain<D>, axis: usize, width: u32, from: &[bool], to: &mut [bool]) {
    let (stride, side) = (domain.strides()[axis], domain.shape[axis] as usize);
    let turns = if domain.periodic[axis] { 2 } else { 1 };
    for first in (0..from.len()).filter(|place| (place / stride).is_multiple_of(side)) {
        for ahead in [true, false] {
            // Nothing was seen yet.
            let mut since = u32::MAX;
            for step in 0..turns * side {
                let at = step % side;
                let place = first + stride * if ahead { at } else { side - 1 - at };
                since = if from[place] { 0 } else { since.saturating_add(1) };
                to[place] |= since <= width;
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
