//! Loops, against every loop that there is.

use std::num::NonZero;

use selvedge_core::{
    Domain, Error as CoreError, Exemplars, Grid, Observer, Origin, Plane, Render, Role, Run, Samples, SeamCosts,
    SeamMeasure, Seed, Source, Transform,
};
use selvedge_graphcut_textures::Error;
use selvedge_graphcut_textures::video::{
    DistanceOptions, FrameDistances, Jump, JumpOptions, Loop, LoopOptions, Surface, looped, median, walk,
};

/// Noise that changes slowly.
fn noise(shape: [u32; 3], seed: u64) -> Plane<3> {
    changing(shape, seed, 1)
}

/// Noise that changes at one pixel in so many.
pub(crate) fn changing(shape: [u32; 3], seed: u64, rarely: u32) -> Plane<3> {
    let domain = Domain::open(shape);
    let (mut rng, frame) = (Seed(seed).rng(), shape[1] as usize * shape[2] as usize);
    let mut samples: Vec<u8> = Vec::new();
    for _ in 0..2 {
        let start = samples.len();
        for i in 0..domain.len() {
            let fresh = rng.below(256);
            let before = if i < frame { fresh } else { samples[start + i - frame].into() };
            let changes = rng.below(rarely) == 0;
            samples.push(if changes { (fresh + 2 * before) / 3 } else { before } as u8);
        }
    }
    Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 2, samples).unwrap()))
}

pub(crate) fn of(plane: &Plane<3>) -> Exemplars<3> {
    Exemplars::of(&[std::slice::from_ref(plane)]).unwrap()
}

/// The same frames, last first.
fn reversed(plane: &Plane<3>) -> Plane<3> {
    let Samples::U8(grid) = &plane.samples else { unreachable!() };
    let frame = grid.domain().strides()[0];
    let channels = (0..grid.channels()).map(|c| grid.plane(c).chunks(frame).rev().flatten().copied());
    let samples = channels.flatten().collect();
    Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(grid.domain(), grid.channels(), samples).unwrap()))
}

fn distances(exemplars: &Exemplars<3>) -> FrameDistances<'_> {
    FrameDistances::new(exemplars, &DistanceOptions::default(), &Run::seeded(0)).unwrap()
}

pub(crate) fn jump(from: u32, to: u32) -> Jump {
    Jump { from, to, error: 0.0 }
}

const MEASURES: [SeamMeasure; 2] = [SeamMeasure::Difference, SeamMeasure::Gradient];

#[test]
fn no_surface_is_cheaper() {
    let (mut bent, mut ends) = (0, 0);
    for case in 0..24 {
        let mut rng = Seed(case).rng();
        let e = of(&changing([13, 2, 2], case, 1 + rng.below(4)));
        let period = 3 + rng.below(4);
        let to = rng.below(14 - period);
        let jump = jump(to + period - 1, to);
        for seam in MEASURES {
            let options = LoopOptions { window: 4, seam, ..LoopOptions::default() };
            let woven = looped(&e, &[jump], &options, &Run::seeded(0)).unwrap();
            let (tried, costs) = (&woven.stats.tried[0], SeamCosts::new(&e, seam).unwrap());
            let price = |time: [u16; 4]| {
                let surface = Surface { time: Grid::from_vec(Domain::open([2, 2]), 1, time.to_vec()).unwrap() };
                costs.total(&Loop::new(&e, jump, surface).unwrap().map().unwrap())
            };
            let times: Vec<u16> = (tried.window.start as u16..=tried.window.end as u16).collect();
            let n = times.len();
            let all = (0..n.pow(4)).map(|i| [0, 1, 2, 3].map(|k| times[i / n.pow(k) % n]));
            let least = all.map(price).min().unwrap();
            let found = &woven.result.surface.time;
            let of_found: [u16; 4] = found.plane(0).try_into().unwrap();
            assert_eq!((tried.price, price(of_found)), (least, least), "case {case}, {jump:?}, {seam:?}");
            assert_eq!(tried.straight, times.iter().map(|&t| price([t; 4])).min().unwrap());
            bent += usize::from(tried.price < tried.straight);
            ends += usize::from(tried.window.len() < 4);
        }
    }
    assert!(8 < bent && 4 < ends, "{bent} surfaces were bent, {ends} windows met an end of the clip");
}

#[test]
fn a_clip_played_backwards_has_the_mirrored_surface() {
    for case in 0..12 {
        let clip = noise([24, 6, 7], 50 + case);
        let (there, back) = (of(&clip), of(&reversed(&clip)));
        let forth = jump(11 + case as u32, 2 + case as u32 / 2);
        let mirrored = jump(23 - forth.to, 23 - forth.from);
        let cut = |e: &Exemplars<3>, jump: Jump| {
            let options = LoopOptions { window: 8, ..LoopOptions::default() };
            let woven = looped(e, &[jump], &options, &Run::seeded(0)).unwrap();
            (woven.result.surface, woven.stats.tried[0].price)
        };
        let (a, b) = (cut(&there, forth), cut(&back, mirrored));
        assert_eq!(a.1, b.1);
        let turned: Vec<u16> = a.0.time.plane(0).iter().map(|&s| 24 - s + forth.period() as u16).collect();
        assert_eq!(turned, b.0.time.plane(0), "case {case}");
    }
}

#[test]
fn every_pixel_jumps_once_and_far_from_the_jump_frames_stay_as_they_are() {
    let clip = noise([40, 9, 8], 4);
    let e = of(&clip);
    let options = LoopOptions { window: 6, ..LoopOptions::default() };
    let woven = looped(&e, &[jump(31, 10)], &options, &Run::seeded(0)).unwrap();
    assert_eq!(woven.stats.tried[0].window, 29..35);
    let map = woven.result.map().unwrap();
    assert_eq!((map.domain().shape, map.domain().periodic), ([22, 9, 8], [true, false, false]));
    for [_, y, x] in Domain::open([1, 9, 8]).positions() {
        let jumps = (0..22).filter(|&t| map.is_seam([t, y, x], 0)).count();
        assert_eq!(jumps, 1);
        // From the window's end on until its beginning comes again.
        assert!((13..29).all(|frame| map.locate([frame - 10, y, x]) == Some((0, [frame, y, x]))));
    }
    assert_eq!(map.render(&[&clip]).unwrap().domain().shape, [22, 9, 8]);
}

/// Waves in both directions that are themselves again after some frames.
fn wave(frames: u32, period: u32) -> Plane<3> {
    let domain = Domain::open([frames, 20, 24]);
    // A smooth hump a turn.
    let hump = |n: u32| {
        let x = f64::from(n % period) / f64::from(period);
        16.0 * (x * (1.0 - x)) * (x * (1.0 - x))
    };
    let of = |[t, y, x]: [u32; 3]| 40.0 + 120.0 * hump(t + 3 * y + x) + 80.0 * hump(t + period - x % period);
    let samples = domain.positions().map(|at| of(at) as u8).collect();
    Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 1, samples).unwrap()))
}

#[test]
fn clips_that_close_come_back_as_they_are() {
    let once = of(&wave(16, 16));
    let known = distances(&once);
    assert!(known.closes() && !known.repeats(8));
    let jumps = known.best(&JumpOptions::default(), &Run::seeded(0)).unwrap();
    assert_eq!((jumps.len(), jumps[0].from, jumps[0].to), (1, 15, 0));
    let map = looped(&once, &jumps, &LoopOptions::default(), &Run::seeded(0)).unwrap().result.map().unwrap();
    assert!(map.ids.plane(0).iter().zip(0..).all(|(id, i)| id.get() == i));

    let clip = wave(32, 16);
    let twice = of(&clip);
    let jumps = distances(&twice).best(&JumpOptions::default(), &Run::seeded(0)).unwrap();
    assert_eq!(jumps, [jump(15, 0)]);
    let woven = looped(&twice, &jumps, &LoopOptions::default(), &Run::seeded(0)).unwrap();
    assert_eq!(woven.stats.tried[0].price, 0);
    let out = woven.result.map().unwrap().render(&[&clip]).unwrap();
    let (Samples::U8(out), Samples::U8(clip)) = (out.samples, clip.samples) else { unreachable!() };
    assert_eq!(out.plane(0), &clip.plane(0)[..out.plane(0).len()]);
    assert!(!distances(&of(&wave(13, 16))).closes(), "the wave has not come around");
    assert!(!distances(&of(&noise([20, 8, 8], 3))).closes());
}

#[test]
fn distances_are_those_of_the_definition() {
    let mut rng = Seed(8).rng();
    let domain = Domain::open([7, 5, 6]);
    for masked in [false, true] {
        let samples: Vec<u8> = (0..domain.len() * 2).map(|_| rng.below(256) as u8).collect();
        // Pixel 4 is masked in all frames.
        let valid: Vec<bool> = (0..domain.len()).map(|i| !masked || (0 < rng.below(4) && i % 30 != 4)).collect();
        let source = Source {
            features: Grid::from_vec(domain, 2, samples.clone()).unwrap(),
            valid: masked.then(|| Grid::from_vec(domain, 1, valid.clone()).unwrap()).map(Into::into),
            origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
        };
        let clip = Exemplars::from_sources(vec![source], vec![3, 7]).unwrap();
        let known = distances(&clip);
        assert!((0..7).all(|a| known.between(a, a) == 0));
        for (a, b) in (0..7).flat_map(|a| (0..7).filter(move |b| *b != a).map(move |b| (a, b))) {
            let mut sum = 0;
            for p in 0..30 {
                let [i, j] = [a, b].map(|frame| frame as usize * 30 + p);
                sum += match (valid[i], valid[j]) {
                    (true, true) => {
                        let of = |c: usize| u64::from(samples[c * 210 + i].abs_diff(samples[c * 210 + j])).pow(2);
                        of(0) * 3 + of(1) * 7
                    }
                    _ if masked && p == 4 => 0,
                    _ => 65_025 * 10,
                };
            }
            assert_eq!(known.between(a, b), sum);
        }
    }
}

#[test]
fn the_best_jumps_are_apart_and_within_the_periods() {
    let e = of(&noise([30, 4, 4], 2));
    let known = distances(&e);
    let options = JumpOptions { count: 6, period: Some(10..=18), spread: 3, ..JumpOptions::default() };
    let best = known.best(&options, &Run::seeded(0)).unwrap();
    assert_eq!(best.len(), 6);
    assert!(best.is_sorted_by(|a, b| a.error <= b.error));
    for (i, a) in best.iter().enumerate() {
        assert!((10..=18).contains(&a.period()) && a.from < 30);
        assert!(best[..i].iter().all(|b| 3 <= a.from.abs_diff(b.from).max(a.to.abs_diff(b.to))));
    }
    // With one tap the error is that of the frame that comes and the one that would have come, or of those before them.
    let one = known.best(&JumpOptions { count: 1, taps: 1, ..options }, &Run::seeded(0)).unwrap()[0];
    let pairs = (0..30).flat_map(|i| (0..=i).map(move |j| (i, j))).filter(|(i, j)| (10..=18).contains(&(i - j + 1)));
    let error = |(i, j): (u32, u32)| if i < 29 { known.between(i + 1, j) } else { known.between(i, j - 1) };
    let least = pairs.map(error).min().unwrap();
    assert_eq!((error((one.from, one.to)), one.error), (least, least as f64 / 16.0));
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let e = of(&noise([24, 12, 10], 6));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let jumps = distances(&e).best(&JumpOptions::default(), &Run::seeded(0)).unwrap();
            let woven = looped(&e, &jumps, &LoopOptions::default(), &Run::seeded(0)).unwrap();
            (jumps, woven.result, woven.stats)
        })
    };
    let one = on(1);
    assert!(1 < one.0.len());
    assert!(on(2) == one && on(3) == one);
}

#[test]
fn jumps_and_surfaces_that_are_in_no_clip_are_refused() {
    let e = of(&noise([40, 2, 2], 3));
    let surface = |times: [u16; 4]| Surface { time: Grid::from_vec(Domain::open([2, 2]), 1, times.to_vec()).unwrap() };
    let new = |j: Jump, times: [u16; 4]| Loop::new(&e, j, surface(times)).map(|_| ());
    for (from, to) in [(3, 5), (40, 2), (65_535, 0)] {
        let wrong = new(jump(from, to), [6; 4]);
        assert!(matches!(wrong, Err(Error::Jump { frames: 40, .. })), "{from} to {to}: {wrong:?}");
        assert!(matches!(
            looped(&e, &[jump(from, to)], &LoopOptions::default(), &Run::seeded(0)),
            Err(Error::Jump { .. })
        ));
    }
    assert!(matches!(Surface::flat(&jump(65_535, 9), [2, 2]), Err(Error::Jump { .. })));
    assert_eq!(new(jump(8, 4), [5, 10, 7, 9]), Ok(()));
    // A pixel that jumps more than a period after another would come from a frame that its surface does not part.
    for times in [[5, 40, 7, 9], [5, 11, 7, 9], [4; 4], [41; 4]] {
        assert!(matches!(new(jump(8, 4), times), Err(Error::Surface { .. })), "{times:?}");
    }
    let long = of(&noise([40, 1, 1], 3));
    let limits = selvedge_core::Limits { memory: 20_000, ..selvedge_core::Limits::default() };
    let refused = FrameDistances::new(&long, &DistanceOptions::default(), &Run { limits, ..Run::seeded(0) });
    assert!(refused.unwrap_err().to_string().contains("memory"));
}

struct Stop;
impl Observer<3> for Stop {
    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn who_stops_early_has_the_straight_seam() {
    let e = of(&noise([20, 4, 5], 6));
    let run = Run { observer: &Stop, ..Run::seeded(0) };
    assert_eq!(FrameDistances::new(&e, &DistanceOptions::default(), &run).unwrap_err(), Error::Cancelled);
    let woven = looped(&e, &[jump(12, 3)], &LoopOptions::default(), &run).unwrap();
    assert!(!woven.complete);
    assert!(woven.result.surface.time.plane(0).iter().all(|&s| s == 13));
}

#[test]
fn prices_beyond_the_cuts_range_are_shortened_and_that_is_told() {
    // White, then black, both flat: no gradient to divide by.
    let domain = Domain::open([300, 3, 3]);
    let samples = domain.positions().map(|[t, ..]| if t < 150 { 255 } else { 0 }).collect();
    let clip = Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 1, samples).unwrap()));
    let (e, options) = (of(&clip), LoopOptions { window: 150, ..LoopOptions::default() });
    let woven = looped(&e, &[jump(224, 75)], &options, &Run::seeded(0)).unwrap();
    let tried = &woven.stats.tried[0];
    assert!(0 < tried.shift && tried.price <= tried.straight, "{tried:?}");
    let map = woven.result.map().unwrap();
    assert_eq!(tried.price, SeamCosts::new(&e, SeamMeasure::Gradient).unwrap().total(&map));
}

#[test]
fn what_cannot_loop_is_refused() {
    let run = Run::seeded(0);
    let still = of(&noise([1, 4, 4], 0));
    let error = FrameDistances::new(&still, &DistanceOptions::default(), &run).unwrap_err();
    assert_eq!(error, Error::Frames { frames: 1 });
    let two = of(&noise([2, 4, 4], 0));
    let jumps = distances(&two).best(&JumpOptions::default(), &Run::seeded(0)).unwrap();
    assert_eq!((jumps.len(), jumps[0].period()), (1, 2), "there is no other");
    let clip = of(&noise([12, 4, 4], 0));
    let best = |options: JumpOptions| distances(&clip).best(&options, &Run::seeded(0)).unwrap_err();
    let options = JumpOptions::default();
    assert_eq!(
        best(JumpOptions { period: Some(13..=20), ..options.clone() }),
        Error::Period { period: 13, frames: 12 }
    );
    for wrong in [
        JumpOptions { count: 0, ..options.clone() },
        JumpOptions { spread: 0, ..options.clone() },
        JumpOptions { taps: 3, ..options.clone() },
        JumpOptions { period: Some(1..=4), ..options.clone() },
    ] {
        assert!(matches!(best(wrong), Error::Core(CoreError::Range { .. })));
    }
    let cut = |jumps: &[Jump]| looped(&two, jumps, &LoopOptions::default(), &run).unwrap_err();
    assert_eq!(cut(&[]), Error::NoJumps);
    assert_eq!(cut(&[jump(2, 0)]), Error::Jump { from: 2, to: 0, frames: 2 });
    let flat = |value: u16| Surface { time: Grid::try_filled(Domain::open([4, 4]), 1, value).unwrap() };
    assert!(Loop::new(&two, jump(1, 0), flat(2)).is_ok());
    let error = Loop::new(&two, jump(1, 0), flat(3)).unwrap_err();
    assert_eq!(error, Error::Surface { found: [4, 4], expected: [4, 4], at: Some([0, 0]), frames: 2 });
    assert!(NonZero::new(error.remedy().len()).is_some() && !error.to_string().is_empty());
}

#[test]
fn walks_jump_along_their_surfaces_and_find_no_dead_end() {
    let clip = noise([40, 7, 6], 21);
    let e = of(&clip);
    let options = LoopOptions { window: 8, ..LoopOptions::default() };
    let loops: Vec<Loop> = [jump(12, 3), jump(25, 14), jump(38, 9), jump(30, 5)]
        .map(|jump| looped(&e, &[jump], &options, &Run::seeded(0)).unwrap().result)
        .to_vec();
    for seed in 0..20 {
        let map = walk(&e, &loops, 300, &Run::seeded(seed)).unwrap();
        assert_eq!((map.domain(), map.holes()), (Domain::open([300, 7, 6]), 0));
        assert!((0..42).all(|p| map.ids.plane(0)[p].get() == p as u32), "it begins with the clip");
        let mut jumps = 0;
        for [t, y, x] in Domain::open([299, 7, 6]).positions() {
            let frame = |t: u32| map.locate([t, y, x]).map(|(_, at)| (at[0], at[1..] == [y, x])).unwrap();
            let ((here, stays), (next, _)) = (frame(t), frame(t + 1));
            let by = |l: &Loop| {
                let end = u32::from(l.surface.time.get(0, [y, x]));
                here + 1 == end && next == end - l.jump.period()
            };
            assert!(stays && (next == here + 1 || loops.iter().any(by)), "seed {seed}: {here} to {next}");
            jumps += u32::from(next != here + 1);
        }
        assert!(42 * 7 <= jumps, "{jumps} jumps");
    }
    let of_seed = |seed: u64| walk(&e, &loops, 90, &Run::seeded(seed)).unwrap();
    assert!(of_seed(1) == of_seed(1) && of_seed(1) != of_seed(2));
    // One loop alone is repeated.
    let alone = walk(&e, &loops[..1], 60, &Run::seeded(0)).unwrap();
    let frame = |t: u32| (0..42).map(|p| alone.ids.plane(0)[t as usize * 42 + p]).collect::<Vec<_>>();
    assert!((20..50).all(|t| frame(t) == frame(t + 10)));
    // Two do not only take turns: their frames do not come again after both periods.
    let both = walk(&e, &[loops[0].clone(), loops[0].clone(), loops[2].clone()], 400, &Run::seeded(3)).unwrap();
    let frame = |t: u32| both.ids.plane(0)[t as usize * 42].get();
    assert!([10, 20, 30, 40, 50, 60].iter().all(|by| (60..300).any(|t| frame(t) != frame(t + by))));
    assert_eq!(walk(&e, &[], 9, &Run::seeded(0)).unwrap_err(), Error::NoJumps);
    assert!(matches!(
        walk(&e, &loops, 0, &Run::seeded(0)).unwrap_err(),
        Error::Core(selvedge_core::Error::EmptyOutput { .. })
    ));
}

/// A wave that runs up a beach dissolves, and no other begins there: the jump whose steps are seen least joins frames
/// that are not alike, and the cut ends a wave where none ends. Steps do not tell. `[Kwatra03 7A]`
#[test]
fn waves_that_dissolve_are_cut_between_frames_that_are_not_alike() {
    let exemplars = of(&selvedge_testkit::exemplars::beach([100, 48, 48]));
    let jumps = distances(&exemplars).best(&JumpOptions::default(), &Run::seeded(0)).unwrap();
    let woven = looped(&exemplars, &jumps, &LoopOptions::default(), &Run::seeded(0)).unwrap();
    let best = &woven.stats.tried[woven.stats.chosen];
    let usual = median(&exemplars.sources()[0].features) as f64 / (48.0 * 48.0);
    assert!(3.0 * usual < best.jump.error && best.price < best.straight && best.closure.closes(), "{usual}, {best:?}");
}

/// What is looked for near the surface of half the size is dearer than the cheapest one by no more than a fiftieth,
/// over the borders of tiles too, and the same on any number of threads.
#[test]
fn surfaces_near_those_of_half_the_size_are_hardly_dearer() {
    for (shape, rarely) in [([24, 90, 150], 3), ([40, 140, 66], 2)] {
        let waves = of(&selvedge_testkit::exemplars::beach(shape));
        for exemplars in [waves, of(&changing(shape, 7, rarely))] {
            let jumps = [jump(shape[0] * 3 / 4, shape[0] / 4)];
            let of = |levels: u32| {
                let options = LoopOptions { levels, ..LoopOptions::default() };
                looped(&exemplars, &jumps, &options, &Run::seeded(0)).unwrap()
            };
            let least = of(1).stats.tried[0].price;
            for levels in [2, 3] {
                let found = of(levels);
                let price = found.stats.tried[0].price;
                assert!(least <= price && 50 * price <= 51 * least, "{shape:?}: {price} for {least}");
                let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| of(levels));
                assert_eq!(alone.result, found.result);
            }
        }
    }
}
