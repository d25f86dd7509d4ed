//! From the words that were typed, and a file of options below them, to a command.

use std::error::Error as _;
use std::ffi::OsString;

use clap::error::ErrorKind;
use clap::{Arg, ArgMatches, FromArgMatches};

use crate::cli::{self, Cli};
use crate::config;
use crate::failure::Failure;
use crate::lists;
use crate::stdio;
use crate::turns::{self, Turns};
use crate::used::Used;
use crate::wrong::Wrong;

/// A command line, understood.
pub(crate) struct Typed {
    /// What it says.
    pub(crate) cli: Cli,
    /// Where each value came from.
    matches: ArgMatches,
    /// The same without what a file of options says.
    own: ArgMatches,
    /// The command line that they match.
    command: clap::Command,
}

impl Typed {
    /// The options that change samples, as typed.
    pub(crate) fn used(&self) -> Used {
        let Some((name, matches)) = self.matches.subcommand() else { return Used::default() };
        Used::of(&config::command(&self.command, name), matches)
    }

    /// Long names of the command's options that were typed, or are by a file of options what they are not by default:
    /// a saved file tells all of them.
    pub(crate) fn names(&self) -> Vec<String> {
        let Some((name, matches)) = self.matches.subcommand() else { return Vec::new() };
        let own = self.own.subcommand_matches(name);
        let command = config::command(&self.command, name);
        let by_hand = |arg: &Arg| own.is_some_and(|own| config::was_typed(arg, own));
        let typed = command.get_arguments().filter(|arg| by_hand(arg) || config::says_other(arg, matches));
        typed.filter_map(|arg| arg.get_long().map(str::to_owned)).collect()
    }

    /// Options that were typed and do nothing for the command, as they are typed.
    pub(crate) fn idle(&self) -> Vec<String> {
        let Some((name, matches)) = self.matches.subcommand() else { return Vec::new() };
        let command = config::command(&self.command, name);
        let of_command = cli::idle(&command);
        let typed = command.get_arguments().filter(|arg| of_command.contains(&arg.get_id().as_str()));
        typed
            .filter(|arg| config::was_typed(arg, matches))
            .filter_map(|arg| Some(format!("--{}", arg.get_long()?)))
            .collect()
    }

    /// The runs that it asks for, where it asks for several.
    pub(crate) fn turns(&self) -> Result<Turns, Failure> {
        turns::turns(&self.command, &self.matches)
    }

    /// The options as a file for `--config`.
    pub(crate) fn saved(&self) -> Result<String, Failure> {
        config::saved(&self.command, &self.matches)
    }
}

/// Why there is nothing to run.
pub(crate) enum Stop {
    /// Help or the version was asked for.
    Answer(clap::Error),
    /// The command line, or the file of options, is wrong.
    Wrong(Failure),
}

impl Stop {
    /// Answers or explains, and gives the exit code.
    pub(crate) fn tell(&self, json: bool) -> u8 {
        match self {
            Self::Wrong(failure) => failure.tell(json),
            Self::Answer(help) => {
                // Nobody listens: that is the listener's business.
                let _ = stdio::answer(format!("{}", help.render()).as_bytes());
                0
            }
        }
    }
}

impl From<Failure> for Stop {
    fn from(failure: Failure) -> Self {
        Self::Wrong(failure)
    }
}

impl From<clap::Error> for Stop {
    fn from(error: clap::Error) -> Self {
        // Whoever types nothing else wants to know what there is.
        let asked = !error.use_stderr() || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
        if asked { Self::Answer(error) } else { Self::Wrong(usage(&error)) }
    }
}

/// Understands a command line. What was typed goes before what `--config` says, and that before the defaults.
pub(crate) fn parse(words: &[OsString]) -> Result<Typed, Stop> {
    let command = numbers(cli::program());
    let words = lists::spread(&command, words);
    // What the file may still supply is not missing yet.
    let typed = config::optional(command.clone()).try_get_matches_from(&words)?;
    let from_file = config::words(&command, &typed)?;
    let words = spliced(&words, from_file.as_ref().map_or(&[], |file| &file.words));
    let all = command.clone().try_get_matches_from(words).and_then(|matches| {
        let cli = Cli::from_arg_matches(&matches)?;
        Ok(Typed { cli, matches, own: typed, command })
    });
    all.map_err(|error| match (Stop::from(error), from_file) {
        // The words alone were fine.
        (Stop::Wrong(failure), Some(file)) if !failure.message.contains("required argument") => {
            Stop::Wrong(failure.about(&file.path))
        }
        (stop, _) => stop,
    })
}

/// The command whose options take negative numbers, so that they are refused by their range.
fn numbers(command: clap::Command) -> clap::Command {
    let names: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    let number = |arg: clap::Arg| {
        let takes = !arg.is_positional() && arg.get_action().takes_values();
        if takes { arg.allow_negative_numbers(true) } else { arg }
    };
    names.into_iter().fold(command.mut_args(number), |command, name| command.mut_subcommand(name, numbers))
}

/// Words with others at their end, but before `--`.
fn spliced(words: &[OsString], more: &[OsString]) -> Vec<OsString> {
    let end = words.iter().position(|w| w == "--").unwrap_or(words.len());
    [&words[..end], more, &words[end..]].concat()
}

/// What other programs call something that this one has under another name: nearest spellings would mislead.
const HINTS: [(&str, &str); 8] = [
    ("--seamless", "use --tile xy"),
    ("--overwrite", "files are replaced unless --no-clobber is given; leave it out"),
    ("--force", "files are replaced unless --no-clobber is given; leave it out"),
    ("--inpaint", "use 'selvedge fill PICTURE --mask MASK'"),
    ("--hole", "use --mask"),
    ("--block", "use --region, the size that patches are found for"),
    ("--region", "use --block, the side of the blocks"),
    ("--width", "use --size WxH"),
];

/// The option that is meant by one that does not exist.
fn hint(error: &clap::Error) -> Option<&'static str> {
    use clap::error::{ContextKind, ContextValue};
    let Some(ContextValue::String(typed)) = error.get(ContextKind::InvalidArg) else { return None };
    if error.kind() != ErrorKind::UnknownArgument {
        return None;
    }
    let name = typed.split('=').next().unwrap_or_default();
    HINTS.iter().find(|(other, _)| *other == name).map(|(_, hint)| *hint)
}

/// The commands that have an option which the one that was typed has not.
fn elsewhere(error: &clap::Error) -> Option<String> {
    use clap::error::{ContextKind, ContextValue};
    let Some(ContextValue::String(typed)) = error.get(ContextKind::InvalidArg) else { return None };
    let name = typed.strip_prefix("--").filter(|_| error.kind() == ErrorKind::UnknownArgument)?;
    let name = name.split('=').next().unwrap_or_default();
    let program = cli::program();
    let has = |command: &&clap::Command| {
        command.get_arguments().any(|arg| !arg.is_global_set() && !arg.is_hide_set() && arg.get_long() == Some(name))
    };
    let commands: Vec<&str> = program.get_subcommands().filter(has).map(clap::Command::get_name).collect();
    let (last, others) = commands.split_last()?;
    let list = if others.is_empty() { (*last).to_owned() } else { format!("{} and {last}", others.join(", ")) };
    Some(format!("--{name} is an option of {list}"))
}

/// A usage error in one line.
fn usage(error: &clap::Error) -> Failure {
    if matches!(error.kind(), ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand | ErrorKind::MissingSubcommand) {
        return Failure::new(2, "no command").remedy("see --help");
    }
    let text = error.to_string();
    let lines = text.lines().map(str::trim).take_while(|l| !l.starts_with("Usage:") && !l.starts_with("For more"));
    let (tips, what): (Vec<&str>, Vec<&str>) = lines.filter(|l| !l.is_empty()).partition(|l| l.starts_with("tip: "));
    let what = what.join(" ");
    let failure = Failure::new(2, what.strip_prefix("error: ").unwrap_or(&what));
    if let Some(hint) = hint(error) {
        return failure.remedy(hint);
    }
    if let Some(elsewhere) = elsewhere(error) {
        return failure.remedy(elsewhere);
    }
    // What is no option is none of the values either.
    let tip = tips.iter().find(|tip| !tip.starts_with("tip: to pass "));
    match (error.source().and_then(|e| e.downcast_ref::<Wrong>()), tip) {
        (Some(wrong), _) => failure.remedy(&wrong.remedy),
        (None, Some(tip)) => failure.remedy(tip.trim_start_matches("tip: ")),
        (None, None) if what.contains("invalid digit found in string") => failure.remedy("give a whole number"),
        (None, None) => failure.remedy("see --help"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::name_of;
    use clap::CommandFactory;
    use serde_json::json;

    fn failure(line: &str) -> String {
        let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        match parse(&words) {
            Err(Stop::Wrong(failure)) => format!("{}; {}", failure.message, failure.remedy.unwrap_or_default()),
            Err(Stop::Answer(_)) => "an answer".into(),
            Ok(_) => "understood".into(),
        }
    }

    #[test]
    fn the_command_line_is_sound() {
        cli::program().debug_assert();
    }

    #[test]
    fn usage_errors_are_one_line_with_a_remedy() {
        assert_eq!(failure("selvedge"), "an answer");
        assert_eq!(failure("selvedge --json"), "no command; see --help");
        let hinted = failure("selvedge quilt a.png -o b.png --seamless");
        assert!(hinted.ends_with("; use --tile xy"), "{hinted}");
        assert_eq!(failure("selvedge quilt a.png --help"), "an answer");
        assert_eq!(
            failure("selvedge quilt a.png -o b.png --size 12px"),
            "invalid value '12px' for '--size <SIZE>': '12px' is no size; write 512, 512x384 or 2x"
        );
        assert_eq!(
            failure("selvedge quilt a.png -o b.png --sise 12"),
            "unexpected argument '--sise' found; a similar argument exists: '--size'"
        );
        assert_eq!(
            failure("selvedge quilt a.png -o b.png --over c.png"),
            "unexpected argument '--over' found; --over is an option of graphcut, numbers, analogy, detail and hybrid"
        );
        assert_eq!(
            failure("selvedge fill a.png -o b.png --reach 3"),
            "unexpected argument '--reach' found; --reach is an option of graphcut and video"
        );
        assert!(failure("selvedge animate a.png -o b.png --with c.png").contains("--with is an option of "));
        assert_eq!(
            failure("selvedge quilt a.png -o b.png --block 4294967296"),
            "invalid value '4294967296' for '--block <N|auto>': '4294967296' is over 4294967295; write a number of pixels, or \
             auto"
        );
        assert_eq!(failure("selvedge quilt a.png --zzz"), "unexpected argument '--zzz' found; see --help");
        assert_eq!(failure("selvedge quilt a.png -o b.png --tolerance -1"), "understood", "the method knows its range");
        assert!(failure("selvedge quilt a.png").contains("--output <OUT>"));
    }

    #[test]
    fn a_file_of_options_goes_before_a_double_dash() {
        let words = |line: &str| line.split(' ').map(OsString::from).collect::<Vec<_>>();
        assert_eq!(spliced(&words("a b -- c"), &words("d e")), words("a b d e -- c"));
        assert_eq!(spliced(&words("a b"), &words("d")), words("a b d"));
    }

    /// A value for an option that differs from its default.
    fn other(command: &str, arg: &clap::Arg) -> String {
        let long = arg.get_long().unwrap_or_default();
        let default: Vec<&std::ffi::OsStr> = arg.get_default_values().iter().map(|d| d.as_os_str()).collect();
        let possible = arg.get_possible_values();
        match (long, possible.iter().find(|v| !default.contains(&std::ffi::OsStr::new(v.get_name())))) {
            ("size" | "region" | "reach", _) if command == "video" => "7x9x5".into(),
            ("size", _) => "7x9".into(),
            ("init", _) => "quilt".into(),
            ("schedule", _) => "2:8,1:8".into(),
            ("jump" | "center", _) => "9,3".into(),
            ("range", _) => "1-3".into(),
            ("flipbook" | "from-flipbook", _) => "2x3".into(),
            ("at", _) => "3,4".into(),
            ("color", _) => "#ffff00=1 --strokes f".into(),
            ("keep", _) if command == "merge" => "1 f".into(),
            ("ignore-light", _) => "0.5".into(),
            ("scale-range", _) => "0.5..3".into(),
            ("correspondence" | "auto-guides", _) => "orientation=3".into(),
            (_, Some(value)) => value.get_name().into(),
            _ if default.contains(&std::ffi::OsStr::new("3")) => "4".into(),
            _ => "3".into(),
        }
    }

    #[test]
    fn paper_stands_for_what_each_method_calls_the_papers() {
        let used = |command: &str| {
            let line = format!("selvedge {command} a -o b --paper");
            let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
            let Ok(typed) = parse(&words) else { panic!("{line}") };
            typed.used().json()
        };
        let (quilt, of) = (used("quilt"), selvedge_quilting::Options::paper());
        assert_eq!((&quilt["tolerance"], &quilt["spread"]), (&json!(of.tolerance), &json!(of.spread)));
        assert_eq!([&quilt["stage"], &quilt["continuation"]], [&name_of(of.stage), &name_of(of.continuation)]);
        let (transfer, of) = (used("transfer"), selvedge_quilting::TransferOptions::paper());
        assert_eq!((&transfer["tolerance"], &transfer["spread"]), (&json!(of.tolerance), &json!(of.spread)));
        let (graphcut, of) = (used("graphcut"), selvedge_graphcut_textures::Options::<2>::paper());
        assert_eq!((&graphcut["reach"], of.reach), (&json!("all"), Some([u32::MAX; 2])));
        let all =
            [&graphcut["variety"], &graphcut["tries"], &graphcut["levels"]].map(|v| v.to_string().replace('"', ""));
        assert_eq!(all, [of.variety.unwrap().to_string(), of.tries.to_string(), of.levels.unwrap().to_string()]);
        let (hybrid, of) = (used("hybrid"), selvedge_hybrid::Options::paper());
        assert_eq!((&hybrid["tolerance"], &hybrid["spread"]), (&json!(of.tolerance), &json!(of.spread)));
        assert_eq!((&hybrid["circular"], &hybrid["k"]), (&json!(of.circular), &json!(of.k)));
        assert_eq!((&hybrid["block"], of.block), (&json!("32"), Some([32, 32])));
        let names = [name_of(of.search), name_of(of.resynthesize), name_of(of.continuation), name_of(of.layout)];
        assert_eq!(["search", "resynthesize", "continuation", "layout"].map(|name| &hybrid[name]), names.each_ref());
        let error = |name: &str| selvedge_hybrid::Threshold::Absolute(hybrid[name].as_str().unwrap().parse().unwrap());
        assert_eq!(["max-error", "pixel-error"].map(error), [of.max_error, of.pixel_error]);
        let (optimize, of) = (used("optimize"), selvedge_texture_optimization::Options::paper());
        assert_eq!((&optimize["iterations"], &optimize["robust"]), (&json!(of.iterations), &json!(of.robust)));
        assert_eq!((&optimize["complete"], of.complete), (&json!("none"), None));
        assert_eq!((&optimize["finish"], &optimize["init"]), (&json!(name_of(of.finish)), &json!("random")));
    }

    #[test]
    fn no_option_of_any_command_is_forgotten_by_what_pictures_carry() {
        let mut program = Cli::command();
        program.build();
        let used = |line: &str| {
            let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
            match parse(&words) {
                Ok(typed) => typed.used(),
                Err(Stop::Wrong(failure)) => panic!("{line}: {failure:?}"),
                Err(Stop::Answer(_)) => panic!("{line}"),
            }
        };
        let mut seen = 0;
        let lines = [
            ("synthesize", "a -o b"),
            ("quilt", "a -o b"),
            ("transfer", "a -o b"),
            ("graphcut", "a -o b"),
            ("hybrid", "a -o b"),
            ("optimize", "a -o b"),
            ("analogy", "a b c -o d --map m.exr"),
            ("numbers", "a --labels b --target c -o d"),
            ("detail", "a --low b --scale 2 -o c"),
            ("animate", "a --flow sink -o b.####.png"),
            ("video", "a -o b"),
            ("merge", "a b -o c"),
            ("fill", "a -o b"),
            ("extend", "a --size 9 -o b"),
            ("extend", "a --size 2x -o b"),
            ("tile", "a -o b"),
            ("apply", "m a -o b"),
            ("compare", "a b"),
        ];
        // Pictures carry how they were made; `again` and `random-labels` have no options of their own.
        let weaves = |c: &clap::Command| c.get_arguments().any(|a| a.get_long() == Some("output"));
        for command in program.get_subcommands().filter(|c| weaves(c)) {
            let name = command.get_name();
            assert!(["again", "random-labels"].contains(&name) || lines.iter().any(|(of, _)| *of == name), "{name}");
        }
        for (name, rest) in lines {
            let command = program.find_subcommand(name).unwrap();
            let plain = used(&format!("selvedge {name} {rest}"));
            for arg in command.get_arguments().filter(|a| !a.is_positional() && !a.is_global_set()) {
                let long = arg.get_long().unwrap();
                if !crate::used::is_used(long) || rest.contains(&format!("--{long} ")) {
                    continue;
                }
                let value =
                    if arg.get_action().takes_values() { format!(" {}", other(name, arg)) } else { String::new() };
                // What only says how another option acts needs that one.
                let more = match long {
                    "scale-range" => " --scale-field f",
                    "want-where" => " --want f",
                    "guide-where" => " --guide x y",
                    "from-pad" => " --from-flipbook 2x3",
                    "pad" => " --flipbook 2x3",
                    "play" => " --frames 9",
                    "surface-from" => " --jump 9,3",
                    "still-frame" => " --fixed f",
                    "fuse-keep" => " --fuse",
                    _ => "",
                };
                let value = if long == "guide" { " x y".to_owned() } else { value };
                // A clip is compared with itself.
                let rest = if (name, long) == ("compare", "loop") { "a" } else { rest };
                let changed = used(&format!("selvedge {name} {rest} --{long}{value}{more}"));
                assert_ne!(changed, plain, "{name} --{long}{value}");
                seen += 1;
            }
        }
        assert!(50 < seen, "{seen}");
    }
}
