//! Headroom: what is accepted never overflows, what is refused changes nothing, and what is taken back can be given
//! again.

use std::cell::Cell;

use crate::common::{Draw, Problem};
use selvedge_maxflow::dimacs;
use selvedge_maxflow::{
    BinaryEnergy, Diagonal, Engine, ErrorKind, Graph, GridGraph, MaxflowError, PairwiseTerm, Side, capacity,
};

const ENGINES: [Engine; 4] = [Engine::Auto, Engine::Trees, Engine::Pseudoflow, Engine::ShortestPath];

type Grid = GridGraph<2>;

/// All eight neighbours of the middle node are pinned and have links of the largest capacity to it (`inward`) or from
/// it, on top of the largest terminal.
fn star(inward: bool) -> Grid {
    let mut graph = Grid::with_diagonals([3, 3], [false; 2]).unwrap();
    let (side, terminal) =
        if inward { (Side::Source, [Grid::MAX_TERMINAL, 0]) } else { (Side::Sink, [0, Grid::MAX_TERMINAL]) };
    (0..9).filter(|&v| v != 4).for_each(|v| graph.pin(v, side).unwrap());
    graph.terminal(4, terminal[0], terminal[1]).unwrap();
    // From a neighbour before the middle, then from the middle.
    let [before, after] =
        if inward { [(Grid::MAX_LINK, 0), (0, Grid::MAX_LINK)] } else { [(0, Grid::MAX_LINK), (Grid::MAX_LINK, 0)] };
    for (v, axis) in [(1, 0), (3, 1)] {
        graph.link(v, axis, before.0, before.1).unwrap();
        graph.link(4, axis, after.0, after.1).unwrap();
    }
    for (v, diagonal) in [(0, Diagonal::Main), (2, Diagonal::Anti)] {
        graph.link_diagonal(v, diagonal, before.0, before.1).unwrap();
        graph.link_diagonal(4, diagonal, after.0, after.1).unwrap();
    }
    graph
}

#[test]
fn a_node_at_every_limit_does_not_overflow() {
    for inward in [true, false] {
        for engine in ENGINES {
            let mut graph = star(inward);
            graph.set_engine(engine);
            let cut = graph.solve().unwrap();
            assert_eq!((cut.flow, graph.capacity_of(cut.source_side()).unwrap()), (0, 0));
            assert_eq!(cut.side(4), if inward { Side::Source } else { Side::Sink });
            // With the middle on the other side everything is paid.
            graph.pin(4, if inward { Side::Sink } else { Side::Source }).unwrap();
            let all = i64::from(Grid::MAX_TERMINAL) + 8 * i64::from(Grid::MAX_LINK);
            assert_eq!(graph.solve().unwrap().flow, all);
        }
    }
}

#[test]
fn headroom_is_that_of_the_capacities_not_of_the_flow() {
    let mut graph = Grid::new([1, 2], [false; 2]).unwrap();
    graph.pin(0, Side::Source).unwrap();
    graph.terminal(1, Grid::MAX_TERMINAL, 0).unwrap();
    graph.link(0, 1, 100, 0).unwrap();
    graph.solve().unwrap();
    graph.change_terminal(1, -1, 0).expect("a capacity within the limit made smaller");
    graph.change_terminal(1, 1, 0).expect("and as large as before");
    assert!(graph.change_terminal(1, 1, 0).is_err(), "one more than the limit");
    // Flow has taken away what was given: the node's excess is small, its terminal is not.
    let mut graph = Grid::new([1, 2], [false; 2]).unwrap();
    graph.terminal(0, 1 << 27, 0).unwrap();
    graph.pin(1, Side::Sink).unwrap();
    graph.link(0, 1, 1 << 27, 0).unwrap();
    graph.solve().unwrap();
    assert!(graph.change_terminal(0, 1 << 30, 0).is_err());
}

#[test]
fn taking_back_what_was_never_given_is_refused_before_anything_overflows() {
    let mut graph = Grid::new([1, 3], [false; 2]).unwrap();
    graph.link(0, 1, 1 << 26, 0).unwrap();
    let refused = (0..100).find(|_| graph.change_link(0, 1, -(1 << 26), 1 << 26).is_err());
    assert!(refused.is_some_and(|k| k < 40), "refused after {refused:?}");
    graph.pin(2, Side::Source).unwrap();
    graph.link(1, 1, 0, 1 << 27).unwrap();
    let cut = graph.solve().unwrap();
    assert_eq!(cut.flow, graph.capacity_of(cut.source_side()).unwrap());
}

#[test]
fn a_graph_gives_headroom_back() {
    let mut graph = Graph::new(2).unwrap();
    let arc = graph.arc(0, 1, 1 << 60, 0).unwrap();
    for _ in 0..100 {
        assert!(matches!(graph.change_arc(arc, -(1 << 61), 0), Err(MaxflowError::NegativeCapacity { .. })));
        assert!(matches!(graph.change_arc(arc, 1 << 62, 0), Err(MaxflowError::CapacityTooLarge { .. })));
        graph.change_arc(arc, -(1 << 60), 0).unwrap();
        graph.change_terminal(0, 1 << 60, 0).unwrap();
        graph.change_terminal(0, -(1 << 60), 0).unwrap();
        graph.change_arc(arc, 1 << 60, 0).unwrap();
        graph.solve().unwrap();
    }
    assert!(matches!(graph.change_arc(arc, 0, -1), Err(MaxflowError::NegativeCapacity { .. })), "none was given");
    for (source, sink) in [(i64::MAX, i64::MIN), (i64::MIN, 0), (i64::MAX, i64::MAX)] {
        let _ = graph.change_terminal(1, source, sink);
    }
    assert!(matches!(Graph::new(usize::MAX), Err(MaxflowError::TooLarge { .. })));
    let mut other = Graph::new(1).unwrap();
    let foreign = MaxflowError::ForeignArc { arc: 0 };
    let unknown = MaxflowError::NoSuchArc { arc: 0, arcs: 0 };
    assert_eq!(other.change_arc(arc, 1, 1), Err(if cfg!(debug_assertions) { foreign.clone() } else { unknown }));
    // With an arc of that number, only debug builds can tell.
    let own = other.arc(0, 0, 1, 1).unwrap();
    let refused = if cfg!(debug_assertions) { Err(foreign) } else { Ok(()) };
    assert_eq!(other.change_arc(arc, 1, 1), refused);
    assert_eq!(other.clone().change_arc(own, 1, 1), Ok(()), "a clone has the same arcs");
}

#[test]
fn severed_arcs_and_terminals_make_up_the_flow() {
    let mut draw = Draw(61);
    for _ in 0..300 {
        let nodes = 1 + draw.below(20);
        let problem = Problem::random(&mut draw, nodes, 9);
        let mut graph = problem.graph();
        let cut = graph.solve().unwrap();
        let severed: Vec<_> = graph.cut_arcs(&cut).collect();
        let side = cut.source_side();
        let expected: Vec<_> = problem.arcs.iter().copied().filter(|&(v, w, c)| side[v] && !side[w] && c > 0).collect();
        assert_eq!(severed, expected);
        let terminals: i64 = problem.terminals.iter().zip(side).map(|(t, &s)| t[usize::from(s)]).sum();
        assert_eq!(terminals + severed.iter().map(|a| a.2).sum::<i64>(), cut.flow);
    }
}

#[test]
fn a_cleared_graph_is_set_again() {
    let mut draw = Draw(62);
    for _ in 0..100 {
        let nodes = 1 + draw.below(20);
        let mut problem = Problem::random(&mut draw, nodes, 9);
        let mut graph = Graph::new(nodes).unwrap();
        let ids: Vec<_> = problem.arcs.iter().map(|&(v, w, c)| graph.arc(v, w, c + 1, 2).unwrap()).collect();
        if draw.chance(50) {
            graph.solve().unwrap();
        }
        graph.clear();
        for (id, arc) in ids.iter().zip(&mut problem.arcs) {
            arc.2 = draw.below(9) as i64;
            graph.change_arc(*id, arc.2, 0).unwrap();
        }
        for (v, (t, &pin)) in problem.terminals.iter().zip(&problem.pins).enumerate() {
            graph.terminal(v, t[0], t[1]).unwrap();
            if let Some(side) = pin {
                graph.pin(v, side).unwrap();
            }
        }
        assert_eq!(graph.solve().unwrap(), problem.graph().solve().unwrap());
    }
}

#[test]
fn a_refused_term_leaves_the_energy_as_it_was() {
    let terms = [
        PairwiseTerm { e00: 0, e01: i32::MAX, e10: i32::MAX, e11: 0 },
        PairwiseTerm { e00: i32::MAX, e01: -2, e10: i32::MIN, e11: 0 },
        PairwiseTerm { e00: 0, e01: 1 << 26, e10: (1 << 26) + 1, e11: -4 },
        PairwiseTerm { e00: i32::MAX, e01: i32::MAX, e10: i32::MIN, e11: i32::MIN },
    ];
    let mut refused = 0;
    for full in [false, true] {
        for term in terms {
            let mut energy = BinaryEnergy::new([1, 2], [false; 2]).unwrap();
            energy.unary(0, 3, 5).unwrap();
            energy.unary(1, if full { Grid::MAX_TERMINAL } else { 7 }, 1).unwrap();
            let before = energy.minimize().unwrap();
            if let Err(error) = energy.pairwise(0, 1, term) {
                assert_eq!(error.kind(), ErrorKind::Input);
                assert_eq!(energy.minimize().unwrap(), before, "{term:?}");
                refused += 1;
            }
        }
    }
    assert!(refused >= 4, "{refused} terms were refused");
}

#[test]
fn a_strip_can_be_cancelled() {
    let mut graph = Grid::new([300, 5], [false; 2]).unwrap();
    for row in 0..300 {
        graph.pin(graph.node([row, 0]), Side::Source).unwrap();
        graph.pin(graph.node([row, 4]), Side::Sink).unwrap();
        for column in 0..4 {
            graph.link(graph.node([row, column]), 1, capacity(row as f64, 1.0).unwrap(), 4).unwrap();
        }
    }
    let polls = Cell::new(0);
    let stop = || {
        polls.set(polls.get() + 1);
        polls.get() > 2
    };
    assert_eq!(graph.solve_until(&stop), Err(MaxflowError::Cancelled));
    assert_eq!(graph.solve().unwrap().flow, (0..300).sum::<i64>());
}

#[test]
fn hostile_files_end_in_one_line() {
    let read = |text: &[u8]| dimacs::Problem::read(text).map_err(|e| e.to_string());
    let lone = read(b"p max 2000000000 0\nn 1 s\nn 2 t\n").unwrap_err();
    assert!(lone.contains("2000000000 nodes for 0 arcs"), "{lone}");
    assert!(read(b"").unwrap_err().contains("without a `p max` line"));
    assert!(
        read(b"p max 2 1\nn 1 s\nn 2 t\na 1 2 5\na 1 2 5\n").unwrap_err().starts_with("line 5: more than the 1 arcs")
    );
    assert!(read(b"p max 2 1 1 1 1 1\n").is_err());
    assert!(read(b"p max 2 1\nn 1 s\nn 2 t\na \xff 2 5\n").is_err());
    let mut long = vec![b' '; 1 << 17];
    assert!(read(&long).unwrap_err().contains("longer than"));
    // Comments may be long, and in any encoding.
    long[0] = b'c';
    long.extend(b"\nc Universit\xe4t\np max 2 1\nn 1 s\nn 2 t\na 1 2 5");
    assert_eq!(read(&long).unwrap().arcs, [(0, 1, 5)]);
    let same = dimacs::Problem { nodes: 1, source: 0, sink: 0, arcs: Vec::new() };
    assert_eq!(same.source_side_len(&same.graph().unwrap().solve().unwrap()), 0);
}

#[test]
#[should_panic(expected = "position [2, 9] is outside a grid of [3, 4]")]
fn a_position_outside_is_told_in_numbers() {
    GridGraph::new([3, 4], [false; 2]).unwrap().node([2, 9]);
}

#[test]
fn positions_are_those_of_nodes() {
    let graph = GridGraph::new([2, 3, 4], [false; 3]).unwrap();
    for node in 0..graph.len() {
        assert_eq!(graph.node(graph.position(node)), node);
    }
    assert_eq!(graph.position(23), [1, 2, 3]);
}

#[test]
#[should_panic(expected = "node 12 is outside a grid of [3, 4]")]
fn a_node_outside_has_no_position() {
    GridGraph::new([3, 4], [false; 2]).unwrap().position(12);
}

#[test]
fn remedies_of_costs_are_of_what_is_wrong() {
    let remedy = |cost, scale| selvedge_maxflow::capacity(cost, scale).unwrap_err().remedy();
    assert!(remedy(-1.0, 16.0).contains("at least 0"));
    assert!(remedy(f64::NAN, 16.0).contains("finite"));
    assert!(remedy(f64::INFINITY, 16.0).contains("finite"));
    assert!(remedy(1.0, 0.0).contains("scale above 0"));
    assert!(remedy(1e9, 16.0).contains("down alike"));
}
