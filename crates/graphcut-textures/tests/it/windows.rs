//! Clips woven some frames at a time.

use selvedge_core::{Domain, Error as CoreError, Exemplars, Run, SeamCosts};
use selvedge_graphcut_textures::video::{least_at_once, woven_in_windows};
use selvedge_graphcut_textures::{Error, Options, graphcut};

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

#[test]
fn windows_are_joined_by_seams_that_cost_no_more_than_others() {
    for (e, output, at_once, options) in cases() {
        let costs = SeamCosts::new(&e, options.seam).unwrap();
        let mut sums = [0; 2];
        for seed in 0..2 {
            let run = Run::seeded(seed);
            let woven = woven_in_windows(&e, output, at_once, &options, &run).unwrap();
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
            pool.install(|| woven_in_windows(&e, output, at_once, &options, &Run::seeded(5)).unwrap().result)
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
    let at_once = |frames| woven_in_windows(&e, output, frames, &options, &run);
    assert_eq!(at_once(90).unwrap().result, graphcut(&e, output, &options, &run).unwrap().result);
    let least = least_at_once(20, &options);
    assert!(at_once(least).unwrap().complete, "{least}");
    let refused = at_once(4).unwrap_err();
    assert!(matches!(refused, Error::Core(CoreError::Range { option: "at_once", .. })), "{refused}");
}
