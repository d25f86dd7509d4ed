//! `selvedge`: textures, materials and moving textures from examples, on the command line.
#![forbid(unsafe_code)]

mod args;
mod commands;
mod failure;
mod files;
mod report;
mod size;
mod watch;

use std::process::ExitCode;

use clap::Parser;

use crate::args::Cli;
use crate::failure::Failure;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return failure::usage(&error),
    };
    let json = cli.global.json;
    // A net below everything: a broken promise of ours ends in one line and code 70, never in a stack trace.
    std::panic::set_hook(Box::new(|_| {}));
    let outcome =
        std::panic::catch_unwind(|| commands::run(&cli)).unwrap_or_else(|panic| Err(Failure::internal(&*panic)));
    match outcome {
        Ok(code) => ExitCode::from(code),
        Err(failure) => failure.tell(json),
    }
}
