//! Labels.

use selvedge_core::Patch;

/// A source at an offset: position `p` of the output shows sample `p - offset` of the source. Around periodic axes of
/// the output it goes on where the source has that sample.
pub type Label<const D: usize> = Patch<D>;

/// At most so many labels can be told apart by place.
pub const MOST_LABELS: usize = 64;
