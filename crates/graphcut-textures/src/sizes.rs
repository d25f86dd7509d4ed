//! At how many sizes a map is solved.

use std::sync::Arc;

use selvedge_analysis::{Texture, feature_size_of};
use selvedge_core::{Domain, Exemplars, Source};

use crate::error::Error;
use crate::options::{MOST_LEVELS, Options};
use crate::regions::{CLIP, LEAST, shortest};

/// The sides that a coarse exemplar has at least: that of 192 samples for which the method's defaults were chosen.
const LEAST_SIDE: u32 = 192;

/// Samples along the largest structures at a coarse level, at least: two light and two dark ones; smaller ones are not
/// seen there, and no longer matched. With 6 a photograph of grass of 20 px took six times as long, and looked no
/// better at twice and at four times its size: the same flowers stood in more of a lattice.
const LEAST_STRUCTURE: u32 = 4;

/// The same of a clip's frames, which can be this small: when patches change is seen at any size, where in a frame they
/// do is found again. At 18 samples a candle's seams cost a third more, at 24 a fire's less than those of one size.
const LEAST_FRAME: u32 = 24;

/// Samples that regions of a clip have along each side of a frame at a coarse level, at least. With 7 a river's seams
/// cost a sixth less than at one size; with 6 a fire's, and with 4 a flame's, cost 4 and 19 % more than with 12 and 8.
const LEAST_REGION: u32 = 7;

/// The sides that a coarse exemplar has at most, whatever it shows: at one size, searches of 2048^2 take gigabytes.
const MOST_SIDE: u32 = 1024;

/// How many levels pay off: exemplars whose shortest side is `side`, with structures of so many samples; of clips the
/// shortest sides of frames and of regions.
pub(crate) fn levels<const D: usize>(side: u32, structure: u32, output: Domain<D>) -> u32 {
    let seen = |level: u32| LEAST_STRUCTURE <= structure >> level || MOST_SIDE < side >> (level - 1);
    let pays = |level: &u32| match D {
        CLIP => LEAST_FRAME <= side >> level && LEAST_REGION <= structure >> level,
        _ => LEAST_SIDE <= side >> level && seen(*level),
    };
    // Around a side that is not a multiple, the last coarse sample would be half of one that the seam has to make up
    // for.
    let is_multiple = |a: usize, level: u32| output.shape[a].is_multiple_of(1 << level);
    let closes = |level: &u32| (0..D).all(|a| !output.periodic[a] || !Domain::<D>::halves(a) || is_multiple(a, *level));
    1 + (1..MOST_LEVELS).take_while(|level| 2 <= D && pays(level) && closes(level)).last().unwrap_or(0)
}

/// Whether a source that cannot be moved along some axes covers the output at a level: of an odd side it leaves out a
/// sample there, where the output has one more.
fn covers<const D: usize>(free: [bool; D], output: Domain<D>, level: u32) -> bool {
    (0..D).all(|a| free[a] || !Domain::<D>::halves(a) || output.shape[a].is_multiple_of(1 << level))
}

/// So many levels, or as many as sources cover the output at.
pub(crate) fn covered<const D: usize>(free: [bool; D], output: Domain<D>, levels: u32) -> u32 {
    1 + (1..levels).take_while(|&level| covers(free, output, level)).count() as u32
}

/// The shortest side of a clip's regions in space from which on there may be more than so many levels.
pub(crate) fn larger_region(levels: u32) -> u32 {
    LEAST_REGION << levels
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
    (measured, region): (&[Texture], [u32; D]),
    options: &Options<D>,
) -> Result<u32, Error> {
    let sides = exemplars.sources().iter().map(|s| shortest(s.domain().shape));
    let largest = sides.max().unwrap_or(0);
    let most = match options.levels {
        Some(levels) => asked(largest, levels),
        // What is too small has one level whatever it shows.
        None if levels(largest, u32::MAX, output) == 1 => 1,
        None => {
            let bound = std::array::from_fn(|a| if options.free[a] { region[a] } else { output.shape[a] });
            let (side, structure) = least(exemplars, (measured, bound), largest)?;
            levels(side, structure, output)
        }
    };
    whole(exemplars, covered(options.free, output, most))
}

/// The least side of the exemplars that count ([`region_sides`](crate::regions::region_sides): not those under half of
/// the largest side), and the least of their largest structures: all of them must be seen. Of clips the least side of
/// frames, and of regions.
fn least<const D: usize>(
    exemplars: &Exemplars<D>,
    (measured, region): (&[Texture], [u32; D]),
    largest: u32,
) -> Result<(u32, u32), Error> {
    let mut least = (largest, u32::MAX);
    for (number, source) in exemplars.firsts().enumerate() {
        let side = shortest(source.domain().shape);
        if side.saturating_mul(2) < largest {
            continue;
        }
        let known = if D == CLIP { Some(shortest(region)) } else { measured.get(number).map(|t| t.feature_size) };
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
    // A coarse sample stands for two along each axis that halves.
    let halved = (0..D).filter(|&a| Domain::<D>::halves(a)).count();
    let mut finer = exemplars.clone();
    for level in 1..levels {
        let coarse = match finer.coarser() {
            Err(selvedge_core::Error::NothingValid) => return Ok(level),
            coarse => coarse?,
        };
        let held = |(fine, coarse): (&Arc<Source<D>>, &Arc<Source<D>>)| valid(fine) <= valid(coarse) << (halved + 1);
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
    use selvedge_core::{Grid, Origin, Transform};

    #[test]
    fn masks_leave_half_of_a_picture_and_of_a_clip() {
        // Of blocks of 2x2 pixels so many in 16 have a hole.
        fn kept<const D: usize>(shape: [u32; D], holed: u32) -> u32 {
            let domain = Domain::open(shape);
            let block = |at: [u32; D]| (at[D - 2] / 2 * 4 + at[D - 1] / 2) % 16;
            let hole = |at: [u32; D]| at[D - 2..].iter().all(|p| p.is_multiple_of(2)) && block(at) < holed;
            let valid = domain.positions().map(|at| !hole(at)).collect();
            let valid = Some(Grid::from_vec(domain, 1, valid).unwrap().into());
            let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
            let source = Source { features: Grid::try_filled(domain, 1, 7).unwrap(), valid, origin };
            whole(&Exemplars::from_sources(vec![source], vec![1]).unwrap(), 2).unwrap()
        }
        // Of 8 in 16 there are 112 samples of 128, 64 of them in whole blocks; of 11 in 16 106 and 40.
        assert_eq!([kept([16, 8], 8), kept([16, 8], 11)], [2, 1]);
        assert_eq!([kept([3, 16, 8], 8), kept([3, 16, 8], 11)], [2, 1]);
    }

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
        // Of clips by frames and regions, whatever tiles in time.
        let clip = |shape, periodic| Domain { shape, periodic };
        let looped = [true, false, false];
        for (side, region, output, expected) in [
            (144, 144, clip([121, 144, 144], looped), 3),
            (116, 29, clip([100, 160, 210], looped), 3),
            (116, 23, clip([100, 160, 210], looped), 2),
            (116, 29, clip([100, 162, 210], [true; 3]), 2),
            (47, 47, clip([20, 47, 60], looped), 1),
        ] {
            assert_eq!(levels(side, region, output), expected, "{side} {region} {output:?}");
        }
    }
}
