//! Exemplars and runs that several tests share.

use selvedge_core::{Domain, Exemplars, Grid, Plane, Role, Run, Samples, Seed, SourceMap};
use selvedge_graphcut_textures::{Options, Placement, Stats, graphcut};

/// All placements.
pub(crate) const PLACEMENTS: [Placement; 4] = [Placement::Auto, Placement::Random, Placement::Entire, Placement::Sub];

/// Blobs: a texture with structure of about eight samples.
pub(crate) fn blobs<const D: usize>(shape: [u32; D], seed: u64) -> Plane<D> {
    let domain = Domain::open(shape);
    let noise = |at: [u32; D]| {
        let key = at.iter().fold(0_u64, |k, &p| k * 1009 + u64::from(p / 4));
        (Seed(seed).derive("blob", key).0 % 200) as u8
    };
    let fine = |at: [u32; D]| at.iter().map(|p| p * 7 % 5).sum::<u32>() as u8;
    let samples = (0..3).flat_map(|c| domain.positions().map(move |at| noise(at) / (c + 1) + fine(at) * 4)).collect();
    Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 3, samples).unwrap()))
}

/// An exemplar as it is.
pub(crate) fn of<const D: usize>(plane: &Plane<D>) -> Exemplars<D> {
    Exemplars::of(&[std::slice::from_ref(plane)]).unwrap()
}

/// A run that ends with everything covered.
pub(crate) fn weave<const D: usize>(
    e: &Exemplars<D>,
    output: Domain<D>,
    options: &Options<D>,
) -> (SourceMap<D>, Stats<D>) {
    let woven = graphcut(e, output, options, &Run::seeded(3)).unwrap();
    assert!(woven.complete);
    assert_eq!(woven.result.holes(), 0, "{options:?}");
    (woven.result, woven.stats)
}
