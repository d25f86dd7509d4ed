//! The engines, and who runs when.
//!
//! An engine takes a residual network with saturated pins and moves flow until no positive excess can reach a negative
//! one. All of them leave the same thing behind, so they can follow each other.

mod between;
pub(crate) mod closure;
pub(crate) mod pseudoflow;
pub(crate) mod strip;
mod strong;
pub(crate) mod tree;

use crate::error::{MaxflowError, Result};
use crate::network::{Network, Reversed, Role, saturate_pins};
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
    /// There is no memory for what the engine notes of the nodes; the pseudoflow is valid.
    OutOfMemory,
}

/// Memory of the engines, kept from solve to solve. `A` names arcs, `S` are engine P's notes of them.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<A, S> {
    tree: TreeScratch<A>,
    pseudo: PseudoScratch<A, S>,
    marks: Vec<u8>,
    stack: Vec<u32>,
}

impl<A, S> Default for Scratch<A, S> {
    fn default() -> Self {
        Self { tree: TreeScratch::default(), pseudo: PseudoScratch::default(), marks: Vec::new(), stack: Vec::new() }
    }
}

/// Saturates the pins and makes the flow maximum, or says [`MaxflowError::Cancelled`] or
/// [`MaxflowError::OutOfMemory`].
///
/// `solved`: the flow was maximum before some changes, and is nearly so now.
pub(crate) fn maximize<N: Network>(
    net: &mut N,
    engine: Engine,
    solved: bool,
    scratch: &mut Scratch<N::Arc, N::Notes>,
    cancelled: &dyn Fn() -> bool,
) -> Result<()> {
    saturate_pins(net);
    let automatic = matches!(engine, Engine::Auto | Engine::ShortestPath);
    let outcome =
        if solved && automatic { mend(net, scratch, cancelled) } else { run(net, engine, scratch, cancelled) };
    match outcome {
        Outcome::Done => Ok(()),
        Outcome::Cancelled => Err(MaxflowError::Cancelled),
        Outcome::OutOfMemory => Err(MaxflowError::OutOfMemory { nodes: net.nodes().len(), links: 0 }),
    }
}

/// Few paths are left to be found: engine T finds them in one growth of its trees, where engine P would first have to
/// give up all the excess that did not get through last time.
fn mend<N: Network>(net: &mut N, scratch: &mut Scratch<N::Arc, N::Notes>, cancelled: &dyn Fn() -> bool) -> Outcome {
    match between::mark(net, &mut scratch.marks, &mut scratch.stack) {
        None => return Outcome::OutOfMemory,
        Some(false) => return Outcome::Done,
        Some(true) => {}
    }
    let marks = &scratch.marks;
    tree::solve(net, &mut scratch.tree, |v| between::is_between(marks, v), cancelled)
}

fn run<N: Network>(
    net: &mut N,
    engine: Engine,
    scratch: &mut Scratch<N::Arc, N::Notes>,
    cancelled: &dyn Fn() -> bool,
) -> Outcome {
    let supply = Supply::of(net);
    let engine = match engine {
        Engine::Auto | Engine::ShortestPath => supply.choose(net.nodes().len()),
        chosen => chosen,
    };
    if engine == Engine::Trees {
        return tree::solve(net, &mut scratch.tree, |_| true, cancelled);
    }
    run_pseudoflow(net, &supply, scratch, cancelled)
}

/// Runs engine P from the side that has less to give: there more gets through, and less has to be given up step by step.
fn run_pseudoflow<N: Network>(
    net: &mut N,
    supply: &Supply,
    scratch: &mut Scratch<N::Arc, N::Notes>,
    cancelled: &dyn Fn() -> bool,
) -> Outcome {
    if supply.lack < supply.excess / 2 {
        pseudoflow::solve(&mut Reversed(net), &mut scratch.pseudo, cancelled)
    } else {
        pseudoflow::solve(net, &mut scratch.pseudo, cancelled)
    }
}

/// What there is to send, and where.
#[derive(Clone, Copy, Debug, Default)]
struct Supply {
    /// Sum of positive excess.
    excess: i64,
    /// Sum of negative excess, as a positive number.
    lack: i64,
    /// Number of nodes with excess, positive or negative.
    terminals: usize,
}

impl Supply {
    fn of<N: Network>(net: &N) -> Self {
        let mut supply = Self::default();
        for v in net.nodes().filter(|&v| net.role(v) == Role::Free) {
            let excess: i64 = net.excess(v).into();
            supply.excess += excess.max(0);
            supply.lack += (-excess).max(0);
            supply.terminals += usize::from(excess != 0);
        }
        supply
    }

    /// Dense terminals of both kinds in balance mean short paths: engine T. All else is for engine P.
    fn choose(&self, nodes: usize) -> Engine {
        let balanced = self.excess < 2 * self.lack && self.lack < 2 * self.excess;
        if balanced && 2 * self.terminals > nodes { Engine::Trees } else { Engine::Pseudoflow }
    }
}
