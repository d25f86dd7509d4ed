//! Replays the fuzzer's corpus, and a thousand byte strings of our own.

mod bytes;

/// SplitMix64.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ *state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

#[test]
fn corpus_of_the_fuzzer() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/maxflow");
    let mut files: Vec<_> = std::fs::read_dir(folder).expect("the corpus").map(|f| f.expect("a file").path()).collect();
    files.sort();
    assert!(files.len() >= 8, "the corpus has {} files", files.len());
    for file in files {
        bytes::run(&std::fs::read(file).expect("a file of the corpus"));
    }
}

#[test]
fn a_thousand_byte_strings() {
    let mut state = 51;
    for _ in 0..1000 {
        let len = next(&mut state) % 600;
        let data: Vec<u8> = (0..len).map(|_| (next(&mut state) >> 56) as u8).collect();
        bytes::run(&data);
    }
}
