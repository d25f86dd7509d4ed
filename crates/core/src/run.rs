//! The surroundings of a run: seed, limits, and who watches it.

use crate::{Bytes, Domain, Error, Render, Seed};

/// How much a run may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes that a method may hold at once.
    pub memory: u64,
    /// Samples along any side.
    pub side: u32,
    /// Samples of one picture or clip.
    pub samples: u64,
}

impl Default for Limits {
    /// 65,535 a side, 2^28 samples, and as much memory as there is.
    fn default() -> Self {
        Self { memory: u64::MAX, side: 65_535, samples: 1 << 28 }
    }
}

impl Limits {
    /// The one rule for outputs and budgets: something to fill, no side and no number of samples over the caps, and no
    /// more than so much `needed` memory.
    ///
    /// # Errors
    /// [`Error::EmptyOutput`], [`Error::OverCaps`] before [`Error::OverBudget`]: no budget helps an output that is too
    /// large by itself.
    pub fn admit<const D: usize>(&self, output: Domain<D>, needed: Bytes) -> Result<(), Error> {
        if output.is_empty() {
            return Err(Error::EmptyOutput { shape: output.shape.to_vec() });
        }
        let over = output.shape.iter().any(|&side| self.side < side);
        if over || self.samples < Bytes::of_samples(output, 1).0 {
            return Err(Error::OverCaps { shape: output.shape.to_vec(), side: self.side, samples: self.samples });
        }
        self.afford(needed)
    }

    /// The half of [`admit`](Self::admit) that is about memory: for runs without an output of their own.
    ///
    /// # Errors
    /// [`Error::OverBudget`].
    pub fn afford(&self, needed: Bytes) -> Result<(), Error> {
        let budget = Bytes(self.memory);
        if needed <= budget { Ok(()) } else { Err(Error::OverBudget { needed, budget }) }
    }
}

/// What a method tells while it works.
pub struct Event<'a, const D: usize> {
    /// The stage, such as `"quilting"`.
    pub stage: &'static str,
    /// Steps done.
    pub done: u64,
    /// Steps in all; 0 where nobody knows.
    pub of: u64,
    /// Of a run of several stages, the work that is done and all of it, in units that take about as long in each: what
    /// is left follows from these. `None` where steps say as much.
    pub work: Option<[u64; 2]>,
    /// The method's energy or cost so far, where it has one.
    pub energy: Option<i64>,
    /// The result so far, where it can be shown.
    pub so_far: Option<&'a dyn Render<D>>,
}

impl<const D: usize> Event<'_, D> {
    /// Progress without energy or picture.
    pub const fn step(stage: &'static str, done: u64, of: u64) -> Self {
        Self { stage, done, of, work: None, energy: None, so_far: None }
    }
}

/// Watches a run, and may end it.
pub trait Observer<const D: usize>: Sync {
    /// Called from the coordinating thread, in order.
    fn event(&self, _event: &Event<'_, D>) {}
    /// Polled by any worker; once true, the method returns its best so far.
    fn cancelled(&self) -> bool {
        false
    }
}

/// An observer that neither listens nor cancels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;
impl<const D: usize> Observer<D> for Silent {}

/// Watches a run that is a part of another one: what it does is told, but not what it has, which is no result of the
/// other.
#[derive(Clone, Copy)]
pub struct Within<'a, const D: usize>(pub &'a dyn Observer<D>);

impl<const D: usize> Observer<D> for Within<'_, D> {
    fn event(&self, event: &Event<'_, D>) {
        self.0.event(&Event { so_far: None, ..*event });
    }

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// Which instructions the search kernels may use. Results are the same with any of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum SimdLevel {
    /// Plain loops.
    Scalar,
    /// At most AVX2.
    Avx2,
    /// At most AVX2 with VNNI.
    AvxVnni,
    /// At most AVX-512 with VNNI.
    Avx512,
    /// Whatever the machine has.
    #[default]
    Auto,
}

/// The run's surroundings: the last argument of every method.
#[derive(Clone, Copy)]
pub struct Run<'a, const D: usize> {
    /// The same seed gives the same samples.
    pub seed: Seed,
    /// How much it may use.
    pub limits: Limits,
    /// Who watches.
    pub observer: &'a dyn Observer<D>,
    /// The kernels' instructions.
    pub simd: SimdLevel,
}

impl<const D: usize> Run<'static, D> {
    /// A silent run with default limits.
    pub fn seeded(seed: u64) -> Self {
        Self { seed: Seed(seed), limits: Limits::default(), observer: &Silent, simd: SimdLevel::Auto }
    }
}

/// What a method answers.
#[derive(Clone, Debug)]
pub struct Woven<R, S> {
    /// The result, such as a [`SourceMap`](crate::SourceMap).
    pub result: R,
    /// The method's own counts.
    pub stats: S,
    /// False if the run was cancelled and this is the best so far.
    pub complete: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn caps_come_before_budgets_and_hold_in_every_dimension() {
        let limits = Limits { memory: 10, side: 7, samples: 50 };
        let admit = |shape, needed| limits.admit(Domain::open(shape), Bytes(needed));
        assert_eq!(admit([7, 7, 1], 10), Ok(()));
        assert_eq!(admit([7, 7, 1], 11), Err(Error::OverBudget { needed: Bytes(11), budget: Bytes(10) }));
        assert_eq!(admit([9, 0, 1], 11), Err(Error::EmptyOutput { shape: vec![9, 0, 1] }));
        for shape in [[8, 1, 1], [1, 1, 8], [4, 4, 4]] {
            let refused = admit(shape, 11).unwrap_err();
            assert_eq!(refused, Error::OverCaps { shape: shape.to_vec(), side: 7, samples: 50 });
        }
        let words = admit([1, 4, 8], 0).unwrap_err().to_string();
        assert_eq!(words, "the output of 8x4x1 px is over the caps of 7 px a side and 50 px in all");
        assert!(Limits::default().admit(Domain::open([u32::MAX; 3]), Bytes(0)).is_err(), "nothing overflows");
    }
}
