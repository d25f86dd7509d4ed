//! At the edges of what is allowed: constant pictures, outputs that go around and are smaller than an exemplar.

use crate::{Constraint, Options, analogy};
use selvedge_core::{Domain, Exemplars, Grid, Guide, Origin, Run, Source, Transform};

/// Exemplars longer than an output that goes around: any part of them may show, not their first corner alone.
#[test]
fn every_sample_can_show_in_a_smaller_output_that_goes_around() {
    let source = Domain::open([40, 48]);
    let right = |at: [u32; 2]| u8::from(24 <= at[1]) * 200;
    let map = |domain: Domain<2>, value: &dyn Fn([u32; 2]) -> u8| {
        Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap()
    };
    let valid = Grid::from_vec(source, 1, source.positions().map(|[y, x]| 20 <= y && 20 <= x).collect()).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let features = map(source, &|[y, x]| (y * 5 + x * 3) as u8);
    for valid in [None, Some(valid)] {
        let sources = vec![Source { features: features.clone(), valid, origin }];
        let exemplars = Exemplars::from_sources(sources, vec![1]).unwrap();
        let output = Domain::periodic([12, 15]);
        let guide = Guide::new(&exemplars, &[map(source, &right)], map(output, &|_| 200)).unwrap();
        let constraints = vec![Constraint { guide, ratio: 1, weight: 1.0 }];
        for random_labels in [None, Some(5)] {
            let options = Options { constraint_weight: 30.0, neighborhood: 1, random_labels, ..Options::paper() };
            let woven = analogy(&exemplars, &constraints, &options, &Run::seeded(2)).unwrap();
            assert_eq!(woven.result.holes(), 0);
            let shows = |i: usize| exemplars.locate(woven.result.ids.plane(0)[i]).unwrap().1;
            let follows = (0..output.len()).all(|i| 24 <= shows(i)[1]);
            assert!(follows || random_labels.is_some(), "the label is in the right half");
        }
    }
}

#[test]
fn constant_pictures_end() {
    for (value, target) in [(7, 7), (0, 255)] {
        let domain = Domain::open([9, 9]);
        let flat = |value| Grid::try_filled(domain, 1, value).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let source = Source { features: flat(value), valid: None, origin };
        let exemplars = Exemplars::from_sources(vec![source], vec![1]).unwrap();
        let guide =
            Guide::new(&exemplars, &[flat(value)], Grid::try_filled(Domain::open([30, 20]), 1, target).unwrap());
        let options = Options { tolerance: Some(0.0), ..Options::paper() };
        let woven = analogy(&exemplars, &[Constraint::new(guide.unwrap())], &options, &Run::seeded(0)).unwrap();
        assert_eq!((woven.result.holes(), woven.stats.model.boundary), (0, 0));
    }
}
