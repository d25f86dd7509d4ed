//! Where samples come from, in the fields that are built in.

use crate::flow::{Field, Motion};
use selvedge_core::{CameFrom, Direction, Domain, Flow, Grid, Seed};

fn motion(field: Field, speed: f64) -> Motion {
    Motion { field, speed, center: None, angle: 30.0 }
}

#[test]
fn what_is_carried_back_and_forth_is_where_it_was() {
    for (case, field) in (0..).zip(Field::ALL) {
        for periodic in [[false; 2], [true; 2]] {
            let domain = Domain { shape: [48, 57], periodic };
            let flow = motion(field, 1.5).flow(domain, Seed(case)).unwrap();
            let all = flow.came_from(Direction::Forward).unwrap();
            let sure = all.iter().filter(|origin| origin.is_sure).count();
            assert!(domain.len() * 8 / 10 < sure, "{field:?}: {sure}");
            for (q, origin) in domain.positions().zip(&all).filter(|(_, origin)| origin.is_sure) {
                let by = flow.between(origin.at).unwrap();
                let there = [origin.at[0] + by[0], origin.at[1] + by[1]];
                for axis in 0..2 {
                    let n = f64::from(domain.shape[axis]);
                    let by = (there[axis] - f64::from(q[axis])).abs();
                    let by = if domain.periodic[axis] { by.min((by - n).abs()) } else { by };
                    assert!(by <= 0.1, "{field:?} {q:?}: {origin:?}, {there:?}");
                }
            }
        }
    }
}

#[test]
fn whole_steps_are_exact_and_nothing_comes_from_beyond_an_edge() {
    let domain = Domain { shape: [9, 11], periodic: [false, true] };
    let by = Grid::from_vec(domain, 2, [vec![2.0; 99], vec![-3.0; 99]].concat()).unwrap();
    for (direction, sign) in [(Direction::Forward, 1.0), (Direction::Backward, -1.0)] {
        let flow = Flow { by: by.map(|v| sign * v).unwrap(), known: None };
        for (q, origin) in domain.positions().zip(flow.came_from(direction).unwrap()) {
            assert_eq!(origin.is_sure, 2 <= q[0]);
            let expected = [f64::from(q[0]) - 2.0, f64::from((q[1] + 3) % 11)];
            assert_eq!(origin.at, expected);
        }
    }
}

#[test]
fn what_is_unknown_stays_and_is_not_sure() {
    let domain = Domain::open([5, 6]);
    let known = Grid::from_vec(domain, 1, (0..30).map(|i| i != 14).collect()).unwrap();
    let flow = Flow { by: Grid::try_filled(domain, 2, 0.0).unwrap(), known: Some(known) };
    let all = flow.came_from(Direction::Forward).unwrap();
    assert_eq!(all.iter().filter(|origin| !origin.is_sure).count(), 1);
    assert_eq!(all[14], CameFrom { at: [2.0, 2.0], is_sure: false });
}

#[test]
fn what_grows_too_much_is_not_wished_for() {
    let domain = Domain::open([40, 40]);
    let all = motion(Field::Source, 3.0).flow(domain, Seed(0)).unwrap().came_from(Direction::Forward).unwrap();
    assert!(!all[20 * 40 + 20].is_sure && all[3 * 40 + 20].is_sure);
}
