//! What must not be used, must stay, or may show in places only: masks, fixed samples, fields of sources.

use crate::common::{PLACEMENTS, blobs, of, weave};
use selvedge_core::{Domain, Encoder, Exemplar, Exemplars, Grid, Limits, Run, SampleId, Seed, SourceMap, Transform};
use selvedge_graphcut_textures::{Error, Options, Placement, Start, graphcut_from, plan};

#[test]
fn masks_do_not_make_patches_of_single_samples() {
    let plane = blobs([60, 60], 8);
    let mut rng = Seed(8).rng();
    let valid = Domain::open([60, 60]).positions().map(|[_, x]| x < 24 || rng.below(50) == 0).collect();
    let valid = Grid::from_vec(Domain::open([60, 60]), 1, valid).unwrap();
    let planes = [std::slice::from_ref(&plane)];
    let e = Exemplars::new(&Encoder::fit(&planes).unwrap(), &[Exemplar::new(planes[0]).masked(Some(&valid))]).unwrap();
    for placement in PLACEMENTS {
        let options = Options { placement, region: Some([12; 2]), ..Options::default() };
        let (map, stats) = weave(&e, Domain::open([80, 80]), &options);
        let single = map.domain().positions().filter(|&p| map.locate(p).is_some_and(|(_, at)| 24 <= at[1])).count();
        assert!(
            stats.patches < 400 && single < 64,
            "{placement:?}: {} patches, {single} single samples",
            stats.patches
        );
    }
}

#[test]
fn masked_samples_are_never_used() {
    let plane = blobs([30, 30], 5);
    let valid = Domain::open([30, 30]).positions().map(|[y, x]| (y + 2 * x) % 41 > 2 && x < 27).collect();
    let valid = Grid::from_vec(Domain::open([30, 30]), 1, valid).unwrap();
    let planes = [std::slice::from_ref(&plane)];
    let encoder = Encoder::fit(&planes).unwrap();
    let e = Exemplars::new(&encoder, &[Exemplar::new(planes[0]).masked(Some(&valid))]).unwrap();
    for placement in PLACEMENTS {
        let (map, _) = weave(&e, Domain::open([40, 44]), &Options { placement, refine: Some(8), ..Options::default() });
        assert!(map.domain().positions().all(|p| map.locate(p).is_some_and(|(_, at)| valid.get(0, at))));
    }
}

#[test]
fn fixed_samples_stay_to_the_bit() {
    let e = of(&blobs([28, 28], 6));
    let output = Domain::open([40, 40]);
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    let mut fixed = Grid::try_filled(output, 1, false).unwrap();
    for y in 10..20 {
        for x in 15..30 {
            map.ids.set(0, [y, x], SampleId::new((y - 8) * 28 + x - 12));
            fixed.set(0, [y, x], true);
        }
    }
    for placement in PLACEMENTS {
        let start = Start { map: map.clone(), fixed: Some(fixed.clone()), sources: None };
        let options = Options { placement, refine: Some(10), ..Options::default() };
        let woven = graphcut_from(&e, start, &options, &Run::seeded(1)).unwrap();
        assert_eq!(woven.result.holes(), 0);
        for p in output.positions().filter(|&p| fixed.get(0, p)) {
            assert_eq!(woven.result.ids.get(0, p), map.ids.get(0, p));
        }
    }
}

#[test]
fn a_field_of_sources_is_obeyed() {
    let plane = blobs([32, 32], 7);
    let planes = [std::slice::from_ref(&plane)];
    let scales = [1.0, 0.5].map(|scale| Transform::new(0.0, scale, false));
    let e = Exemplars::new(&Encoder::fit(&planes).unwrap(), &[Exemplar::new(planes[0]).shown(&scales)]).unwrap();
    let output = Domain::open([40, 40]);
    let field = output
        .positions()
        .map(|[y, _]| {
            if y < 18 {
                0b10
            } else if y < 24 {
                0b11
            } else {
                0b01
            }
        })
        .collect();
    let field = Grid::from_vec(output, 1, field).unwrap();
    for placement in PLACEMENTS {
        let map = SourceMap::unassigned(&e, output).unwrap();
        let start = Start { map, fixed: None, sources: Some(field.clone()) };
        let options = Options { placement, refine: Some(6), ..Options::default() };
        let woven = graphcut_from(&e, start, &options, &Run::seeded(1)).unwrap();
        for p in output.positions() {
            let (source, _) = woven.result.locate(p).unwrap();
            assert_eq!(field.get(0, p) >> source & 1, 1, "{p:?}");
        }
    }
}

#[test]
fn patches_at_the_border_of_a_field_show_more_than_a_sliver() {
    // The first exemplar stands up to column 29 and may go on for one more: no patch goes on as well as it does itself,
    // but there is one column left for it. The second may show from there on.
    let planes = [blobs([60, 40], 1), blobs([60, 40], 2)];
    let e = Exemplars::of(&planes.each_ref().map(std::slice::from_ref)).unwrap();
    let output = Domain::open([60, 70]);
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    for [y, x] in output.positions().filter(|at| at[1] < 30) {
        map.ids.set(0, [y, x], e.table().id(0, [y, x]));
    }
    let bits = |[_, x]: [u32; 2]| u64::from(x <= 30) | u64::from(30 <= x) << 1;
    let field = Grid::from_vec(output, 1, output.positions().map(bits).collect()).unwrap();
    for placement in PLACEMENTS {
        let start = Start { map: map.clone(), fixed: None, sources: Some(field.clone()) };
        // With less variety a random patch may go on with the first exemplar itself.
        let options =
            Options { placement, region: Some([12; 2]), variety: Some(1.0), refine: Some(0), ..Options::default() };
        let woven = graphcut_from(&e, start, &options, &Run::seeded(1)).unwrap().result;
        assert!((0..60).all(|y| woven.locate([y, 30]).unwrap().0 == 1), "{placement:?}");
    }
}

#[test]
fn where_no_source_has_room_the_roomiest_is_laid() {
    // Stripes of one row and column: no source may show in a fourth of any region.
    let planes = [1, 2, 3, 4, 5].map(|seed| blobs([24, 24], seed));
    let refs = planes.each_ref().map(std::slice::from_ref);
    let e = Exemplars::of(&refs).unwrap();
    let output = Domain::periodic([30, 35]);
    let field = Grid::from_vec(output, 1, output.positions().map(|[y, x]| 1_u64 << ((y + x) % 5)).collect()).unwrap();
    for placement in PLACEMENTS {
        let start =
            Start { map: SourceMap::unassigned(&e, output).unwrap(), fixed: None, sources: Some(field.clone()) };
        let options = Options { placement, refine: Some(9), ..Options::default() };
        let map = graphcut_from(&e, start, &options, &Run::seeded(1)).unwrap().result;
        assert!(output.positions().all(|[y, x]| map.locate([y, x]).unwrap().0 == ((y + x) % 5) as usize));
    }
}

#[test]
fn what_may_not_be_laid_is_not_measured_and_small_sources_are_refined_as_well() {
    // A picture of 120 samples a side with a hole in it, and an exemplar of 24.
    let planes = [blobs([24, 24], 1), blobs([120, 120], 2)];
    let e = Exemplars::of(&planes.each_ref().map(std::slice::from_ref)).unwrap();
    let alone = Exemplars::of(&[std::slice::from_ref(&planes[0])]).unwrap();
    let output = Domain::open([120, 120]);
    let hole = |[y, x]: [u32; 2]| (20..100).contains(&y) && (20..100).contains(&x);
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    for at in output.positions().filter(|&at| !hole(at)) {
        map.ids.set(0, at, e.table().id(1, at));
    }
    let only = |bits: u64| Some(Grid::from_vec(output, 1, vec![bits; output.len()]).unwrap());
    let run = |options: &Options<2>, bits| {
        graphcut_from(&e, Start { map: map.clone(), fixed: None, sources: only(bits) }, options, &Run::seeded(1))
    };
    let woven = run(&Options::default(), 1).unwrap();
    let (_, of_exemplar) = weave(&alone, output, &Options { refine: Some(0), ..Options::default() });
    assert_eq!(
        (woven.stats.settings.region, woven.stats.settings.placement),
        (of_exemplar.settings.region, of_exemplar.settings.placement)
    );
    assert!(0 < woven.stats.improvements);
    let large = Options { region: Some([30; 2]), ..Options::default() };
    assert!(matches!(run(&large, 1), Err(Error::RegionExceedsExemplar { .. })));

    // Where the larger one may be laid as well, but only in a corner, all else is the small one's to refine.
    let bits = |at: [u32; 2]| if at == [0, 0] { 0b11 } else { 0b01 };
    let field = Grid::from_vec(output, 1, output.positions().map(bits).collect()).unwrap();
    let start = Start { map: SourceMap::unassigned(&e, output).unwrap(), fixed: None, sources: Some(field) };
    let woven = graphcut_from(&e, start, &large, &Run::seeded(1)).unwrap();
    assert!(10 < woven.stats.improvements, "{}", woven.stats.improvements);
}

#[test]
fn a_mask_of_one_sample_is_laid_everywhere_at_once() {
    let plane = blobs([64, 64], 1);
    let only = |at: [u32; 2]| at == [20, 30];
    let domain = plane.domain();
    let mask = Grid::from_vec(domain, 1, domain.positions().map(only).collect()).unwrap();
    let planes = std::slice::from_ref(&plane);
    let e = Exemplars::new(&Encoder::fit(&[planes]).unwrap(), &[Exemplar::new(planes).masked(Some(&mask))]).unwrap();
    // One position fits, and it is known without a search of all others.
    let plan = plan(&e, Domain::open([40, 40]), None, &Options::default(), &Limits::default()).unwrap();
    assert_eq!((plan.settings.region, plan.settings.reach), ([1; 2], [1; 2]));
    for placement in [Placement::Random, Placement::Sub, Placement::Entire] {
        let options = Options { placement, ..Options::default() };
        let map = weave(&e, Domain::open([40, 40]), &options).0;
        assert!(map.ids.plane(0).iter().all(|&id| e.locate(id) == Some((0, [20, 30]))));
    }
}

/// Searches that masks of chance may cost beside a run without one: each takes as long as any other.
#[test]
fn masks_of_noise_take_no_more_than_twice_as_many_patches() {
    let plane = blobs([96, 96], 1);
    let (domain, planes) = (plane.domain(), std::slice::from_ref(&plane));
    let encoder = Encoder::fit(&[planes]).unwrap();
    let patches = |mask: Option<&Grid<bool, 2>>| {
        let e = Exemplars::new(&encoder, &[Exemplar::new(planes).masked(mask)]).unwrap();
        let (map, stats) = weave(&e, Domain::open([192, 192]), &Options::default());
        assert!(map.ids.plane(0).iter().all(|id| id.is_assigned()), "everything is covered");
        let shown = map.ids.plane(0).iter().filter_map(|&id| e.locate(id));
        assert!(mask.is_none_or(|mask| shown.clone().all(|(_, at)| mask.get(0, at))), "nothing masked shows");
        stats.patches + stats.refinements
    };
    let whole = patches(None);
    for valid in [200, 500, 800, 950] {
        let mut rng = Seed(valid.into()).rng();
        let mask = Grid::from_vec(domain, 1, (0..domain.len()).map(|_| rng.below(1000) < valid).collect()).unwrap();
        let noisy = patches(Some(&mask));
        assert!(noisy <= 2 * whole, "{valid} of 1000: {noisy} for {whole}");
    }
}

#[test]
fn samples_scattered_by_a_mask_are_strewn_without_a_search() {
    let plane = blobs([96, 96], 1);
    let (domain, planes) = (plane.domain(), std::slice::from_ref(&plane));
    let valid = |at: [u32; 2]| [[3, 80], [41, 7], [60, 62], [90, 33]].contains(&at);
    let mask = Grid::from_vec(domain, 1, domain.positions().map(valid).collect()).unwrap();
    let e = Exemplars::new(&Encoder::fit(&[planes]).unwrap(), &[Exemplar::new(planes).masked(Some(&mask))]).unwrap();
    for placement in [Placement::Random, Placement::Sub, Placement::Entire] {
        let (map, stats) = weave(&e, Domain::open([60, 50]), &Options { placement, ..Options::default() });
        let mut shown = [0; 4];
        for &id in map.ids.plane(0) {
            let at = e.locate(id).unwrap().1;
            shown[[3, 41, 60, 90].iter().position(|&y| y == at[0]).unwrap()] += 1;
            assert!(valid(at), "{at:?}");
        }
        assert!(shown.iter().all(|&n| 500 < n), "each as often as any other: {shown:?}");
        assert!(stats.cuts < 100, "{} cuts of {} samples", stats.cuts, stats.patches);
    }
}
