//! The project's own chores. `cargo xtask ci` runs every check and test.
#![forbid(unsafe_code)]

use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    match std::env::args().nth(1).as_deref() {
        Some("ci") => ci(),
        _ => {
            eprintln!("usage: cargo xtask ci");
            ExitCode::from(2)
        }
    }
}

/// Formatting, lints, documentation, tests, in the order in which they are cheap.
fn ci() -> ExitCode {
    let steps: [(&[&str], &[(&str, &str)]); 4] = [
        (&["fmt", "--all", "--check"], &[]),
        (&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"], &[]),
        (&["doc", "--workspace", "--no-deps", "--document-private-items"], &[("RUSTDOCFLAGS", "-D warnings")]),
        (&["test", "--workspace"], &[]),
    ];
    for (args, env) in steps {
        eprintln!("xtask: cargo {}", args.join(" "));
        let status = Command::new("cargo").args(args).envs(env.iter().copied()).status();
        if !status.is_ok_and(|s| s.success()) {
            eprintln!("xtask: failed: cargo {}", args.join(" "));
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
