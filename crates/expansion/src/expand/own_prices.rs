//! Tests with prices of single samples, pins and free holes, in clips: against brute force, and pruning against none.

use selvedge_core::{
    Domain, Exemplars, Grid, Origin, Patch, Rng, SampleId, SeamCosts, SeamMeasure, Seed, Source, SourceMap, Transform,
};

use super::*;
use crate::choice::{Holes, Pin};

/// Seams, and a price of each sample at each place. Half of them are 0, so that much is free to change.
struct Guided<'a, const D: usize> {
    seams: &'a SeamCosts<D>,
    /// The largest price of a sample.
    most: u32,
    seed: Seed,
    /// Adds to each pair what no cut can hold.
    skew: i32,
}

impl<const D: usize> Prices<D> for Guided<'_, D> {
    fn pair(&self, axis: usize, here: SampleId, there: SampleId) -> i32 {
        let seam = self.seams.pair(axis, here, there);
        let key = u64::from(here.get()) * 31 + u64::from(there.get());
        seam + if seam == 0 { 0 } else { self.seed.derive("skew", key).rng().below(self.skew as u32 + 1) as i32 }
    }

    fn unary(&self, place: usize, sample: SampleId) -> i32 {
        let mut rng = self.seed.derive("own", place as u64 * 4099 + u64::from(sample.get() % 4099)).rng();
        if rng.below(2) == 0 { 0 } else { rng.below(self.most + 1) as i32 - (self.most / 4) as i32 }
    }
}

/// Own prices and those of all pairs of which one is free, given who takes the offer.
fn price<const D: usize>(frame: &Frame<D>, choices: &[Choice], prices: &impl Prices<D>, taken: &[bool]) -> i64 {
    let id = |i: usize| if taken[i] { frame.new[i] } else { frame.old[i] };
    let is_free = |i: usize| choices[i] == Choice::Free;
    let own = (0..taken.len()).filter(|&i| is_free(i)).map(|i| prices.unary(frame.places[i] as usize, id(i)));
    let mut sum: i64 = own.map(i64::from).sum();
    for axis in 0..D {
        for (s, t) in frame.pairs(axis).filter(|&(s, t)| is_free(s) || is_free(t)) {
            if choices[s] != Choice::Empty && choices[t] != Choice::Empty {
                sum += i64::from(prices.pair(axis, id(s), id(t)));
            }
        }
    }
    sum
}

/// A clip under some patches with holes, and another patch over all of it, with choices; the axes are open or periodic.
fn clip(case: u64, rng: &mut Rng) -> (SeamCosts<3>, SourceMap<3>, Frame<3>, Vec<Choice>) {
    let domain = Domain::open([7, 7, 7]);
    let samples = (0..domain.len()).map(|_| (rng.below(4) * 60) as u8).collect();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let source = Source { features: Grid::from_vec(domain, 1, samples).unwrap(), valid: None, origin };
    let e = Exemplars::from_sources(vec![source], vec![1]).unwrap();
    let shape = std::array::from_fn(|_| 1 + rng.below(3));
    let output = Domain { shape, periodic: std::array::from_fn(|_| rng.below(2) == 1) };
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    for id in map.ids.plane_mut(0).iter_mut() {
        let hole = case.is_multiple_of(2) && rng.below(5) == 0;
        *id = if hole { SampleId::UNASSIGNED } else { SampleId::new(rng.below(343)) };
    }
    let patch = Patch { source: 0, offset: std::array::from_fn(|a| -(rng.below(8 - output.shape[a]) as i32)) };
    let frame = Frame::of_patch(&e, &map, &patch, &Window::all(output)).unwrap();
    let holes = if rng.below(2) == 0 { Holes::Fill } else { Holes::Free };
    let salt = rng.below(97) as usize;
    let pin = |place: usize| match (place + salt) % 7 {
        0 => Some(Pin::Old),
        1 => Some(Pin::New),
        _ => None,
    };
    let choices = frame.choices(holes, pin).unwrap();
    (SeamCosts::new(&e, SeamMeasure::Difference).unwrap(), map, frame, choices)
}

#[test]
fn moves_with_own_prices_pins_and_free_holes_are_as_cheap_as_any_in_a_clip() {
    let mut decided = 0;
    for case in 0..400 {
        let mut rng = Seed(5000 + case).rng();
        let (seams, _, frame, choices) = clip(case, &mut rng);
        let free: Vec<usize> = (0..choices.len()).filter(|&i| choices[i] == Choice::Free).collect();
        if 12 < free.len() {
            continue;
        }
        let prices = Guided { seams: &seams, most: 1 + rng.below(6000), seed: Seed(case), skew: 0 };
        let found = expand(&frame, &choices, &prices, &mut Scratch::default(), &|| false).unwrap();
        let labelling = |bits: usize| -> Vec<bool> {
            let mut taken: Vec<bool> = choices.iter().map(|&c| c == Choice::New).collect();
            free.iter().enumerate().for_each(|(k, &i)| taken[i] = bits >> k & 1 == 1);
            taken
        };
        let of = |bits| price(&frame, &choices, &prices, &labelling(bits));
        // A hole beside what is there has no seam: that is no metric, and terms may be lowered.
        let least = (0..1 << free.len()).map(of).min().unwrap();
        let after = price(&frame, &choices, &prices, &found.taken);
        assert!(after == least || 0 < found.truncated, "case {case}");
        assert_eq!((found.gain, found.free), (of(0) - after, free.len()));
        assert!(0 <= found.gain);
        decided += free.len();
    }
    assert!(500 < decided, "only {decided} free samples in all");
}

#[test]
fn pruning_changes_nothing_but_the_size_of_the_cut() {
    let (mut pruned, mut free, mut changed) = (0, 0, 0);
    for case in 0..600 {
        let mut rng = Seed(9000 + case).rng();
        let (seams, _, frame, choices) = clip(case, &mut rng);
        let skew = if case % 3 == 0 { 3000 } else { 0 };
        let prices = Guided { seams: &seams, most: 1 + rng.below(20_000), seed: Seed(case), skew };
        let [with, without] = [true, false]
            .map(|pruning| decide(&frame, &choices, &prices, &mut Scratch::default(), pruning, &|| false).unwrap());
        if without.truncated == 0 {
            assert_eq!(with, without, "case {case}");
        }
        // Terms of what was decided before the cut need not be lowered; prices are true either way.
        let price = |taken: &[bool]| price(&frame, &choices, &prices, taken);
        let kept: Vec<bool> = choices.iter().map(|&c| c == Choice::New).collect();
        assert!(with.truncated <= without.truncated && 0 <= with.gain);
        assert_eq!(with.gain, price(&kept) - price(&with.taken));
        let differences = vec![0; choices.len()];
        if let Some(after) = prune(&frame, &choices, &prices, &differences).unwrap() {
            pruned += (0..choices.len()).filter(|&i| after[i] != choices[i]).count();
        }
        free += without.free;
        changed += (0..choices.len()).filter(|&i| choices[i] == Choice::Free && without.taken[i]).count();
    }
    assert!(free / 8 < pruned && free / 10 < changed, "{pruned} of {free} pruned, {changed} changed");
}

#[test]
fn what_follows_from_a_pruned_sample_is_pruned_too() {
    // A row in which each sample could save by a change only if the one before it changed as well.
    struct Chain;
    impl Prices<1> for Chain {
        fn pair(&self, _: usize, here: SampleId, there: SampleId) -> i32 {
            if (here.get() < 50) == (there.get() < 50) { 0 } else { 10 }
        }
        fn unary(&self, place: usize, sample: SampleId) -> i32 {
            if sample.get() < 50 { 0 } else { [0, 25, 5, 5, 5, 5, 0][place] }
        }
    }
    let features = Grid::try_filled(Domain::open([100]), 1, 0).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let e = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
    let mut map = SourceMap::unassigned(&e, Domain::open([7])).unwrap();
    map.ids.plane_mut(0).fill(SampleId::new(0));
    let window = Window { start: [1], shape: [5] };
    let frame = Frame::of_patch(&e, &map, &Patch { source: 0, offset: [-60] }, &window).unwrap();
    let mut choices = frame.choices(Holes::Fill, |_| None).unwrap();
    assert_eq!(choices[1..6], [Choice::Old, Choice::Free, Choice::Free, Choice::Free, Choice::Old]);
    choices[1..6].fill(Choice::Free);
    let after = prune(&frame, &choices, &Chain, &[0; 7]).unwrap().unwrap();
    assert_eq!(after, [Choice::Old; 7]);
}
