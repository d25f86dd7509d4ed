//! Prices are what the papers' equations say, wherever patches end.

use super::*;
use crate::{Grid, Origin, Seed, Source, Transform};

fn exemplars(domain: Domain<2>, weights: &[u8], valid: Option<Vec<bool>>) -> Exemplars<2> {
    let mut rng = Seed(9).rng();
    let samples = (0..domain.len() * weights.len()).map(|_| rng.below(256) as u8).collect();
    let source = Source {
        features: Grid::from_vec(domain, weights.len(), samples).unwrap(),
        valid: valid.map(|v| Grid::from_vec(domain, 1, v).unwrap()).map(Into::into),
        origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
    };
    Exemplars::from_sources(vec![source], weights.to_vec()).unwrap()
}

fn id(n: u32) -> SampleId {
    SampleId::new(n)
}

/// Equation 1 written out: both patches at both samples.
#[test]
fn seams_cost_what_equation_1_says() {
    let e = exemplars(Domain::open([5, 7]), &[2, 3], None);
    let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
    let f = |c: usize, i: usize| f64::from(e.sources()[0].features.plane(c)[i]);
    let norm = |a: usize, b: usize| {
        let [d, e] = [0, 1].map(|c| f(c, a) - f(c, b));
        (16.0 * (2.0 * d * d + 3.0 * e * e).sqrt()).ceil() as i32
    };
    // Patch A runs through 8, 9 and patch B through 17, 18: here 8, there 18.
    assert_eq!(costs.between(1, id(8), id(18)), norm(8, 17) + norm(9, 18));
    assert_eq!(costs.between(1, id(8), id(9)), 0);
    // Sample 6 ends its row, sample 7 begins one: A is not defined at the second, B not at the first.
    assert_eq!(costs.between(1, id(6), id(18)), 2 * norm(6, 17));
    assert_eq!(costs.between(1, id(8), id(14)), 2 * norm(9, 14));
    assert_eq!(costs.between(1, id(6), id(7)), 2 * norm(6, 7));
}

#[test]
fn gradients_divide_the_price() {
    let e = exemplars(Domain::open([5, 7]), &[1], None);
    let [plain, weighed] = [SeamMeasure::Difference, SeamMeasure::Gradient].map(|m| SeamCosts::new(&e, m).unwrap());
    // Central differences along axis 0 at 15 and 17, and at 22 and 24.
    let half = |a: u32, b: u32| u64::from(plain.norm(id(a), id(b)) / 2);
    let gradients = half(8, 22) + half(10, 24) + half(15, 29) + half(17, 31);
    let expected = (plain.between(0, id(15), id(24)) as u64 * 1024).div_ceil(gradients + 16);
    assert_eq!(weighed.between(0, id(15), id(24)) as u64, expected);
}

#[test]
fn in_a_clip_seams_between_frames_are_divided_by_gradients_in_time() {
    let mut rng = Seed(4).rng();
    let features = (0..60).map(|_| rng.below(256) as u8).collect();
    let transform = Transform::IDENTITY;
    let source = Source {
        features: Grid::from_vec(Domain::open([5, 3, 4]), 1, features).unwrap(),
        valid: None,
        origin: Origin { exemplar: 0, transform },
    };
    let e = Exemplars::from_sources(vec![source], vec![1]).unwrap();
    let [plain, weighed] = [SeamMeasure::Difference, SeamMeasure::Gradient].map(|m| SeamCosts::new(&e, m).unwrap());
    // Sample 17 of frame 1, and sample 30 of frame 2; a frame holds 12.
    let half = |a: u32, b: u32| u64::from(plain.norm(id(a), id(b)) / 2);
    let gradients = half(5, 29) + half(17, 41) + half(6, 30) + half(18, 42);
    let norms = plain.norm(id(17), id(18)) + plain.norm(id(29), id(30));
    assert_eq!(weighed.between(0, id(17), id(30)) as u64, (u64::from(norms) * 1024).div_ceil(gradients + 16));
}

#[test]
fn norms_obey_the_triangle_inequality_after_rounding() {
    let e = exemplars(Domain::open([6, 6]), &[1, 1, 1], None);
    let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
    for (a, b, c) in (0..36 * 36 * 36).map(|i| (id(i % 36), id(i / 36 % 36), id(i / 1296))) {
        assert!(costs.norm(a, c) <= costs.norm(a, b) + costs.norm(b, c));
    }
}

#[test]
fn patches_continue_around_periodic_sources_and_stop_at_masks() {
    let domain = Domain { shape: [2, 4], periodic: [false, true] };
    let mut valid = vec![true; 8];
    valid[4] = false;
    let e = exemplars(domain, &[1], Some(valid));
    let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
    assert_eq!(costs.continued(id(3), 2), Some(id(0)));
    assert_eq!(costs.continued(id(0), 3), Some(id(3)));
    assert_eq!(costs.continued(id(0), 0), None, "the sample below is masked");
    assert_eq!(costs.continued(id(7), 2), None, "so is the one around the border");
    assert_eq!(costs.continued(id(1), 1), None, "the source ends");
}

/// Sources of more shapes than links can number, of some axes periodic.
#[test]
fn patches_continue_in_every_source_as_its_table_says() {
    fn check<const D: usize>(shapes: impl Iterator<Item = Domain<D>>) {
        let source = |domain: Domain<D>| Source {
            features: Grid::try_filled(domain, 1, 0).unwrap(),
            valid: None,
            origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
        };
        let e = Exemplars::from_sources(shapes.map(source).collect(), vec![1]).unwrap();
        let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
        for sample in (0..e.table().len()).map(id) {
            for direction in 0..2 * D {
                let forward = direction.is_multiple_of(2);
                let by = std::array::from_fn(|a| i32::from(a == direction / 2) * if forward { 1 } else { -1 });
                assert_eq!(costs.continued(sample, direction), e.step(sample, by), "{sample:?}, {direction}");
            }
        }
    }
    check((1..12).map(|n| Domain { shape: [2, n], periodic: [n % 2 == 0, n % 3 == 0] }));
    check((1..5).map(|n| Domain { shape: [2, n, 6 - n], periodic: [false, n % 2 == 0, n == 3] }));
}

#[test]
fn a_map_costs_the_sum_of_its_seams() {
    let e = exemplars(Domain::open([4, 4]), &[1], None);
    let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
    let mut map = SourceMap::unassigned(&e, Domain::periodic([1, 3])).unwrap();
    map.ids.plane_mut(0).copy_from_slice(&[id(5), id(6), SampleId::UNASSIGNED]);
    assert_eq!(costs.total(&map), i64::from(costs.between(0, id(5), id(5)) + costs.between(0, id(6), id(6))));
    map.ids.plane_mut(0)[2] = id(11);
    let down: i32 = [5, 6, 11].map(|i| costs.between(0, id(i), id(i))).iter().sum();
    let along = costs.between(1, id(6), id(11)) + costs.between(1, id(11), id(5));
    assert_eq!(costs.total(&map), i64::from(down + along));
}
