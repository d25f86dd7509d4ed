//! Clips woven of patches, moved in time alone or in space as well.

use selvedge_core::{
    Domain, Error as CoreError, Exemplars, Grid, Run, SampleId, SeamCosts, SeamMeasure, Seed, SourceMap,
};
use selvedge_graphcut_textures::video::{Ends, Jump, LoopOptions, hold_still, looped};
use selvedge_graphcut_textures::{Error, Options, Placement, graphcut, graphcut_from};

use crate::video::{changing, of};

#[test]
fn patches_that_move_in_time_alone_keep_their_place() {
    let e = of(&changing([20, 9, 11], 5, 2));
    for (output, placement) in
        [([33, 9, 11], Placement::Auto), ([31, 8, 10], Placement::Entire), ([8, 9, 11], Placement::Random)]
    {
        let output = Domain { shape: output, periodic: [true, false, output[2] == 11] };
        let options = Options { placement, free: [true, false, false], ..Options::default() };
        let woven = graphcut(&e, output, &options, &Run::seeded(1)).unwrap();
        assert_eq!((woven.result.holes(), woven.stats.settings.region[1..].to_vec()), (0, output.shape[1..].to_vec()));
        let stays = |at: [u32; 3]| woven.result.locate(at).is_some_and(|(_, from)| from[1..] == at[1..]);
        assert!(output.positions().all(stays), "{placement:?}");
        assert!(woven.stats.energy.is_sorted_by(|a, b| b <= a));
    }
    let wide = Domain::open([20, 9, 12]);
    let options = Options { free: [true, false, false], ..Options::default() };
    let error = graphcut(&e, wide, &options, &Run::seeded(1)).unwrap_err();
    assert!(matches!(error, Error::RegionExceedsExemplar { .. }), "{error}");
    let options = Options { free: [false; 3], ..Options::default() };
    assert!(matches!(
        graphcut(&e, wide, &options, &Run::seeded(1)).unwrap_err(),
        Error::Core(CoreError::Range { option: "free", .. })
    ));
}

#[test]
fn between_ends_that_are_the_same_a_clip_loops() {
    let clip = changing([24, 9, 11], 7, 2);
    let e = of(&clip);
    let costs = SeamCosts::new(&e, SeamMeasure::Gradient).unwrap();
    let frame = |map: &SourceMap<3>, t: u32| map.ids.plane(0)[t as usize * 99..][..99].to_vec();
    let ends = Ends::of_clip(&e, 4).unwrap();
    for free in [[true, false, false], [true; 3]] {
        let options = Options { free, refine: Some(6), ..Options::default() };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| graphcut_from(&e, ends.start(30).unwrap(), &options, &Run::seeded(3)).unwrap())
        };
        let woven = on(1);
        assert!([2, 3].into_iter().all(|threads| on(threads).result == woven.result), "on any number of threads");
        let map = ends.closed(&woven.result).unwrap();
        assert_eq!((map.domain().shape, map.domain().periodic, map.holes()), ([30, 9, 11], [true, false, false], 0));
        for k in 0..4 {
            // Frames 10 to 13 are the middle ones of 24.
            let kept: Vec<u32> = ((10 + k) * 99..(11 + k) * 99).collect();
            for at in [k, 30 + k] {
                let ids = frame(&woven.result, at);
                assert!(ids.iter().map(|id| id.get()).eq(kept.iter().copied()), "{free:?}: frame {at}");
            }
        }
        assert!((0..30).all(|t| frame(&map, t) == frame(&woven.result, t + 4)));
        // What was taken off is there at the other end: the seams are the same ones.
        assert_eq!(costs.total(&map), costs.total(&woven.result));
        assert_eq!(Some(&costs.total(&map)), woven.stats.energy.last());
    }
    // Frames that tile were woven themselves.
    let tiled = Domain { shape: [3, 12, 14], periodic: [false, true, true] };
    let ends = Ends::woven(graphcut(&e, tiled, &Options::default(), &Run::seeded(0)).unwrap().result);
    let woven = graphcut_from(&e, ends.start(9).unwrap(), &Options::default(), &Run::seeded(0)).unwrap().result;
    let map = ends.closed(&woven).unwrap();
    assert_eq!((map.domain().shape, map.domain().periodic), ([9, 12, 14], [true; 3]));
    assert_eq!(map.ids.plane(0)[6 * 168..], woven.ids.plane(0)[..3 * 168]);
    for wrong in [Ends::of_clip(&e, 24).map(drop), Ends::of_clip(&e, 0).map(drop), ends.start(3).map(drop)] {
        assert!(matches!(wrong, Err(Error::Core(CoreError::Range { option: "keep", .. }))), "{wrong:?}");
    }
}

#[test]
fn a_region_of_several_clips_fits_into_those_that_count() {
    // The long one is too small to count for space, and so it does for time.
    let (long, wide) = (changing([60, 12, 12], 3, 2), changing([8, 64, 64], 4, 2));
    let both = Exemplars::of(&[std::slice::from_ref(&long), std::slice::from_ref(&wide)]).unwrap();
    let woven = graphcut(
        &both,
        Domain::open([10, 70, 70]),
        &Options { refine: Some(0), ..Options::default() },
        &Run::seeded(0),
    );
    let [frames, height, width] = woven.unwrap().stats.settings.region;
    assert!(frames <= 8 && 8 < height.min(width), "{frames}x{height}x{width}");
}

#[test]
fn a_region_along_axes_that_are_not_free_is_all_of_them() {
    let e = of(&changing([24, 9, 11], 5, 2));
    // 40 is more than any side of a frame, and does not count.
    let options = Options { free: [true, false, false], region: Some([6, 40, 40]), ..Options::default() };
    let woven = graphcut(&e, Domain::open([30, 9, 11]), &options, &Run::seeded(1)).unwrap();
    assert_eq!(woven.stats.settings.region, [6, 9, 11]);
    let options = Options { region: Some([25, 1, 1]), ..options };
    let error = graphcut(&e, Domain::open([30, 9, 11]), &options, &Run::seeded(1)).unwrap_err();
    assert!(matches!(error, Error::RegionExceedsExemplar { .. }), "{error}");
}

#[test]
fn what_is_held_still_ends_where_seams_are_cheapest() {
    let (mut least, mut wider) = (0, 0);
    for case in 0..40 {
        let e = of(&changing([10, 1, 4], case, 1 + case as u32 % 4));
        let jump = Jump { from: 6, to: 4, error: 0.0 };
        let map = looped(&e, &[jump], &LoopOptions::default(), &Run::seeded(0)).unwrap().result.map().unwrap();
        let mask = Grid::from_vec(Domain::open([1, 4]), 1, vec![false, true, false, false]).unwrap();
        let frame = Seed(case).rng().below(10);
        let held = hold_still(&e, &map, (&mask, frame), SeamMeasure::Gradient, &Run::seeded(0)).unwrap();
        let costs = SeamCosts::new(&e, SeamMeasure::Gradient).unwrap();
        let still = |place: usize| SampleId::new(frame * 4 + place as u32 % 4);
        for place in 0..12 {
            let id = held.ids.plane(0)[place];
            assert!(id == still(place) || (place % 4 != 1 && id == map.ids.plane(0)[place]), "case {case}");
        }
        // All ways to hold other pixels still at some times.
        let free: Vec<usize> = (0..12).filter(|place| place % 4 != 1).collect();
        let price = |ways: u32| {
            let mut map = map.clone();
            let ids = map.ids.plane_mut(0);
            (0..3).for_each(|t| ids[t * 4 + 1] = still(1));
            free.iter().enumerate().filter(|(i, _)| ways >> i & 1 == 1).for_each(|(_, &p)| ids[p] = still(p));
            costs.total(&map)
        };
        let (best, found) = ((0..1 << 9).map(price).min().unwrap(), costs.total(&held));
        assert!(best <= found && found <= price(0), "case {case}");
        least += usize::from(found == best);
        wider += usize::from(found < price(0));
    }
    assert!(34 <= least && 5 < wider, "{least} of 40 the least of all, {wider} wider than their mask");
    let e = of(&changing([10, 3, 4], 1, 2));
    let map = SourceMap::unassigned(&e, Domain::open([5, 3, 5])).unwrap();
    let mask = Grid::try_filled(Domain::open([3, 4]), 1, true).unwrap();
    let held = |frame: u32| hold_still(&e, &map, (&mask, frame), SeamMeasure::Gradient, &Run::seeded(0)).map(drop);
    assert!(matches!(held(10), Err(Error::Core(CoreError::Range { option: "still", .. }))));
    assert!(matches!(held(9), Err(Error::Core(CoreError::StartShape { .. }))));
}
