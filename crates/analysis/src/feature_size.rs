//! How large the structures of exemplars are.

use selvedge_core::{Exemplars, Grid};
use selvedge_fft_ssd::Error;

use crate::periods::{Period, Strengths, middle};
use crate::reach::{CLOSELY, ROUGHLY};

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
    let mut sizes = exemplars.firsts().map(|s| feature_size_of(&s.features, s.valid.as_deref(), exemplars.weights()));
    sizes.try_fold(1, |size, of_one| Ok(size.max(of_one?)))
}

/// The side of a box that holds the largest structures of a texture, as far as its statistics tell: five times the
/// distance at which samples have lost four fifths of their likeness, or one and a quarter of the strongest
/// [period](crate::periods) if that is longer. At least 1, whatever the size of the texture.
///
/// Distances are measured along the last two axes and their diagonals. The factors were chosen by eye on some fifty
/// textures.
///
/// Of more than 2^18 samples the middle is looked at; where structures fill more than a fourth of its sides, or none is
/// seen, what is twice as large as well, at half the size, and so on (of a clip
/// frames of half the size, as many as before). Of the whole, at a fraction of the size, at least
/// periods are looked for that no middle held. Takes `O(samples)`, and for each look what
/// [`periods`](crate::periods()) takes.
///
/// # Errors
/// Those of [`periods`](crate::periods()).
pub fn feature_size_of<const D: usize>(
    features: &Grid<u8, D>,
    valid: Option<&Grid<bool, D>>,
    weights: &[u8],
) -> Result<u32, Error> {
    Ok(of_largest(features, valid, weights, None)?.max(1))
}

/// The largest structures, 0 if there are none: of them all, or only of periods longer than so many samples.
fn of_largest<const D: usize>(
    features: &Grid<u8, D>,
    valid: Option<&Grid<bool, D>>,
    weights: &[u8],
    longer: Option<u32>,
) -> Result<u32, Error> {
    let samples = features.domain().len();
    let is_whole = samples <= if longer.is_none() { CLOSELY } else { ROUGHLY };
    let (mut size, mut longer) = (0, longer);
    if longer.is_none() || is_whole {
        let part = middle(features, CLOSELY)?;
        let valid = valid.map(|valid| middle(valid, CLOSELY)).transpose()?;
        let side = part.domain().shape.into_iter().min().unwrap_or(0);
        if let Some(strengths) = Strengths::of(&part, valid.as_ref(), weights)? {
            let likeness = if longer.is_none() { 5 * lost_likeness(&strengths) } else { 0 };
            size = likeness.max(of_periods(&strengths, longer.unwrap_or(0))?);
        }
        if is_whole {
            return Ok(size);
        }
        // Of what is larger too little is seen: a few bodies resemble each other by chance.
        if (1..=side / 4).contains(&size) {
            longer = Some(side / 2);
        } else {
            size = 0;
        }
    }
    let (coarse, valid) = (features.coarser()?, valid.map(Grid::<bool, D>::coarser).transpose()?);
    if coarse.domain() == features.domain() {
        // Frames of a clip that are a single sample.
        return Ok(size);
    }
    let coarse = of_largest(&coarse, valid.as_ref(), weights, longer.map(|n| n / 2))?;
    Ok(size.max(coarse.saturating_mul(2)))
}

/// One and a quarter of the strongest period, if it is longer than so many samples (its multiples say nothing new);
/// else 0.
fn of_periods<const D: usize>(strengths: &Strengths<D>, longer: u32) -> Result<u32, Error> {
    let periods = strengths.periods()?;
    let length = |p: &Period<D>| p.vector.iter().map(|&v| i64::from(v).pow(2)).sum::<i64>().isqrt() as u32;
    let strongest = periods.first().filter(|p| STRONG <= p.strength && longer < length(p));
    Ok(strongest.map_or(0, |p| length(p) * 5 / 4))
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
    fn large_exemplars_have_the_sizes_of_small_ones() {
        let hash = |y: u32, x: u32| {
            (y.wrapping_mul(0x9e37_79b9) ^ x.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35) >> 24
        };
        let spots = |size: u32| move |y: u32, x: u32| hash(y / size, x / size) as u8;
        // What is fine is seen in the middle, as it is; what is large, at half the size; no eye tells ten percent.
        assert_eq!(size_of([800, 700], spots(3)), size_of([400, 450], spots(3)));
        let [large, small] = [size_of([800, 700], spots(40)), 2 * size_of([400, 350], spots(20))];
        assert!(large.abs_diff(small) * 10 <= small, "{large} {small}");
        // Dots, farther apart than half of a middle: nothing but their period is large.
        let dots = |y: u32, x: u32| if y % 300 < 8 && x % 300 < 8 { 255 } else { (hash(y, x) % 8) as u8 };
        let size = size_of([1000, 1000], dots);
        assert!((365..=385).contains(&size), "{size}");
        assert_eq!(size_of([900, 900], |y, x| u8::from(y < 30 && x < 30) * 200) % 2, 0, "the middle is flat");
    }

    #[test]
    fn any_exemplar_has_a_size() {
        assert_eq!(size_of([7, 300], |_, _| 9), 1);
        for shape in [[1, 1], [1, 50], [3, 2]] {
            assert!(1 <= size_of(shape, |y, x| (y * 91 + x * 57) as u8), "{shape:?}");
        }
    }
}
