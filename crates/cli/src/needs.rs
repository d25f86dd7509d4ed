//! What a run that weaves takes beside its method's own share, so that the whole is known twice: of headers alone, and
//! again once the method has chosen what it leaves open.

use std::path::PathBuf;

use selvedge_core::{Bytes, Domain, Limits};

use crate::failure::Failure;
use crate::memory::{self, Resized};

/// Bytes of a run by when they are held.
#[derive(Clone, Debug)]
pub(crate) struct Needs {
    /// From the first picture to the end.
    pub(crate) kept: Bytes,
    /// While exemplars are read and made.
    pub(crate) reading: Bytes,
    /// Of the sources, which the method works on.
    pub(crate) sources: Bytes,
    /// While seams are hidden, beside the method's own.
    pub(crate) blended: Share,
    /// What is rendered and written after it.
    pub(crate) written: Share,
    /// The only exemplar.
    pub(crate) exemplar: Option<PathBuf>,
    pub(crate) resized: Resized,
}

/// What grows with the output: of one of a single sample, and of the one that is wanted, of so many.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Share {
    least: Bytes,
    all: Bytes,
    samples: u64,
}

impl Share {
    pub(crate) fn of(output: Domain<2>, bytes: impl Fn(Domain<2>) -> Bytes) -> Self {
        let one = Domain { shape: [1; 2], ..output };
        Self { least: bytes(one), all: bytes(output), samples: Bytes::of_samples(output, 1).0 }
    }

    /// That of an output of another size, between them by its samples.
    fn at(&self, output: Domain<2>) -> Bytes {
        let (grown, samples) = (self.all.0.saturating_sub(self.least.0), Bytes::of_samples(output, 1).0);
        let more = u128::from(grown) * u128::from(samples) / u128::from(self.samples.max(1));
        self.least + Bytes(u64::try_from(more).unwrap_or(u64::MAX))
    }
}

impl Needs {
    /// All of a run with an output of that shape, with the method's own bytes for it.
    pub(crate) fn with(&self, method: Bytes, output: Domain<2>) -> Bytes {
        let worked = self.sources + (method + self.blended.at(output)).then(self.written.at(output));
        memory::PROGRAM + self.kept + self.reading.max(worked)
    }

    /// Refuses what exceeds the budget, and says what would fit.
    pub(crate) fn check(
        &self,
        limits: &Limits,
        output: Domain<2>,
        method: &dyn Fn(Domain<2>) -> Bytes,
    ) -> Result<Bytes, Failure> {
        let need = |output: Domain<2>| self.with(method(output), output);
        memory::check(limits, self.exemplar.as_deref(), output, self.resized, &need)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_that_end_do_not_add_up() {
        let output = Domain::open([10, 10]);
        let share = |least: u64, each: u64| Share::of(output, |d| Bytes(least) + Bytes::of_samples(d, each));
        let needs = Needs {
            kept: Bytes(1000),
            reading: Bytes(500),
            sources: Bytes(100),
            blended: share(0, 1),
            written: share(40, 2),
            exemplar: None,
            resized: Resized::Size,
        };
        let all =
            |method: u64, side: u32| needs.with(Bytes(method), Domain::open([side; 2])).0 - memory::PROGRAM.0 - 1000;
        assert_eq!(all(0, 10), 500, "reading is the most");
        assert_eq!(all(1000, 10), 100 + 1100 + 240 / 4);
        assert_eq!(all(1000, 20), 100 + 1397 + 834 / 4, "four times as much of what grows: 1 + 99 * 4, 42 + 198 * 4");
    }
}
