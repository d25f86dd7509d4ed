//! Replays the fuzzers' corpus, and random changes of it: a hundred rounds, or for as many seconds as
//! `SELVEDGE_FUZZ_SECONDS` says (`cargo xtask soak fuzz` sets it where there is no libFuzzer).

use std::path::PathBuf;
use std::time::{Duration, Instant};

use selvedge_core::{Rng, Seed};

use crate::bytes::{run_clip, run_flipbook, run_names};

/// What a fuzz target does with bytes.
type Target = fn(&[u8]);

const TARGETS: [(&str, Target); 4] =
    [("y4m", run_clip), ("apng", run_clip), ("flipbook", run_flipbook), ("names", run_names)];

/// The files of a target's corpus.
fn corpus(target: &str) -> Vec<Vec<u8>> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target);
    let mut files: Vec<_> = std::fs::read_dir(folder).expect("the corpus").map(|f| f.expect("a file").path()).collect();
    files.sort();
    assert!(3 <= files.len(), "the corpus of {target} has {} files", files.len());
    files.iter().map(|file| std::fs::read(file).expect("a file of the corpus")).collect()
}

/// A file of the corpus with up to eight bytes put in, left out or changed.
fn mutated(file: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut data = file.to_vec();
    for _ in 0..=rng.below(8) {
        let at = rng.below(data.len() as u32 + 1) as usize;
        match rng.below(8) {
            0 | 1 => data.insert(at, rng.below(256) as u8),
            2 => data.truncate(at),
            _ => data.iter_mut().skip(at).take(1).for_each(|byte| *byte = rng.below(256) as u8),
        }
    }
    data
}

#[test]
fn corpus_of_the_fuzzers() {
    for (target, run) in TARGETS {
        corpus(target).iter().for_each(|data| run(data));
    }
}

#[test]
fn byte_strings() {
    let seconds = std::env::var("SELVEDGE_FUZZ_SECONDS").ok().and_then(|s| s.parse().ok());
    let (start, limit) = (Instant::now(), Duration::from_secs(seconds.unwrap_or(0)));
    let files = TARGETS.map(|(target, _)| corpus(target));
    let (mut rng, mut runs) = (Seed(19).rng(), 0_usize);
    while runs < 100 || start.elapsed() < limit {
        for ((_, run), files) in TARGETS.iter().zip(&files) {
            run(&mutated(&files[runs % files.len()], &mut rng));
        }
        runs += 1;
    }
    eprintln!("{runs} rounds of byte strings");
}
