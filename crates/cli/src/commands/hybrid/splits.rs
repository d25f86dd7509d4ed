//! How blocks were split, for eyes.

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_hybrid::Stats;

use crate::failure::Failure;
use crate::thumbnail::Thumbnail;

/// What pictures of it stand under.
pub(super) const HEADING: &str = "How seams were repaired, and blocks split";
/// Of start blocks, and of those that were split once, twice and more.
const LEVELS: [[u8; 3]; 5] = [[38, 52, 92], [40, 120, 160], [70, 180, 110], [240, 190, 60], [225, 80, 50]];
const CHOSEN: [u8; 3] = [255; 3];
const STOOD: [u8; 3] = [90; 3];

/// Each pixel in the colour of the block that shows there.
pub(super) fn drawn(stats: &Stats, output: Domain<2>) -> Result<Thumbnail, Failure> {
    let color = |laid: u8| match laid {
        Stats::CHOSEN => CHOSEN,
        Stats::STOOD => STOOD,
        level => LEVELS[usize::from(level).min(LEVELS.len() - 1)],
    };
    let mut picture = Grid::try_filled(Domain::open(output.shape), 3, 0)?;
    for c in 0..3 {
        picture.plane_mut(c).iter_mut().zip(&stats.laid).for_each(|(to, &laid)| *to = color(laid)[c]);
    }
    let picture = Plane::new(Role::Color, Samples::U8(picture));
    let caption = "Blocks by how often they were split: blue never, then teal, green, yellow, red four times and more; \
                   white are pixels that were re-synthesised before repair, grey is what stood before";
    Ok(Thumbnail::new(picture, caption))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_and_chosen_pixels_have_colours_of_their_own() {
        let stats = Stats { laid: vec![0, 1, 4, 9, Stats::CHOSEN, Stats::STOOD], ..Stats::default() };
        let Samples::U8(grid) = drawn(&stats, Domain::open([2, 3])).unwrap().picture.samples else { unreachable!() };
        let colors: Vec<[u8; 3]> = grid.domain().positions().map(|at| [0, 1, 2].map(|c| grid.get(c, at))).collect();
        assert_eq!(colors, [LEVELS[0], LEVELS[1], LEVELS[4], LEVELS[4], CHOSEN, STOOD]);
    }
}
