//! A block size for an exemplar.

use selvedge_analysis::feature_size_of;
use selvedge_core::{Exemplars, Source, try_vec};

use crate::options::Error;

/// Blocks are three eighths of the largest square free of masked samples, but no more than four times the
/// [`feature_size_of`] the exemplar.
///
/// Ranked blind, such blocks are preferred to any that follow the statistics of structures more closely: few textures
/// have structures so small that smaller blocks keep them whole. Of fine textures four times the largest structures are
/// as good, and more of the exemplar is mixed. Of several exemplars the one of the smallest such square counts, but
/// those under half of the largest do not count: an exemplar too small for the others' blocks is passed over. The paper
/// leaves the block to the user. `[Efros01 2.2]`
///
/// # Errors
/// No memory for the search of periods.
pub fn suggest_block(exemplars: &Exemplars<2>) -> Result<u32, Error> {
    let weights = exemplars.weights();
    let sides = exemplars.sources().iter().map(|source| largest_square(source)).collect::<Result<Vec<u32>, Error>>()?;
    let largest = sides.iter().copied().max().unwrap_or(1);
    let counts = |side: u32| largest <= side.saturating_mul(2);
    let shorter = sides.iter().copied().filter(|&side| counts(side)).min().unwrap_or(1).max(1);
    let mut structure = 0;
    for (source, _) in exemplars.sources().iter().zip(&sides).filter(|&(_, &side)| counts(side)) {
        structure = structure.max(feature_size_of(&source.features, source.valid.as_deref(), weights)?);
    }
    if structure <= FLAT {
        return Ok(largest_block(shorter));
    }
    Ok(largest_block(shorter).min(structure.saturating_mul(STRUCTURES)).max(shorter.min(LEAST)))
}

/// A block holds no more than so many times the largest structures: of fine textures larger blocks are no better.
const STRUCTURES: u32 = 4;
/// What has so small structures has none at all: every block shows all of it, and the largest ones are the fewest.
const FLAT: u32 = 1;
/// Smaller blocks hold nothing that could be matched.
const LEAST: u32 = 4;

/// No block that is suggested is larger, for exemplars of so large a square.
pub(crate) fn largest_block(square: u32) -> u32 {
    (square * 3 / 8).max(square.min(LEAST))
}

/// Side of the largest square of a source without a masked sample.
fn largest_square(source: &Source<2>) -> Result<u32, Error> {
    let [height, width] = source.domain().shape;
    let Some(valid) = &source.valid else { return Ok(height.min(width)) };
    let mut largest = 0;
    // Sides of the largest squares that end at each sample of the row above, then of this one.
    let mut sides = try_vec(width as usize + 1, 0_u32)?;
    for row in valid.plane(0).chunks(width.max(1) as usize) {
        let mut above_left = 0;
        for (x, &valid) in row.iter().enumerate() {
            let above = sides[x + 1];
            sides[x + 1] = if valid { 1 + above.min(above_left).min(sides[x]) } else { 0 };
            (above_left, largest) = (above, largest.max(sides[x + 1]));
        }
    }
    Ok(largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Plane, Role, Samples};

    fn block_for(shape: [u32; 2], at: impl Fn(u32, u32) -> u8) -> u32 {
        let domain = Domain::open(shape);
        let samples = domain.positions().map(|[y, x]| at(y, x)).collect();
        let plane = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 1, samples).unwrap()));
        suggest_block(&Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap()).unwrap()
    }

    #[test]
    fn a_block_holds_a_period() {
        // Dots on a lattice of 32 samples; between them nothing.
        let dots = |y: u32, x: u32| if y % 32 < 4 && x % 32 < 4 { 255 } else { 0 };
        assert_eq!(block_for([160, 160], dots), 60);
    }

    #[test]
    fn of_what_is_flat_blocks_are_large() {
        assert_eq!(block_for([192, 192], |_, _| 90), 72);
        assert!(block_for([192, 192], |y, x| ((y * 31 + x * 17) % 3) as u8) < 72);
    }

    #[test]
    fn a_block_holds_large_structures() {
        let hash = |y: u32, x: u32| {
            (y.wrapping_mul(0x9e37_79b9) ^ x.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35) >> 24
        };
        let spots = |size: u32| move |y: u32, x: u32| hash(y / size, x / size) as u8;
        let (fine, coarse) = (block_for([200, 200], spots(2)), block_for([200, 200], spots(14)));
        assert!((20..60).contains(&fine), "{fine}");
        assert_eq!(coarse, 75, "three eighths");
    }

    /// An exemplar of noise, of which some samples may be used.
    fn masked(shape: [u32; 2], valid: impl Fn(u32, u32) -> bool) -> Source<2> {
        let domain = Domain::open(shape);
        let samples = domain.positions().map(|[y, x]| (y * 31 + x * 57 + y * x) as u8).collect();
        let valid = domain.positions().map(|[y, x]| valid(y, x)).collect();
        Source {
            features: Grid::from_vec(domain, 1, samples).unwrap(),
            valid: Some(Grid::from_vec(domain, 1, valid).unwrap().into()),
            origin: selvedge_core::Origin { exemplar: 0, transform: selvedge_core::Transform::IDENTITY },
        }
    }

    #[test]
    fn a_block_that_is_chosen_can_be_laid() {
        // A lattice of masked lines leaves squares of 12 samples.
        let lattice = masked([100, 100], |y, x| y % 13 != 0 && x % 13 != 0);
        assert_eq!(largest_square(&lattice).unwrap(), 12);
        assert_eq!(largest_square(&masked([5, 9], |y, x| (y, x) != (2, 4))).unwrap(), 4);
        assert_eq!(largest_square(&masked([5, 9], |_, _| true)).unwrap(), 5);
        let exemplars = Exemplars::from_sources(vec![lattice], vec![1]).unwrap();
        let options = crate::Options::default();
        let run = selvedge_core::Run::seeded(1);
        let woven = crate::quilt(&exemplars, Domain::open([40, 40]), &options, &run).unwrap();
        assert!((1..=12).contains(&woven.stats.block), "{}", woven.stats.block);
    }

    #[test]
    fn a_tiny_exemplar_beside_a_large_one_does_not_count() {
        let (large, tiny) = (masked([100, 120], |_, _| true), masked([9, 200], |_, _| true));
        let block =
            |sources: Vec<Source<2>>| suggest_block(&Exemplars::from_sources(sources, vec![1]).unwrap()).unwrap();
        assert_eq!(block(vec![large.clone(), tiny]), block(vec![large]));
    }

    #[test]
    fn small_and_flat_exemplars_have_blocks_that_fit() {
        for shape in [[1, 1], [1, 50], [3, 2], [7, 300], [64, 64]] {
            let block = block_for(shape, |_, _| 9);
            assert!((1..=shape[0].min(shape[1])).contains(&block), "{shape:?} {block}");
        }
    }
}
