//! The commands of README.md: each one that starts the program must work as it stands there.

use std::fs;
use std::path::Path;

use libtest_mimic::{Failed, Trial};

use crate::program::{fresh, selvedge_in};

/// How a reader starts the program.
const STARTS: [&str; 2] = ["cargo run --release -p selvedge -- ", "selvedge "];

/// One test a block of commands: they run one after the other in the same folder.
pub(crate) fn trials() -> Vec<Trial> {
    let text = fs::read_to_string(crate::root().join("README.md")).unwrap_or_default();
    let blocks = blocks(&text);
    if blocks.is_empty() {
        return vec![Trial::test("README.md shows a command", || Err("it shows none".into()))];
    }
    let trial = |(i, commands): (usize, Vec<String>)| {
        Trial::test(format!("README.md: {}", commands[0]), move || check(i, &commands))
    };
    blocks.into_iter().enumerate().map(trial).collect()
}

/// Arguments of the commands in each block of shell code, without comments.
fn blocks(text: &str) -> Vec<Vec<String>> {
    let blocks = text.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    let arguments = |line: &str| {
        let line = line.split(" #").next().unwrap_or_default().trim();
        STARTS.iter().find_map(|start| line.strip_prefix(start)).map(str::to_owned)
    };
    let commands = blocks.map(|block| block.lines().filter_map(arguments).collect::<Vec<_>>());
    commands.filter(|commands| !commands.is_empty()).collect()
}

/// Runs commands in a folder of their own with the fixtures in it.
fn check(number: usize, commands: &[String]) -> Result<(), Failed> {
    let folder = crate::out_dir().join(format!("readme-{number}"));
    fresh(&folder);
    copy(&crate::root().join("fixtures"), &folder.join("fixtures")).map_err(|e| format!("the fixtures: {e}"))?;
    for command in commands {
        let said = selvedge_in(&folder, command.split_whitespace());
        if said.exit != Some(0) {
            return Err(format!("`{command}` ended with {:?}: {}", said.exit, said.stderr).into());
        }
    }
    let _ = fs::remove_dir_all(&folder);
    Ok(())
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let to = to.join(entry.file_name());
        if entry.path().is_dir() { copy(&entry.path(), &to)? } else { fs::copy(entry.path(), &to).map(drop)? }
    }
    Ok(())
}
