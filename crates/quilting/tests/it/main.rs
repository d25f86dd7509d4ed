//! Quilting from outside. One binary: each is a link.
#![forbid(unsafe_code)]

mod above;
mod memory;
mod properties;
