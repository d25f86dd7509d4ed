//! The engines, and who runs when.
//!
//! An engine takes a residual network with saturated pins and moves flow until no positive excess can reach a negative
//! one. All of them leave the same thing behind, so they can follow each other.

mod between;
pub(crate) mod closure;
mod nearby;
pub(crate) mod pseudoflow;
pub(crate) mod settle;
mod steps;
pub(crate) mod strip;
mod strong;
pub(crate) mod tree;

use crate::error::{MaxflowError, Result};
use crate::network::{Network, Reversed, Role, saturate_pins};
use nearby::NearbyScratch;
use pseudoflow::PseudoScratch;
use tree::TreeScratch;

/// How a minimum cut is found. The answer is the same from all of them, flow and nodes; only the time differs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Engine {
    /// Whatever promises to be fastest for the graph at hand.
    #[default]
    Auto,
    /// Augmenting paths between two search trees (Boykov and Kolmogorov).
    Trees,
    /// Highest-label pseudoflow (Hochbaum).
    Pseudoflow,
    /// Shortest path through the faces, where the graph is a plain strip; elsewhere as [`Engine::Auto`].
    ShortestPath,
}

/// Whether an engine finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// The flow is maximum.
    Done,
    /// The caller wants to stop; the pseudoflow is valid.
    Cancelled,
    /// The engine has done more work than it was given; the pseudoflow is valid, and another may go on.
    OverBudget,
    /// There is no memory for what the engine notes of the nodes; the pseudoflow is valid.
    OutOfMemory,
}

/// Memory of the engines, kept from solve to solve. `A` names arcs, `S` are engine P's notes of them.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<A, S> {
    nearby: NearbyScratch,
    tree: TreeScratch<A>,
    pseudo: PseudoScratch<A, S>,
    marks: Vec<u8>,
    stack: Vec<u32>,
    settled: Vec<u32>,
}

impl<A, S> Default for Scratch<A, S> {
    fn default() -> Self {
        let (marks, stack, settled) = (Vec::new(), Vec::new(), Vec::new());
        let (nearby, tree, pseudo) = (NearbyScratch::default(), TreeScratch::default(), PseudoScratch::default());
        Self { nearby, tree, pseudo, marks, stack, settled }
    }
}

/// Saturates the pins and makes the flow maximum, or says [`MaxflowError::Cancelled`] or
/// [`MaxflowError::OutOfMemory`].
///
/// `solved`: the flow was maximum before some changes, and may be nearly so now.
pub(crate) fn maximize<N: Network>(
    net: &mut N,
    engine: Engine,
    solved: bool,
    scratch: &mut Scratch<N::Arc, N::Notes>,
    cancelled: &dyn Fn() -> bool,
) -> Result<()> {
    let automatic = matches!(engine, Engine::Auto | Engine::ShortestPath);
    let outcome = if solved && automatic {
        saturate_pins(net);
        mend(net, scratch, cancelled)
    } else {
        run_unsettled(net, engine, scratch, cancelled)
    };
    match outcome {
        Outcome::Done => Ok(()),
        Outcome::Cancelled => Err(MaxflowError::Cancelled),
        Outcome::OverBudget | Outcome::OutOfMemory => {
            Err(MaxflowError::OutOfMemory { nodes: net.nodes().len(), links: 0 })
        }
    }
}

/// Runs an engine on what is not settled before.
fn run_unsettled<N: Network>(
    net: &mut N,
    engine: Engine,
    scratch: &mut Scratch<N::Arc, N::Notes>,
    cancelled: &dyn Fn() -> bool,
) -> Outcome {
    let mut settled = std::mem::take(&mut scratch.settled);
    let outcome = if settle::settle(net, &mut settled) {
        saturate_pins(net);
        run(net, engine, |_| true, net.nodes().len() - settled.len(), scratch, cancelled)
    } else {
        Outcome::OutOfMemory
    };
    settle::release(net, &settled);
    scratch.settled = settled;
    outcome
}

/// How much work engine T may do on what changes have left, in arcs and ancestors looked at for each of these nodes, if
/// they are not most of the graph.
///
/// After a stroke of a brush few paths are left, and T finds them without giving every node between a distance: over
/// two textures of 1000^2 (`S/1000/gravel`) 91 ms in the median where P took 317. With 1 or 4 a node it is stopped too
/// often (`S/400/gravel`: the worst stroke but one took 50 ms, with 24 it takes 24), with 16 still on `S/1000/brick`
/// (median 186 ms, with 24 it is 125); with 64 what it is bad at, paths that are cut off again and again, loses more
/// than it saves (`S/1000/gravel`: worst but one 521 ms, with 16 327).
const MENDING: u64 = 24;

/// The same where they are more than half of it. 24 looks take as long there as P, and T is mostly not done: the
/// strokes of `brush 1000` took a fifth longer in all than by P alone. With less than 12, or as many as the part beside
/// them, T is stopped where it nearly was (`S/400/gravel`: the worst stroke but one 41 ms, with 24 26).
const MENDING_MOST: u64 = 12;

/// How much work engine T may do on some nodes of a graph. None where they are all of it but a sixteenth: then nothing
/// that was found is left, and P is as fast as anew (the first pins of `brush 1000`: .5 s, 1.2 with 24 looks before).
fn mending(nodes: usize, of: usize) -> u64 {
    let looks = match nodes {
        most if of - most < of / 16 => 0,
        most if most > of / 2 => MENDING_MOST,
        _ => MENDING,
    };
    looks * nodes as u64
}

/// Solves what changes have left to do, which lies between positive and negative excess: engine T, and if that would
/// take long, whatever else is best.
fn mend<N: Network>(net: &mut N, scratch: &mut Scratch<N::Arc, N::Notes>, cancelled: &dyn Fn() -> bool) -> Outcome {
    // One engine's memory at a time.
    scratch.pseudo = PseudoScratch::default();
    let outcome = among_the_between(net, scratch, |net, relevant, nodes, scratch| {
        let work = mending(nodes, net.nodes().len());
        if work == 0 { Outcome::OverBudget } else { tree::solve(net, &mut scratch.tree, relevant, work, cancelled) }
    });
    if outcome != Outcome::OverBudget {
        return outcome;
    }
    scratch.tree = TreeScratch::default();
    among_the_between(net, scratch, |net, relevant, nodes, scratch| {
        run(net, Engine::Auto, relevant, nodes, scratch, cancelled)
    })
}

/// Runs an engine on the nodes between positive and negative excess, if there are any.
fn among_the_between<N: Network>(
    net: &mut N,
    scratch: &mut Scratch<N::Arc, N::Notes>,
    engine: impl FnOnce(&mut N, &dyn Fn(usize) -> bool, usize, &mut Scratch<N::Arc, N::Notes>) -> Outcome,
) -> Outcome {
    let Some(nodes) = between::mark(net, &mut scratch.marks, &mut scratch.stack) else { return Outcome::OutOfMemory };
    if nodes == 0 {
        return Outcome::Done;
    }
    let marks = std::mem::take(&mut scratch.marks);
    let outcome = engine(net, &|v| between::is_between(&marks, v), nodes, scratch);
    scratch.marks = marks;
    outcome
}

/// Runs an engine on the `relevant` nodes, of which there are `nodes`.
fn run<N: Network>(
    net: &mut N,
    engine: Engine,
    relevant: impl Fn(usize) -> bool + Copy,
    nodes: usize,
    scratch: &mut Scratch<N::Arc, N::Notes>,
    cancelled: &dyn Fn() -> bool,
) -> Outcome {
    match engine {
        Engine::Trees => loop {
            let outcome = tree::solve(net, &mut scratch.tree, relevant, u64::MAX, cancelled);
            if outcome != Outcome::OverBudget {
                return outcome;
            }
        },
        Engine::Pseudoflow => run_pseudoflow(net, relevant, Supply::of(net, relevant), scratch, cancelled),
        Engine::Auto | Engine::ShortestPath => {
            let supply = Supply::of(net, relevant);
            if 2 * (supply.givers + supply.takers) > nodes {
                run_nearby_first(net, relevant, supply, scratch, cancelled)
            } else {
                run_pseudoflow(net, relevant, supply, scratch, cancelled)
            }
        }
    }
}

/// Decides what is decided nearby, and runs engine P on the rest.
fn run_nearby_first<N: Network>(
    net: &mut N,
    relevant: impl Fn(usize) -> bool + Copy,
    supply: Supply,
    scratch: &mut Scratch<N::Arc, N::Notes>,
    cancelled: &dyn Fn() -> bool,
) -> Outcome {
    let (nearby, pseudo) = (&mut scratch.nearby, &mut scratch.pseudo);
    if supply.givers < supply.takers {
        run_nearby(net, relevant, nearby, pseudo, cancelled)
    } else {
        run_nearby(&mut Reversed(net), relevant, nearby, pseudo, cancelled)
    }
}

/// Nodes that have excess among this many are solved before the next: their notes stay in cache (D 512: 12.3 for 16.4
/// ms). Overlays take up to twice as long so: their flows are long, and gather before they go on.
const TOGETHER: usize = 1 << 15;

fn run_nearby<N: Network>(
    net: &mut N,
    relevant: impl Fn(usize) -> bool,
    nearby: &mut NearbyScratch,
    pseudo: &mut PseudoScratch<N::Arc, N::Notes>,
    cancelled: &dyn Fn() -> bool,
) -> Outcome {
    match nearby::decide(net, nearby, relevant) {
        None => Outcome::OutOfMemory,
        Some(false) => Outcome::Done,
        Some(true) => pseudoflow::solve(net, pseudo, |v| nearby.open(v), TOGETHER, cancelled),
    }
}

/// Runs engine P from the side that floods less: what does not get through has to be given up label by label.
fn run_pseudoflow<N: Network>(
    net: &mut N,
    relevant: impl Fn(usize) -> bool + Copy,
    supply: Supply,
    scratch: &mut Scratch<N::Arc, N::Notes>,
    cancelled: &dyn Fn() -> bool,
) -> Outcome {
    // One engine's memory at a time.
    scratch.tree = TreeScratch::default();
    if supply.sink_starts() {
        pseudoflow::solve(&mut Reversed(net), &mut scratch.pseudo, relevant, usize::MAX, cancelled)
    } else {
        pseudoflow::solve(net, &mut scratch.pseudo, relevant, usize::MAX, cancelled)
    }
}

/// What there is to send, and where.
#[derive(Clone, Copy, Debug, Default)]
struct Supply {
    /// Sum of positive excess.
    excess: i64,
    /// Sum of negative excess, as a positive number.
    lack: i64,
    /// Number of nodes with positive excess.
    givers: usize,
    /// Number of nodes with negative excess.
    takers: usize,
}

impl Supply {
    fn of<N: Network>(net: &N, relevant: impl Fn(usize) -> bool) -> Self {
        let mut supply = Self::default();
        for v in net.nodes().filter(|&v| net.role(v) == Role::Free && relevant(v)) {
            let excess: i64 = net.excess(v).into();
            supply.excess += excess.max(0);
            supply.lack += (-excess).max(0);
            supply.givers += usize::from(excess > 0);
            supply.takers += usize::from(excess < 0);
        }
        supply
    }

    /// Whether engine P starts from the sink. A side floods the more the more it has to give, and the more nodes it has
    /// to give it from. Where both are about as much, the source starts: of 104 overlays one is below 1, none below
    /// 15/16.
    ///
    /// Amounts alone, with some threshold, are wrong either for overlays (a ring of pins around many old seams: 2 to 3
    /// times as long from the sink, though that has less), or for boxes (7 times as long from the source) and many
    /// patches.
    fn sink_starts(&self) -> bool {
        let flood = |amount: i64, nodes: usize| i128::from(amount) * nodes as i128;
        16 * flood(self.lack, self.takers) < 15 * flood(self.excess, self.givers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::{MinCut, Side};
    use crate::grid::GridGraph;

    /// A grid of noise between two pinned corners, with a few terminals.
    fn noise(seed: u32) -> GridGraph<2> {
        let mut graph = GridGraph::new([7, 9], [false, true]).unwrap();
        let mut state = seed;
        let mut draw = |n: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) % n
        };
        for v in 0..graph.len() {
            for axis in (0..2).filter(|&a| graph.next(v, a).is_some()).collect::<Vec<_>>() {
                graph.link(v, axis, draw(20) as i32, draw(20) as i32).unwrap();
            }
            if draw(4) == 0 {
                graph.terminal(v, draw(30) as i32, draw(30) as i32).unwrap();
            }
        }
        graph.pin(0, Side::Source).unwrap();
        graph.pin(40, Side::Sink).unwrap();
        graph
    }

    #[test]
    fn pseudoflow_starts_where_less_is_flooded() {
        let sink_starts = |excess, lack, givers, takers| Supply { excess, lack, givers, takers }.sink_starts();
        // Overlays of 512^2 (brick, gravel) and 256^2 (ihc); a box and an expansion; the same from both sides.
        assert!(!sink_starts(12_720_575, 4_645_771, 2044, 6803));
        assert!(!sink_starts(5_846_000, 2_153_553, 2044, 5499));
        assert!(!sink_starts(5_200_800, 4_767_716, 1020, 2962));
        assert!(sink_starts(17_288_482, 2_530_256, 9852, 2400));
        assert!(sink_starts(6_029_506_189, 41_264_944, 60_000, 5532));
        assert!(!sink_starts(500, 500, 7, 7));
        assert!(!sink_starts(i64::MAX / 2, i64::MAX / 2, 1 << 31, 1 << 31), "no overflow");
    }

    #[test]
    fn the_more_is_left_the_less_is_mended() {
        assert_eq!(mending(50, 100), 50 * MENDING);
        assert_eq!(mending(51, 100), 51 * MENDING_MOST);
        assert_eq!((mending(94, 100), mending(95, 100)), (94 * MENDING_MOST, 0));
        assert_eq!((mending(1, 1), mending(8, 8), mending(7, 8)), (MENDING_MOST, 8 * MENDING_MOST, 7 * MENDING_MOST));
        assert_eq!(mending(1 << 31, 1 << 31), 0);
    }

    #[test]
    fn trees_may_stop_at_any_budget() {
        let (mut over, mut done) = (0, 0);
        for seed in 0..20 {
            let expected = noise(seed).solve().unwrap();
            for budget in 0..400 {
                let mut graph = noise(seed);
                let total = graph.source_total();
                let (mut net, mut scratch) = (graph.net::<4, true>(), Scratch::default());
                saturate_pins(&mut net);
                match tree::solve(&mut net, &mut scratch.tree, |_| true, budget, &|| false) {
                    Outcome::OverBudget => over += 1,
                    outcome => {
                        assert_eq!(outcome, Outcome::Done);
                        done += 1;
                    }
                }
                let supply = Supply::of(&net, |_| true);
                assert_eq!(run_pseudoflow(&mut net, |_| true, supply, &mut scratch, &|| false), Outcome::Done);
                let mut cut = MinCut::default();
                closure::read_off(&net, total, &mut cut, &mut Vec::new()).unwrap();
                assert_eq!(cut, expected, "seed {seed}, budget {budget}");
            }
        }
        assert!(over > 100 && done > 100, "{over} over the budget, {done} within it");
    }
}
