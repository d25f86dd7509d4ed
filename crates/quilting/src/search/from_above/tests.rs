//! What is found from above: its errors are true, and near the least of all.

use super::*;
use crate::search::Space;
use selvedge_core::{Domain, Grid, Origin, Plane, Rng, Role, Samples, Seed, Source, Transform};
use selvedge_fft_ssd::Template;

/// Smooth noise: structures of some twenty samples, finer ones upon them.
fn noise(rng: &mut Rng, shape: [u32; 2]) -> Plane<2> {
    let domain = Domain::open(shape);
    let keys: Vec<u64> = (0..3).map(|_| rng.below_u64(1 << 40)).collect();
    let samples = keys.iter().flat_map(|&key| {
        let value = move |y: u32, x: u32, cell: u32| {
            let corner = |y: u32, x: u32| {
                f64::from((Seed(key).derive("noise", u64::from((y * 999 + x) * 64 + cell)).0 % 256) as u8)
            };
            let (fy, fx) = (f64::from(y % cell) / f64::from(cell), f64::from(x % cell) / f64::from(cell));
            let [y, x] = [y / cell, x / cell];
            let row = |y: u32| corner(y, x) * (1.0 - fx) + corner(y, x + 1) * fx;
            row(y) * (1.0 - fy) + row(y + 1) * fy
        };
        domain
            .positions()
            .map(move |[y, x]| (0.6 * value(y, x, 21) + 0.3 * value(y, x, 8) + 0.1 * value(y, x, 2)) as u8)
    });
    Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 3, samples.collect()).unwrap()))
}

/// An overlap above and left of a block, cut out of another place each.
fn overlap(rng: &mut Rng, e: &Exemplars<2>, side: u32, width: u32) -> (Vec<u8>, Vec<bool>) {
    let features = &e.sources()[0].features;
    let [h, w] = features.domain().shape;
    let [above, left] = [(); 2].map(|()| [rng.below(h - side), rng.below(w - side)]);
    let at = |[y, x]: [u32; 2]| if y < width { [above[0] + y, above[1] + x] } else { [left[0] + y, left[1] + x] };
    let block = Domain::open([side; 2]);
    let samples = (0..3).flat_map(|c| block.positions().map(move |p| features.get(c, at(p)))).collect();
    (samples, block.positions().map(|[y, x]| y < width || x < width).collect())
}

#[test]
fn the_least_error_from_above_is_near_the_least_of_all() {
    let (mut near, mut all) = (0, 0);
    for case in 0..50 {
        let mut rng = Seed(case).derive("above", 0).rng();
        let plane = noise(&mut rng, [220, 260]);
        let e = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let reduced = Reduced::times(&e, 2).unwrap();
        let fast = FromAbove::new(&e, &reduced, None, SimdLevel::Auto).unwrap().unwrap();
        let exact = BlockSearch::new(&e, None, SimdLevel::Auto).unwrap();
        for _ in 0..3 {
            let (features, mask) = overlap(&mut rng, &e, 60, 17);
            let template = Template::new([60; 2], &features).masked(&mask);
            let terms = [Term { space: Space::Texture, template, weight: 1 }];
            let (mut a, mut b) = (AboveScratch::default(), BlockScratch::default());
            let found = fast.near(&terms, &|_| 0, &|_, _| false, &mut a).unwrap()[0];
            let least = exact.near(&terms, &|_| 0, &|_, _| false, &mut b).unwrap()[0];
            assert!(least.error <= found.error, "errors are true");
            (near, all) = (near + u32::from(found.error * 20 <= least.error * 21), all + 1);
        }
    }
    assert!(all * 19 <= near * 20, "{near} of {all} within a twentieth");
}

/// What a block of a transfer agrees with: its overlap, what lies under it, and a guide of its luminance.
fn of_transfer(rng: &mut Rng, e: &Exemplars<2>, side: u32, is_first: bool) -> Vec<(Space, Vec<u8>, Vec<bool>, u64)> {
    let features = &e.sources()[0].features;
    let [h, w] = features.domain().shape;
    let whole = Domain::open([side; 2]);
    let (overlapped, mask) = overlap(rng, e, side, (side / 6).max(2));
    let cut = |[y, x]: [u32; 2], c: usize| whole.positions().map(move |p| features.get(c, [y + p[0], x + p[1]]));
    let [under, asked] = [(); 2].map(|()| [rng.below(h - side), rng.below(w - side)]);
    let mut terms = vec![(Space::Texture, overlapped, mask, 3)];
    if !is_first {
        let under = (0..3).flat_map(|c| cut(under, c)).collect();
        terms.push((Space::Texture, under, vec![true; whole.len()], 3));
    }
    terms.push((Space::Guide, cut(asked, 0).collect(), vec![true; whole.len()], 9));
    terms
}

#[test]
fn of_several_terms_the_least_error_from_above_is_near_the_least_of_all() {
    for (side, is_first) in [(36, true), (24, false), (16, false), (11, false), (7, false)] {
        let (mut near, mut all) = (0, 0);
        for case in 0..10 {
            let mut rng = Seed(case).derive("several", side.into()).rng();
            let plane = noise(&mut rng, [220, 260]);
            let e = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
            let domain = e.sources()[0].domain();
            let map = Grid::from_vec(domain, 1, e.sources()[0].features.plane(0).to_vec()).unwrap();
            let guide = Guide::new(&e, std::slice::from_ref(&map), map.clone()).unwrap();
            // As often as of one that is large enough.
            let times = (1..3).take_while(|&n| is_seen_whole(side, n)).last().unwrap_or(0);
            let [reduced, of_guide] = [&e, guide.exemplars()].map(|e| Reduced::times(e, times).unwrap());
            let Some(fast) = FromAbove::new(&e, &reduced, Some((&guide, &of_guide)), SimdLevel::Auto).unwrap() else {
                continue;
            };
            let exact = BlockSearch::new(&e, Some(&guide), SimdLevel::Auto).unwrap();
            for _ in 0..3 {
                let terms = of_transfer(&mut rng, &e, side, is_first);
                let terms: Vec<Term<'_>> = terms
                    .iter()
                    .map(|(space, features, mask, weight)| {
                        let template = Template::new([side; 2], features).masked(mask);
                        Term { space: *space, template, weight: *weight }
                    })
                    .collect();
                let (mut a, mut b) = (AboveScratch::default(), BlockScratch::default());
                let found = fast.near(&terms, &|_| 210, &|_, _| false, &mut a).unwrap();
                let of_all = exact.near(&terms, &|_| u32::MAX, &|_, _| false, &mut b).unwrap();
                assert!(found.iter().all(|c| of_all.contains(c)), "errors are true");
                let [found, least] = [found, of_all].map(|all| *all.iter().min().unwrap());
                (near, all) = (near + u32::from(found.error * 20 <= least.error * 21), all + 1);
            }
        }
        assert!(all * 19 <= near * 20, "{side}: {near} of {all} within a twentieth");
    }
}

#[test]
fn errors_are_those_of_the_exact_search_and_places_are_allowed() {
    let mut rng = Seed(3).rng();
    let plane = noise(&mut rng, [200, 210]);
    let e = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
    let reduced = Reduced::times(&e, 1).unwrap();
    let fast = FromAbove::new(&e, &reduced, None, SimdLevel::Auto).unwrap().unwrap();
    let exact = BlockSearch::new(&e, None, SimdLevel::Auto).unwrap();
    let (features, mask) = overlap(&mut rng, &e, 41, 9);
    let terms = [Term { space: Space::Texture, template: Template::new([41; 2], &features).masked(&mask), weight: 3 }];
    let avoid = |_: usize, [y, _]: [u32; 2]| y < 100;
    let (mut a, mut b) = (AboveScratch::default(), BlockScratch::default());
    let found = fast.near(&terms, &|_| 2000, &avoid, &mut a).unwrap().to_vec();
    let all = exact.near(&terms, &|_| u32::MAX, &|_, _| false, &mut b).unwrap();
    assert!(30 < found.len(), "{}", found.len());
    assert!(found.iter().all(|c| all.contains(c) && 100 <= c.at[0]));
    assert!(found.is_sorted_by_key(|c| (c.source, c.at)));
    // Where all are avoided, none is.
    assert!(!fast.near(&terms, &|_| 0, &|_, _| true, &mut a).unwrap().is_empty());
}

#[test]
fn what_is_small_thin_masked_or_tiled_is_searched_whole() {
    let source = |shape, periodic, masked: bool| {
        let domain = Domain { shape, periodic: [periodic, false] };
        let features = Grid::try_filled(domain, 1, 7).unwrap();
        let valid = masked.then(|| Grid::try_filled(domain, 1, true).unwrap());
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        Exemplars::from_sources(vec![Source { features, valid: valid.map(Into::into), origin }], vec![1]).unwrap()
    };
    let of = |e: Exemplars<2>, overlap| halvings(&e, overlap);
    assert_eq!(of(source([383, 999], false, false), 99), 0);
    assert_eq!([8, 15, 16, 99].map(|overlap| of(source([800, 900], false, false), overlap)), [1, 1, 2, 2]);
    assert_eq!(of(source([800, 900], false, false), 7), 0);
    // Larger ones are halved while anything is left.
    assert_eq!([0, 1, 2, 4, 99].map(|overlap| of(source([1030, 1200], false, false), overlap)), [0, 0, 1, 1, 2]);
    assert_eq!([of(source([800, 900], true, false), 99), of(source([800, 900], false, true), 99)], [0, 0]);
}

#[test]
fn what_ends_early_is_what_does_not_matter() {
    for case in 0..20 {
        let mut rng = Seed(case).derive("early", 0).rng();
        let plane = noise(&mut rng, [60, 70]);
        let e = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let searcher = SsdSearcher::new(&e).unwrap();
        let (features, mask) = overlap(&mut rng, &e, 30, 7);
        let template = Template::new([30; 2], &features).masked(&mask);
        let mut costs = Costs::new();
        searcher.search(&template, Placement::INSIDE, &mut Scratch::new(), &mut costs).unwrap();
        // Half of all places.
        let all: Vec<Candidate> = costs.iter().map(Candidate::from).filter(|_| rng.below(2) == 0).collect();
        let mut sorted = all.clone();
        sorted.sort_unstable();
        let compared = |to: &mut Vec<Place>| *to = all.iter().map(|c| Place::new(c.source, c.at)).collect();
        let (mut places, mut found) = (Vec::new(), Vec::new());
        for k in [1, 5, 32, 5000] {
            compared(&mut places);
            Compared::new(&searcher, template, &mut places).unwrap().least(k, &mut found).unwrap();
            assert_eq!(found, sorted[..k.min(sorted.len())]);
        }
        for per_mille in [0, 210, 1500, u32::MAX] {
            compared(&mut places);
            Compared::new(&searcher, template, &mut places).unwrap().near(&|_| per_mille, &mut found).unwrap();
            let most = u128::from(sorted[0].error) * (1000 + u128::from(per_mille));
            let expected: Vec<_> = all.iter().copied().filter(|c| u128::from(c.error) * 1000 <= most).collect();
            assert_eq!(found, expected, "{case} {per_mille}");
        }
    }
}

#[test]
fn thin_pieces_are_never_halved_away() {
    let mut rng = Seed(4).rng();
    let plane = noise(&mut rng, [400, 420]);
    let e = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
    let reduced = Reduced::times(&e, 1).unwrap();
    let fast = FromAbove::new(&e, &reduced, None, SimdLevel::Auto).unwrap().unwrap();
    for shape in [[1, 1], [1, 60], [60, 1], [3, 60], [15, 2], [60, 5]] {
        // Cut out of the exemplar: whole, it is found again.
        let at = [rng.below(400 - shape[0]), rng.below(420 - shape[1])];
        let domain = Domain::open(shape);
        let get = |c: usize, p: [u32; 2]| e.sources()[0].features.get(c, [at[0] + p[0], at[1] + p[1]]);
        let features: Vec<u8> = (0..3).flat_map(|c| domain.positions().map(move |p| get(c, p))).collect();
        let terms = [Term { space: Space::Texture, template: Template::new(shape, &features), weight: 1 }];
        let mut scratch = AboveScratch::default();
        let found = fast.near(&terms, &|_| 0, &|_, _| false, &mut scratch).unwrap()[0];
        assert!(!scratch.places.is_empty(), "{shape:?} was looked for everywhere");
        let samples = u64::from(shape[0] * shape[1]);
        assert!(found.error <= 3 * 30 * samples, "{shape:?}: {} of {samples} samples", found.error);
    }
}
