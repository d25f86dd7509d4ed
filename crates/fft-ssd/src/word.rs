//! The integers of a map: 32 bits where every error fits, else 64. Sums on the way may wrap.

/// An unsigned integer that sums are taken in, modulo its range.
pub(crate) trait Word: Copy + Ord + Send + Sync + std::fmt::Debug + 'static {
    const ZERO: Self;
    /// Marks what is no candidate.
    const NONE: Self;
    fn wrapping(value: i64) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
}

macro_rules! word {
    ($t:ty) => {
        impl Word for $t {
            const ZERO: Self = 0;
            const NONE: Self = Self::MAX;
            #[inline(always)]
            fn wrapping(value: i64) -> Self {
                value as Self
            }
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
            #[inline(always)]
            fn minus(self, other: Self) -> Self {
                self.wrapping_sub(other)
            }
            #[inline(always)]
            fn times(self, other: Self) -> Self {
                self.wrapping_mul(other)
            }
        }
    };
}

word!(u32);
word!(u64);
