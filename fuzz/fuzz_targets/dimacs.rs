//! `cargo fuzz run dimacs`: DIMACS files of any bytes. What can be read is written, read again and solved.
//!
//! The same check replays the corpus in `cargo test -p selvedge-maxflow corpus`, without the fuzzer.
#![no_main]

#[allow(dead_code, reason = "the other target runs the rest")]
#[path = "../../crates/maxflow/tests/it/bytes.rs"]
mod bytes;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bytes::run_dimacs(data));
