//! Where a template may stand in a source.

use crate::axes::Shape;

/// Where the template may stand, and how much of it must stand on valid samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// Which positions are asked for.
    pub positions: Positions,
    /// What a position needs to be a candidate.
    pub cover: Cover,
}

impl Placement {
    /// The box lies inside and every sample of it is valid: a patch that can be copied whole.
    pub const INSIDE: Self = Self { positions: Positions::Inside, cover: Cover::Box };
    /// Every circular shift of the source `[Ding eq. 1]`.
    pub const CIRCULAR: Self = Self { positions: Positions::Circular, cover: Cover::Box };

    /// Every position at which at least `samples` unmasked samples (0 counts as 1) stand on the source
    /// `[Kwatra03 eq. 2]`.
    pub const fn overlapping(samples: u64) -> Self {
        Self { positions: Positions::Overlapping, cover: Cover::AtLeast(samples) }
    }
}

/// Positions of the template's first sample, in source samples.
///
/// Along an axis on which the source is periodic, every kind means all `N` shifts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Positions {
    /// `0 ..= N - m` along each axis: the box lies inside.
    Inside,
    /// `0 .. N` along each axis: the source wraps around.
    Circular,
    /// `-(m - 1) .. N` along each axis: the box meets the source in at least one sample.
    Overlapping,
}

/// What a position needs to be a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cover {
    /// Every sample of the box stands on a valid sample of the source.
    Box,
    /// Every unmasked sample does.
    Mask,
    /// At least so many unmasked samples do (0 counts as 1); the others do not count, and costs are compared by
    /// their mean over the samples that do.
    AtLeast(u64),
}

/// The positions of one source, over three axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Range {
    /// The first position.
    pub(crate) first: [isize; 3],
    /// Positions along each axis.
    pub(crate) count: Shape,
    /// Axes on which source samples wrap around.
    pub(crate) wraps: [bool; 3],
}

impl Range {
    pub(crate) fn new(positions: Positions, source: Shape, periodic: [bool; 3], template: Shape) -> Self {
        let mut range = Self { first: [0; 3], count: [0; 3], wraps: periodic };
        for axis in 0..3 {
            let (n, m) = (source[axis], template[axis]);
            range.wraps[axis] |= positions == Positions::Circular;
            range.count[axis] = match positions {
                _ if n == 0 => 0,
                _ if range.wraps[axis] => n,
                Positions::Inside | Positions::Circular => (n + 1).saturating_sub(m),
                Positions::Overlapping => {
                    range.first[axis] = 1 - m as isize;
                    n + m - 1
                }
            };
        }
        range
    }

    /// Positions at which a part of the template, a box that starts at `start`, lies inside.
    pub(crate) fn of_part(source: Shape, periodic: [bool; 3], start: Shape, part: Shape) -> Self {
        let mut range = Self::new(Positions::Inside, source, periodic, part);
        for axis in (0..3).filter(|&axis| !periodic[axis]) {
            range.first[axis] = -(start[axis] as isize);
        }
        range
    }

    /// Positions in all; `None` where they cannot be counted.
    pub(crate) fn checked_len(&self) -> Option<usize> {
        self.count.iter().try_fold(1_usize, |n, &c| n.checked_mul(c))
    }
}
