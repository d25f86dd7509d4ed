//! Moves against brute force, against the paper's graph with its seam nodes, and against the seams' true price.

use petgraph::algo::ford_fulkerson;
use petgraph::graph::{DiGraph, NodeIndex};
use selvedge_core::{
    Domain, Exemplars, Grid, Origin, Patch, Rng, SampleId, SeamCosts, SeamMeasure, Seed, Source, SourceMap, Transform,
};

use super::*;
use crate::choice::Holes;
use crate::prices::Quad;

fn exemplars(shape: [u32; 2], seed: u64) -> Exemplars<2> {
    let mut rng = Seed(seed).rng();
    let domain = Domain::open(shape);
    let channels = 1 + rng.below(3) as usize;
    // Few grey levels, so that costs tie and patches agree here and there.
    let samples = (0..domain.len() * channels).map(|_| (rng.below(5) * 60) as u8).collect();
    let source = Source {
        features: Grid::from_vec(domain, channels, samples).unwrap(),
        valid: None,
        origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
    };
    Exemplars::from_sources(vec![source], vec![1; channels]).unwrap()
}

/// A patch that covers the whole output with a margin.
fn covering(exemplars: &Exemplars<2>, output: Domain<2>, rng: &mut Rng) -> Patch<2> {
    let source = exemplars.sources()[0].domain().shape;
    let offset = std::array::from_fn(|a| -1 - rng.below(source[a] - output.shape[a] - 1) as i32);
    Patch { source: 0, offset }
}

/// An output under a stack of patches, each laid whole over a random window.
fn stack(exemplars: &Exemplars<2>, output: Domain<2>, rng: &mut Rng, patches: usize) -> SourceMap<2> {
    let mut map = SourceMap::unassigned(exemplars, output).unwrap();
    for i in 0..patches {
        let patch = covering(exemplars, output, rng);
        let window = if i == 0 { Window::all(output) } else { random_window(output, rng) };
        let frame = Frame::of_patch(exemplars, &map, &patch, &window).unwrap();
        for (&place, &new) in frame.places.iter().zip(&frame.new).filter(|(_, n)| n.is_assigned()) {
            map.ids.plane_mut(0)[place as usize] = new;
        }
    }
    map
}

fn random_window(output: Domain<2>, rng: &mut Rng) -> Window<2> {
    let shape = output.shape.map(|n| 1 + rng.below(n));
    Window { start: std::array::from_fn(|a| rng.below(output.shape[a] - shape[a] + 1) as i32), shape }
}

/// Cost of all seams of a frame, given who takes the patch.
fn energy(frame: &Frame<2>, choices: &[Choice], costs: &SeamCosts<2>, taken: &[bool]) -> i64 {
    let id = |i: usize| if taken[i] { frame.new[i] } else { frame.old[i] };
    let mut sum = 0;
    for axis in 0..2 {
        for (s, t) in frame.pairs(axis) {
            if choices[s] == Choice::Free || choices[t] == Choice::Free {
                sum += i64::from(costs.between(axis, id(s), id(t)));
            }
        }
    }
    sum
}

#[test]
fn tiny_cuts_are_as_cheap_as_any_labelling() {
    let mut cut_nodes = 0;
    for case in 0..200 {
        let mut rng = Seed(case).rng();
        let (e, output) = (exemplars([12, 12], case), Domain::open([3 + rng.below(2), 3 + rng.below(3)]));
        let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
        let map = stack(&e, output, &mut rng, 3);
        let (patch, window) = (covering(&e, output, &mut rng), random_window(output, &mut rng));
        let frame = Frame::of_patch(&e, &map, &patch, &window).unwrap();
        let choices = frame.choices(Holes::Fill, |_| None).unwrap();
        let free: Vec<usize> = (0..choices.len()).filter(|&i| choices[i] == Choice::Free).collect();
        if 14 < free.len() {
            continue;
        }
        let decided = expand(&frame, &choices, &costs, &mut Scratch::default(), &|| false).unwrap();
        let labelling = |bits: usize| -> Vec<bool> {
            let mut taken: Vec<bool> = choices.iter().map(|&c| c == Choice::New).collect();
            free.iter().enumerate().for_each(|(k, &i)| taken[i] = bits >> k & 1 == 1);
            taken
        };
        let least = (0..1 << free.len()).map(|b| energy(&frame, &choices, &costs, &labelling(b))).min().unwrap();
        assert_eq!(energy(&frame, &choices, &costs, &decided.taken), least, "case {case}");
        assert_eq!(decided.gain, energy(&frame, &choices, &costs, &labelling(0)) - least);
        cut_nodes += free.len();
    }
    assert!(300 < cut_nodes, "only {cut_nodes} free positions in all");
}

/// The flow through the paper's graph: pixel nodes, a seam node on each old seam, terminals for old and new.
fn literal_flow(frame: &Frame<2>, choices: &[Choice], costs: &SeamCosts<2>) -> u64 {
    const SURE: u64 = 1 << 40;
    let mut graph: DiGraph<(), u64> = DiGraph::new();
    let nodes: Vec<NodeIndex> = choices.iter().map(|_| graph.add_node(())).collect();
    let (old, new) = (graph.add_node(()), graph.add_node(()));
    let both = |graph: &mut DiGraph<(), u64>, a: NodeIndex, b: NodeIndex, cost: u64| {
        graph.add_edge(a, b, cost);
        graph.add_edge(b, a, cost);
    };
    for (i, choice) in choices.iter().enumerate() {
        match choice {
            Choice::Old => drop(graph.add_edge(old, nodes[i], SURE)),
            Choice::New => drop(graph.add_edge(nodes[i], new, SURE)),
            _ => {}
        }
    }
    for axis in 0..2 {
        for (s, t) in frame.pairs(axis) {
            if choices[s] != Choice::Free && choices[t] != Choice::Free {
                continue;
            }
            let price = |a: SampleId, b: SampleId| costs.between(axis, a, b) as u64;
            // The patch is defined beyond the window, too: the ring only keeps what is there.
            let (new_s, new_t) = (frame.new[s], frame.new[t]);
            if costs.continued(frame.old[s], 2 * axis) == Some(frame.old[t]) {
                let cost = if new_t.is_assigned() { price(frame.old[s], new_t) } else { price(new_s, frame.old[t]) };
                both(&mut graph, nodes[s], nodes[t], cost);
                continue;
            }
            let new_t = if new_t.is_assigned() { new_t } else { costs.continued(new_s, 2 * axis).unwrap() };
            let new_s = if new_s.is_assigned() { new_s } else { costs.continued(new_t, 2 * axis + 1).unwrap() };
            let seam = graph.add_node(());
            both(&mut graph, nodes[s], seam, price(frame.old[s], new_t));
            both(&mut graph, seam, nodes[t], price(new_s, frame.old[t]));
            graph.add_edge(seam, new, price(frame.old[s], frame.old[t]));
        }
    }
    ford_fulkerson(&graph, old, new).0
}

#[test]
fn seam_nodes_are_not_needed() {
    for case in 0..60 {
        let mut rng = Seed(1000 + case).rng();
        let (e, output) = (exemplars([24, 24], case), Domain::open([5 + rng.below(6), 5 + rng.below(6)]));
        let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
        let map = stack(&e, output, &mut rng, 5);
        let (patch, window) = (covering(&e, output, &mut rng), random_window(output, &mut rng));
        let frame = Frame::of_patch(&e, &map, &patch, &window).unwrap();
        let choices = frame.choices(Holes::Fill, |_| None).unwrap();
        let decided = expand(&frame, &choices, &costs, &mut Scratch::default(), &|| false).unwrap();
        let price = energy(&frame, &choices, &costs, &decided.taken);
        assert_eq!(price as u64, literal_flow(&frame, &choices, &costs), "case {case}");
        assert_eq!(decided.truncated, 0, "eq. 1 is a metric where patches go on");
    }
}

/// Offers a patch wherever it covers the output; `None` where it does not.
fn offer(
    e: &Exemplars<2>,
    map: &SourceMap<2>,
    costs: &SeamCosts<2>,
    patch: &Patch<2>,
    window: &Window<2>,
) -> Option<(Frame<2>, Proposal)> {
    let window = patch.footprint(e, window).shared(window)?;
    let frame = Frame::of_patch(e, map, patch, &window).unwrap();
    let choices = frame.choices(Holes::Fill, |_| None).unwrap();
    let proposal = expand(&frame, &choices, costs, &mut Scratch::default(), &|| false).unwrap();
    Some((frame, proposal))
}

#[test]
fn a_gain_is_a_gain_in_truth_also_around_the_output_and_for_prices_that_are_no_metric() {
    let (mut improved, mut truncated) = (0, 0);
    for case in 0..300 {
        let mut rng = Seed(2000 + case).rng();
        let e = exemplars([16, 16], case);
        let periodic = [rng.below(2) == 1, rng.below(2) == 1];
        let output = Domain { shape: [1 + rng.below(11), 1 + rng.below(11)], periodic };
        for measure in [SeamMeasure::Difference, SeamMeasure::Gradient] {
            let mut map = stack(&e, output, &mut rng, 4);
            let costs = SeamCosts::new(&e, measure).unwrap();
            for _ in 0..3 {
                // Anywhere, also sticking out of the output and around its borders.
                let offset = std::array::from_fn(|a| rng.below(16 + output.shape[a]) as i32 - 16);
                let patch = Patch { source: 0, offset };
                let Some((frame, proposal)) = offer(&e, &map, &costs, &patch, &Window::all(output)) else { continue };
                let before = costs.total(&map);
                proposal.lay(&frame, &mut map);
                assert!(0 <= proposal.gain, "case {case}");
                assert_eq!(before - costs.total(&map), proposal.gain, "case {case}");
                improved += u32::from(0 < proposal.gain);
                truncated += proposal.truncated;
            }
        }
    }
    assert!(300 < improved && 0 < truncated, "{improved} patches improved, {truncated} terms were lowered");
}

#[test]
fn a_patch_on_its_own_place_changes_nothing() {
    let (e, output) = (exemplars([12, 12], 5), Domain::open([8, 8]));
    let costs = SeamCosts::new(&e, SeamMeasure::Gradient).unwrap();
    let patch = Patch { source: 0, offset: [-2, -3] };
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    for expected in [64, 0] {
        let (frame, proposal) = offer(&e, &map, &costs, &patch, &Window::all(output)).unwrap();
        assert_eq!((proposal.filled, proposal.gain), (expected, 0));
        proposal.lay(&frame, &mut map);
        assert_eq!((costs.total(&map), map.holes()), (0, 0));
    }
    assert_eq!(map.locate([0, 0]), Some((0, [2, 3])));
    assert_eq!(map.locate([7, 7]), Some((0, [9, 10])));
}

#[test]
fn both_patches_are_defined_on_both_sides_of_a_seam() {
    let (e, output) = (exemplars([10, 10], 6), Domain::open([16, 16]));
    let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
    let mut map = SourceMap::unassigned(&e, output).unwrap();
    for offset in [[0, 0], [1, 6], [6, 1], [6, 6], [3, 3]] {
        let (frame, proposal) = offer(&e, &map, &costs, &Patch { source: 0, offset }, &Window::all(output)).unwrap();
        proposal.lay(&frame, &mut map);
    }
    let (mut seams, mut one_sided) = (0, 0);
    for (at, axis) in output.positions().flat_map(|p| [(p, 0), (p, 1)]).filter(|&(p, a)| map.is_seam(p, a)) {
        let (here, there) = (map.ids.get(0, at), map.ids.get(0, output.next(at, axis).unwrap()));
        let both = costs.continued(here, 2 * axis).and(costs.continued(there, 2 * axis + 1));
        one_sided += usize::from(both.is_none());
        seams += 1;
    }
    // Each of three overlaps has two ends, where the seam runs out between a patch and what it does not reach.
    assert!(20 < seams && one_sided <= 2 * 3, "{one_sided} of {seams}");
}

#[test]
fn default_prices_of_four_agree_with_those_of_seams() {
    struct Plain<'a>(&'a SeamCosts<2>);
    impl Prices<2> for Plain<'_> {
        fn pair(&self, axis: usize, here: SampleId, there: SampleId) -> i32 {
            Prices::pair(self.0, axis, here, there)
        }
    }
    let mut rng = Seed(3).rng();
    for case in 0..20 {
        let e = exemplars([6, 6], case);
        for measure in [SeamMeasure::Difference, SeamMeasure::Gradient] {
            let costs = SeamCosts::new(&e, measure).unwrap();
            for axis in [0, 1] {
                let any = |rng: &mut Rng| {
                    let id = rng.below(40);
                    if id < 36 { SampleId::new(id) } else { SampleId::UNASSIGNED }
                };
                let two = |rng: &mut Rng| {
                    let s = any(rng);
                    let on = if s.is_assigned() { costs.continued(s, 2 * axis) } else { None };
                    [s, on.filter(|_| rng.below(4) != 0).unwrap_or_else(|| any(rng))]
                };
                for _ in 0..200 {
                    let (old, new) = (two(&mut rng), two(&mut rng));
                    let differences = [0, 1].map(|i| costs.difference(old[i], new[i]));
                    let quads: [Quad; 2] =
                        [costs.quad(axis, old, new, differences), Plain(&costs).quad(axis, old, new, [0; 2])];
                    assert_eq!(quads[0], quads[1], "{old:?} {new:?}");
                }
            }
        }
    }
}

#[test]
fn a_wish_to_stop_is_heard_and_memory_serves_on() {
    let (e, output) = (exemplars([40, 40], 1), Domain::open([30, 30]));
    let costs = SeamCosts::new(&e, SeamMeasure::Gradient).unwrap();
    let mut rng = Seed(1).rng();
    let map = stack(&e, output, &mut rng, 6);
    let patch = covering(&e, output, &mut rng);
    let frame = Frame::of_patch(&e, &map, &patch, &Window::all(output)).unwrap();
    let choices = frame.choices(Holes::Fill, |_| None).unwrap();
    let mut scratch = Scratch::default();
    let stopped = expand(&frame, &choices, &costs, &mut scratch, &|| true);
    assert!(stopped.is_err_and(|e| e.is_cancelled()));
    let fresh = expand(&frame, &choices, &costs, &mut Scratch::default(), &|| false).unwrap();
    for _ in 0..2 {
        assert_eq!(expand(&frame, &choices, &costs, &mut scratch, &|| false).unwrap(), fresh);
    }
}

#[test]
fn a_cut_costs_at_most_the_boundary_cut() {
    // A vertical strip between an old patch on the left and a new one on the right; dynamic programming finds the
    // cheapest path that goes down row by row and moves by at most one sample a row. `[Efros01 2.1]`
    for case in 0..50 {
        let mut rng = Seed(3000 + case).rng();
        let (h, w) = (4 + rng.below(10) as usize, 3 + rng.below(6) as usize);
        let output = Domain::open([h as u32, 16]);
        let e = exemplars([40, 40], case);
        let costs = SeamCosts::new(&e, SeamMeasure::Difference).unwrap();
        let mut map = SourceMap::unassigned(&e, output).unwrap();
        let old = covering(&e, output, &mut rng);
        let new = covering(&e, output, &mut rng);
        let left = Window { start: [0, 0], shape: [h as u32, w as u32 + 2] };
        let right = Window { start: [0, 1], shape: [h as u32, 15] };
        for (patch, window) in [(&old, &left), (&new, &right)] {
            let (frame, proposal) = offer(&e, &map, &costs, patch, window).unwrap();
            proposal.lay(&frame, &mut map);
        }
        assert!(costs.total(&map) <= dynamic_program(&e, &costs, &old, &new, h, w), "case {case}");
    }
}

/// Cost, by eq. 1 on the labelling that it induces, of the boundary cut through columns 1 to `w` of a strip.
fn dynamic_program(e: &Exemplars<2>, costs: &SeamCosts<2>, old: &Patch<2>, new: &Patch<2>, h: usize, w: usize) -> i64 {
    let id = |p: &Patch<2>, y: usize, x: usize| {
        e.table().id(0, [(y as i32 - p.offset[0]) as u32, (x as i32 - p.offset[1]) as u32])
    };
    // The error surface of quilting.
    let error = |y: usize, x: usize| u64::from(costs.norm(id(old, y, x), id(new, y, x))).pow(2);
    let mut sums = vec![vec![0_u64; w]; h];
    for y in 0..h {
        for x in 0..w {
            let above = (x.saturating_sub(1)..=(x + 1).min(w - 1)).map(|u| if y == 0 { 0 } else { sums[y - 1][u] });
            sums[y][x] = error(y, x + 1) + above.min().unwrap();
        }
    }
    let mut path = vec![0; h];
    path[h - 1] = (0..w).min_by_key(|&x| sums[h - 1][x]).unwrap();
    for y in (0..h - 1).rev() {
        let x = path[y + 1];
        path[y] = (x.saturating_sub(1)..=(x + 1).min(w - 1)).min_by_key(|&u| sums[y][u]).unwrap();
    }
    let label = |y: usize, x: usize| if x <= path[y] + 1 { id(old, y, x) } else { id(new, y, x) };
    let mut cost = 0;
    for y in 0..h {
        for x in 0..w + 2 {
            cost += i64::from(costs.between(1, label(y, x), label(y, x + 1)));
            if y + 1 < h {
                cost += i64::from(costs.between(0, label(y, x), label(y + 1, x)));
            }
        }
    }
    cost
}
