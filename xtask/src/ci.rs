//! `ci`: everything that has to pass, in the order in which it is cheap. Needs cargo, rustfmt and clippy.

use std::time::{Duration, Instant};

use crate::outcome::Outcome;
use crate::program::{self, cargo};
use crate::tidy;

/// What all of it may take from a clean clone on two quiet cores when all methods stand. It is run at every change:
/// what would go over belongs into `soak`, unless it guards a promise.
const BUDGET: Duration = Duration::from_secs(15 * 60);

/// The optional features that no member of the workspace asks for: with them, their tests run beside all others.
const FEATURES: &str = "--features=selvedge-maxflow/petgraph,selvedge-core/image";

/// A step: its name, and cargo's line; without a line, `tidy`.
type Step = (&'static str, &'static [&'static str]);

/// The program asks for rayon whatever its features say, and so would all crates beside it: it is left out of what is
/// `bare`. The core is the crate that has a serial twin of every loop, so its tests run without rayon as well.
const STEPS: [Step; 7] = [
    ("format", &["fmt", "--all", "--check"]),
    ("tidy", &[]),
    ("lints", &["clippy", "--workspace", "--all-targets", FEATURES, "--", "-D", "warnings"]),
    ("documentation", &["doc", "--workspace", "--no-deps", FEATURES]),
    (
        "bare",
        &["check", "--workspace", "--exclude", "selvedge", "--exclude", "xtask", "--no-default-features", "--tests"],
    ),
    ("tests", &["test", "--workspace", FEATURES]),
    ("core's tests, bare", &["test", "--package", "selvedge-core", "--no-default-features", "--lib"]),
];

/// Runs every check and test, and tells what each took.
pub(crate) fn run(_: &[String]) -> Outcome {
    let started = Instant::now();
    let mut table = String::new();
    for (name, line) in STEPS {
        let (began, cpu) = (Instant::now(), program::children_time());
        match line {
            [] => tidy::run(&[])?,
            line => cargo(line)?,
        }
        let cpu = program::children_time().saturating_sub(cpu);
        table += &format!("{name:<20} {:>7.1} {:>9.1}\n", began.elapsed().as_secs_f64(), cpu.as_secs_f64());
        eprintln!("xtask: {name}: {:.1} s", began.elapsed().as_secs_f64());
    }
    let (total, budget) = (started.elapsed().as_secs(), BUDGET.as_secs());
    eprintln!("\n{:<20} {:>7} {:>9}\n{table}", "", "seconds", "processor");
    eprintln!("xtask: all green after {total} s; a clean clone may take {budget} s on two quiet cores");
    Ok(())
}
