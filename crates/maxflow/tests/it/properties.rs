//! What must hold of any minimum cut, on grids too large for the slow oracles, and on awkward ones.

use crate::common::{Draw, GridCase, diagonal, no_diagonal};
use selvedge_maxflow::{Diagonal, Engine, ErrorKind, Graph, GridGraph, MaxflowError, MinCut, Side, capacity};

const ENGINES: [Engine; 4] = [Engine::Auto, Engine::Trees, Engine::Pseudoflow, Engine::ShortestPath];

fn solve(case: &GridCase<2>, engine: Engine) -> MinCut {
    let make = if case.diagonals { GridGraph::with_diagonals } else { GridGraph::new };
    let mut graph = make(case.shape, case.periodic).unwrap();
    graph.set_engine(engine);
    case.fill(&mut graph, diagonal);
    graph.solve().unwrap()
}

/// The same cut from every engine, and its capacity is the flow.
#[track_caller]
fn cut_of(case: &GridCase<2>) -> MinCut {
    let cut = solve(case, Engine::Auto);
    for engine in ENGINES {
        assert_eq!(solve(case, engine), cut, "{engine:?}");
    }
    assert_eq!(cut.flow, case.problem().capacity(cut.source_side()));
    cut
}

fn large(draw: &mut Draw) -> GridCase<2> {
    GridCase::random(draw, 900, 40)
}

#[test]
fn grid_and_general_solver_agree() {
    let mut draw = Draw(41);
    for _ in 0..60 {
        let case = large(&mut draw);
        assert_eq!(cut_of(&case), case.problem().graph().solve().unwrap());
        let volume = GridCase::<3>::random(&mut draw, 700, 40);
        let mut graph = GridGraph::new(volume.shape, volume.periodic).unwrap();
        volume.fill(&mut graph, no_diagonal);
        assert_eq!(graph.solve().unwrap(), volume.problem().graph().solve().unwrap());
    }
}

#[test]
fn terminals_larger_than_all_links_are_pins() {
    let mut draw = Draw(52);
    let mut pinned = 0;
    for round in 0..120 {
        let mut case = large(&mut draw);
        if round % 3 == 0 {
            // A plain strip, for the engine of strips.
            case = GridCase { pins: vec![None; case.len()], masked: vec![false; case.len()], ..case };
            let columns = case.shape[1];
            for v in 0..case.len() {
                case.terminals[v] = [0; 2];
                case.pins[v] =
                    [(0, Side::Source), (columns - 1, Side::Sink)].iter().find(|p| v % columns == p.0).map(|p| p.1);
            }
        }
        let mut heavy = case.clone();
        for v in (0..case.len()).filter(|&v| !case.masked[v]) {
            // What a pin has of other terminals would count against the large one.
            case.terminals[v] = if case.pins[v].is_some() { [0; 2] } else { case.terminals[v] };
            heavy.terminals[v] = match heavy.pins[v].take() {
                Some(Side::Source) => [1 << 28, 0],
                Some(Side::Sink) => [0, 1 << 28],
                None => case.terminals[v],
            };
            pinned += usize::from(case.pins[v].is_some());
        }
        assert_eq!(cut_of(&heavy), cut_of(&case));
    }
    assert!(5000 < pinned, "{pinned} pins");
}

#[test]
fn capacities_times_k_make_the_flow_times_k() {
    let mut draw = Draw(42);
    for _ in 0..40 {
        let mut case = large(&mut draw);
        let cut = cut_of(&case);
        case.terminals.iter_mut().flatten().for_each(|c| *c *= 7);
        case.links.iter_mut().for_each(|(.., f, b)| (*f, *b) = (7 * *f, 7 * *b));
        let scaled = cut_of(&case);
        assert_eq!((scaled.flow, scaled.source_side()), (7 * cut.flow, cut.source_side()));
    }
}

#[test]
fn the_same_at_both_terminals_adds_to_the_flow_only() {
    let mut draw = Draw(43);
    for _ in 0..40 {
        let mut case = large(&mut draw);
        let cut = cut_of(&case);
        let v = draw.below(case.len());
        case.terminals[v].iter_mut().for_each(|c| *c += 11);
        let shifted = cut_of(&case);
        let added = if case.masked[v] { 0 } else { 11 };
        assert_eq!((shifted.flow, shifted.source_side()), (cut.flow + added, cut.source_side()));
    }
}

#[test]
fn a_cut_mirrored_is_the_cut_of_the_mirror() {
    let mut draw = Draw(44);
    for _ in 0..40 {
        let mut case = GridCase::<2>::random(&mut draw, 900, 40);
        case.diagonals = false;
        case.links.retain(|l| l.1 < 2);
        let flipped = |v: usize| v / case.shape[1] * case.shape[1] + case.shape[1] - 1 - v % case.shape[1];
        let cut = cut_of(&case);
        let mut mirror = case.clone();
        for v in 0..case.len() {
            let w = flipped(v);
            (mirror.masked[w], mirror.pins[w]) = (case.masked[v], case.pins[v]);
            mirror.terminals[w] = case.terminals[v];
        }
        for (link, &(v, along, f, b)) in mirror.links.iter_mut().zip(&case.links) {
            // Along the mirrored axis a link starts at its other end.
            *link =
                if along == 1 { (flipped(case.neighbour(v, 1).unwrap()), 1, b, f) } else { (flipped(v), along, f, b) };
        }
        let other = cut_of(&mirror);
        assert_eq!(other.flow, cut.flow);
        assert!((0..case.len()).all(|v| other.side(flipped(v)) == cut.side(v)));
    }
}

#[test]
fn more_capacity_never_means_less_flow() {
    let mut draw = Draw(45);
    for _ in 0..40 {
        let mut case = large(&mut draw);
        let before = cut_of(&case).flow;
        for _ in 0..case.links.len() / 4 {
            let k = draw.below(case.links.len());
            case.links[k].2 += 3;
        }
        assert!(cut_of(&case).flow >= before);
    }
}

/// A single path that winds through the whole grid, row by row: the longest augmenting path there is.
fn winding(rows: usize, columns: usize) -> GridCase<2> {
    let mut case = GridCase::blank([rows, columns]);
    for row in 0..rows {
        case.links.extend((0..columns - 1).map(|column| (row * columns + column, 1, 9, 9)));
        if row + 1 < rows {
            let turn = if row % 2 == 0 { columns - 1 } else { 0 };
            case.links.push((row * columns + turn, 0, 5, 5));
        }
    }
    case.pins[0] = Some(Side::Source);
    let last = if rows.is_multiple_of(2) { 0 } else { columns - 1 };
    case.pins[(rows - 1) * columns + last] = Some(Side::Sink);
    case
}

#[test]
fn awkward_grids() {
    assert_eq!(cut_of(&winding(60, 50)).flow, 5);
    let mut narrow = winding(40, 30);
    narrow.links[777].2 = 2;
    narrow.links[777].3 = 2;
    assert_eq!(cut_of(&narrow).flow, 2);
    assert_eq!(cut_of(&GridCase::blank([20, 20])).flow, 0);
    for side in [Side::Source, Side::Sink] {
        let mut pinned = GridCase::blank([9, 9]);
        pinned.pins.fill(Some(side));
        assert_eq!(cut_of(&pinned).source_len(), if side == Side::Source { 81 } else { 0 });
    }
    for shape in [[1, 1], [1, 30], [30, 1]] {
        let mut line = GridCase::blank(shape);
        line.terminals.fill([3, 2]);
        assert_eq!(cut_of(&line).flow, 2 * line.len() as i64);
        line.terminals.fill([4, 4]);
        assert_eq!(cut_of(&line).source_len(), 0, "ties go to the sink");
    }
}

#[test]
fn a_strip_that_turns_back_a_hundred_times() {
    // Walls with gaps at alternate ends: the cheapest path through the faces sweeps from side to side.
    let (rows, columns) = (203, 40);
    let mut case = GridCase::blank([rows, columns]);
    for v in 0..rows * columns {
        let (row, column) = (v / columns, v % columns);
        if column == 0 || column == columns - 1 {
            case.pins[v] = Some(if column == 0 { Side::Source } else { Side::Sink });
        }
        let gap = if row % 4 == 1 { column < 3 } else { column > columns - 5 };
        if column + 1 < columns {
            let cost = if row % 2 == 1 && !gap { 100_000 } else { 1 };
            case.links.push((v, 1, cost, cost));
        }
        if row + 1 < rows {
            case.links.push((v, 0, 1, 1));
        }
    }
    cut_of(&case);
    // And along the strip: the path climbs back up between walls that stand across the columns.
    let mut case = GridCase::blank([60, 160]);
    for v in 0..case.len() {
        let (row, column) = (v / 160, v % 160);
        if column == 0 || column == 159 {
            case.pins[v] = Some(if column == 0 { Side::Source } else { Side::Sink });
        }
        let gap = if column % 4 == 0 { row < 2 } else { row > 57 };
        if column < 159 {
            case.links.push((v, 1, 1, 1));
        }
        if row < 59 {
            let cost = if column % 2 == 0 && !gap { 100_000 } else { 1 };
            case.links.push((v, 0, cost, cost));
        }
    }
    cut_of(&case);
}

#[test]
fn capacities_at_the_limit() {
    let max = GridGraph::<2>::MAX_LINK;
    let mut graph = GridGraph::with_diagonals([3, 3], [true, true]).unwrap();
    for v in 0..9 {
        let terminal = GridGraph::<2>::MAX_TERMINAL;
        graph.terminal(v, if v % 2 == 0 { terminal } else { 0 }, if v % 2 == 0 { 0 } else { terminal }).unwrap();
        for axis in 0..2 {
            graph.link(v, axis, max / 2, max / 2).unwrap();
        }
        for diagonal in [Diagonal::Main, Diagonal::Anti] {
            graph.link_diagonal(v, diagonal, max, 0).unwrap();
        }
    }
    let too_large = graph.link(4, 0, 1, 0).unwrap_err();
    assert_eq!(too_large, MaxflowError::CapacityTooLarge { node: 4, value: i64::from(max) + 1, max: i64::from(max) });
    assert_eq!(too_large.kind(), ErrorKind::Input);
    let mut cuts = ENGINES.into_iter().map(|engine| {
        let mut graph = graph.clone();
        graph.set_engine(engine);
        graph.solve().unwrap()
    });
    let first = cuts.next().unwrap();
    assert_eq!(graph.capacity_of(first.source_side()).unwrap(), first.flow);
    assert!(cuts.all(|cut| cut == first));
    assert!(graph.change_terminal(0, i32::MAX, 0).is_err());
    let mut sparse = Graph::new(2).unwrap();
    sparse.arc(0, 1, Graph::MAX_TOTAL, 0).unwrap();
    assert!(matches!(sparse.arc(0, 1, 1, 0), Err(MaxflowError::CapacityTooLarge { .. })));
    assert!(matches!(sparse.change_terminal(0, i64::MAX, 0), Err(MaxflowError::CapacityTooLarge { .. })));
    assert!(matches!(sparse.change_terminal(0, i64::MIN, 0), Err(MaxflowError::NegativeCapacity { .. })));
    sparse.clear();
    sparse.terminal(0, 5, 3).unwrap();
    let refused = sparse.change_terminal(0, 0, -4);
    assert_eq!(refused, Err(MaxflowError::NegativeCapacity { node: 0, value: -1 }));
    assert_eq!(sparse.change_terminal(0, -5, -3), Ok(()));
}

#[test]
fn wrong_input_is_an_error_with_numbers() {
    use MaxflowError::*;
    assert!(matches!(GridGraph::new([0, 5], [false; 2]), Err(Shape { .. })));
    assert!(matches!(GridGraph::new([usize::MAX, 2], [false; 2]), Err(Shape { .. })));
    assert!(matches!(GridGraph::new([1 << 16, 1 << 16], [false; 2]), Err(Shape { .. })));
    let mut graph = GridGraph::new([2, 3], [false, true]).unwrap();
    assert_eq!(graph.link(3, 0, 1, 1), Err(NoNeighbour { node: 3, along: "axis 0".into() }));
    assert!(graph.link(2, 1, 1, 1).is_ok(), "axis 1 is periodic");
    assert_eq!(graph.next(2, 1), Some(0));
    assert!(matches!(graph.link(0, 2, 1, 1), Err(NoNeighbour { .. })));
    assert!(matches!(graph.link_diagonal(0, Diagonal::Main, 1, 1), Err(NoNeighbour { .. })));
    assert_eq!(graph.terminal(6, 1, 1), Err(NodeOutOfRange { node: 6, len: 6 }));
    assert_eq!(graph.link(0, 0, -4, 1), Err(NegativeCapacity { node: 0, value: -4 }));
    assert_eq!(graph.terminal(0, 3, -1), Err(NegativeCapacity { node: 0, value: -1 }));
    assert_eq!(graph.mask(0), Err(MaskTooLate { node: 0 }));
    assert!(matches!(graph.capacity_of(&[true; 5]), Err(LabellingSize { given: 5, len: 6 })));
    for cost in [f64::NAN, -0.5, f64::INFINITY, 1e300] {
        assert!(matches!(capacity(cost, 1000.0), Err(Cost { .. })), "{cost}");
    }
    assert_eq!(capacity(1e-310, 1.0), Ok(1), "a denormal is a cost too");
}

#[test]
fn estimates_follow_the_shape() {
    assert_eq!(GridGraph::<2>::estimate([1000, 1000]), 43 * 1_002_000);
    assert_eq!(GridGraph::<3>::estimate([100, 100, 100]), 51 * 1_020_000);
    assert_eq!(GridGraph::<2>::estimate([1, 1_000_000]), 43 * 1_000_002, "a row needs no margins of its length");
    assert_eq!(GridGraph::<2>::estimate([usize::MAX, usize::MAX]), u64::MAX);
}

#[test]
fn a_seam_node_is_a_pairwise_term() {
    // [Kwatra03 3.1]: seam node x between s and t, arcs of c1 to s, c2 to t and c3 to the sink; M a metric.
    let mut draw = Draw(46);
    for _ in 0..1000 {
        let (rows, columns) = (3, 4);
        let n = rows * columns;
        // Three labels with random colours: the norm of differences, rounded up, is a metric.
        let colour: Vec<[f64; 3]> = (0..4 * n).map(|_| [0; 3].map(|_: i32| draw.below(256) as f64)).collect();
        let norm = |l: usize, m: usize, v: usize| {
            let [a, b] = [colour[l * n + v], colour[m * n + v]];
            let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
            capacity(square.sqrt(), 4.0).unwrap()
        };
        let cost = |l: usize, m: usize, v: usize, w: usize| norm(l, m, v) + norm(l, m, w);
        let old: Vec<usize> = (0..n).map(|_| draw.below(3)).collect();
        let new = 3;
        let mut energy = selvedge_maxflow::BinaryEnergy::new([rows, columns], [false; 2]).unwrap();
        let pairs: Vec<(usize, usize, usize)> = (0..n)
            .flat_map(|v| [(v, 0), (v, 1)])
            .filter_map(|(v, axis)| energy.graph().next(v, axis).map(|w| (v, axis, w)))
            .collect();
        let mut literal = Graph::new(n + pairs.len()).unwrap();
        let mut seams = 0;
        for (k, &(v, axis, w)) in pairs.iter().enumerate() {
            let [e00, e01, e10] = [cost(old[v], old[w], v, w), cost(old[v], new, v, w), cost(new, old[w], v, w)];
            energy.pairwise(v, axis, selvedge_maxflow::PairwiseTerm { e00, e01, e10, e11: 0 }).unwrap();
            if old[v] == old[w] {
                literal.arc(v, w, e01.into(), e01.into()).unwrap();
            } else {
                literal.terminal(n + k, 0, e00.into()).unwrap();
                literal.arc(v, n + k, e01.into(), e01.into()).unwrap();
                literal.arc(n + k, w, e10.into(), e10.into()).unwrap();
                seams += 1;
            }
        }
        for v in 0..n {
            if let Some(side) = [None, Some(Side::Source), Some(Side::Sink)][draw.below(3)] {
                energy.graph_mut().pin(v, side).unwrap();
                literal.pin(v, side).unwrap();
            }
        }
        let minimum = energy.minimize().unwrap();
        assert_eq!(minimum.truncated, 0, "a metric is regular");
        assert_eq!(minimum.after, literal.solve().unwrap().flow, "{seams} seams");
    }
}
