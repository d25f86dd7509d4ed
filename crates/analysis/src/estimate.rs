//! How much memory an analysis takes.

use selvedge_core::{Bytes, Domain};
use selvedge_fft_ssd::{Holdings, Options};

use crate::lattice::Lattice;
use crate::picture::{cells, frame};
use crate::reach::{CLOSELY, Reach, SAMPLES, shape_of_middle, sizes_held};

/// What is as large whatever the picture is: its cells, which are at most 200 a side.
const CELLS: Bytes = Bytes(3 << 20);
/// Plans of transforms, and lists of periods.
const A_SEARCH: Bytes = Bytes(1 << 20);

/// An upper bound of the bytes that an analysis of a texture of this size holds beside its features,
/// [`Texture`](crate::Texture) or any other: no more than 2^20 samples are looked at closely.
pub fn estimate<const D: usize>(domain: Domain<D>, channels: usize, masked: bool) -> Bytes {
    in_middle(domain, channels, masked, SAMPLES).max(estimate_texture(domain, channels, masked))
}

/// That of [`Texture`](crate::Texture) alone: no more than 2^18 samples are looked at closely.
pub fn estimate_texture<const D: usize>(domain: Domain<D>, channels: usize, masked: bool) -> Bytes {
    let (_, cells) = cells(frame(domain));
    let moved = searched(cells, channels, (true, masked), Lattice::reach(cells));
    estimate_size(domain, channels, masked).then(moved + CELLS)
}

/// That of [`feature_size_of`](crate::feature_size_of) alone: no more than 2^18 samples are looked at closely, and the
/// whole is halved.
pub fn estimate_size<const D: usize>(domain: Domain<D>, channels: usize, masked: bool) -> Bytes {
    let each = channels as u64 + u64::from(masked);
    let halves = if is_seen_whole(domain) { Bytes(0) } else { Bytes::of_samples(domain, each) };
    in_middle(domain, channels, masked, CLOSELY) + halves
}

fn is_seen_whole<const D: usize>(domain: Domain<D>) -> bool {
    Bytes::of_samples(domain, 1).0 <= CLOSELY as u64
}

/// A look at a middle of at most so many samples.
fn in_middle<const D: usize>(domain: Domain<D>, channels: usize, masked: bool, most: usize) -> Bytes {
    let middle = Domain::open(shape_of_middle(domain.shape, most));
    let copied = channels as u64 + u64::from(masked);
    let searched = searched(middle, channels, (masked, masked), Reach::half(middle));
    A_SEARCH + searched + Bytes::of_samples(middle, copied)
}

/// What moving a texture over itself takes, with holes or not, of any shape or not.
fn searched<const D: usize>(domain: Domain<D>, channels: usize, holes: (bool, bool), reach: Reach<D>) -> Bytes {
    let weights = vec![u8::MAX; channels];
    let held = sizes_held(domain, &weights, holes, reach, &Options::default());
    held.map_or(Bytes::MOST, |Holdings { tables, spectra, working }| tables + spectra + working)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Texture, feature_size_of};
    use selvedge_core::{Grid, Seed};
    use selvedge_testkit::memory;

    const TEST: &str = "estimate::tests::analyses_stay_within_their_estimate";

    /// Height and width, whether there is a mask, weights as they are or as the eye has them, and whether all of the
    /// texture is asked for.
    fn cases() -> Vec<([u32; 2], bool, [u8; 3], bool)> {
        let (even, eye) = ([1; 3], [54, 183, 18]);
        vec![
            ([96, 96], false, even, true),
            ([192, 192], false, even, false),
            ([192, 192], false, even, true),
            ([192, 192], true, eye, true),
            ([300, 420], true, even, false),
            ([512, 512], false, even, true),
            ([512, 512], false, eye, false),
            ([1000, 800], false, eye, false),
            ([1000, 800], false, even, true),
            ([1500, 1100], false, even, false),
        ]
    }

    #[test]
    fn analyses_stay_within_their_estimate() {
        let cases = cases();
        let measure = |number: usize| {
            let (shape, masked, weights, whole) = cases[number];
            let (domain, mut rng) = (Domain::open(shape), Seed(1).rng());
            let samples = (0..3 * domain.len()).map(|_| rng.below(256) as u8).collect();
            let features = Grid::from_vec(domain, 3, samples).unwrap();
            let valid = domain.positions().map(|[y, x]| !(30..60).contains(&y) || !(20..70).contains(&x)).collect();
            let valid = masked.then(|| Grid::from_vec(domain, 1, valid).unwrap());
            let before = memory::held();
            if whole {
                Texture::of(&features, valid.as_ref(), &weights).unwrap();
            } else {
                feature_size_of(&features, valid.as_ref(), &weights).unwrap();
            }
            memory::tell(before);
        };
        let check = |number: usize, held: u64| {
            let (shape, masked, _, whole) = cases[number];
            let estimate = if whole { estimate_texture } else { estimate_size };
            let told = estimate(Domain::open(shape), 3, masked).0;
            println!("{:.2} case {number}: held {held}, estimated {told}", told as f64 / held as f64);
            assert!(held <= told && told <= held * 3 / 2 + (8 << 20), "case {number}: held {held}, estimated {told}");
        };
        memory::of_each(TEST, cases.len(), measure, check);
    }
}
