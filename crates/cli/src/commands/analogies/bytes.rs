//! Memory of a run of constrained synthesis.

use selvedge_cms_analogies::{Sizes, estimate};
use selvedge_core::{Bytes, Domain};

use super::job::Job;
use super::shown;
use crate::correspondence::What;
use crate::failure::Failure;
use crate::followed::MASKS;
use crate::loom::Loom;

/// Bytes of a sample of the pictures that a constraint is made of: four channels of 16 bits, three of a map, its label,
/// and where it shows anything.
const OF_PICTURE: u64 = 8 + 3 + 1 + MASKS;

impl Job<'_> {
    /// The method's memory where its own constraint has so many channels, and some samples may not be used or all may.
    pub(super) fn bytes_with(
        &self,
        (own, holes): (usize, bool),
        sources: &[Domain<2>],
        channels: usize,
        output: Domain<2>,
    ) -> Bytes {
        let constraints: Vec<_> = std::iter::once((own, self.ratio))
            .chain((0..self.knobs.guides.len()).map(|_| (3, 1)))
            .chain((0..self.derived).map(|_| (What::CHANNELS, 1)))
            .chain(self.frame.map(|_| (channels, 1)))
            .collect();
        let sizes = Sizes { sources, channels, constraints: &constraints, output, holes };
        let orientations = self.knobs.turning(self.task).transforms().len();
        // Maps lie under every source, the pictures that they are made of under the exemplars, both under the output.
        let of = |domain: &Domain<2>, each: u64| Bytes::of_samples(*domain, each);
        let maps = constraints.iter().map(|&(channels, _)| channels as u64).sum::<u64>();
        let pictures = maps + OF_PICTURE * constraints.len() as u64;
        // That of `--follow-where`, and a copy in each constraint. `--match-low` holds less than the work before it.
        let asked = if self.knobs.follow_where.is_some() { 1 + constraints.len() as u64 } else { 0 };
        let held: Bytes = sources.iter().chain(std::iter::once(&output)).map(|domain| of(domain, maps)).sum();
        let made: Bytes = sources
            .iter()
            .step_by(orientations)
            .chain(std::iter::once(&output))
            .map(|domain| of(domain, pictures))
            .sum();
        let page = if self.weaving.report.is_some() { shown::bytes(output) } else { Bytes(0) };
        let mapped = if self.knobs.mapped.is_some() { of(&output, 2 * 3) } else { Bytes(0) };
        estimate(&sizes, &self.options)
            + page
            + mapped
            + held
            + made
            + self.knobs.start.bytes(output)
            + of(&output, asked)
            + self.frame.map_or(Bytes(0), |frame| frame.bytes(output))
    }

    /// Refuses constraints of more channels than were known before anything was read, where there is no room for them.
    pub(super) fn admit_channels(&self, loom: &mut Loom<'_>, channels: usize) -> Result<(), Failure> {
        let (sources, features) = loom.sources();
        let of = |own| self.bytes_with((own, false), &sources, features, loom.domain).0;
        loom.admit_more(Bytes(of(channels).saturating_sub(of(self.channels))))
    }
}
