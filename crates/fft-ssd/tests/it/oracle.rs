//! Every engine against the slow definition, on random searches.

use crate::support::{Case, Kind};
use selvedge_core::{Domain, Exemplars, Grid, Origin, Seed, SimdLevel, Source, Transform};
use selvedge_fft_ssd::{Costs, Cover, Engine, Errors, Options, Placement, Positions, Scratch, SsdSearcher, Template};

/// A part of a template, by its start and shape.
type Part<const D: usize> = Option<([u32; D], [u32; D])>;

/// Compares every position of a case, in every way of computing it, with the definition.
#[track_caller]
fn check<const D: usize>(case: &Case<D>, part: Part<D>, scratch: &mut Scratch, costs: &mut Costs<D>) {
    let template = Template::new(case.shape, &case.features);
    let template = case.mask.as_ref().map_or(template, |m| template.masked(m));
    let levels = [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Avx512];
    let direct = levels.map(|simd| Options { simd, engine: Engine::Direct, ..Options::default() });
    // The transforms differ between no vectors, some, and where no spectra may be kept.
    let kept = 1 << 30;
    let fft = [(SimdLevel::Scalar, kept), (SimdLevel::Avx2, kept), (SimdLevel::Avx512, kept), (SimdLevel::Auto, 0)];
    let fft = fft.map(|(simd, cache)| Options { simd, engine: Engine::Fft, cache });
    let mut expected: Option<Vec<_>> = None;
    for options in direct.into_iter().chain(fft) {
        let searcher = SsdSearcher::with_options(&case.exemplars, options).expect("memory suffices");
        let done = match (part, case.placement.cover) {
            (Some((start, part)), Cover::AtLeast(least)) => {
                searcher.search_part(&template, start, part, least, scratch, costs)
            }
            _ => searcher.search(&template, case.placement, scratch, costs),
        };
        done.expect("the case is well formed");
        assert_eq!(scratch.repeated(), 0, "{options:?}");
        let all = costs.sources().iter().enumerate().flat_map(|(number, positions)| {
            let at = move |at: [u32; D]| std::array::from_fn(|axis| positions.first[axis] + at[axis] as i32);
            selvedge_core::Domain::open(positions.shape).positions().map(move |p| (number, at(p)))
        });
        let definition =
            |(number, at)| (number, at, case.definition(number, at).filter(|_| case.stands(number, at, part)));
        let expected = expected.get_or_insert_with(|| all.map(definition).collect());
        assert_eq!(expected.len(), costs.len());
        for &(number, at, definition) in expected.iter() {
            let found = costs.get(number, at).map(|c| (c.error, c.samples));
            assert_eq!(found, definition, "{options:?} at {at:?} of {case:?}");
        }
    }
}

/// A level that the machine lacks is not tested: say so.
#[test]
fn levels_that_this_machine_has() {
    let case = Case::<2>::random(&mut Seed(1).rng(), 9);
    for simd in [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Avx512] {
        let searcher = SsdSearcher::with_options(&case.exemplars, Options { simd, ..Options::default() });
        let used = searcher.expect("memory suffices").simd();
        assert!(used <= simd);
        if used != simd {
            eprintln!("not tested: {simd:?} is not there, {used:?} stands in");
        }
    }
}

/// How many times as many cases as usual: `cargo xtask soak search` sets it.
fn soak() -> u64 {
    std::env::var("SELVEDGE_SOAK").ok().and_then(|times| times.parse().ok()).unwrap_or(1)
}

/// Checks a case of each of these kinds; returns how many candidates each had.
fn check_kinds<const D: usize>(stage: &'static str, kinds: impl Iterator<Item = u64>, side: u32) -> Vec<u64> {
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    let mut candidates = vec![0; Kind::COUNT as usize];
    for i in kinds {
        let case = Case::<D>::of(Kind::nth(i), &mut Seed(1).derive(stage, i).rng(), side);
        check(&case, None, &mut scratch, &mut costs);
        candidates[(i % Kind::COUNT) as usize] += costs.iter().count() as u64;
    }
    candidates
}

/// Checks all kinds so many times. Where the template fits into no source nothing is compared, but not in all cases of
/// a sort.
fn check_all<const D: usize>(stage: &'static str, times: u64, side: u32) {
    let candidates = check_kinds::<D>(stage, 0..soak() * times * Kind::COUNT, side);
    let compared = |of: &dyn Fn(Kind) -> bool| {
        let numbers = candidates.iter().zip(0..).filter(|&(_, i)| of(Kind::nth(i)));
        numbers.map(|(n, _)| n).sum::<u64>()
    };
    for kind in (0..Kind::COUNT).map(Kind::nth) {
        assert_ne!(compared(&|k| (k.positions, k.region) == (kind.positions, kind.region)), 0, "{kind:?}");
        assert_ne!(compared(&|k| (k.sides, k.channels) == (kind.sides, kind.channels)), 0, "{kind:?}");
    }
}

#[test]
fn lines() {
    check_all::<1>("lines", 1, 64);
}

#[test]
fn small_pictures() {
    check_all::<2>("small pictures", 3, 16);
}

#[test]
fn pictures() {
    check_all::<2>("pictures", 1, 36);
}

#[test]
fn large_pictures() {
    // 113 has no factor in common with the number of kinds: the channels, regions and sides of all these differ.
    check_kinds::<2>("large pictures", (0..soak() * 100).map(|i| i * 113), 64);
}

#[test]
fn clips() {
    check_all::<3>("clips", 2, 7);
}

#[test]
fn longer_clips() {
    check_all::<3>("longer clips", 1, 12);
}

/// Errors fit 32 bits up to 258 samples with weights of 256 in all, and up to 22,017 with three of 1.
#[test]
fn the_border_between_32_and_64_bits() {
    for (weights, samples) in [(vec![77, 150, 29], 258), (vec![1, 1, 1], 22_017)] {
        for wide in [false, true] {
            let n = samples + u32::from(wide);
            let (domain, channels) = (Domain::open([2, n + 3]), weights.len());
            let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
            let features = Grid::try_filled(domain, channels, 0).expect("memory suffices");
            let source = Source { features, valid: None, origin };
            let exemplars = Exemplars::from_sources(vec![source], weights.clone()).expect("one source");
            let white = vec![255; channels * n as usize];
            for simd in [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Avx512] {
                for engine in [Engine::Direct, Engine::Fft] {
                    let options = Options { simd, engine, ..Options::default() };
                    let searcher = SsdSearcher::with_options(&exemplars, options).expect("memory suffices");
                    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
                    let template = Template::new([1, n], &white);
                    searcher.search(&template, Placement::INSIDE, &mut scratch, &mut costs).expect("it fits");
                    assert_eq!(matches!(costs.errors(0), Errors::Wide(_)), wide, "{n} samples");
                    let error = u64::from(n) * 255 * 255 * weights.iter().map(|&w| u64::from(w)).sum::<u64>();
                    assert!(costs.len() == 8 && costs.iter().all(|c| c.error == error), "{options:?}");
                }
            }
        }
    }
}

/// Searches by a part have the positions at which that part lies inside.
fn check_parts<const D: usize>(stage: &'static str, cases: u64, side: u32) {
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    for i in 0..cases {
        let mut rng = Seed(1).derive(stage, i).rng();
        let mut case = Case::<D>::random(&mut rng, side);
        case.placement = Placement { positions: Positions::Inside, cover: Cover::AtLeast(u64::from(rng.below(9))) };
        let start = case.shape.map(|n| rng.below(n));
        let part: [u32; D] = std::array::from_fn(|a| 1 + rng.below(case.shape[a] - start[a]));
        check(&case, Some((start, part)), &mut scratch, &mut costs);
        for (source, found) in case.exemplars.sources().iter().zip(costs.sources()) {
            for a in 0..D {
                let (n, wraps) = (source.domain().shape[a], source.domain().periodic[a]);
                let expected = if wraps { (0, n) } else { (-(start[a] as i32), (n + 1).saturating_sub(part[a])) };
                assert_eq!((found.first[a], found.shape[a]), expected);
            }
        }
    }
}

#[test]
fn parts_of_lines_pictures_and_clips() {
    check_parts::<1>("parts of lines", 200, 40);
    check_parts::<2>("parts of pictures", 600, 16);
    check_parts::<3>("parts of clips", 200, 7);
}

#[test]
fn a_part_lies_inside_its_template() {
    let case = Case::<2>::random(&mut Seed(1).rng(), 9);
    let searcher = SsdSearcher::new(&case.exemplars).expect("memory suffices");
    let template = Template::new(case.shape, &case.features);
    for (start, part) in [([0, 0], [1, 0]), ([0, 0], [case.shape[0] + 1, 1]), ([0, u32::MAX], [1, 2])] {
        let found = searcher.search_part(&template, start, part, 1, &mut Scratch::new(), &mut Costs::new());
        assert!(matches!(found, Err(selvedge_fft_ssd::Error::Part { .. })), "{found:?}");
    }
}
