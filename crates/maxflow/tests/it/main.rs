//! Max-flow from outside: against slow oracles and known answers, on graphs of every kind. One binary: each is a link.
#![forbid(unsafe_code)]

mod adversarial;
mod again;
mod bytes;
mod common;
mod corpus;
mod energy;
mod flow;
mod golden;
mod grid;
mod limits;
mod npz;
mod oracles;
#[cfg(feature = "petgraph")]
mod petgraph;
mod properties;
