//! Guides, and what splits a block.

use selvedge_core::{
    Domain, Error as CoreError, ErrorKind, Exemplars, Grid, Guidance, Guide, Run, SeamCosts, SeamMeasure, SourceMap,
    Start,
};
use selvedge_hybrid::{Error, Options, PixelSearch, Plan, Resynthesize, Split, Threshold, hybrid, hybrid_from};
use selvedge_quilting::Continuation;
use selvedge_testkit::{exemplars, simple};

fn of_noise() -> Exemplars<2> {
    Exemplars::of(&[&[simple::noise(40, 32, 4)][..]]).unwrap()
}

/// Of the exemplars the left half shows 0, the right one 200; of the output the upper one 200, the lower one 0.
fn guide(exemplars: &Exemplars<2>, output: Domain<2>) -> Guide<2> {
    let of = |domain: Domain<2>, is_high: &dyn Fn([u32; 2]) -> bool| {
        let samples = domain.positions().map(|at| if is_high(at) { 200 } else { 0 }).collect();
        Grid::from_vec(domain, 1, samples).unwrap()
    };
    let map = of(exemplars.sources()[0].domain(), &|[_, x]| 20 <= x);
    Guide::new(exemplars, &[map], of(output, &|[y, _]| y < output.shape[0] / 2)).unwrap()
}

fn blocks(side: u32) -> Options {
    Options { block: Some([side; 2]), ..Options::default() }
}

fn woven(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    weight: Option<f64>,
    options: &Options,
    seed: u64,
) -> SourceMap<2> {
    let guidance = weight.map(|weight| Guidance { guide: guide(exemplars, output), weight });
    let start = Start::empty(exemplars, output).unwrap();
    hybrid_from(exemplars, start, guidance, options, &Run::seeded(seed)).unwrap().result
}

/// The share of samples that come from the half that is asked for.
fn followed(exemplars: &Exemplars<2>, map: &SourceMap<2>) -> f64 {
    let domain = map.domain();
    let right = domain.positions().filter(|&at| {
        let (_, [_, x]) = exemplars.locate(map.ids.get(0, at)).unwrap();
        (20 <= x) == (at[0] < domain.shape[0] / 2)
    });
    right.count() as f64 / domain.len() as f64
}

#[test]
fn a_guide_is_followed_as_much_as_it_weighs() {
    let (exemplars, output) = (of_noise(), Domain { shape: [48, 40], periodic: [false, true] });
    for options in [
        blocks(8),
        Options { circular: true, ..blocks(16) },
        Options { k: 0.0, resynthesize: Resynthesize::Overlap, search: PixelSearch::Exact, ..blocks(8) },
    ] {
        let share = |weight| followed(&exemplars, &woven(&exemplars, output, weight, &options, 3));
        let shares = [None, Some(0.3), Some(2.0)].map(share);
        assert!(shares[0] < 0.7 && shares[0] < shares[1] && shares[1] <= shares[2] && 0.8 < shares[2], "{shares:?}");
    }
}

#[test]
fn a_guide_of_no_weight_or_that_asks_for_nothing_changes_nothing() {
    let (exemplars, output) = (of_noise(), Domain::open([40, 40]));
    let options = Options { k: 0.2, pixel_error: Threshold::OfRandom(0.01), ..blocks(8) };
    let without = woven(&exemplars, output, None, &options, 1);
    assert_eq!(woven(&exemplars, output, Some(0.0), &options, 1), without);
    let nothing = guide(&exemplars, output).asking(Grid::try_filled(output, 1, false).unwrap()).unwrap();
    let plan = Plan::new(&exemplars, output, &options, &Run::seeded(1)).unwrap();
    let plan = plan.following(Guidance { guide: nothing, weight: 1.0 }).unwrap();
    assert_eq!(plan.weave(&Run::seeded(1)).unwrap().result, without);
}

#[test]
fn what_guides_cannot_be_is_refused() {
    let (exemplars, output) = (of_noise(), Domain::open([30, 30]));
    let refused = |guide: Guide<2>, weight| {
        let plan = Plan::new(&exemplars, output, &blocks(8), &Run::seeded(1)).unwrap();
        plan.following(Guidance { guide, weight }).unwrap_err()
    };
    for weight in [-1.0, f64::NAN, f64::INFINITY] {
        let error = refused(guide(&exemplars, output), weight);
        assert!(matches!(error, Error::Core(CoreError::GuideWeight { .. })), "{error}");
    }
    let other = refused(guide(&exemplars, Domain::open([30, 31])), 1.0);
    assert!(matches!(other, Error::Core(CoreError::GuideTarget { .. })), "{other}");
    let valid = Grid::from_vec(Domain::open([32, 40]), 1, (0..32 * 40).map(|i| i % 7 != 3).collect()).unwrap();
    let masked = refused(guide(&exemplars, output).knowing(&[Some(valid)]).unwrap(), 1.0);
    assert_eq!((&masked, masked.kind()), (&Error::GuideMask, ErrorKind::Input));
}

#[test]
fn blocks_are_split_where_that_makes_seams_cheaper() {
    let exemplars = Exemplars::of(&[&[exemplars::cobbles()][..]]).unwrap();
    let costs = SeamCosts::new(&exemplars, SeamMeasure::Gradient).unwrap();
    // Two blocks, of which the second may be split.
    let (output, mut cheaper, mut dearer) = (Domain::open([32, 64]), 0, 0);
    for seed in 0..12 {
        let price = |split, largest| {
            let max_error = Threshold::OfRandom(largest);
            // What continues the first block would have no seam.
            let continuation = Continuation::Avoid;
            let options = Options { max_error, split, k: 1.0, continuation, ..blocks(32) };
            let woven = hybrid(&exemplars, output, &options, &Run::seeded(seed)).unwrap();
            (costs.total(&woven.result), woven.stats.levels[0].splits)
        };
        let [(whole, none), (always, all), (least, some)] =
            [(Split::Always, 1000.0), (Split::Always, 0.02), (Split::Cheaper, 0.02)].map(|(s, e)| price(s, e));
        assert!(none == 0 && all == 1 && least <= whole, "{seed}: {whole} {always} {least}");
        assert_eq!(some == 0, least == whole, "{seed}: {whole} {always} {least}");
        (cheaper, dearer) = (cheaper + u32::from(least < whole), dearer + u32::from(whole < always));
    }
    assert!(0 < cheaper && 0 < dearer, "{cheaper} {dearer}");
}
