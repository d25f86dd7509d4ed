//! Every engine against the slow definition, on random searches.

mod support;

use selvedge_core::{Seed, SimdLevel};
use selvedge_fft_ssd::{Costs, Engine, Options, Scratch, SsdSearcher, Template};
use support::Case;

/// Compares every position of a case, in every way of computing it, with the definition.
#[track_caller]
fn check<const D: usize>(case: &Case<D>, scratch: &mut Scratch, costs: &mut Costs<D>) {
    let template = Template::new(case.shape, &case.features);
    let template = case.mask.as_ref().map_or(template, |m| template.masked(m));
    let levels = [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Avx512];
    let direct = levels.map(|simd| Options { simd, engine: Engine::Direct, ..Options::default() });
    // The transforms differ between no vectors, some, and where no spectra may be kept.
    let fft = [(SimdLevel::Scalar, 1 << 30), (SimdLevel::Avx2, 1 << 30), (SimdLevel::Auto, 0)];
    let fft = fft.map(|(simd, cache)| Options { simd, engine: Engine::Fft, cache });
    for options in direct.into_iter().chain(fft) {
        let searcher = SsdSearcher::with_options(&case.exemplars, options).expect("memory suffices");
        searcher.search(&template, case.placement, scratch, costs).expect("the case is well formed");
        assert_eq!(scratch.repeated(), 0, "{options:?}");
        for (number, positions) in costs.sources().iter().enumerate() {
            let domain = selvedge_core::Domain::open(positions.shape);
            for at in domain.positions() {
                let position = std::array::from_fn(|axis| positions.first[axis] + at[axis] as i32);
                let found = costs.get(number, position).map(|c| (c.error, c.samples));
                assert_eq!(found, case.definition(number, position), "{options:?} at {position:?} of {case:?}");
            }
        }
    }
}

fn check_many<const D: usize>(stage: &'static str, cases: u64, side: u32) {
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    for i in 0..cases {
        check(&Case::<D>::random(&mut Seed(1).derive(stage, i).rng(), side), &mut scratch, &mut costs);
    }
}

#[test]
fn lines() {
    check_many::<1>("lines", 500, 64);
}

#[test]
fn small_pictures() {
    check_many::<2>("small pictures", 3000, 16);
}

#[test]
fn pictures() {
    check_many::<2>("pictures", 100, 64);
}

#[test]
fn clips() {
    check_many::<3>("clips", 1400, 7);
}
