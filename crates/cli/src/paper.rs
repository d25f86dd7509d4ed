//! `--paper`: a switch that stands for other options. What it stands for is written once, in its help.

use clap::{Arg, ArgAction, Command};

/// What parts the options that may be typed beside the switch from those that may not.
const BESIDE: &str = "where they are not given";

/// The command with its switch standing for the options that its help names, which have those values by default then.
pub(crate) fn spelt_out(command: Command) -> Command {
    let Some(help) = command.get_arguments().find(|arg| arg.get_id() == "paper").and_then(Arg::get_help) else {
        return command;
    };
    let help = help.to_string();
    let instead = options(&command, help.split_once(BESIDE).map_or(&*help, |(_, instead)| instead));
    let all = options(&command, &help);
    // All at once: an option that is changed alone becomes the last one.
    command.mut_args(|arg| match all.iter().find(|(id, _)| arg.get_id() == id) {
        Some((_, value)) => arg.default_value_if("paper", "true", value),
        None if arg.get_id() == "paper" => arg.conflicts_with_all(instead.iter().map(|(id, _)| id)),
        None => arg,
    })
}

/// Options that a text names, with their values.
fn options(command: &Command, text: &str) -> Vec<(String, String)> {
    let mut words = text.split_whitespace().map(|word| word.trim_end_matches([',', '.']));
    let mut all = Vec::new();
    while let Some(word) = words.next() {
        let Some(long) = word.strip_prefix("--") else { continue };
        let arg = command.get_arguments().find(|arg| arg.get_long() == Some(long)).expect("an option of the command");
        let value =
            if matches!(arg.get_action(), ArgAction::SetTrue) { "true" } else { words.next().expect("a value") };
        all.push((arg.get_id().to_string(), value.to_owned()));
    }
    all
}
