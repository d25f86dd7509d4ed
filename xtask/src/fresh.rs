//! `fresh`: the answers of benchmarks and the pictures of README.md are what the program makes today.

use crate::{Outcome, bench, gallery, program};

/// Makes each of them once, with the program as tests build it, and names those that have changed.
pub(crate) fn run(_: &[String]) -> Outcome {
    let program = program::build_for_tests()?;
    let stale = [bench::stale(&program)?, gallery::stale(&program)?].concat();
    stale.iter().for_each(|what| eprintln!("xtask: {what}"));
    let fix = "look at what changed, then write the new answers, or run `cargo xtask gallery`";
    program::check(stale.is_empty(), || format!("{} made otherwise today; {fix}", stale.len()))
}
