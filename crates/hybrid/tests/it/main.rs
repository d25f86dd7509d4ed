//! Hybrid synthesis from outside. One binary: each is a link.
#![forbid(unsafe_code)]

mod guided;
mod memory;
mod properties;
mod repair;
