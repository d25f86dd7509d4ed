//! How what is written was made: for pictures and clips alike.

use std::path::PathBuf;

use selvedge_io::{Fingerprint, Provenance};

use crate::used::Used;

/// What tells an input by name and content: eight signs, few enough to be read in a command line. They guard against
/// mistakes, and not against whoever makes a file on purpose.
pub(crate) fn mark(input: &Fingerprint) -> String {
    let mut hasher = blake3::Hasher::new();
    for part in [input.name.as_bytes(), b"\0", input.blake3.as_bytes()] {
        hasher.update(part);
    }
    hasher.finalize().to_hex()[..8].to_owned()
}

/// The command of a picture for people who paste it: with other files of these names it is refused. That is no part of
/// what pictures carry, which stays as it was typed: it follows from the inputs beside it. The masks of an animation
/// are read one by one and known as one, so that none of them could be told by itself; commands of clips read what no
/// picture of theirs tells, and one of frames names all of them where each carries its own.
pub(crate) fn pasteable(made: &Provenance) -> String {
    let marks: Vec<String> = made.inputs.iter().map(mark).collect();
    let is_of = |command: &str| made.command.starts_with(&format!("selvedge {command} "));
    let of_frames = (is_of("analogy") || is_of("apply")) && made.command.contains('#');
    if marks.is_empty() || of_frames || is_of("animate") || is_of("video") {
        made.command.clone()
    } else {
        format!("{} --expect {}", made.command, marks.join(","))
    }
}

/// A run by what decides its samples: nothing that differs between equal runs.
pub(crate) fn provenance(
    (command, seed): (&str, u64),
    options: Used,
    files: &[PathBuf],
    inputs: Vec<Fingerprint>,
) -> Provenance {
    let command = options.with("seed", seed).command(command, files);
    Provenance { version: env!("CARGO_PKG_VERSION").into(), seed, inputs, command }
}
