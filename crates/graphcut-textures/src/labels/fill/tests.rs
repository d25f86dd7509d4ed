//! What fills show, and from where.

use selvedge_core::{Exemplars, Observer, Origin, Seed, Source, Transform};

use super::*;
use crate::labels::dominant_offsets;

/// Noise of a period in each of some sources.
fn periodic(shape: [u32; 2], period: [u32; 2], sources: usize) -> Exemplars<2> {
    let domain = Domain::open(shape);
    let source = |number: usize| {
        let mut rng = Seed(number as u64).rng();
        let cell: Vec<u8> = (0..period[0] * period[1]).map(|_| rng.below(256) as u8).collect();
        let value = |[y, x]: [u32; 2]| cell[(y % period[0] * period[1] + x % period[1]) as usize];
        let features = Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap();
        let origin = Origin { exemplar: number as u16, transform: Transform::IDENTITY };
        Source { features, valid: None, origin }
    };
    Exemplars::from_sources((0..sources).map(source).collect(), vec![1]).unwrap()
}

/// The first source with holes, which cannot be copied from.
fn holed(e: &Exemplars<2>, hole: impl Fn([u32; 2]) -> bool) -> (Exemplars<2>, Start<2>) {
    let domain = e.sources()[0].domain();
    let mut sources: Vec<Source<2>> = e.sources().iter().map(|source| (**source).clone()).collect();
    let valid = domain.positions().map(|at| !hole(at)).collect();
    sources[0].valid = Some(Grid::from_vec(domain, 1, valid).unwrap().into());
    let e = Exemplars::from_sources(sources, vec![1]).unwrap();
    let mut map = SourceMap::unassigned(&e, domain).unwrap();
    for (i, at) in domain.positions().enumerate().filter(|(_, at)| !hole(*at)) {
        map.ids.plane_mut(0)[i] = e.table().id(0, at);
    }
    (e, Start { map, fixed: None, sources: None })
}

#[test]
fn what_repeats_itself_is_whole_again() {
    let whole = periodic([60, 64], [7, 11], 1);
    let (e, start) = holed(&whole, |[y, x]| y.abs_diff(30) < 8 && x.abs_diff(28) < 9);
    let woven = fill(&e, start, &FillOptions::default(), &Run::seeded(0)).unwrap();
    let features = &whole.sources()[0].features;
    for at in woven.result.domain().positions() {
        let (_, from) = woven.result.locate(at).unwrap();
        assert_eq!(features.get(0, from), features.get(0, at), "{at:?} from {from:?}");
    }
    assert_eq!((woven.stats.grown, woven.stats.filled), (0, 15 * 17));
}

#[test]
fn holes_show_sources_that_may_be_used_there_alone() {
    let whole = periodic([60, 64], [7, 11], 2);
    let hole = |[y, x]: [u32; 2]| y.abs_diff(30) < 8 && x.abs_diff(28) < 9;
    let (e, mut start) = holed(&whole, hole);
    // The picture itself would be without a seam; its left half must be of the other one.
    let bits = |[_, x]: [u32; 2]| if x < 28 { 0b10 } else { 0b11 };
    let domain = start.map.domain();
    start.sources = Some(Grid::from_vec(domain, 1, domain.positions().map(bits).collect()).unwrap());
    let woven = fill(&e, start, &FillOptions::default(), &Run::seeded(0)).unwrap();
    for at in domain.positions().filter(|at| hole(*at)) {
        let (source, _) = woven.result.locate(at).unwrap();
        assert!(bits(at) >> source & 1 == 1, "{at:?} shows source {source}");
    }
}

#[test]
fn specks_everywhere_are_filled_by_labels() {
    let whole = periodic([420, 40], [9, 7], 1);
    // At the next level each 8x8 patch would have one.
    let speck = |[y, x]: [u32; 2]| (y % 12, x % 12) == (5, 5);
    let (e, start) = holed(&whole, speck);
    let woven = fill(&e, start, &FillOptions::default(), &Run::seeded(0)).unwrap();
    assert!(0 < woven.stats.offsets && 0 < woven.stats.used, "{:?}", woven.stats);
    assert_eq!((woven.stats.levels, woven.stats.grown), (1, 0));
    let features = &whole.sources()[0].features;
    let same = |at: &[u32; 2]| features.get(0, woven.result.locate(*at).unwrap().1) == features.get(0, *at);
    assert!(woven.result.domain().positions().all(|at| same(&at)));
}

#[test]
fn clips_are_halved_in_their_frames_alone() {
    let clip = |shape| {
        let domain = Domain::open(shape);
        let value = |[t, y, x]: [u32; 3]| (t % 3 * 80 + y % 4 * 20 + x % 5 * 3) as u8;
        let features = Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap();
        let hole = |[t, y, x]: [u32; 3]| t.abs_diff(9) < 2 && y.abs_diff(5) < 2 && x.abs_diff(21) < 3;
        let valid = Grid::from_vec(domain, 1, domain.positions().map(|at| !hole(at)).collect()).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let source = Source { features, valid: Some(valid.into()), origin };
        let e = Exemplars::from_sources(vec![source], vec![1]).unwrap();
        let mut map = SourceMap::unassigned(&e, domain).unwrap();
        for (i, at) in domain.positions().enumerate().filter(|(_, at)| !hole(*at)) {
            map.ids.plane_mut(0)[i] = e.table().id(0, at);
        }
        (e, map)
    };
    let options = FillOptions::default();
    let (e, map) = clip([14, 16, 420]);
    let all = levels(&e, map.clone(), None, &options).unwrap();
    let holes = all.iter().map(|level| level.standing.holes()).collect::<Vec<_>>();
    // Frames 8 to 10, of rows 4 to 6 and columns 19 to 23 in blocks of two.
    assert_eq!((all[1].standing.domain().shape, &holes[..]), ([14, 8, 210], &[3 * 3 * 5, 3 * 2 * 3][..]));
    let start = Start { map, fixed: None, sources: None };
    let woven = fill(&e, start, &options, &Run::seeded(0)).unwrap();
    assert_eq!((woven.result.holes(), woven.stats.filled), (0, 3 * 3 * 5));
    // However many frames there are.
    let (e, map) = clip([430, 12, 24]);
    assert_eq!(levels(&e, map, None, &options).unwrap().len(), 1);
}

#[test]
fn patches_without_samples_are_refused() {
    let (e, start) = holed(&periodic([20, 20], [5, 5], 1), |at| at == [4, 4]);
    let none = OffsetOptions { side: 0, ..OffsetOptions::default() };
    let options = FillOptions { offsets: none, ..FillOptions::default() };
    let range = |error: Error| matches!(error, Error::Core(CoreError::Range { .. }));
    assert!(range(dominant_offsets(&e, &start.map, &none).unwrap_err()));
    assert!(range(fill(&e, start, &options, &Run::seeded(0)).unwrap_err()));
}

#[test]
fn a_fill_that_is_cancelled_keeps_what_stands() {
    struct Stop;
    impl Observer<2> for Stop {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let (e, start) = holed(&periodic([40, 40], [5, 9], 1), |[y, x]| y < 9 && x < 9);
    let run = Run { observer: &Stop, ..Run::seeded(0) };
    let woven = fill(&e, start.clone(), &FillOptions::default(), &run).unwrap();
    assert!(!woven.complete);
    let stood = start.map.ids.plane(0).iter().zip(woven.result.ids.plane(0));
    assert!(stood.filter(|(stood, _)| stood.is_assigned()).all(|(stood, shows)| stood == shows));
}

#[test]
fn nobody_looks_for_labels_once_it_is_cancelled() {
    let (e, start) = holed(&periodic([40, 40], [5, 9], 1), |[y, x]| y < 9 && x < 9);
    for cancelled in [false, true] {
        let found = repeating(&e, &start.map, &OffsetOptions::default(), &|| cancelled).unwrap();
        let beside = continuing(&e, &start.map, 12, 1, &|| cancelled).unwrap();
        assert_eq!([found.is_empty(), beside.is_empty()], [cancelled; 2]);
    }
}
