//! `selvedge man`: manual pages.

use std::path::PathBuf;

use clap::{Args, Command, ValueHint};
use clap_mangen::Man as Page;

use crate::failure::{Failure, shown};
use crate::outputs::{self, Outputs};
use crate::report::{Done, Report};
use crate::session::Session;

/// Options of `man`.
#[derive(Args, Debug)]
pub(crate) struct Man {
    /// The folder to write to, such as ~/.local/share/man/man1.
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
    folder: PathBuf,
}

impl Man {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>, program: Command) -> Result<Done, Failure> {
        let report = Report::new("man");
        let pages = pages(program).map_err(|e| Failure::new(70, e.to_string()).remedy("please report it"))?;
        let paths: Vec<PathBuf> = pages.iter().map(|(name, _)| self.folder.join(name)).collect();
        outputs::check(session, &paths, &[])?;
        let (would, n) = (if session.global.dry_run { "would be " } else { "" }, pages.len());
        let mut outputs = Outputs::default();
        if !session.global.dry_run {
            paths.iter().zip(pages).for_each(|(path, (_, page))| outputs.bytes(path, page));
        }
        let line = format!("{}: {would}{n} pages", shown(&self.folder));
        Ok(Done::made(report, line, outputs))
    }
}

/// The pages by their names: one for the program, one a command.
fn pages(mut command: Command) -> std::io::Result<Vec<(String, Vec<u8>)>> {
    command.build();
    let page = |command: &Command| {
        let page = Page::new(command.clone());
        let mut bytes = Vec::new();
        page.render(&mut bytes)?;
        Ok((page.get_filename(), bytes))
    };
    let commands = command.get_subcommands().filter(|c| !c.is_hide_set() && c.get_name() != "help");
    std::iter::once(&command).chain(commands).map(page).collect()
}
