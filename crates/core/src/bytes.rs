//! Amounts of memory, composed from what the owners of buffers tell.

use std::fmt;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Mul};

use crate::Domain;

/// An amount of memory in bytes. Sums and products stop at the greatest number instead of passing it: whatever is told
/// of sizes that nobody could have, a budget refuses it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bytes(pub u64);

impl Bytes {
    /// What nobody has: the estimate of what cannot be done.
    pub const MOST: Self = Self(u64::MAX);

    /// So many bytes for each sample of a domain.
    pub fn of_samples<const D: usize>(domain: Domain<D>, each: u64) -> Self {
        Self::of_box(domain.shape.map(u64::from), each)
    }

    /// So many bytes for each sample of a box.
    pub fn of_box<const D: usize>(shape: [u64; D], each: u64) -> Self {
        shape.into_iter().fold(Self(each), |bytes, side| bytes * side)
    }

    /// Of two stages of which the one ends before the other begins: the greater, and a quarter of the other, since not
    /// all that is freed is given back. (The allocators that were measured kept up to a fifth.)
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        self.max(next) + Self(self.min(next).0 / 4)
    }
}

impl Add for Bytes {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl AddAssign for Bytes {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<u64> for Bytes {
    type Output = Self;
    fn mul(self, times: u64) -> Self {
        Self(self.0.saturating_mul(times))
    }
}

impl Sum for Bytes {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self(0), Self::add)
    }
}

/// As people write it, rounded upwards, so that what is written suffices when it is typed.
impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = ["B", "KiB", "MiB", "GiB", "TiB"];
        let mut value = self.0 as f64;
        let mut unit = 0;
        while 1024.0 <= value && unit + 1 < units.len() {
            value /= 1024.0;
            unit += 1;
        }
        if unit == 0 || 10.0 <= value {
            write!(f, "{} {}", value.ceil(), units[unit])
        } else {
            write!(f, "{:.1} {}", (value * 10.0).ceil() / 10.0, units[unit])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_read_as_people_write_them() {
        assert_eq!([0, 1023, 1536].map(|b| Bytes(b).to_string()), ["0 B", "1023 B", "1.5 KiB"]);
        assert_eq!([100 << 20, 5 << 30].map(|b| Bytes(b).to_string()), ["100 MiB", "5.0 GiB"]);
    }

    #[test]
    fn what_nobody_could_have_stays_the_most() {
        let most = Bytes(u64::MAX);
        assert_eq!((most + Bytes(1), most * 3, most.then(most)), (most, most, most));
        assert_eq!(Bytes::of_samples(Domain::open([u32::MAX; 3]), 4), most);
        assert_eq!([Bytes(1), Bytes(2)].into_iter().sum::<Bytes>(), Bytes(3));
        assert_eq!((Bytes(8).then(Bytes(100)), Bytes(100).then(Bytes(8))), (Bytes(102), Bytes(102)));
    }
}
