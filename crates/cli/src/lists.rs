//! Lists of files with commas: `--mask a.png,b.png` is `--mask a.png --mask b.png`, unless there is a file of that
//! name.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::{Arg, ArgAction, Command, ValueHint};

/// The command line with every list of files as if its files were typed one by one.
pub(crate) fn spread(all: &Command, words: &[OsString]) -> Vec<OsString> {
    let named = |word: &OsString| word.to_str().and_then(|name| all.find_subcommand(name));
    let Some((at, command)) = words.iter().enumerate().find_map(|(i, word)| Some((i, named(word)?))) else {
        return words.to_vec();
    };
    let mut out = words[..=at].to_vec();
    // The option whose values may follow, how it was typed, and whether one has.
    let mut open: Option<(&Arg, &OsStr, bool)> = None;
    for (i, word) in words.iter().enumerate().skip(at + 1) {
        let text = word.as_encoded_bytes();
        if text == b"--" {
            out.extend_from_slice(&words[i..]);
            break;
        }
        if text.starts_with(b"--") {
            let (flag, value) = word.to_str().and_then(|w| w.split_once('=')).unzip();
            let arg = list(command, flag.map_or(word.as_os_str(), OsStr::new));
            match (arg, flag, value) {
                (Some(_), Some(flag), Some(value)) => out.extend(parts(value.as_ref()).map(|part| joined(flag, &part))),
                _ => out.push(word.clone()),
            }
            open = arg.filter(|_| value.is_none()).map(|arg| (arg, word.as_os_str(), false));
        } else if let Some((arg, flag, has_value)) = open.filter(|_| !text.starts_with(b"-") || text == b"-") {
            let takes_more = arg.get_num_args().is_some_and(|range| 1 < range.max_values());
            if has_value && !takes_more {
                out.push(word.clone());
                open = None;
                continue;
            }
            for (i, part) in parts(word).enumerate() {
                if 0 < i && !takes_more {
                    out.push(flag.to_owned());
                }
                out.push(part);
            }
            open = Some((arg, flag, true));
        } else {
            out.push(word.clone());
            open = None;
        }
    }
    out
}

/// The option of this name, if it is a list of files. One of so many values each time, such as a pair, is none: it
/// means something by their places, and reads lists among them itself.
fn list<'c>(command: &'c Command, flag: &OsStr) -> Option<&'c Arg> {
    let long = flag.to_str()?.strip_prefix("--")?;
    let arg = command.get_arguments().find(|arg| arg.get_long() == Some(long))?;
    let files = matches!(arg.get_value_hint(), ValueHint::FilePath | ValueHint::DirPath);
    let is_group = arg.get_num_args().is_some_and(|n| 1 < n.max_values() && n.min_values() == n.max_values());
    (files && !is_group && matches!(arg.get_action(), ArgAction::Append)).then_some(arg)
}

fn joined(flag: &str, value: &OsStr) -> OsString {
    let mut word = OsString::from(flag);
    word.push("=");
    word.push(value);
    word
}

/// The names between commas; the whole where there is such a file, or nothing between two. Commas in brackets choose
/// channels.
fn parts(word: &OsStr) -> impl Iterator<Item = OsString> {
    let (mut names, mut depth) = (vec![String::new()], 0_u32);
    for c in word.to_str().unwrap_or_default().chars() {
        match c {
            '[' => depth += 1,
            ']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        match names.last_mut() {
            Some(last) if c != ',' || 0 < depth => last.push(c),
            _ => names.push(String::new()),
        }
    }
    let whole = names.len() == 1 || names.iter().any(String::is_empty) || Path::new(word).exists();
    if whole { vec![word.to_owned()] } else { names.into_iter().map(OsString::from).collect() }.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread_line(line: &str) -> String {
        let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let all = crate::cli::program();
        spread(&all, &words).iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn lists_are_files_one_by_one() {
        for (typed, meant) in [
            ("quilt a b --mask none,m.png -o o", "quilt a b --mask none --mask m.png -o o"),
            ("quilt a b --mask=none,m.png", "quilt a b --mask=none --mask=m.png"),
            ("quilt --mask m,n a,b", "quilt --mask m --mask n a,b"),
            ("quilt a --with n,h r -o o", "quilt a --with n h r -o o"),
            ("quilt a --match x.exr[R,G],y --seed 1,2", "quilt a --match x.exr[R,G] y --seed 1,2"),
            ("transfer a b --guide s,u t --target x,y", "transfer a b --guide s,u t --target x,y"),
            ("again p --look-in a,b c", "again p --look-in a b c"),
            ("fill p --from a,b --source-mask none,m", "fill p --from a --from b --source-mask none --source-mask m"),
            ("quilt a --mask m -- --mask a,b", "quilt a --mask m -- --mask a,b"),
            ("quilt a --mask ,m --mask m,", "quilt a --mask ,m --mask m,"),
            ("--seed 1,2 quilt a --tile x", "--seed 1,2 quilt a --tile x"),
            ("--version", "--version"),
        ] {
            let (typed, meant) = (format!("selvedge {typed}"), format!("selvedge {meant}"));
            assert_eq!(spread_line(&typed), meant);
            assert_eq!(spread_line(&meant), meant);
        }
    }
}
