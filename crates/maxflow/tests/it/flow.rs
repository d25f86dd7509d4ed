//! The flow on each arc: kept by nodes, within capacities, and as large as the cut.

use selvedge_maxflow::{ArcId, Engine, Graph, MaxflowError, Side};

use crate::common::Draw;

struct Case {
    graph: Graph,
    arcs: Vec<(usize, usize, [i64; 2], ArcId)>,
    terminals: Vec<[i64; 2]>,
    pins: Vec<Option<Side>>,
}

impl Case {
    fn random(draw: &mut Draw) -> Self {
        let nodes = 2 + draw.below(9);
        let mut graph = Graph::new(nodes).unwrap();
        let mut arcs = Vec::new();
        for _ in 0..draw.below(3 * nodes) {
            let (tail, head) = (draw.below(nodes), draw.below(nodes));
            let capacities = [draw.below(9) as i64, draw.below(4) as i64];
            let id = graph.arc(tail, head, capacities[0], capacities[1]).unwrap();
            arcs.push((tail, head, capacities, id));
        }
        let pins = (0..nodes).map(|_| draw.chance(15).then(|| if draw.chance(50) { Side::Source } else { Side::Sink }));
        let pins: Vec<Option<Side>> = pins.collect();
        let terminals =
            (0..nodes).map(|_| if draw.chance(50) { [draw.below(9) as i64, draw.below(9) as i64] } else { [0; 2] });
        let terminals: Vec<[i64; 2]> = terminals.collect();
        for v in 0..nodes {
            graph.terminal(v, terminals[v][0], terminals[v][1]).unwrap();
            if let Some(side) = pins[v] {
                graph.pin(v, side).unwrap();
            }
        }
        Self { graph, arcs, terminals, pins }
    }

    /// What flows is a flow, of the value of the cut.
    fn check(&mut self, number: u64) {
        let value = self.graph.solve().unwrap().flow;
        let mut out = vec![0; self.graph.len()];
        for &(tail, head, [forward, backward], id) in &self.arcs {
            let flow = self.graph.flow(id).unwrap();
            assert!((-backward..=forward).contains(&flow), "case {number}: {flow} of {forward}, {backward}");
            out[tail] += flow;
            out[head] -= flow;
        }
        let mut sum = 0;
        for (v, &out) in out.iter().enumerate() {
            let [from, to] = self.terminals[v];
            let net = from - to;
            let kept = self.pins[v].is_some() || (net.min(0)..=net.max(0)).contains(&out);
            assert!(kept, "case {number}: node {v} gives {out} of {net}");
            sum += match self.pins[v] {
                None => from.min(to) + out.max(0),
                // What a pinned node is given by its own side costs nothing.
                Some(Side::Source) => to + out,
                Some(Side::Sink) => from,
            };
        }
        assert_eq!(sum, value, "case {number}");
    }
}

#[test]
fn flows_are_kept_within_capacities_and_as_large_as_the_cut() {
    for number in 0..600 {
        let mut draw = Draw(number);
        let mut case = Case::random(&mut draw);
        case.graph.set_engine([Engine::Auto, Engine::Trees, Engine::Pseudoflow][number as usize % 3]);
        case.check(number);
        // And again, from the flow that was made whole.
        for i in 0..case.arcs.len() {
            if draw.chance(30) {
                let more = draw.below(5) as i64;
                case.graph.change_arc(case.arcs[i].3, more, 0).unwrap();
                case.arcs[i].2[0] += more;
            }
        }
        case.check(number);
    }
}

#[test]
fn a_flow_is_asked_for_after_a_solve() {
    let mut graph = Graph::new(2).unwrap();
    let arc = graph.arc(0, 1, 3, 0).unwrap();
    assert_eq!(graph.flow(arc), Err(MaxflowError::NotSolved));
    graph.terminal(0, 9, 0).unwrap();
    graph.terminal(1, 0, 9).unwrap();
    graph.solve().unwrap();
    assert_eq!(graph.flow(arc), Ok(3));
    graph.change_arc(arc, 1, 0).unwrap();
    assert_eq!(graph.flow(arc), Err(MaxflowError::NotSolved));
}

#[test]
fn arcs_that_others_added_have_names() {
    let mut graph = Graph::new(3).unwrap();
    assert_eq!((graph.arc_id(0), graph.arc_ids().count()), (None, 0));
    let arcs = [graph.arc(0, 1, 3, 0).unwrap(), graph.arc(1, 2, 2, 0).unwrap()];
    graph.terminal(0, 9, 0).unwrap();
    graph.terminal(2, 0, 9).unwrap();
    for _ in 0..2 {
        assert_eq!(graph.arc_ids().collect::<Vec<_>>(), arcs);
        assert_eq!([0, 1, 2].map(|number| graph.arc_id(number)), [Some(arcs[0]), Some(arcs[1]), None]);
        graph.solve().unwrap();
    }
    assert_eq!(graph.arc_ids().map(|arc| graph.flow(arc).unwrap()).collect::<Vec<_>>(), [2, 2]);
}
