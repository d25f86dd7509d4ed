//! `selvedge`: textures, materials and moving textures from examples, on the command line.
#![forbid(unsafe_code)]

mod args;
mod available;
mod backdrop;
mod blending;
mod cli;
mod clips;
mod commands;
mod config;
mod course;
mod exemplars;
mod explain;
mod failure;
mod ground;
mod harmonise;
mod inputs;
mod light;
mod loom;
mod made;
mod memory;
mod method;
mod names;
mod outputs;
mod page;
mod planes;
mod repairing;
mod report;
mod roles;
mod run;
mod session;
mod setup;
mod size;
mod stdio;
mod steps;
mod typed;
mod used;
mod values;
mod watch;
mod weaving;
mod with;
mod wrong;

use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

use crate::failure::Failure;

fn main() -> ExitCode {
    // A net below everything: a broken promise of ours ends in one line and code 70, never in a stack trace.
    failure::catch_panics();
    let words: Vec<OsString> = std::env::args_os().collect();
    ExitCode::from(run(&words))
}

fn run(words: &[OsString]) -> u8 {
    let typed = match typed::parse(words) {
        Ok(typed) => typed,
        // Errors in the command line itself are told as it asks for, as far as can be seen.
        Err(stop) => return stop.tell(words.iter().any(|word| word == "--json")),
    };
    // Nothing of what was typed is looked at again but whether errors are wanted as JSON.
    let outcome = catch_unwind(AssertUnwindSafe(|| run::run(&typed)));
    let outcome = outcome.unwrap_or_else(|panic| Err(Failure::internal(&*panic)));
    outcome.unwrap_or_else(|failure| failure.tell(typed.cli.global.json))
}
