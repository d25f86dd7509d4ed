//! `cargo fuzz run y4m`: YUV4MPEG2 of any bytes: frames as the head tells, twice, or one line.
//!
//! The same check replays the corpus in `cargo test -p selvedge-io corpus`, without the fuzzer.
#![no_main]

#[allow(dead_code, reason = "the other targets run the rest")]
#[path = "../../crates/io/tests/it/bytes.rs"]
mod bytes;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bytes::run_clip(data));
