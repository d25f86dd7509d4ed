//! At how many sizes a map is solved.

use std::sync::Arc;

use selvedge_analysis::{Texture, feature_size_of};
use selvedge_core::{Domain, Exemplars, Source};

use crate::error::Error;
use crate::options::{MOST_LEVELS, Options};
use crate::regions::{LEAST, shortest};

/// The sides that a coarse exemplar has at least: that of 192 samples for which the method's defaults were chosen.
const LEAST_SIDE: u32 = 192;

/// Samples along the largest structures at a coarse level, at least: two light and two dark ones; smaller ones are not
/// seen there, and no longer matched. With 6 a photograph of grass of 20 px took six times as long, and looked no
/// better at twice and at four times its size: the same flowers stood in more of a lattice.
const LEAST_STRUCTURE: u32 = 4;

/// The sides that a coarse exemplar has at most, whatever it shows: at one size, searches of 2048^2 take gigabytes.
const MOST_SIDE: u32 = 1024;

/// How many levels pay off: exemplars whose shortest side is `side`, with structures of so many samples.
pub(crate) fn levels<const D: usize>(side: u32, structure: u32, output: Domain<D>) -> u32 {
    let seen = |level: u32| LEAST_STRUCTURE <= structure >> level || MOST_SIDE < side >> (level - 1);
    let pays = |level: &u32| LEAST_SIDE <= side >> level && seen(*level);
    // Around a side that is not a multiple, the last coarse sample would be half of one that the seam has to make up
    // for.
    let closes = |level: &u32| (0..D).all(|a| !output.periodic[a] || output.shape[a].is_multiple_of(1 << level));
    1 + (1..MOST_LEVELS).take_while(|level| D == 2 && pays(level) && closes(level)).last().unwrap_or(0)
}

/// How many of the levels that were asked for leave something of exemplars whose shortest side is `largest` at most.
pub(crate) fn asked(largest: u32, levels: u32) -> u32 {
    1 + (1..levels.min(MOST_LEVELS)).take_while(|level| 2 * LEAST <= largest >> level).last().unwrap_or(0)
}

/// At how many sizes the map is solved: as asked, while an exemplar is large enough to be halved, and while masks leave
/// most of each source at half the size.
pub(crate) fn sizes<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    measured: &[Texture],
    options: &Options<D>,
) -> Result<u32, Error> {
    if options.free.contains(&false) {
        // What may not move along an axis must not be shifted along it.
        return Ok(1);
    }
    let sides = exemplars.sources().iter().map(|s| shortest(s.domain().shape));
    let largest = sides.max().unwrap_or(0);
    if let Some(levels) = options.levels {
        return whole(exemplars, asked(largest, levels));
    }
    // What is too small has one level whatever it shows.
    if levels(largest, u32::MAX, output) == 1 {
        return Ok(1);
    }
    let (side, structure) = least(exemplars, measured, largest)?;
    whole(exemplars, levels(side, structure, output))
}

/// The least side of the exemplars that count ([`region_sides`](crate::regions::region_sides): not those under half of
/// the largest side), and the least of their largest structures: all of them must be seen.
fn least<const D: usize>(exemplars: &Exemplars<D>, measured: &[Texture], largest: u32) -> Result<(u32, u32), Error> {
    let mut least = (largest, u32::MAX);
    for (number, source) in exemplars.firsts().enumerate() {
        let side = shortest(source.domain().shape);
        if side.saturating_mul(2) < largest {
            continue;
        }
        let known = measured.get(number).map(|t| t.feature_size);
        let measure = || feature_size_of(&source.features, source.valid.as_deref(), exemplars.weights());
        let structure = known.map_or_else(measure, Ok)?;
        least = (least.0.min(side), least.1.min(structure));
    }
    Ok(least)
}

/// So many levels, or fewer: no source may lose more than half of what is valid from one size to the next. A coarse
/// sample is valid only where all are that it stands for, so that a source with a fine mask would vanish without a
/// word.
fn whole<const D: usize>(exemplars: &Exemplars<D>, levels: u32) -> Result<u32, Error> {
    if !exemplars.is_masked() {
        return Ok(levels);
    }
    let valid = |source: &Source<D>| {
        source.valid.as_deref().map_or(source.domain().len(), |v| v.samples().iter().filter(|v| **v).count())
    };
    let mut finer = exemplars.clone();
    for level in 1..levels {
        let coarse = match finer.coarser() {
            Err(selvedge_core::Error::NothingValid) => return Ok(level),
            coarse => coarse?,
        };
        let held = |(fine, coarse): (&Arc<Source<D>>, &Arc<Source<D>>)| valid(fine) <= valid(coarse) << (D + 1);
        if !finer.sources().iter().zip(coarse.sources()).all(held) {
            return Ok(level);
        }
        finer = coarse;
    }
    Ok(levels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_follow_sizes_structures_and_tiling() {
        let open = Domain::open([2048, 2048]);
        for (side, structure, expected) in [
            (192, 100, 1),
            (383, 100, 1),
            (384, 100, 2),
            (1024, 100, 3),
            (4096, 400, 5),
            (1024, 16, 3),
            (1024, 15, 2),
            (1024, 7, 1),
            (1025, 7, 2),
            (4096, 1, 3),
        ] {
            assert_eq!(levels(side, structure, open), expected, "{side} {structure}");
        }
        let tiled = |side| Domain { shape: [side, 2048], periodic: [true, false] };
        assert_eq!([2048, 2046, 2047].map(|side| levels(1024, 100, tiled(side))), [3, 2, 1]);
        assert_eq!(levels(1024, 100, Domain::open([2048; 3])), 1, "of clips nothing was measured");
    }
}
