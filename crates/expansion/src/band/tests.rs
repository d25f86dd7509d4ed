//! Bands against distances by their definition, and their cuts against those of everything.

use super::*;
use crate::{Holes, Scratch, expand};
use selvedge_core::{
    Exemplars, Grid, Origin, Patch, Rng, SeamCosts, SeamMeasure, Seed, Source, SourceMap, Transform, Window,
};

/// Two sources of few grey levels, the second with masked samples, and a map of patches of both with some holes; all
/// sides up to `most`, axes open or periodic.
pub(crate) fn patched<const D: usize>(rng: &mut Rng, most: u32, holes: bool) -> (Exemplars<D>, SourceMap<D>) {
    let mut source = |exemplar| {
        let domain = Domain { shape: [most + 4; D], periodic: std::array::from_fn(|_| rng.below(3) == 0) };
        let features = (0..domain.len()).map(|_| (rng.below(5) * 50) as u8).collect();
        let valid = (0..domain.len()).map(|_| rng.below(16) != 0).collect();
        Source {
            features: Grid::from_vec(domain, 1, features).unwrap(),
            valid: (exemplar == 1).then(|| Grid::from_vec(domain, 1, valid).unwrap()).map(Into::into),
            origin: Origin { exemplar, transform: Transform::IDENTITY },
        }
    };
    let e = Exemplars::from_sources(vec![source(0), source(1)], vec![1]).unwrap();
    let shape = std::array::from_fn(|_| 1 + rng.below(most));
    let output = Domain { shape, periodic: std::array::from_fn(|_| rng.below(2) == 0) };
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    for n in 0..6 {
        let offset = std::array::from_fn(|_| -(rng.below(5) as i32));
        let patch = Patch { source: if n == 0 { 0 } else { rng.below(2) as usize }, offset };
        let sides = if n == 0 { shape } else { shape.map(|n| 1 + rng.below(n)) };
        let start = std::array::from_fn(|a| rng.below(shape[a] - sides[a] + 1) as i32);
        let window = Window { start, shape: sides };
        let samples: Vec<SampleId> = patch.samples(&e, &window).collect();
        for (place, id) in window.places(output).zip(samples) {
            if id.is_assigned() {
                map.ids.plane_mut(0)[place.unwrap()] = id;
            }
        }
    }
    if holes {
        map.ids.plane_mut(0).iter_mut().filter(|_| rng.below(9) == 0).for_each(|id| *id = SampleId::UNASSIGNED);
    }
    (e, map)
}

/// All of a map as a frame, offered a patch of the first source.
fn whole<const D: usize>(rng: &mut Rng, e: &Exemplars<D>, map: &SourceMap<D>) -> Frame<D> {
    let patch = Patch { source: 0, offset: std::array::from_fn(|_| -(rng.below(5) as i32)) };
    Frame::of_patch(e, map, &patch, &Window::all(map.domain())).unwrap()
}

/// The greatest distance along any axis, around periodic ones.
fn distance<const D: usize>(domain: Domain<D>, a: usize, b: usize) -> u32 {
    let (a, b) = (domain.position(a), domain.position(b));
    let along = |axis: usize| {
        let d = a[axis].abs_diff(b[axis]);
        if domain.periodic[axis] { d.min(domain.shape[axis] - d) } else { d }
    };
    (0..D).map(along).max().unwrap()
}

fn check_band<const D: usize>(case: u64) -> usize {
    let mut rng = Seed(case).derive("band", D as u64).rng();
    let (e, map) = patched::<D>(&mut rng, 9, case.is_multiple_of(2));
    let frame = whole(&mut rng, &e, &map);
    let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
    let is_seam = |axis: usize, s, t| costs.continued(s, 2 * axis) != Some(t);
    let before = frame.choices(Holes::Fill, |_| None).unwrap();
    let beside: Vec<usize> = (0..D)
        .flat_map(|axis| frame.pairs(axis).map(move |pair| (axis, pair)))
        .filter(|&(_, (s, t))| frame.old[s].is_assigned() && frame.old[t].is_assigned())
        .filter(|&(axis, (s, t))| is_seam(axis, frame.old[s], frame.old[t]))
        .flat_map(|(_, (s, t))| [s, t])
        .collect();
    let mut taken = 0;
    for width in [0, 1, 3] {
        let mut choices = before.clone();
        frame.band(&mut choices, width, is_seam).unwrap();
        for i in 0..choices.len() {
            let near = beside.iter().any(|&b| distance(frame.domain, i, b) <= width);
            let expected = if before[i] == Choice::Free && !near { Choice::Old } else { before[i] };
            assert_eq!(choices[i], expected, "case {case}, width {width}");
            taken += usize::from(choices[i] != before[i]);
        }
    }
    let mut all = before.clone();
    frame.band(&mut all, u32::MAX, is_seam).unwrap();
    assert_eq!(all, before);
    taken
}

#[test]
fn a_band_holds_what_lies_near_seams() {
    let taken: usize = (0..100).map(|case| check_band::<1>(case) + check_band::<2>(case) + check_band::<3>(case)).sum();
    assert!(2000 < taken, "only {taken}");
}

#[test]
fn the_cut_of_a_band_is_no_better_than_that_of_all_and_no_worse_than_none() {
    let (mut lost, mut gained) = (0, 0);
    for case in 0..200 {
        let mut rng = Seed(case).derive("cut", 0).rng();
        let (e, map) = patched::<2>(&mut rng, 12, false);
        let frame = whole(&mut rng, &e, &map);
        let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
        let cut = |width| {
            let mut choices = frame.choices(Holes::Fill, |_| None).unwrap();
            frame.band(&mut choices, width, |axis, s, t| costs.continued(s, 2 * axis) != Some(t)).unwrap();
            expand(&frame, &choices, &costs, &mut Scratch::default(), &|| false).unwrap().gain
        };
        let (narrow, wide, all) = (cut(1), cut(u32::MAX), {
            let choices = frame.choices(Holes::Fill, |_| None).unwrap();
            expand(&frame, &choices, &costs, &mut Scratch::default(), &|| false).unwrap().gain
        });
        assert_eq!(wide, all, "a band of everything is the full cut");
        assert!(0 <= narrow && narrow <= wide);
        (lost, gained) = (lost + wide - narrow, gained + narrow);
    }
    assert!(0 < lost && lost < gained, "{lost} of {gained}");
}
