//! What exemplars refuse, and what becomes of what they are given.

use super::*;
use crate::{Role, Samples};

fn rgba(alpha: [u8; 2]) -> Plane<2> {
    let samples = vec![1, 2, 3, 4, 5, 6, alpha[0], alpha[1]];
    Plane::with_alpha(Role::Color, Samples::U8(Grid::from_vec(Domain::open([1, 2]), 4, samples).unwrap()))
}

#[test]
fn transparent_samples_are_not_valid() {
    let plane = rgba([0, 9]);
    let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
    assert_eq!(exemplars.channels(), 3);
    assert_eq!(exemplars.sources()[0].valid.as_deref().unwrap().samples(), [false, true]);
}

#[test]
fn fully_transparent_exemplars_are_refused() {
    let plane = rgba([0, 0]);
    assert_eq!(Exemplars::of(&[std::slice::from_ref(&plane)]), Err(Error::NothingValid));
}

#[test]
fn exemplars_without_samples_or_channels_are_no_masked_ones() {
    let plane = Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(Domain::open([0, 4]), 1, Vec::new()).unwrap()));
    let empty = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap_err();
    assert_eq!(empty, Error::EmptyExemplar { exemplar: 0, shape: vec![0, 4] });
    assert_eq!(empty.to_string(), "exemplar 0 is empty: it has 4x0 px");
    let origin = Origin { exemplar: 2, transform: Transform::IDENTITY };
    let features = Grid::from_vec(Domain::open([1, 1]), 0, Vec::new()).unwrap();
    let none = Exemplars::from_sources(vec![Source { features, valid: None, origin }], Vec::new());
    assert_eq!(none, Err(Error::NoChannels { exemplar: 2 }));
}

#[test]
fn each_orientation_is_a_source() {
    let plane = rgba([1, 1]);
    let planes = [std::slice::from_ref(&plane)];
    let turn = Transform::Exact { quarter_turns: 1, mirror: false };
    let encoder = Encoder::fit(&planes).unwrap();
    let exemplars = Exemplars::new(&encoder, &[Exemplar::new(planes[0]).shown(&[Transform::IDENTITY, turn])]).unwrap();
    assert_eq!(exemplars.sources()[1].domain().shape, [2, 1]);
    assert_eq!(exemplars.sources()[1].features.plane(0), [1, 2]);
    assert_eq!(exemplars.locate(SampleId::new(3)), Some((1, [1, 0])));
}

#[test]
fn a_view_of_some_sources_shares_them() {
    let plane = rgba([1, 1]);
    let transforms = [Transform::new(90.0, 1.0, false), Transform::IDENTITY, Transform::new(30.0, 1.0, true)];
    let encoder = Encoder::fit(&[std::slice::from_ref(&plane)]).unwrap();
    let exemplar = Exemplar::new(std::slice::from_ref(&plane)).shown(&transforms);
    let all = Exemplars::new(&encoder, &[exemplar, exemplar]).unwrap();
    let origins: Vec<Transform> = all.sources().iter().map(|s| s.origin.transform).collect();
    assert_eq!(origins, [transforms, transforms].concat(), "in the order asked for");
    let some = all.only([4, 0]).unwrap();
    assert!(Arc::ptr_eq(&some.sources()[0], &all.sources()[4]) && Arc::ptr_eq(&some.sources()[1], &all.sources()[0]));
    assert_eq!(some.locate(SampleId::new(3)), Some((1, [1, 0])));
    assert_eq!(all.only([]), Err(Error::NoExemplars));
}

#[test]
fn a_mask_of_another_size_is_refused() {
    let plane = rgba([1, 1]);
    let planes = [std::slice::from_ref(&plane)];
    let mask = Grid::try_filled(Domain::open([2, 2]), 1, true).unwrap();
    let encoder = Encoder::fit(&planes).unwrap();
    let masked = Exemplars::new(&encoder, &[Exemplar::new(planes[0]).masked(Some(&mask))]);
    let words = masked.unwrap_err().to_string();
    assert_eq!(words, "the mask of exemplar 0 is 2x2 px, but the exemplar is 2x1 px");
}
