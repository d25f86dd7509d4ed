//! A block size for an exemplar.

use selvedge_core::Exemplars;

/// A block for these exemplars: a quarter of the smallest one's shorter side, from 1 to 64.
pub fn suggest_block(exemplars: &Exemplars<2>) -> u32 {
    let sides = exemplars.sources().iter().flat_map(|s| s.domain().shape);
    let shorter = sides.min().unwrap_or(1);
    (shorter / 4).clamp(shorter.min(8), 64)
}
