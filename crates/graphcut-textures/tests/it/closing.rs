//! Which of some jumps is taken, and which are cut at all.

use selvedge_core::{Domain, Exemplars, Grid, Plane, Render, Role, Run, Samples, Seed, Source};
use selvedge_graphcut_textures::video::{
    CLOSES, DistanceOptions, FrameDistances, LoopOptions, Trial, Usual, looped, over_seams,
};

use crate::video::{changing, jump, of};

#[test]
fn the_loop_is_taken_whose_seam_is_seen_least_and_of_equal_ones_the_cheapest() {
    let (mut dearer, mut equal, mut more) = (0, 0, 0);
    for case in 0..40 {
        let e = of(&if case < 20 { changing([26, 18, 20], case, 1 + case as u32 % 5) } else { flickering(case) });
        let features = &e.sources()[0].features;
        let usual = Usual::of(features).unwrap();
        // The clip's ends leave the first few frames to jump in.
        let jumps = [jump(24, 0), jump(20, 3), jump(17, 6), jump(22, 11), jump(24, 9)];
        let woven = looped(&e, &jumps, &LoopOptions::default(), &Run::seeded(0)).unwrap();
        let (tried, chosen) = (&woven.stats.tried, woven.stats.chosen);
        for (number, trial) in tried.iter().enumerate() {
            let alone = looped(&e, &jumps[number..=number], &LoopOptions::default(), &Run::seeded(0)).unwrap().result;
            let map = alone.map().unwrap();
            let plane = Plane::new(Role::Scalar, Samples::U8(features.clone()));
            let Samples::U8(output) = map.render(&[&plane]).unwrap().samples else { unreachable!() };
            assert_eq!(trial.closure, usual.closure(over_seams(&map, &output)), "case {case}: {trial:?}");
        }
        assert!(tried.iter().all(|trial| rank(&tried[chosen]) <= rank(trial)), "case {case}: {chosen} of {tried:?}");
        dearer += usize::from(tried.iter().any(|trial| trial.price < tried[chosen].price));
        // Where the first is to be enough and does not close, others that may be better are cut.
        let few = looped(&e, &jumps, &LoopOptions { jumps: 1, ..LoopOptions::default() }, &Run::seeded(0)).unwrap();
        let closes = |t: &Trial| t.closure.whole <= CLOSES && t.closure.block <= 1.0;
        let of_few = &few.stats.tried;
        assert!(of_few[0] == tried[0] && of_few.iter().all(|trial| tried.contains(trial)), "case {case}");
        assert!(!closes(&tried[0]) || of_few.len() == 1, "case {case}");
        let best = |all: &[Trial]| all.iter().map(rank).min_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(Some(rank(&of_few[few.stats.chosen])), best(of_few), "case {case}");
        assert_eq!(few.result.jump, of_few[few.stats.chosen].jump);
        more += usize::from(1 < of_few.len());
        equal += usize::from(2 <= tried.iter().filter(|trial| trial.closure.closes()).count());
    }
    assert!(4 < dearer && 4 < equal, "{dearer} were not the cheapest, of {equal} several close");
    assert!(4 < more && more < 36, "of {more} the first did not close");
}

/// How a loop ranks among others.
fn rank(t: &Trial) -> (f64, f64, i64) {
    (t.closure.whole.max(CLOSES), t.closure.block.max(1.0), t.price)
}

/// Frames of half the size, by means of two by two samples, rounded.
fn halved(clip: &Exemplars<3>) -> Exemplars<3> {
    let Source { features, origin, .. } = &*clip.sources()[0];
    let [frames, height, width] = features.domain().shape;
    let domain = Domain::open([frames, height / 2, width / 2]);
    let mean = |c: usize, [t, y, x]: [u32; 3]| {
        let four = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[v, u]| u32::from(features.get(c, [t, 2 * y + v, 2 * x + u])));
        ((four.iter().sum::<u32>() + 2) / 4) as u8
    };
    let samples = (0..features.channels()).flat_map(|c| domain.positions().map(move |at| mean(c, at))).collect();
    let features = Grid::from_vec(domain, features.channels(), samples).unwrap();
    Exemplars::from_sources(vec![Source { features, valid: None, origin: *origin }], clip.weights().to_vec()).unwrap()
}

#[test]
fn jumps_are_sifted_at_half_the_size_and_the_best_are_cut_at_full_size() {
    let (mut two, mut more, mut doubled) = (0, 0, 0);
    for case in 0..10 {
        let clip = changing([22, 64, 66], case, 1 + case as u32 % 5);
        // The first and the last two have the same period, and so short a window that it is all there is.
        let jumps =
            [jump(17, 3), jump(20, 0), jump(14, 6), jump(18, 9), jump(21, 9), jump(19, 1), jump(15, 7), jump(14, 6)];
        let options = LoopOptions { sifted: true, jumps: 4, ..LoopOptions::default() };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| looped(&of(&clip), &jumps, &options, &Run::seeded(0)).unwrap())
        };
        let woven = on(3);
        assert!(on(1).result == woven.result && on(2).stats == woven.stats, "case {case}");
        let (tried, all) = (&woven.stats.tried, &woven.stats.halved);
        let whole = LoopOptions { sifted: false, ..options };
        let half = looped(&halved(&of(&clip)), &jumps, &whole, &Run::seeded(0)).unwrap();
        assert!(*all == half.stats.tried, "case {case}: {all:?} for {:?}", half.stats.tried);
        let mut best: Vec<&Trial> = all.iter().collect();
        best.sort_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap());
        let closes = |t: &Trial| t.closure.whole <= CLOSES && t.closure.block <= 1.0;
        // Two that part the same frames at the same times are one.
        let same = |a: &Trial, b: &Trial| a.window == b.window && a.jump.period() == b.jump.period();
        let best: Vec<&Trial> =
            (0..best.len()).filter(|&i| !best[..i].iter().any(|t| same(t, best[i]))).map(|i| best[i]).collect();
        let first = looped(&of(&clip), &[best[0].jump, best[1].jump], &whole, &Run::seeded(0)).unwrap();
        assert!(first.stats.tried == tried[..2], "case {case}: {tried:?} for {first:?}");
        // Others follow in their order, until one closes.
        let close = best.iter().filter(|t| closes(t)).count();
        let mut others = best[2..best.len().min(close.max(4))].iter();
        assert!(tried[2..].iter().all(|t| others.any(|other| other.jump == t.jump)), "case {case}: {tried:?}");
        assert!(tried.len() == 2 || !tried[..tried.len() - 1].iter().any(closes), "case {case}: {tried:?}");
        assert!(tried.iter().all(|t| rank(&tried[woven.stats.chosen]) <= rank(t)), "case {case}");
        (two, more) = (two + usize::from(tried.len() == 2), more + usize::from(2 < tried.len()));
        doubled += usize::from(best.len() < all.len());
        // Of two there is nothing to choose, and of smaller frames little is left.
        let few = looped(&of(&clip), &jumps[..2], &options, &Run::seeded(0)).unwrap();
        assert!(few.stats.halved.is_empty() && few.stats.tried.len() == 2);
    }
    assert!(0 < two && 0 < more && 0 < doubled, "{two} of two, {more} of more, {doubled} with the same twice");
    let small = changing([22, 64, 63], 0, 1);
    let options = LoopOptions { sifted: true, ..LoopOptions::default() };
    let jumps = [jump(20, 0), jump(17, 3), jump(14, 6)];
    assert!(looped(&of(&small), &jumps, &options, &Run::seeded(0)).unwrap().stats.halved.is_empty());
}

#[test]
fn where_half_the_size_hides_a_step_other_jumps_are_tried() {
    // A fine pattern that turns into its negative halfway, of which half the size shows nothing.
    let domain = Domain::open([120, 64, 64]);
    let sample = |[t, y, x]: [u32; 3]| (100 + 40 * ((x + y + u32::from(60 <= t)) % 2)) as u8;
    let samples = domain.positions().map(sample).collect();
    let e = of(&Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 1, samples).unwrap())));
    let jumps = [jump(80, 20), jump(50, 10), jump(45, 2)];
    let options = LoopOptions { sifted: true, jumps: 1, window: 4, ..LoopOptions::default() };
    let woven = looped(&e, &jumps, &options, &Run::seeded(0)).unwrap();
    assert_eq!((woven.stats.halved.len(), woven.result.jump), (3, jumps[1]));
}

#[test]
fn jumps_that_would_be_seen_more_are_not_cut_after_the_first() {
    // One part grows lighter beside what flickers: the longer the period, the larger its step.
    let domain = Domain::open([30, 20, 40]);
    let samples = domain.positions().map(|[t, _, x]| if x < 16 { t } else { 200 * (t % 2) } as u8).collect();
    let e = of(&Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 1, samples).unwrap())));
    let cut = |periods: [u32; 2], first: usize| {
        let jumps = periods.map(|period| jump(13 + period, 14));
        let options = LoopOptions { jumps: first, ..LoopOptions::default() };
        looped(&e, &jumps, &options, &Run::seeded(0)).unwrap().stats.tried.len()
    };
    assert_eq!([cut([4, 12], 1), cut([4, 12], 2), cut([12, 4], 1)], [1, 2, 2]);
}

#[test]
fn a_clip_whose_end_is_hidden_by_noise_does_not_close() {
    // What grows lighter from frame to frame under noise, beside what flickers but near the end.
    let closes = |grows: u32| {
        let (domain, mut rng) = (Domain::open([24, 16, 64]), Seed(5).rng());
        let sample = |[t, _, x]: [u32; 3]| match x {
            0..16 => 60 + t * grows / 10 + rng.below(60),
            _ => 100 + rng.below(if (2..22).contains(&t) { 20 + 90 * (t % 2) } else { 20 }),
        };
        let samples = domain.positions().map(sample).map(|v| v as u8).collect();
        let e = of(&Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 1, samples).unwrap())));
        FrameDistances::new(&e, &DistanceOptions::default(), &Run::seeded(0)).unwrap().closes()
    };
    assert_eq!([0, 8, 30].map(closes), [true, false, false]);
}

/// Six frames of noise again and again, with less noise over them.
fn flickering(seed: u64) -> Plane<3> {
    let (domain, mut rng) = (Domain::open([26, 18, 20]), Seed(seed).rng());
    let six: Vec<u32> = (0..6 * 360).map(|_| rng.below(220)).collect();
    let samples = (0..domain.len()).map(|i| (six[i % six.len()] + rng.below(30)) as u8).collect();
    Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 1, samples).unwrap()))
}
