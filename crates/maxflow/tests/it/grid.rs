//! Grids of up to 16 nodes against all cuts.

use crate::common::{Draw, GridCase, diagonal, no_diagonal};
use selvedge_maxflow::{Diagonal, Engine, GridGraph, MaxflowError, Side};

const ENGINES: [Engine; 4] = [Engine::Auto, Engine::Trees, Engine::Pseudoflow, Engine::ShortestPath];

fn solve_and_check<const D: usize>(
    case: &GridCase<D>,
    mut graph: GridGraph<D>,
    link: fn(&mut GridGraph<D>, usize, Diagonal, i32, i32),
) {
    case.fill(&mut graph, link);
    let problem = case.problem();
    let expected = problem.by_enumeration();
    for engine in ENGINES {
        graph.set_engine(engine);
        let cut = graph.solve().unwrap();
        problem.check(&cut, &expected);
        assert_eq!(graph.capacity_of(cut.source_side()).unwrap(), cut.flow);
        // Solving again finds nothing to do, and a cleared graph is as good as new.
        assert_eq!(graph.solve().unwrap(), cut);
        graph.clear();
        case.fill(&mut graph, link);
    }
}

fn random_grids<const D: usize>(seed: u64, cases: usize) {
    let mut draw = Draw(seed);
    for _ in 0..cases {
        let case = GridCase::<D>::random(&mut draw, 12, 9);
        solve_and_check(&case, GridGraph::new(case.shape, case.periodic).unwrap(), no_diagonal);
    }
}

#[test]
fn lines_against_all_cuts() {
    random_grids::<1>(1, 500);
}

#[test]
fn volumes_against_all_cuts() {
    random_grids::<3>(3, 1500);
}

#[test]
fn planes_against_all_cuts() {
    let mut draw = Draw(2);
    for _ in 0..3000 {
        let case = GridCase::<2>::random(&mut draw, 12, 9);
        let make = if case.diagonals { GridGraph::with_diagonals } else { GridGraph::new };
        solve_and_check(&case, make(case.shape, case.periodic).unwrap(), diagonal);
    }
}

/// A strip along either axis, with the source on either side.
fn random_strip(draw: &mut Draw, along: usize, across: usize, max: usize) -> GridCase<2> {
    let axis = draw.below(2);
    let mut shape = [1 + draw.below(along); 2];
    shape[axis] = 2 + draw.below(across - 1);
    let flip = draw.chance(50);
    let mut case = GridCase::<2>::blank(shape);
    for v in 0..case.len() {
        let at = [v / shape[1], v % shape[1]][axis];
        if at == 0 || at == shape[axis] - 1 {
            case.pins[v] = Some(if (at == 0) == flip { Side::Source } else { Side::Sink });
        }
        for along in 0..2 {
            if case.neighbour(v, along).is_some() {
                case.links.push((v, along, draw.below(max + 1) as i32, draw.below(max + 1) as i32));
            }
        }
    }
    case
}

#[test]
fn strips_against_all_cuts() {
    let mut draw = Draw(4);
    for _ in 0..2000 {
        let case = random_strip(&mut draw, 4, 4, 9);
        solve_and_check(&case, GridGraph::new(case.shape, case.periodic).unwrap(), no_diagonal);
    }
}

#[test]
fn engines_agree_on_larger_strips() {
    let mut draw = Draw(5);
    for _ in 0..200 {
        let case = random_strip(&mut draw, 40, 20, 30);
        let problem = case.problem();
        let mut cuts = ENGINES.into_iter().map(|engine| {
            let mut graph = GridGraph::new(case.shape, case.periodic).unwrap();
            graph.set_engine(engine);
            case.fill(&mut graph, no_diagonal);
            graph.solve().unwrap()
        });
        let first = cuts.next().unwrap();
        assert_eq!(first.flow, problem.capacity(first.source_side()));
        assert!(cuts.all(|cut| cut == first), "{case:?}");
    }
}

#[test]
fn a_strip_solved_again_after_changes_is_as_if_new() {
    let mut draw = Draw(6);
    for _ in 0..300 {
        let mut case = random_strip(&mut draw, 12, 9, 9);
        let mut graph = GridGraph::new(case.shape, case.periodic).unwrap();
        case.fill(&mut graph, no_diagonal);
        for _ in 0..3 {
            let cut = graph.solve().unwrap();
            let mut fresh = GridGraph::new(case.shape, case.periodic).unwrap();
            fresh.set_engine(Engine::Pseudoflow);
            case.fill(&mut fresh, no_diagonal);
            assert_eq!(cut, fresh.solve().unwrap(), "{case:?}");
            assert_eq!(graph.capacity_of(cut.source_side()).unwrap(), cut.flow);
            for _ in 0..case.links.len().min(5) {
                let k = draw.below(case.links.len());
                let (v, axis, forward, back) = case.links[k];
                let new = [draw.below(9) as i32, draw.below(9) as i32];
                graph.change_link(v, axis, new[0] - forward, new[1] - back).unwrap();
                (case.links[k].2, case.links[k].3) = (new[0], new[1]);
            }
            let v = draw.below(case.len());
            case.pins[v] = None;
            graph.unpin(v).unwrap();
        }
    }
}

#[test]
fn all_at_once_is_one_by_one() {
    for seed in 0..200 {
        let mut draw = Draw(seed);
        let case = GridCase::<2> { masked: Vec::new(), ..GridCase::random(&mut draw, 30, 9) };
        let n = case.len();
        let periodic = case.periodic;
        let (mut one, mut all) =
            (GridGraph::new(case.shape, periodic).unwrap(), GridGraph::new(case.shape, periodic).unwrap());
        all.terminals(&case.terminals).unwrap();
        (0..n).for_each(|v| one.terminal(v, case.terminals[v][0], case.terminals[v][1]).unwrap());
        for axis in 0..2 {
            let mut capacities = vec![[0; 2]; n];
            for &(v, along, forward, backward) in case.links.iter().filter(|link| link.1 == axis) {
                one.link(v, along, forward, backward).unwrap();
                capacities[v] = [forward, backward];
            }
            all.links(axis, &capacities).unwrap();
        }
        assert_eq!(one.solve(), all.solve(), "{seed}");
    }
    let mut graph = GridGraph::new([2, 3], [false; 2]).unwrap();
    assert_eq!(graph.terminals(&[[1, 0]; 5]), Err(MaxflowError::Count { given: 5, len: 6 }));
    let refused = graph.links(1, &[[1, 1]; 6]);
    assert!(matches!(refused, Err(MaxflowError::NoNeighbour { node: 2, .. })), "{refused:?}");
}
