//! Grids of up to 16 nodes against all cuts.

mod common;

use common::{Draw, GridCase, diagonal, no_diagonal};
use selvedge_maxflow::{Diagonal, Engine, GridGraph};

const ENGINES: [Engine; 3] = [Engine::Auto, Engine::Trees, Engine::Pseudoflow];

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
        let cut = graph.solve(&|| false).unwrap();
        problem.check(&cut, &expected);
        assert_eq!(graph.capacity_of(cut.source_side()).unwrap(), cut.flow);
        // Solving again finds nothing to do, and a cleared graph is as good as new.
        assert_eq!(graph.solve(&|| false).unwrap(), cut);
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
