//! How large the structures of exemplars are.

use selvedge_core::{Exemplars, Grid};
use selvedge_fft_ssd::Error;

use crate::periods::Strengths;

/// A period counts from this strength on (of 1000): weaker ones are chance resemblances of a few large features.
const STRONG: u32 = 300;
/// Samples are unlike each other from this strength down: four fifths of their likeness are lost. A level of 0 would be
/// passed late, or never, where light is uneven. Chosen by eye, with the factors of [`feature_size_of`].
const UNLIKE: i64 = 200;

/// The side of a box that holds the largest structures of some exemplars: the largest
/// [`feature_size_of`] them. Of an exemplar in several orientations the first counts.
///
/// # Errors
/// [`Error::Core`] if memory is short.
pub fn feature_size<const D: usize>(exemplars: &Exemplars<D>) -> Result<u32, Error> {
    let mut sizes = exemplars.firsts().map(|s| feature_size_of(&s.features, s.valid.as_ref(), exemplars.weights()));
    sizes.try_fold(1, |size, of_one| Ok(size.max(of_one?)))
}

/// The side of a box that holds the largest structures of a texture, as far as its statistics tell: five times the
/// distance at which samples have lost four fifths of their likeness, or one and a quarter of the strongest
/// [period](crate::periods) if that is longer. At least 1, whatever the size of the texture.
///
/// Distances are measured along the last two axes and their diagonals. The factors were chosen by eye on some fifty
/// textures. Takes what [`periods`](crate::periods()) takes.
///
/// # Errors
/// Those of [`periods`](crate::periods()).
pub fn feature_size_of<const D: usize>(
    features: &Grid<u8, D>,
    valid: Option<&Grid<bool, D>>,
    weights: &[u8],
) -> Result<u32, Error> {
    Strengths::of(features, valid, weights)?.map_or(Ok(1), |strengths| of_strengths(&strengths))
}

/// See [`feature_size_of`].
pub(crate) fn of_strengths<const D: usize>(strengths: &Strengths<D>) -> Result<u32, Error> {
    let size = 5 * lost_likeness(strengths);
    let periods = strengths.periods()?;
    let Some(strongest) = periods.first().filter(|p| STRONG <= p.strength) else { return Ok(size) };
    let squared: i64 = strongest.vector.iter().map(|&v| i64::from(v).pow(2)).sum();
    Ok(size.max(squared.isqrt() as u32 * 5 / 4))
}

/// The distance from which on samples are unlike each other, in the mean over the directions; at most half the
/// exemplar.
pub(crate) fn lost_likeness<const D: usize>(strengths: &Strengths<D>) -> u32 {
    let along = |y: i32, x: i32| {
        let mut vector = [0; D];
        vector[D - 1] = x;
        if 2 <= D {
            vector[D - 2] = y;
        }
        strengths.at(vector)
    };
    let mean = |d: u32| {
        // The diagonal of a square of side d / sqrt(2), rounded.
        let (d, s) = (d as i32, ((2 * d * d).isqrt().div_ceil(2) as i32).max(1));
        let directions = if D == 1 { vec![(0, d)] } else { vec![(0, d), (d, 0), (s, s), (s, -s)] };
        let found: Vec<i64> = directions.into_iter().filter_map(|(y, x)| along(y, x)).collect();
        (!found.is_empty()).then(|| found.iter().sum::<i64>() / found.len() as i64)
    };
    (1..).find(|&d| mean(d).is_none_or(|strength| strength < UNLIKE)).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Origin, Source, Transform};

    fn size_of(shape: [u32; 2], at: impl Fn(u32, u32) -> u8) -> u32 {
        let domain = Domain::open(shape);
        let samples = domain.positions().map(|[y, x]| at(y, x)).collect();
        let features = Grid::from_vec(domain, 1, samples).expect("right length");
        let source = Source { features, valid: None, origin: Origin { exemplar: 0, transform: Transform::IDENTITY } };
        feature_size(&Exemplars::from_sources(vec![source], vec![1]).expect("well formed")).expect("memory suffices")
    }

    #[test]
    fn periods_and_spots_have_a_size() {
        // Dots on a lattice of 32 samples; between them nothing.
        let dots = |y: u32, x: u32| if y % 32 < 4 && x % 32 < 4 { 255 } else { 0 };
        assert_eq!(size_of([160, 160], dots), 40);
        let hash = |y: u32, x: u32| {
            (y.wrapping_mul(0x9e37_79b9) ^ x.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35) >> 24
        };
        let spots = |size: u32| move |y: u32, x: u32| hash(y / size, x / size) as u8;
        let (fine, coarse) = (size_of([200, 200], spots(2)), size_of([200, 200], spots(14)));
        assert!(fine < 16 && (50..=80).contains(&coarse), "{fine} {coarse}");
    }

    #[test]
    fn any_exemplar_has_a_size() {
        assert_eq!(size_of([7, 300], |_, _| 9), 1);
        for shape in [[1, 1], [1, 50], [3, 2]] {
            assert!(1 <= size_of(shape, |y, x| (y * 91 + x * 57) as u8), "{shape:?}");
        }
    }
}
