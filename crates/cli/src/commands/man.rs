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

/// What is typed, in the order in which it is read: files, what must be given, all else.
fn synopsis(command: &Command) -> String {
    let name = command.get_bin_name().unwrap_or_else(|| command.get_name());
    if command.has_subcommands() {
        return format!("{name} COMMAND [OPTIONS]");
    }
    let mut words = vec![name.to_owned()];
    for arg in command.get_positionals() {
        let more = if arg.get_num_args().is_some_and(|n| 1 < n.max_values()) { "..." } else { "" };
        words.push(arg.get_value_names().unwrap_or_default().iter().map(|name| format!("{name}{more}")).collect());
    }
    for arg in command.get_arguments().filter(|arg| !arg.is_positional() && arg.is_required_set()) {
        let value = arg.get_value_names().unwrap_or_default().join(" ");
        let flag = arg.get_short().map_or_else(|| format!("--{}", arg.get_id()), |short| format!("-{short}"));
        words.push(format!("{flag} {value}"));
    }
    words.push("[OPTIONS]".to_owned());
    words.join(" ")
}

/// The pages by their names: one for the program, one a command.
fn pages(mut command: Command) -> std::io::Result<Vec<(String, Vec<u8>)>> {
    command.build();
    let page = |command: &Command| {
        let page = Page::new(command.clone().override_usage(synopsis(command)));
        let mut bytes = Vec::new();
        page.render(&mut bytes)?;
        Ok((page.get_filename(), bytes))
    };
    let commands = command.get_subcommands().filter(|c| !c.is_hide_set() && c.get_name() != "help");
    std::iter::once(&command).chain(commands).map(page).collect()
}
