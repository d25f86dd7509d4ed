//! Random small inputs of this crate's tests.

use selvedge_core::{Domain, Exemplars, Grid, Origin, Rng, Source, Transform};

/// Two sources of up to `shape` with two channels of smooth noise; some axes periodic, the second masked if that is
/// wanted.
pub(crate) fn exemplars(rng: &mut Rng, shape: [u32; 2], masked: bool) -> Exemplars<2> {
    let source = |exemplar: u16, rng: &mut Rng| {
        let domain = Domain { shape, periodic: [rng.below(3) == 0, rng.below(3) == 0] };
        let mut value = 128_i32;
        let features = (0..domain.len() * 2).map(|_| {
            value = (value + rng.below(61) as i32 - 30).clamp(0, 255);
            value as u8
        });
        let features = Grid::from_vec(domain, 2, features.collect()).unwrap();
        let hole = rng.below(domain.len() as u32 / 8) as usize;
        let valid = (masked && exemplar == 1).then(|| (0..domain.len()).map(|i| i != hole).collect());
        let valid = valid.map(|v| Grid::from_vec(domain, 1, v).unwrap());
        Source { features, valid: valid.map(Into::into), origin: Origin { exemplar, transform: Transform::IDENTITY } }
    };
    let sources = vec![source(0, rng), source(1, rng)];
    Exemplars::from_sources(sources, vec![1, 1 + rng.below(3) as u8]).unwrap()
}

/// An output that neighborhoods of a size fit into, open or periodic.
pub(crate) fn output(rng: &mut Rng, size: u32) -> Domain<2> {
    let mut side = || size + rng.below(14);
    let shape = [side(), side()];
    Domain { shape, periodic: [rng.below(2) == 0, rng.below(2) == 0] }
}
