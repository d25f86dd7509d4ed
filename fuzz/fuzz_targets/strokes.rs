//! `cargo fuzz run strokes`: strokes of a brush from bytes, laid and taken back, against merges made anew.
//!
//! The same check replays the corpus in `cargo test -p selvedge-graphcut-textures byte_strings`, without the fuzzer.
#![no_main]

#[allow(dead_code, reason = "tests are no part of a target")]
#[path = "../../crates/graphcut-textures/tests/it/strokes.rs"]
mod strokes;

libfuzzer_sys::fuzz_target!(|data: &[u8]| strokes::run(data));
