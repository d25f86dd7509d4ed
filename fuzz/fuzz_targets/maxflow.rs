//! `cargo fuzz run maxflow`: graphs from bytes, every engine against every other, changes and solves in turn.
//!
//! The same check replays the corpus in `cargo test -p selvedge-maxflow --test corpus`, without the fuzzer.
#![no_main]

#[path = "../../crates/maxflow/tests/bytes/mod.rs"]
mod bytes;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bytes::run(data));
