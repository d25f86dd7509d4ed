//! `selvedge completions`: scripts for shells.

use std::path::Path;

use clap::{Args, Command};
use clap_complete::Shell;
use serde_json::json;

use crate::args::typed_name;
use crate::failure::Failure;
use crate::outputs;
use crate::report::{Done, Report};
use crate::session::Session;

/// Options of `completions`.
#[derive(Args, Debug)]
pub(crate) struct Completions {
    /// The shell. For bash: selvedge completions bash > ~/.local/share/bash-completion/completions/selvedge
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

impl Completions {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>, mut program: Command) -> Result<Done, Failure> {
        outputs::check::<&Path>(session, &[], &[])?;
        let mut report = Report::new("completions");
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut program, "selvedge", &mut script);
        let script = String::from_utf8_lossy(&script).into_owned();
        report.stats = json!({"shell": typed_name(self.shell), "script": script});
        Ok(Done::answered(report, script))
    }
}
