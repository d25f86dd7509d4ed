//! Maps that are solved small and carried up.

use crate::common::{PLACEMENTS, blobs, of, weave};
use selvedge_core::{
    Domain, Encoder, Error as CoreError, Event, Exemplar, Exemplars, Grid, Limits, Observer, Run, SeamCosts,
    SeamMeasure, SimdLevel, SourceMap, Start,
};
use selvedge_graphcut_textures::video::Ends;
use selvedge_graphcut_textures::{Error, Options, graphcut, graphcut_from, plan};
use std::sync::Mutex;

/// Two exemplars of odd sides, the second with a masked disc.
fn masked() -> Exemplars<2> {
    let planes = [blobs([67, 70], 1), blobs([53, 48], 2)];
    let disc = |[y, x]: [u32; 2]| 64 < y.abs_diff(20).pow(2) + x.abs_diff(30).pow(2);
    let domain = planes[1].domain();
    let mask = Grid::from_vec(domain, 1, domain.positions().map(disc).collect()).unwrap();
    let [a, b] = planes.each_ref().map(std::slice::from_ref);
    let exemplars = [Exemplar::new(a), Exemplar::new(b).masked(Some(&mask))];
    Exemplars::new(&Encoder::fit(&[a, b]).unwrap(), &exemplars).unwrap()
}

#[test]
fn carried_maps_are_whole_and_show_only_what_is_valid() {
    let e = masked();
    for levels in [2, 3] {
        for (placement, periodic) in PLACEMENTS.into_iter().zip([[false; 2], [true; 2], [false, true], [true; 2]]) {
            let options = Options { placement, levels: Some(levels), ..Options::default() };
            let (map, stats) = weave(&e, Domain { shape: [101, 96], periodic }, &options);
            assert_eq!(stats.settings.levels, levels);
            for &id in map.ids.plane(0) {
                let (source, at) = e.locate(id).unwrap();
                assert!(e.sources()[source].valid.as_deref().is_none_or(|v| v.get(0, at)), "{source} {at:?}");
            }
        }
    }
}

#[test]
fn levels_cost_little_in_seams_and_less_than_what_was_carried_up() {
    let e = of(&blobs([96, 90], 4));
    let (output, options) = (Domain::open([190, 200]), Options { levels: Some(2), ..Options::default() });
    let costs = SeamCosts::new(&e, SeamMeasure::Gradient).unwrap();
    let price = |levels, seed| {
        let options = Options { levels: Some(levels), ..Options::default() };
        costs.total(&graphcut(&e, output, &options, &Run::seeded(seed)).unwrap().result)
    };
    let small = e.coarser().unwrap();
    // The same regions at half the size.
    let plan = plan(&e, output, None, &options, &Limits::default()).unwrap();
    let [region, reach] = [plan.settings.region, plan.settings.reach].map(|sides| Some(sides.map(|n| n / 2)));
    let coarse = Options { placement: plan.settings.placement, region, reach, levels: Some(1), ..options };
    let carried = |seed| {
        let woven = graphcut(&small, output.coarser(), &coarse, &Run::seeded(seed)).unwrap();
        costs.total(&woven.result.finer(&e, output).unwrap())
    };
    let of = |levels| (0..4).map(|seed| price(levels, seed)).sum::<i64>();
    let ([one, two], carried) = ([of(1), of(2)], (0..4).map(carried).sum::<i64>());
    assert!(two < one * 3 / 2, "{one} at one size, {two} at two");
    assert!(two < carried * 9 / 10, "{carried} as it was carried up, {two} once it was decided");
}

#[test]
fn no_source_vanishes_behind_a_fine_mask() {
    let planes = [blobs([400, 400], 1), blobs([400, 390], 2)];
    // A lattice of lines three samples apart leaves few blocks at half the size, and none at a fourth.
    let lattice = |[y, x]: [u32; 2]| y % 3 != 0 && x % 3 != 0;
    let domain = planes[1].domain();
    let fine = Grid::from_vec(domain, 1, domain.positions().map(lattice).collect()).unwrap();
    let [a, b] = planes.each_ref().map(std::slice::from_ref);
    let levels = |mask: Option<&Grid<bool, 2>>, asked| {
        let exemplars = [Exemplar::new(a), Exemplar::new(b).masked(mask)];
        let e = Exemplars::new(&Encoder::fit(&[a, b]).unwrap(), &exemplars).unwrap();
        plan(&e, Domain::open([600, 600]), None, &Options { levels: asked, ..Options::default() }, &Limits::default())
            .unwrap()
            .settings
            .levels
    };
    assert_eq!([levels(None, None), levels(None, Some(3))], [2, 3]);
    assert_eq!([levels(Some(&fine), None), levels(Some(&fine), Some(3))], [1, 1]);
}

#[test]
fn carried_maps_do_not_depend_on_threads() {
    let e = masked();
    let output = Domain { shape: [150, 130], periodic: [true, false] };
    let options = Options { levels: Some(2), ..Options::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| graphcut(&e, output, &options, &Run::seeded(7)).unwrap().result)
    };
    let one = on(1);
    assert!([2, 3].into_iter().all(|threads| on(threads) == one));
}

/// The energies after each finer level, and how many events had a map.
#[derive(Default)]
struct Notes(Mutex<(Vec<i64>, usize)>);

impl Observer<2> for Notes {
    fn event(&self, event: &Event<'_, 2>) {
        let mut notes = self.0.lock().unwrap();
        if event.stage == "settle" {
            notes.0.extend(event.energy);
        }
        notes.1 += usize::from(event.so_far.is_some());
    }
}

#[test]
fn only_maps_of_the_exemplars_are_shown_while_a_run_goes_on() {
    let e = of(&blobs([64, 64], 5));
    let notes = Notes::default();
    let options = Options { levels: Some(3), ..Options::default() };
    let run = Run { observer: &notes, ..Run::seeded(1) };
    let woven = graphcut(&e, Domain::open([100, 100]), &options, &run).unwrap();
    let (energies, maps) = notes.0.into_inner().unwrap();
    assert_eq!((energies.len(), maps), (2, 1));
    assert_eq!(energies[1], SeamCosts::new(&e, options.seam).unwrap().total(&woven.result));
}

#[test]
fn what_stands_is_gone_on_from_at_one_size() {
    let e = of(&blobs([400, 400], 6));
    let output = Domain::open([410, 400]);
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    map.ids.plane_mut(0)[0] = e.table().id(0, [3, 3]);
    let start = || Start { map: map.clone(), fixed: None, sources: None };
    let options = Options { refine: Some(0), ..Options::default() };
    let woven = graphcut_from(&e, start(), &options, &Run::seeded(0)).unwrap();
    assert_eq!(woven.stats.settings.levels, 1);
    let asked = Options { levels: Some(2), ..options };
    let refused = graphcut_from(&e, start(), &asked, &Run::seeded(0)).unwrap_err();
    assert_eq!(refused, Error::LevelsOfStart { levels: 2 });
    let empty = Start { map: SourceMap::unassigned(&e, output).unwrap(), fixed: None, sources: None };
    assert_eq!(graphcut_from(&e, empty, &options, &Run::seeded(0)).unwrap().stats.settings.levels, 2);
    for levels in [0, 9] {
        let wrong = Options { levels: Some(levels), ..options };
        assert!(matches!(
            graphcut(&e, output, &wrong, &Run::seeded(0)),
            Err(Error::Core(CoreError::Range { option: "levels", .. }))
        ));
    }
}

#[test]
fn carried_maps_do_not_depend_on_instructions_nor_on_limits_that_admit_them() {
    let e = masked();
    let (output, options) = (Domain::open([120, 140]), Options { levels: Some(2), ..Options::default() });
    let on = |simd, limits| graphcut(&e, output, &options, &Run { simd, limits, ..Run::seeded(8) }).map(|w| w.result);
    let first = on(SimdLevel::Auto, Limits::default()).unwrap();
    for simd in [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::AvxVnni] {
        assert_eq!(on(simd, Limits::default()).unwrap(), first, "{simd:?}");
    }
    let memory = plan(&e, output, None, &options, &Limits::default()).unwrap().bytes().0;
    assert_eq!(on(SimdLevel::Auto, Limits { memory, ..Limits::default() }).unwrap(), first);
    let refused = on(SimdLevel::Auto, Limits { memory: 1 << 20, ..Limits::default() });
    assert!(matches!(refused, Err(Error::Core(CoreError::OverBudget { .. }))), "{refused:?}");
}

#[test]
fn where_a_carried_map_closes_its_seam_is_priced() {
    let e = of(&blobs([90, 96], 7));
    let costs = SeamCosts::new(&e, SeamMeasure::Gradient).unwrap();
    let options = Options { levels: Some(2), ..Options::default() };
    // Odd around one axis, so that the last coarse sample stands for the last and the first one.
    let closed = Domain { shape: [131, 140], periodic: [true; 2] };
    let around = |map: &SourceMap<2>| {
        let mut closed = SourceMap::unassigned(&e, closed).unwrap();
        closed.ids.plane_mut(0).copy_from_slice(map.ids.plane(0));
        costs.total(&closed)
    };
    let sum =
        |output| (0..4).map(|seed| around(&graphcut(&e, output, &options, &Run::seeded(seed)).unwrap().result)).sum();
    let [tiled, open]: [i64; 2] = [closed, Domain::open(closed.shape)].map(sum);
    assert!(tiled * 4 < open * 3, "{tiled} tiled, {open} where ends meet by chance");
}

/// Clips that loop, moved in time alone and along all axes.
fn looped_clips() -> [(Exemplars<3>, Domain<3>, Options<3>); 2] {
    let e = of(&blobs([20, 48, 56], 9));
    let looped = |shape| Domain { shape, periodic: [true, false, false] };
    let options = Options { refine: Some(4), ..Options::default() };
    let in_time = Options { free: [true, false, false], ..options };
    [(e.clone(), looped([31, 48, 56]), in_time), (e, looped([24, 60, 66]), options)]
}

#[test]
fn clips_are_halved_in_space_alone_and_do_not_depend_on_threads() {
    for (e, output, options) in looped_clips() {
        let options = Options { levels: Some(2), ..options };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| graphcut(&e, output, &options, &Run::seeded(5)).unwrap())
        };
        let one = on(1);
        assert_eq!((one.stats.settings.levels, one.stats.settled.len(), one.result.holes()), (2, 1, 0));
        assert!([2, 3].into_iter().all(|threads| on(threads).result == one.result));
        let moved = output.positions().filter(|&at| one.result.locate(at).unwrap().1[1..] != at[1..]).count();
        assert_eq!(moved == 0, !options.free[1], "{:?}", options.free);
        let times = output.positions().map(|at| one.result.locate(at).unwrap().1[0] + output.shape[0] - at[0]);
        assert!(times.collect::<std::collections::BTreeSet<_>>().iter().any(|by| by % 2 == 1), "of single frames");
    }
}

#[test]
fn what_stands_in_parts_of_frames_is_gone_on_from_at_one_size() {
    let e = of(&blobs([20, 48, 56], 9));
    let output = Domain::open([24, 60, 66]);
    let options = Options { refine: Some(4), ..Options::default() };
    // Columns of odd numbers stay, which no frame of half the size holds.
    let start = |stays: fn([u32; 3]) -> bool| {
        let mut map = SourceMap::unassigned(&e, output).unwrap();
        let mut fixed = Grid::try_filled(output, 1, false).unwrap();
        for at @ [t, y, x] in output.positions().filter(|at| stays(*at)).collect::<Vec<_>>() {
            map.ids.set(0, at, e.table().id(0, [t % 20, y % 48, x % 56]));
            fixed.set(0, at, true);
        }
        Start { map, fixed: Some(fixed), sources: None }
    };
    let columns = || start(|[_, _, x]| x % 16 == 5);
    let at = |levels| graphcut_from(&e, columns(), &Options { levels, ..options }, &Run::seeded(5));
    let woven = at(None).unwrap();
    assert_eq!(woven.stats.settings.levels, 1);
    assert_eq!(at(Some(2)).unwrap_err(), Error::LevelsOfStart { levels: 2 });
    // Of whole frames some may stay in part.
    let frames = || start(|[t, ..]| t < 4);
    let woven = graphcut_from(&e, frames(), &Options { levels: Some(2), ..options }, &Run::seeded(5)).unwrap();
    assert_eq!(woven.stats.settings.levels, 2);
    let mut parts = frames();
    parts.fixed.as_mut().unwrap().set(0, [2, 9, 9], false);
    let refused = graphcut_from(&e, parts, &Options { levels: Some(2), ..options }, &Run::seeded(5));
    assert_eq!(refused.unwrap_err(), Error::LevelsOfStart { levels: 2 });
}

#[test]
fn frames_that_stand_are_halved_and_stay() {
    for (e, output, options) in looped_clips() {
        // Some of the clip, some of its first frames again, and frames between that may change.
        let ends = Ends::woven(
            graphcut(&e, Domain::open([4, output.shape[1], output.shape[2]]), &options, &Run::seeded(2))
                .unwrap()
                .result,
        );
        let start = || {
            let mut start = ends.start(output.shape[0]).unwrap();
            let frame = output.strides()[0];
            let own = start.map.ids.plane(0)[3 * frame..4 * frame].to_vec();
            start.map.ids.plane_mut(0)[4 * frame..5 * frame].copy_from_slice(&own);
            start
        };
        let at = |levels, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let options = Options { levels: Some(levels), ..options };
            pool.install(|| graphcut_from(&e, start(), &options, &Run::seeded(5)).unwrap())
        };
        let [one, two] = [1, 2].map(|levels| at(levels, 1));
        assert_eq!((two.stats.settings.levels, two.stats.settled.len(), two.result.holes()), (2, 1, 0));
        assert!([2, 3].into_iter().all(|threads| at(2, threads).result == two.result));
        let Start { map, fixed, .. } = start();
        let stays = fixed.unwrap();
        let same = |place: &usize| two.result.ids.plane(0)[*place] == map.ids.plane(0)[*place];
        assert!((0..stays.samples().len()).filter(|&place| stays.samples()[place]).all(|place| same(&place)));
        let costs = SeamCosts::new(&e, options.seam).unwrap();
        let [one, two] = [one, two].map(|woven| costs.total(&woven.result));
        assert!(two < one * 5 / 4, "{one} at one size, {two} at two, moved along {:?}", options.free);
    }
}

#[test]
fn levels_of_clips_cost_little_in_seams() {
    for (e, output, options) in looped_clips() {
        let costs = SeamCosts::new(&e, options.seam).unwrap();
        let price = |levels, seed| {
            let options = Options { levels: Some(levels), ..options };
            costs.total(&graphcut(&e, output, &options, &Run::seeded(seed)).unwrap().result)
        };
        let of = |levels| (0..3).map(|seed| price(levels, seed)).sum::<i64>();
        let [one, two] = [of(1), of(2)];
        assert!(two < one * 5 / 4, "{one} at one size, {two} at two, moved along {:?}", options.free);
    }
}

#[test]
fn what_moves_in_time_alone_has_a_sample_for_each_at_every_size() {
    let levels = |height: u32| {
        let e = of(&blobs([12, height, 96], 3));
        let output = Domain::open([20, height, 96]);
        let options = Options { free: [true, false, false], refine: Some(0), ..Options::default() };
        let plan = |levels| plan(&e, output, None, &Options { levels, ..options }, &Limits::default()).unwrap();
        assert_eq!(graphcut(&e, output, &options, &Run::seeded(1)).unwrap().result.holes(), 0);
        [None, Some(3)].map(|asked| plan(asked).settings.levels)
    };
    assert_eq!([96, 98, 97].map(levels), [[3, 3], [2, 2], [1, 1]]);
}
