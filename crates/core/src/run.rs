//! The surroundings of a run: seed, limits, and who watches it.

use crate::{Render, Seed};

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

/// What a method tells while it works.
pub struct Event<'a, const D: usize> {
    /// The stage, such as `"quilting"`.
    pub stage: &'static str,
    /// Steps done.
    pub done: u64,
    /// Steps in all; 0 where nobody knows.
    pub of: u64,
    /// The method's energy or cost so far, where it has one.
    pub energy: Option<i64>,
    /// The result so far, where it can be shown.
    pub so_far: Option<&'a dyn Render<D>>,
}

impl<const D: usize> Event<'_, D> {
    /// Progress without energy or picture.
    pub const fn step(stage: &'static str, done: u64, of: u64) -> Self {
        Self { stage, done, of, energy: None, so_far: None }
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
