//! How what is written was made: for pictures and clips alike.

use std::path::PathBuf;

use selvedge_io::{Fingerprint, Provenance};

use crate::used::Used;

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
