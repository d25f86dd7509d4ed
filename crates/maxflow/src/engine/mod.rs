//! The engines, and who runs when.
//!
//! An engine takes a residual network with saturated pins and moves flow until no positive excess can reach a negative
//! one. All of them leave the same thing behind, so they can follow each other.

pub(crate) mod closure;
pub(crate) mod tree;

/// Whether an engine finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// The flow is maximum.
    Done,
    /// The work budget is spent; the pseudoflow is valid and another engine can go on.
    OverBudget,
    /// The caller wants to stop; the pseudoflow is valid.
    Cancelled,
}
