//! Choosing among candidates, against sorting all of them.

use crate::support::Case;
use selvedge_core::{Domain, Exemplars, Grid, Guide, Seed, SimdLevel};
use selvedge_fft_ssd::{
    Candidate, Costs, Error, Options, Placement, Positions, Scratch, SsdSearcher, SumScratch, Template, Term,
    Tolerance, search_sum,
};

fn searched(i: u64, scratch: &mut Scratch) -> (Case<2>, Costs<2>) {
    let case = Case::<2>::random(&mut Seed(2).derive("choice", i).rng(), 12);
    let searcher = SsdSearcher::new(&case.exemplars).unwrap();
    let template = Template::new(case.shape, &case.features);
    let template = case.mask.as_ref().map_or(template, |m| template.masked(m));
    let mut costs = Costs::new();
    searcher.search(&template, case.placement, scratch, &mut costs).unwrap();
    (case, costs)
}

/// All candidates, by mean error, then source, then position.
fn sorted(costs: &Costs<2>) -> Vec<Candidate<2>> {
    let mut all: Vec<_> = costs.iter().collect();
    all.sort_by(|a, b| mean(a, b).then((a.source, a.position).cmp(&(b.source, b.position))));
    all
}

fn mean(a: &Candidate<2>, b: &Candidate<2>) -> std::cmp::Ordering {
    if a.samples == 0 && b.samples == 0 {
        return std::cmp::Ordering::Equal;
    }
    (u128::from(a.error) * u128::from(b.samples)).cmp(&(u128::from(b.error) * u128::from(a.samples)))
}

#[test]
fn the_best_and_those_within_a_tolerance_are_the_first_when_sorted() {
    let mut scratch = Scratch::new();
    for i in 0..300 {
        let (_, mut costs) = searched(i, &mut scratch);
        let mut all = sorted(&costs);
        assert_eq!(costs.best(), all.first().copied());
        // Excluding the winner makes the second the best.
        let winner = all.first().map(|c| (c.source, c.position));
        assert_eq!(costs.best_where(|s, p| Some((s, p)) != winner), all.get(1).copied());
        let Some(&best) = all.first() else {
            assert!(costs.within(100).unwrap().is_empty());
            continue;
        };
        let near = |c: &Candidate<2>| {
            u128::from(c.error) * u128::from(best.samples) * 1000
                <= u128::from(best.error) * u128::from(c.samples) * 1210
        };
        all.retain(near);
        let mut found = costs.within(210).unwrap();
        assert_eq!(found.len() as usize, all.len());
        // Asked for in any order.
        for k in (0..found.len()).rev().chain(0..found.len()) {
            assert_eq!(found.nth(k), all[k as usize]);
        }
    }
}

#[test]
fn a_floor_widens_and_exclusion_narrows() {
    let mut scratch = Scratch::new();
    let mut narrowed = 0;
    for i in 0..50 {
        let (_, mut costs) = searched(i, &mut scratch);
        let all = costs.iter().count() as u32;
        narrowed += u32::from(costs.within(0).unwrap().len() < all);
        assert_eq!(costs.within(Tolerance { per_mille: 0, floor: u64::MAX }).unwrap().len(), all);
        assert_eq!(costs.within_where(0, |_, _| false).unwrap().len(), 0);
    }
    assert!(10 < narrowed, "a floor was never needed");
}

#[test]
fn picks_keep_their_distance() {
    let mut scratch = Scratch::new();
    let wrapped = std::cell::Cell::new(0);
    for i in 0..100 {
        let (case, costs) = searched(i, &mut scratch);
        let apart = |a: &Candidate<2>, b: &Candidate<2>| {
            let domain = case.exemplars.sources()[a.source].domain();
            let way = |axis: usize| {
                let (d, n) = ((a.position[axis] - b.position[axis]).abs(), domain.shape[axis] as i32);
                let wraps = domain.periodic[axis] || case.placement.positions == Positions::Circular;
                wrapped.set(wrapped.get() + u32::from(wraps && n - d < d));
                if wraps { d.min(n - d) } else { d }
            };
            a.source != b.source || 16 <= [0, 1].map(way).iter().map(|d| d * d).sum::<i32>()
        };
        // Greedy, from the sorted list.
        let mut expected: Vec<Candidate<2>> = Vec::new();
        for c in sorted(&costs) {
            if expected.len() < 5 && expected.iter().all(|e| apart(e, &c)) {
                expected.push(c);
            }
        }
        assert_eq!(costs.best_k(5, 4).unwrap(), expected);
        assert_eq!(costs.best_k(3, 0).unwrap(), sorted(&costs)[..costs.iter().count().min(3)]);
        assert!(costs.best_k(9, u32::MAX).unwrap().len() <= costs.sources().len());
    }
    assert!(100 < wrapped.get(), "a shorter way round was never met");
}

#[test]
fn sums_weigh_each_search() {
    let mut scratch = Scratch::new();
    for i in 0..50 {
        let (case, a) = searched(i, &mut scratch);
        let searcher = SsdSearcher::new(&case.exemplars).unwrap();
        let inverted: Vec<u8> = case.features.iter().map(|f| 255 - f).collect();
        let template = Template::new(case.shape, &inverted);
        let mut b = Costs::new();
        let template = case.mask.as_ref().map_or(template, |m| template.masked(m));
        searcher.search(&template, case.placement, &mut scratch, &mut b).unwrap();
        // The heaviest weight that cannot pass 64 bits, mostly one of more than 32; then a sum of sums.
        let (mut once, mut sum) = (Costs::new(), Costs::new());
        let weights = (0..40).rev().map(|bits| 1_u64 << bits);
        let heavy = weights.into_iter().find(|&heavy| {
            once.sum_of(&[(3, &a), (heavy, &b)]).and_then(|()| sum.sum_of(&[(2, &once), (7, &a), (0, &b)])).is_ok()
        });
        let heavy = heavy.unwrap();
        for c in a.iter() {
            let other = b.get(c.source, c.position).unwrap();
            assert_eq!(sum.get(c.source, c.position).unwrap().error, 13 * c.error + 2 * heavy * other.error);
        }
        assert_eq!(sum.iter().count(), a.iter().count());
        if a.iter().any(|c| 0 < c.samples) {
            assert!(matches!(sum.sum_of(&[(u64::MAX, &a), (1, &b)]), Err(Error::Overflow { .. })));
        }
    }
}

/// The exemplars' own features, changed, as what steers.
fn guide_of<const D: usize>(exemplars: &Exemplars<D>, change: impl Fn(u8) -> u8, weights: Vec<u8>) -> Guide<D> {
    let maps: Vec<_> = exemplars.sources().iter().map(|s| s.features.map(&change).unwrap()).collect();
    let target = Grid::try_filled(Domain::open([1; D]), exemplars.channels(), 0).unwrap();
    Guide::new(exemplars, &maps, target).unwrap().weighing(weights).unwrap()
}

#[test]
fn sums_in_one_go_are_those_of_their_searches() {
    let (mut scratch, mut together) = (Scratch::new(), SumScratch::new());
    let mut fused = 0;
    for i in 0..300 {
        let mut rng = Seed(2).derive("sums", i).rng();
        let mut case = Case::<2>::random(&mut rng, 20);
        if i % 4 != 0 {
            case.placement.cover = selvedge_fft_ssd::Cover::Box;
        }
        let weights: Vec<u8> = (0..case.exemplars.channels()).map(|_| rng.below(3) as u8).collect();
        let guide = guide_of(&case.exemplars, |f| f ^ 90, weights);
        let levels = [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni, SimdLevel::Auto];
        let options = Options { simd: levels[i as usize % 4], ..Options::default() };
        let searcher = SsdSearcher::with_options(&case.exemplars, options).unwrap();
        let guide = SsdSearcher::of_guide(&guide, options).unwrap();
        let inverted: Vec<u8> = case.features.iter().map(|f| !f).collect();
        let masked = Template::new(case.shape, &case.features);
        let masked = case.mask.as_ref().map_or(masked, |m| masked.masked(m));
        let whole = Template::new(case.shape, &inverted);
        let terms = [(&searcher, masked, 3), (&searcher, whole, 3), (&guide, whole, 5), (&guide, masked, 0)];
        let terms = terms.map(|(searcher, template, weight)| Term { searcher, template, weight });
        let (mut parts, mut expected, mut found) = (Vec::new(), Costs::new(), Costs::new());
        for Term { searcher, template, .. } in &terms {
            let mut costs = Costs::new();
            searcher.search(template, case.placement, &mut scratch, &mut costs).unwrap();
            parts.push(costs);
        }
        let weighted: Vec<_> = terms.iter().map(|t| t.weight).zip(&parts).collect();
        let summed = expected.sum_of(&weighted);
        let went = search_sum(&terms, case.placement, &mut together, &mut found);
        assert_eq!(went, summed);
        if went.is_ok() {
            assert_eq!(found.sources(), expected.sources());
            assert!(found.iter().eq(expected.iter()), "{case:?}");
            fused += u32::from(case.placement.cover == selvedge_fft_ssd::Cover::Box && !found.is_empty());
        }
        // One search of weight 1 is that search.
        search_sum(&[Term { weight: 1, ..terms[0] }], case.placement, &mut together, &mut found).unwrap();
        assert!(found.iter().eq(parts[0].iter()));
    }
    assert!(50 < fused, "only {fused} were summed in one go");
}

#[test]
fn sums_of_different_shapes_are_refused() {
    let case = Case::<2>::random(&mut Seed(2).derive("shapes", 0).rng(), 12);
    let searcher = SsdSearcher::new(&case.exemplars).unwrap();
    let n = case.exemplars.channels();
    let features = vec![0; 6 * n];
    let [a, b] = [Template::new([2, 3], &features), Template::new([3, 2], &features)];
    let terms = [a, b].map(|template| Term { searcher: &searcher, template, weight: 1 });
    let refused = search_sum(&terms, Placement::INSIDE, &mut SumScratch::new(), &mut Costs::new());
    assert_eq!(refused, Err(Error::Mismatch));
}

#[test]
fn what_does_not_fit_is_refused_with_its_numbers() {
    let case = Case::<2>::random(&mut Seed(2).derive("errors", 0).rng(), 12);
    let searcher = SsdSearcher::new(&case.exemplars).unwrap();
    let ask = |template: Template<'_, 2>| {
        searcher.search(&template, Placement::INSIDE, &mut Scratch::new(), &mut Costs::new()).unwrap_err()
    };
    assert_eq!(ask(Template::new([0, 3], &[])), Error::EmptyTemplate { shape: vec![0, 3] });
    let channels = case.exemplars.channels();
    let expected = 2 * channels as u64;
    assert_eq!(
        ask(Template::new([1, 2], &[])),
        Error::TemplateLength { shape: vec![1, 2], channels, expected, found: 0 }
    );
    let features = vec![0; 2 * channels];
    let short = Template::new([1, 2], &features).masked(&[true]);
    assert_eq!(ask(short), Error::MaskLength { expected: 2, found: 1 });
    assert_eq!(ask(short).kind(), selvedge_core::ErrorKind::Input, "the caller's, not a promise of ours");
}

#[test]
fn guides_share_the_positions_of_their_exemplars() {
    let mut compared = 0;
    for i in 0..30 {
        let case = Case::<2>::random(&mut Seed(2).derive("guides", i).rng(), 10);
        let guide = guide_of(&case.exemplars, |f| 255 - f, vec![7; case.exemplars.channels()]);
        let guide = SsdSearcher::of_guide(&guide, Options::default()).unwrap();
        let searcher = SsdSearcher::new(&case.exemplars).unwrap();
        let (mut scratch, mut a, mut b) = (Scratch::new(), Costs::new(), Costs::new());
        let template = Template::new(case.shape, &case.features);
        searcher.search(&template, Placement::INSIDE, &mut scratch, &mut a).unwrap();
        guide.search(&template, Placement::INSIDE, &mut scratch, &mut b).unwrap();
        assert!(a.iter().map(|c| (c.source, c.position)).eq(b.iter().map(|c| (c.source, c.position))));
        let separate: Vec<u64> = a.iter().zip(b.iter()).map(|(a, b)| 2 * a.error + 3 * b.error).collect();
        let mut sum = Costs::new();
        sum.sum_of(&[(2, &a), (3, &b)]).unwrap();
        assert!(sum.iter().map(|c| c.error).eq(separate.iter().copied()));
        compared += separate.len();
    }
    assert!(100 < compared);
}
