//! Columns from outside: what they say of outputs whose fault is known. One binary: each is a link.
#![forbid(unsafe_code)]

mod columns;
