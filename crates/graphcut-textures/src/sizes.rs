//! At how many sizes a map is solved.

use selvedge_analysis::{Texture, feature_size};
use selvedge_core::{Domain, Exemplars};

use crate::error::Error;
use crate::options::{MOST_LEVELS, Options};
use crate::regions::LEAST;

/// The sides that a coarse exemplar has at least: that of 192 samples for which the method's defaults were chosen.
const LEAST_SIDE: u32 = 192;

/// Samples along the largest structures at a coarse level, at least: smaller ones are not seen there, and no longer
/// matched.
const LEAST_STRUCTURE: u32 = 6;

/// How many levels pay off: exemplars whose shortest side is `side`, with structures of so many samples.
fn levels<const D: usize>(side: u32, structure: u32, output: Domain<D>) -> u32 {
    let pays = |level: &u32| LEAST_SIDE <= side >> level && LEAST_STRUCTURE <= structure >> level;
    // Around a side that is not a multiple, the last coarse sample would be half of one that the seam has to make up
    // for.
    let closes = |level: &u32| (0..D).all(|a| !output.periodic[a] || output.shape[a].is_multiple_of(1 << level));
    1 + (1..MOST_LEVELS).take_while(|level| D == 2 && pays(level) && closes(level)).last().unwrap_or(0)
}

/// At how many sizes the map is solved: as asked, while an exemplar is large enough to be halved.
pub(crate) fn sizes<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    measured: &[Texture],
    options: &Options<D>,
) -> Result<u32, Error> {
    let sides = exemplars.sources().iter().map(|s| s.domain().shape.into_iter().min().unwrap_or(0));
    let side = sides.max().unwrap_or(0);
    if let Some(levels) = options.levels.filter(|_| !options.free.contains(&false)) {
        return Ok((1..levels).take_while(|level| 2 * LEAST <= side >> level).last().unwrap_or(0) + 1);
    }
    // What is too small has one level whatever it shows, and what may not move along an axis must not be shifted along
    // it.
    if options.free.contains(&false) || levels(side, u32::MAX, output) == 1 {
        return Ok(1);
    }
    let known = measured.iter().map(|t| t.feature_size).max();
    Ok(levels(side, known.map_or_else(|| feature_size(exemplars), Ok)?, output))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_follow_sizes_structures_and_tiling() {
        let open = Domain::open([2048, 2048]);
        for (side, structure, expected) in
            [(192, 100, 1), (383, 100, 1), (384, 100, 2), (1024, 100, 3), (4096, 400, 5), (1024, 12, 2), (1024, 11, 1)]
        {
            assert_eq!(levels(side, structure, open), expected, "{side} {structure}");
        }
        let tiled = |side| Domain { shape: [side, 2048], periodic: [true, false] };
        assert_eq!([2048, 2046, 2047].map(|side| levels(1024, 100, tiled(side))), [3, 2, 1]);
        assert_eq!(levels(1024, 100, Domain::open([2048; 3])), 1, "of clips nothing was measured");
    }
}
