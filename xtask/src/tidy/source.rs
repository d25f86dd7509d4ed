//! Rules about source text: first lines, lengths, leftovers, silence.

use super::Breach;
use crate::tree::Tree;

/// Lines a source file may have.
const LONGEST: usize = 400;

/// Columns a comment may have: those that rustfmt wraps code at.
const WIDEST: usize = 120;

/// The crates that may open files, start threads, read the clock or print.
const LOUD: [&str; 4] = ["crates/cli/", "crates/io/", "crates/testkit/", "xtask/"];

/// Words that must not stay, each with what is wrong with it. In two halves, so that this file is no breach itself.
const LEFTOVERS: [(&str, &str, &str); 10] = [
    ("todo", "!(", "unfinished"),
    ("unimplemented", "!(", "unfinished"),
    ("dbg", "!(", "a trace of debugging"),
    ("#[ig", "nore", "a test that is skipped: assert the present behaviour and write why"),
    ("/ho", "me/", "a path of one machine"),
    ("/ro", "ot/", "a path of one machine"),
    ("/Us", "ers/", "a path of one machine"),
    ("/wo", "rk/", "a path of one machine"),
    ("C:", "\\\\", "a path of one machine"),
    ("<<<<", "<<<", "an unfinished merge"),
];

/// What a quiet library does not name.
const LOUD_WORDS: [&str; 8] =
    ["std::fs", "std::env", "std::time", "std::thread", "println!", "eprintln!", "print!(", "std::process"];

/// Source files that do not begin with `//!`.
pub(super) fn module_comments(tree: &Tree) -> Vec<Breach> {
    tree.texts(".rs")
        .filter(|(_, text)| !text.starts_with("//! "))
        .map(|(path, _)| Breach::at_line(path, 1, "does not begin with `//!`"))
        .collect()
}

/// Source files longer than [`LONGEST`].
pub(super) fn sizes(tree: &Tree) -> Vec<Breach> {
    tree.texts(".rs")
        .map(|(path, text)| (path, text.lines().count()))
        .filter(|(_, lines)| LONGEST < *lines)
        .map(|(path, lines)| Breach::new(path, format!("{lines} lines, {LONGEST} at most")))
        .collect()
}

/// Comments wider than [`WIDEST`]; rows of tables cannot be broken.
pub(super) fn widths(tree: &Tree) -> Vec<Breach> {
    let mut breaches = Vec::new();
    for (path, text) in tree.texts(".rs") {
        for (number, line) in (1..).zip(text.lines()).filter(|(_, line)| line.trim_start().starts_with("//")) {
            let columns = line.chars().count();
            let is_row = line.trim_start().trim_start_matches(['/', '!', ' ']).starts_with('|');
            if WIDEST < columns && !is_row {
                breaches.push(Breach::at_line(path, number, format!("{columns} columns, {WIDEST} at most")));
            }
        }
    }
    breaches
}

/// Leftovers, blanks at the end of lines, and files whose last line does not end.
pub(super) fn leftovers(tree: &Tree) -> Vec<Breach> {
    let mut breaches = Vec::new();
    let kinds = [".rs", ".toml", ".md", ".yml", "run"];
    for (path, text) in kinds.iter().flat_map(|kind| tree.texts(kind)) {
        for (number, line) in (1..).zip(text.lines()) {
            for (head, tail, what) in LEFTOVERS {
                if let Some(at) = line.find(&format!("{head}{tail}"))
                    && starts_a_word(line, at, head)
                {
                    breaches.push(Breach::at_line(path, number, format!("`{head}{tail}`: {what}")));
                }
            }
            if line.ends_with([' ', '\t']) {
                breaches.push(Breach::at_line(path, number, "blanks at the end of the line"));
            }
        }
        if !text.is_empty() && !text.ends_with('\n') {
            breaches.push(Breach::new(path, "the last line does not end"));
        }
    }
    breaches
}

/// `debug_dbg` holds no leftover, and `a/home/b` is no path of a machine.
fn starts_a_word(line: &str, at: usize, head: &str) -> bool {
    let before = line[..at].chars().next_back();
    match head.starts_with('/') {
        true => before.is_none_or(|c| !c.is_alphanumeric() && c != '.' && c != '_' && c != '-'),
        false => before.is_none_or(|c| !c.is_alphanumeric() && c != '_'),
    }
}

/// Library code that prints or reaches for files, threads or the clock. What stands below `#[cfg(test)]` may.
pub(super) fn quiet(tree: &Tree) -> Vec<Breach> {
    let mut breaches = Vec::new();
    let is_library = |path: &str| path.contains("/src/") && !LOUD.iter().any(|loud| path.starts_with(loud));
    for (path, text) in tree.texts(".rs").filter(|(path, _)| is_library(path)) {
        let code = (1..).zip(text.lines()).take_while(|(_, line)| line.trim() != "#[cfg(test)]");
        for (number, line) in code.filter(|(_, line)| !line.trim_start().starts_with("//")) {
            for word in LOUD_WORDS.iter().filter(|word| line.contains(**word)) {
                breaches.push(Breach::at_line(path, number, format!("`{word}` in a library")));
            }
        }
    }
    breaches
}

#[cfg(test)]
mod tests {
    use super::super::lines;
    use super::*;

    #[test]
    fn bare_files_and_long_files_are_found() {
        let long = format!("//! Long.\n{}", "\n".repeat(LONGEST));
        let tree = Tree::of(&[("crates/a/src/lib.rs", "mod b;\n"), ("crates/a/src/b.rs", &long)]);
        assert_eq!(lines(&module_comments(&tree)), ["crates/a/src/lib.rs:1: does not begin with `//!`"]);
        assert_eq!(lines(&sizes(&tree)), ["crates/a/src/b.rs: 401 lines, 400 at most"]);
    }

    #[test]
    fn wide_comments_are_found_but_no_rows_of_tables() {
        let (wide, fits) = ("x".repeat(WIDEST - 3), "\u{f6}".repeat(WIDEST - 4));
        let text = format!("//! {fits}\n    /// {wide}\nlet {wide}\n/// | {wide} |\n// \"{wide}\"\n");
        let found = lines(&widths(&Tree::of(&[("crates/a/src/lib.rs", &text)])));
        let at = |line, columns| format!("crates/a/src/lib.rs:{line}: {columns} columns, 120 at most");
        assert_eq!(found, [at(2, 125), at(5, 122)]);
    }

    #[test]
    fn leftovers_are_found_and_look_alikes_are_not() {
        let word = |i: usize| format!("{}{}", LEFTOVERS[i].0, LEFTOVERS[i].1);
        let bad = format!("//! A.\nfn a() {{ {}) }}\nlet b = 1; \nx = \"{}me\"\n", word(0), word(4));
        let found = lines(&leftovers(&Tree::of(&[("xtask/src/a.rs", &bad)])));
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found[0].starts_with("xtask/src/a.rs:2: ") && found[1].ends_with("end of the line"), "{found:?}");
        let good = format!("//! A.\nmy_{}) https://a.org{}x\n", word(2), word(4));
        assert_eq!(leftovers(&Tree::of(&[("xtask/src/a.rs", &good)])), []);
        assert_eq!(leftovers(&Tree::of(&[("README.md", "open")])).len(), 1);
    }

    #[test]
    fn libraries_are_quiet_but_their_tests_need_not_be() {
        let text = "//! A.\nuse std::fs;\n/// No `println!`.\n#[cfg(test)]\nmod tests { use std::thread; }\n";
        assert_eq!(
            lines(&quiet(&Tree::of(&[("crates/a/src/lib.rs", text)]))),
            ["crates/a/src/lib.rs:2: `std::fs` in a library"]
        );
        assert_eq!(quiet(&Tree::of(&[("crates/io/src/lib.rs", text)])), []);
    }
}
