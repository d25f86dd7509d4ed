//! Clips woven some frames at a time.

use selvedge_core::{Domain, Exemplars, Run, SeamCosts, SourceMap, Start};
use selvedge_graphcut_textures::video::{
    Ends, WindowsCheckpoint, least_at_once, woven_in_windows, woven_in_windows_on,
};
use selvedge_graphcut_textures::{Error, Options, graphcut, graphcut_from};

use crate::common::{blobs, of};

/// A clip, an output that is longer than a window, and options.
fn cases() -> [(Exemplars<3>, Domain<3>, u32, Options<3>); 3] {
    let e = of(&blobs([20, 48, 56], 9));
    let clip = |shape, loops| Domain { shape, periodic: [loops, false, false] };
    let options = Options { refine: Some(4), ..Options::default() };
    let in_time = Options { free: [true, false, false], ..options };
    [
        (e.clone(), clip([90, 48, 56], true), 40, in_time),
        (e.clone(), clip([90, 48, 56], false), 30, in_time),
        (e, clip([70, 50, 60], true), 32, options),
    ]
}

fn empty(e: &Exemplars<3>, output: Domain<3>) -> Start<3> {
    Start::empty(e, output).unwrap()
}

#[test]
fn windows_are_joined_by_seams_that_cost_no_more_than_others() {
    for (e, output, at_once, options) in cases() {
        let costs = SeamCosts::new(&e, options.seam).unwrap();
        let mut sums = [0; 2];
        for seed in 0..2 {
            let run = Run::seeded(seed);
            let woven = woven_in_windows(&e, empty(&e, output), at_once, &options, &run).unwrap();
            let total = costs.total(&woven.result);
            assert_eq!((woven.complete, woven.result.holes(), woven.stats.settled.last()), (true, 0, Some(&total)));
            sums[0] += total;
            sums[1] += costs.total(&graphcut(&e, output, &options, &run).unwrap().result);
        }
        assert!(sums[0] < sums[1] * 9 / 8, "{sums:?} by windows and at once");
    }
}

#[test]
fn windows_do_not_depend_on_threads() {
    for (e, output, at_once, options) in cases() {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| woven_in_windows(&e, empty(&e, output), at_once, &options, &Run::seeded(5)).unwrap().result)
        };
        let one = on(1);
        assert!([2, 3].into_iter().all(|threads| on(threads) == one));
        let stays = |at: [u32; 3]| one.locate(at).unwrap().1[1..] == at[1..];
        assert!(options.free[1] || output.positions().all(stays));
    }
}

#[test]
fn one_window_is_the_clip_and_too_short_ones_are_refused() {
    let (e, output, _, options) = cases()[0].clone();
    let run = Run::seeded(4);
    let at_once = |frames| woven_in_windows(&e, empty(&e, output), frames, &options, &run);
    assert_eq!(at_once(90).unwrap().result, graphcut(&e, output, &options, &run).unwrap().result);
    let least = least_at_once(20, &options);
    assert!(at_once(least).unwrap().complete, "{least}");
    let Error::AtOnce { frames: 4, least } = at_once(4).unwrap_err() else { panic!("too few") };
    assert!(at_once(least).unwrap().complete, "{least}");
    assert_eq!(at_once(least - 1).unwrap_err(), Error::AtOnce { frames: least - 1, least });
    assert_eq!(at_once(4).unwrap_err().remedy(), format!("weave {least} or more at once"));
}

#[test]
fn windows_lie_between_ends_that_stay() {
    let (e, output, at_once, options) = cases()[1].clone();
    let costs = SeamCosts::new(&e, options.seam).unwrap();
    // Fewer frames than two windows share, and more than one holds new ones of.
    for (keep, at_once) in [(6, at_once), (3, 40), (17, 21)] {
        let ends = Ends::of_clip(&e, keep).unwrap();
        let start = || ends.start(output.shape[0]).unwrap();
        let mut sums = [0; 2];
        for seed in 0..2 {
            let run = Run::seeded(seed);
            let woven = woven_in_windows(&e, start(), at_once, &options, &run).unwrap();
            assert!(woven.complete && woven.result.holes() == 0 && woven.result.domain().shape[0] == 90 + keep);
            let (ids, first) = (woven.result.ids.plane(0), (20 - keep) / 2 * 48 * 56);
            let stays = keep as usize * 48 * 56;
            for end in [&ids[..stays], &ids[ids.len() - stays..]] {
                assert!(end.iter().map(|id| id.get()).eq(first..first + stays as u32), "{keep}");
            }
            sums[0] += costs.total(&ends.closed(&woven.result).unwrap());
            sums[1] += costs.total(&graphcut_from(&e, start(), &options, &run).unwrap().result);
        }
        assert!(sums[0] < sums[1] * 9 / 8, "{keep}: {sums:?} by windows and at once");
    }
}

#[test]
fn windows_make_the_seams_of_what_stands_better_and_none_worse() {
    for (e, output, at_once, options) in cases() {
        let costs = SeamCosts::new(&e, options.seam).unwrap();
        let run = Run::seeded(3);
        let first = graphcut(&e, output, &Options { refine: Some(0), ..options }, &run).unwrap().result;
        let start = || Start { map: first.clone(), fixed: None, sources: None };
        let mut totals = Vec::new();
        let mut keep = |made: &dyn Fn() -> WindowsCheckpoint| {
            let mut map = SourceMap::unassigned(&e, output).unwrap();
            let bytes = made().to_bytes();
            let ids = bytes[bytes.len() - 4 * output.len()..].as_chunks::<4>().0;
            for (id, bytes) in map.ids.plane_mut(0).iter_mut().zip(ids) {
                *id = selvedge_core::SampleId::new(u32::from_le_bytes(*bytes));
            }
            totals.push(costs.total(&map));
        };
        let woven = woven_in_windows_on(&e, start(), (at_once, None), &options, &run, &mut keep).unwrap();
        totals.push(costs.total(&woven.result));
        assert!(totals.is_sorted_by(|a, b| b <= a) && totals[totals.len() - 1] < totals[0], "{totals:?}");
        assert_eq!((totals[0], woven.stats.patches), (costs.total(&first), 0));
        let several = Options { levels: Some(2), ..options };
        let refused = woven_in_windows(&e, start(), at_once, &several, &run).unwrap_err();
        assert_eq!(refused, Error::LevelsOfStart { levels: 2 });
    }
}

#[test]
fn windows_go_on_from_any_of_them_as_if_they_had_not_stopped() {
    let (e, output, at_once, options) = cases()[0].clone();
    let options = Options { levels: Some(2), ..options };
    let go_on = |from: Option<&WindowsCheckpoint>, at_once, keep: &mut dyn FnMut(&dyn Fn() -> WindowsCheckpoint)| {
        woven_in_windows_on(&e, empty(&e, output), (at_once, from), &options, &Run::seeded(7), keep)
    };
    let mut all = Vec::new();
    let whole = go_on(None, at_once, &mut |made| all.push(made().to_bytes())).unwrap();
    let alone = woven_in_windows(&e, empty(&e, output), at_once, &options, &Run::seeded(7)).unwrap();
    assert!(alone.result == whole.result && alone.stats == whole.stats);
    assert!(2 < all.len());
    for (number, bytes) in all.iter().enumerate() {
        let from = WindowsCheckpoint::of_bytes(bytes).unwrap();
        assert_eq!((from.windows(), &from.to_bytes()), (number as u64, bytes));
        let mut kept = 0;
        let woven = go_on(Some(&from), at_once, &mut |_| kept += 1).unwrap();
        assert!(woven.complete && woven.result == whole.result, "from {number}");
        assert_eq!((woven.stats, kept), (whole.stats.clone(), all.len() - number));
        for end in (0..bytes.len()).step_by(4999) {
            assert!(WindowsCheckpoint::of_bytes(&bytes[..end]).is_err(), "{end}");
        }
    }
    let from = WindowsCheckpoint::of_bytes(&all[1]).unwrap();
    let refused = go_on(Some(&from), at_once + 1, &mut |_| ()).unwrap_err();
    assert_eq!(refused, Error::Checkpoint { what: "number of frames at once" });
    let shorter = empty(&e, Domain { shape: [80, 48, 56], ..output });
    let refused = woven_in_windows_on(&e, shorter, (at_once, Some(&from)), &options, &Run::seeded(7), &mut |_| ());
    assert_eq!(refused.unwrap_err(), Error::Checkpoint { what: "output" });
}
