//! What is refused, and in which words.

use selvedge_core::{
    Domain, ErrorKind, Exemplars, Grid, Guidance, Guide, Limits, Plane, Role, Run, Samples, SourceMap,
};
use selvedge_texture_optimization::{
    Animation, Control, Error, Level, Options, Plan, Search, Wanted, optimize, optimize_from,
};

fn exemplars(shape: [u32; 2]) -> Exemplars<2> {
    let domain = Domain::open(shape);
    let noise = (0..domain.len()).map(|i| (i * i / 7) as u8).collect();
    let plane = Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(domain, 1, noise).unwrap()));
    Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap()
}

fn refused(options: Options) -> Error {
    optimize(&exemplars([20, 20]), Domain::open([20, 20]), &options, &Run::seeded(0)).unwrap_err()
}

#[test]
fn options_out_of_range_are_named_with_their_numbers() {
    let with = |scale, size| Options { schedule: vec![Level { scale, size }], ..Options::default() };
    assert_eq!(refused(with(1, 10)), Error::Size { size: 10 });
    assert_eq!(refused(with(3, 8)), Error::Scale { scale: 3 });
    assert_eq!(refused(with(2, 8)), Error::Schedule);
    assert_eq!(refused(Options { schedule: Vec::new(), ..Options::default() }), Error::Schedule);
    for robust in [0.0, -1.0, 2.1, f64::NAN] {
        let error = refused(Options { robust, ..Options::default() });
        assert!(matches!(error, Error::Core(selvedge_core::Error::Amount { what: "an exponent", .. })));
        assert_eq!(error.kind(), ErrorKind::Option);
    }
    for gradient in [-1.0, 101.0, f64::NAN] {
        let error = refused(Options { gradient, ..Options::default() });
        assert!(matches!(error, Error::Core(selvedge_core::Error::Amount { what: "a weight of gradients", .. })));
    }
    let complete = refused(Options { complete: Some(-0.5), ..Options::default() });
    assert_eq!(complete.to_string(), "a completeness of -0.5 is out of range");
    assert_eq!(refused(Options { iterations: 0, ..Options::default() }), Error::Iterations);
    assert_eq!(refused(Options { search: Search::Tree, ..Options::default() }), Error::Tree);
    let even = |search| Options { search, spread: 0.5, ..Options::default() };
    assert_eq!(refused(even(Search::Reference)), Error::Spread);
    let of_frames = |search| Animation { frame: even(search), ..Animation::default() }.validate();
    assert_eq!([Search::Coherent, Search::Exact].map(of_frames), [Err(Error::Spread), Ok(())]);
}

#[test]
fn what_is_too_small_is_said_to_be() {
    let of = |exemplar, output| {
        let exemplars = exemplars(exemplar);
        optimize(&exemplars, Domain::open(output), &Options::default(), &Run::seeded(0)).unwrap_err()
    };
    let small = of([7, 30], [30, 30]);
    assert_eq!(small.to_string(), "no neighborhood of 8 px fits into 30x7 px at full resolution");
    assert_eq!((small.kind(), small.remedy().contains("larger exemplar")), (ErrorKind::Input, true));
    assert_eq!(of([30, 30], [5, 30]).remedy(), "make an output of at least 8x8");
    assert_eq!(of([30, 30], [0, 30]), selvedge_core::Error::EmptyOutput { shape: vec![0, 30] }.into());
}

#[test]
fn starts_that_do_not_fit_are_refused() {
    let (own, other) = (exemplars([20, 20]), exemplars([20, 21]));
    let of = |map: &SourceMap<2>| {
        optimize_from(&own, map, &Control::default(), &Options::default(), &Run::seeded(0)).unwrap_err()
    };
    let output = Domain::open([10, 10]);
    assert_eq!(of(&SourceMap::unassigned(&other, output).unwrap()), Error::ForeignMap);
    assert_eq!(of(&SourceMap::unassigned(&own, output).unwrap()), Error::Holes { holes: 100 });
}

#[test]
fn a_budget_that_does_not_suffice_is_known_before_the_work() {
    let run = Run { limits: Limits { memory: 1 << 16, ..Limits::default() }, ..Run::seeded(0) };
    let refused = optimize(&exemplars([20, 20]), Domain::open([500, 500]), &Options::default(), &run);
    assert_eq!(refused.unwrap_err().kind(), ErrorKind::Memory);
}

#[test]
fn constraints_that_do_not_fit_are_refused() {
    let own = exemplars([20, 20]);
    let output = Domain::open([12, 12]);
    let plan = Plan::new(&own, output, &Options::default(), &Run::seeded(0)).unwrap();
    let of = |control: Control| plan.weave(None, &control, &Run::seeded(0)).unwrap_err();
    let wanted = |shape: Domain<2>, channels, lambda: f32| {
        let features = Grid::try_filled(shape, channels, 0).unwrap();
        let weight = Grid::try_filled(output, 1, lambda).unwrap();
        Control { wanted: Some(Wanted { features, weight }), ..Control::default() }
    };
    let small = of(wanted(Domain::open([9, 12]), 1, 1.0));
    assert_eq!(small.to_string(), "the picture that is wanted is [9, 12, 1], and [12, 12, 1] is needed");
    assert!(matches!(of(wanted(output, 2, 1.0)), Error::Control { .. }));
    assert_eq!(of(wanted(output, 1, -1.0)).to_string(), "a lambda of -1 is out of range");
    assert_eq!(of(wanted(output, 1, f32::NAN)).to_string(), "a lambda of NaN is out of range");
    let heavy = Animation { lambda: 1e308, ..Animation::default() };
    let refused = [of(wanted(output, 1, 2e6)), heavy.validate().unwrap_err()];
    assert!(refused.iter().all(|error| error.remedy() == "use 0 (no wish) to 1000000 (nothing else)"), "{refused:?}");
    let guidance = |target, weight| {
        let map = Grid::try_filled(Domain::open([20, 20]), 1, 0).unwrap();
        let guide = Guide::new(&own, &[map], Grid::try_filled(Domain::open(target), 1, 0).unwrap()).unwrap();
        Control { guidance: Some(Guidance { guide, weight }), ..Control::default() }
    };
    let small = of(guidance([12, 13], 1.0));
    assert_eq!(small.to_string(), "the picture that is followed is [12, 13, 1], and [12, 12, 1] is needed");
    for weight in [-1.0, f64::NAN] {
        let error = of(guidance([12, 12], weight));
        assert!(matches!(error, Error::Core(selvedge_core::Error::GuideWeight { .. })), "{error}");
    }
    let fixed = Some(Grid::try_filled(output, 1, true).unwrap());
    assert_eq!(of(Control { fixed, ..Control::default() }), Error::NothingFixed);
}
