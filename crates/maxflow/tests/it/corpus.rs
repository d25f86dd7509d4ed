//! Replays the fuzzers' corpus, and byte strings of our own: a thousand, or for as many seconds as
//! `SELVEDGE_FUZZ_SECONDS` says (`cargo xtask soak fuzz` sets it where there is no libFuzzer).

use std::path::PathBuf;
use std::time::{Duration, Instant};

/// SplitMix64.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ *state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// The files of a fuzz target's corpus.
fn corpus(target: &str, least: usize) -> Vec<Vec<u8>> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target);
    let mut files: Vec<_> = std::fs::read_dir(folder).expect("the corpus").map(|f| f.expect("a file").path()).collect();
    files.sort();
    assert!(least <= files.len(), "the corpus has {} files", files.len());
    files.iter().map(|file| std::fs::read(file).expect("a file of the corpus")).collect()
}

#[test]
fn corpus_of_the_fuzzers() {
    corpus("maxflow", 8).iter().for_each(|data| crate::bytes::run(data));
    corpus("dimacs", 4).iter().for_each(|data| crate::bytes::run_dimacs(data));
}

/// One in a few bytes differs from a file of the corpus.
fn mutated(file: &[u8], state: &mut u64) -> Vec<u8> {
    let mut data = file.to_vec();
    for _ in 0..=next(state) % 8 {
        let at = next(state) as usize % (data.len() + 1);
        match next(state) % 4 {
            0 => data.insert(at, (next(state) >> 56) as u8),
            1 => data.truncate(at),
            _ => data.iter_mut().skip(at).take(1).for_each(|byte| *byte = (next(state) >> 56) as u8),
        }
    }
    data
}

#[test]
fn byte_strings() {
    let seconds = std::env::var("SELVEDGE_FUZZ_SECONDS").ok().and_then(|s| s.parse().ok());
    let (start, limit) = (Instant::now(), Duration::from_secs(seconds.unwrap_or(0)));
    let (graphs, texts) = (corpus("maxflow", 8), corpus("dimacs", 4));
    let (mut state, mut runs) = (51, 0_usize);
    while runs < 1000 || start.elapsed() < limit {
        let len = next(&mut state) % 600;
        let data: Vec<u8> = (0..len).map(|_| (next(&mut state) >> 56) as u8).collect();
        crate::bytes::run(&data);
        crate::bytes::run(&mutated(&graphs[runs % graphs.len()], &mut state));
        crate::bytes::run_dimacs(&mutated(&texts[runs % texts.len()], &mut state));
        runs += 1;
    }
    eprintln!("{runs} rounds of byte strings");
}
