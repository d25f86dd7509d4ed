//! Every engine against the slow definition, on random searches.

mod support;

use selvedge_core::{Seed, SimdLevel};
use selvedge_fft_ssd::{Costs, Options, Scratch, SsdSearcher, Template};
use support::Case;

/// Compares every position of a case, in every way of computing it, with the definition.
#[track_caller]
fn check<const D: usize>(case: &Case<D>, scratch: &mut Scratch, costs: &mut Costs<D>) {
    let template = Template::new(case.shape, &case.features);
    let template = case.mask.as_ref().map_or(template, |m| template.masked(m));
    let levels = [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Avx512];
    for options in levels.map(|simd| Options { simd, ..Options::default() }) {
        let searcher = SsdSearcher::with_options(&case.exemplars, options).expect("memory suffices");
        searcher.search(&template, case.placement, scratch, costs).expect("the case is well formed");
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
