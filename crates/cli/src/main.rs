//! `selvedge`: textures, materials and moving textures from examples, on the command line.
#![forbid(unsafe_code)]

mod args;
mod available;
mod backdrop;
mod blending;
mod cli;
mod clip_given;
mod clip_look;
mod clip_maps;
mod clips;
mod commands;
mod config;
mod correspondence;
mod course;
mod exemplars;
mod explain;
mod eyes;
mod failure;
mod flows;
mod followed;
mod fuse_keep;
mod ground;
mod harmonise;
mod inputs;
mod kept;
mod kept_weave;
mod light;
mod lists;
mod loaded;
mod loom;
mod made;
mod memory;
mod method;
mod names;
mod needs;
mod options;
mod outcome;
mod output_size;
mod outputs;
mod page;
mod pairs;
mod paper;
mod planes;
mod reel;
mod repairing;
mod report;
mod roles;
mod run;
mod session;
mod setup;
mod sheet;
mod size;
mod stdio;
mod sweep;
mod thumbnail;
mod turns;
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

/// Bytes that a command line, its errors and the run's threads take before any buffer that is sized by a picture: no
/// step of that can be refused memory and go on. With 6 MiB runs were seen to abort at 28 to 38 MiB of address space,
/// with 20 one of many.
const ROOM: usize = 26 << 20;

fn main() -> ExitCode {
    if std::hint::black_box(Vec::<u8>::new()).try_reserve_exact(ROOM).is_err() {
        let failure = Failure::new(6, "the system has no memory for the program itself");
        return ExitCode::from(failure.remedy("allow more").tell(std::env::args_os().any(|word| word == "--json")));
    }
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
