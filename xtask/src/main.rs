//! The project's own chores. `cargo xtask` lists them.
#![forbid(unsafe_code)]

mod banner;
mod bench;
mod ci;
mod fit;
mod fixtures;
mod gallery;
mod large;
mod outcome;
mod program;
mod readme;
mod regress;
mod soak;
mod table;
mod tidy;
mod tree;

use std::process::ExitCode;

use self::outcome::Outcome;

/// A chore: its name and arguments, what it does, and the function.
type Chore = (&'static str, &'static str, fn(&[String]) -> Outcome);

const CHORES: [Chore; 11] = [
    (
        "bench [PATTERN]",
        "time whole runs of the program and check their answers; --against PROGRAM compares; `large` times real sizes, `cms` a table",
        bench::run,
    ),
    ("ci", "everything that has to pass: format, lints, documentation, tests, each crate bare, tidiness", ci::run),
    ("fit", "the coefficients of the preference again, from the table of columns and ranks", fit::run),
    (
        "fixtures [--write]",
        "check fixtures/ against its manifest and the code that made it, or make it again",
        fixtures::run,
    ),
    ("gallery", "make the pictures of README.md again, with the program itself", gallery::run),
    ("readme", "each crate's README.md again, from the first page of its documentation", readme::run),
    ("regress [PATTERN]", "the end-to-end suite in release, and a page of its pictures", regress::run),
    ("bless NAME...", "write the references of recipes in tests/suite", regress::bless),
    ("review [PATTERN]", "regress, then ask for each recipe that differs whether to bless it", regress::review),
    (
        "soak [PART]",
        "the long checks: crates alone and as packages, random options, runs killed half way, large graphs, fuzzing",
        soak::run,
    ),
    ("tidy", "rules that no compiler knows: edges between crates, citations, sizes, licences", tidy::run),
];

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let wanted = args.first().map_or("", String::as_str);
    let Some((_, _, run)) = CHORES.iter().find(|(usage, ..)| usage.split(' ').next() == Some(wanted)) else {
        eprintln!("usage: cargo xtask CHORE");
        for (usage, does, _) in CHORES {
            eprintln!("  {usage:<20} {does}");
        }
        return ExitCode::from(2);
    };
    match run(&args[1..]) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("xtask {wanted}: {why}");
            ExitCode::FAILURE
        }
    }
}
