//! `tidy`: rules that no compiler knows. Each says its reason and the fix; each is also a test.

mod circles;
mod citations;
mod crates;
mod edges;
mod paths;
mod pictures;
mod source;

use crate::outcome::Outcome;
use crate::tree::Tree;

/// One breach of a rule.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Breach {
    /// File, and line where there is one.
    place: String,
    /// What is wrong there.
    what: String,
}

impl Breach {
    fn new(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self { place: place.into(), what: what.into() }
    }

    fn at_line(path: &str, line: usize, what: impl Into<String>) -> Self {
        Self::new(format!("{path}:{line}"), what)
    }
}

/// A rule over the whole tree.
struct Rule {
    name: &'static str,
    reason: &'static str,
    fix: &'static str,
    check: fn(&Tree) -> Vec<Breach>,
}

const RULES: [Rule; 19] = [
    Rule {
        name: "edges between crates",
        reason: "each crate is picked alone, and is understood by what it must never know",
        fix: "move the code to the crate that may know; a new edge is rare and argued: xtask/src/tidy/edges.rs, ARCHITECTURE.md",
        check: edges::inside,
    },
    Rule {
        name: "outside dependencies",
        reason: "codecs belong to io, threads to core, the command line to cli",
        fix: "call the crate that owns the dependency; a new owner goes into the table in xtask/src/tidy/edges.rs",
        check: edges::outside,
    },
    Rule {
        name: "inherited manifests",
        reason: "versions, edition and lints have one place, the root",
        fix: "write `version.workspace = true`, `NAME = { workspace = true }`, `[lints] workspace = true`",
        check: crates::manifests,
    },
    Rule {
        name: "the map of the crates",
        reason: "a newcomer finds every crate in ARCHITECTURE.md, and nothing there that is gone",
        fix: "add a paragraph that names `crates/NAME` to ARCHITECTURE.md, or take the stale one out",
        check: crates::architecture,
    },
    Rule {
        name: "the first page as README",
        reason: "what a registry shows of a crate is what was tested as its documentation",
        fix: "run `cargo xtask readme`",
        check: crates::readmes,
    },
    Rule {
        name: "no circle of files",
        reason: "files in a circle are read, tested and changed as one, however small each is",
        fix: "move what both need to a file of its own, or hand it in",
        check: circles::check,
    },
    Rule {
        name: "crates from the ground up",
        reason: "who reads the map from its top knows the ground before what stands on it",
        fix: "move the paragraph of `crates/NAME` in ARCHITECTURE.md below those of all crates that it needs",
        check: crates::ground_up,
    },
    Rule {
        name: "forbidden unsafe",
        reason: "unsafe code lives in the SIMD module of fft-ssd and nowhere else",
        fix: "write `#![forbid(unsafe_code)]` below the crate's `//!` lines",
        check: crates::forbid_unsafe,
    },
    Rule {
        name: "one binary of tests a crate",
        reason: "each file in tests/ is a binary, and a link: they were a third of what the checks take",
        fix: "make it a module of tests/it/main.rs",
        check: crates::test_binaries,
    },
    Rule {
        name: "module comments",
        reason: "the first line of a file says what it is for",
        fix: "begin the file with `//!` and one sentence",
        check: source::module_comments,
    },
    Rule {
        name: "file sizes",
        reason: "a file holds one idea; above 400 lines it holds two",
        fix: "split by idea, not by number",
        check: source::sizes,
    },
    Rule {
        name: "widths of comments",
        reason: "rustfmt wraps code and leaves comments: what is wider is cut in reviews and side by side",
        fix: "move what is beyond to the next line",
        check: source::widths,
    },
    Rule {
        name: "leftovers",
        reason: "nothing unfinished, skipped, local to a machine or invisible stays in the tree",
        fix: "finish it, make it an error value, or take it out",
        check: source::leftovers,
    },
    Rule {
        name: "quiet libraries",
        reason: "no library opens a file, starts a thread, reads the clock or prints: the caller decides",
        fix: "hand the value in, or tell it to the `Observer`; files belong to crates/io and crates/cli",
        check: source::quiet,
    },
    Rule {
        name: "citations",
        reason: "a key in a comment leads to a row of PAPERS.md, and from there to the paper",
        fix: "add the row to PAPERS.md, or mend the key",
        check: citations::check,
    },
    Rule {
        name: "implementations",
        reason: "PAPERS.md leads from an equation to the function; a name that is gone leads nowhere",
        fix: "name the function that does it now",
        check: citations::functions,
    },
    Rule {
        name: "fixtures",
        reason: "every file has an origin and a licence, and a clone stays small",
        fix: "add it to fixtures/MANIFEST.toml, then `cargo xtask fixtures --write`",
        check: pictures::fixtures,
    },
    Rule {
        name: "reference pictures",
        reason: "references are for the eye, the hash decides: at most 32 KiB each and 3 MiB in all",
        fix: "make the recipe's output smaller",
        check: pictures::references,
    },
    Rule {
        name: "living references",
        reason: "a reference without a recipe checks nothing",
        fix: "delete it, or bring its recipe back",
        check: pictures::dead,
    },
];

/// Checks every rule and prints what is wrong, why it matters and how to mend it.
pub(crate) fn run(_: &[String]) -> Outcome {
    let tree = Tree::of_project();
    let mut broken = 0;
    for rule in &RULES {
        let breaches = (rule.check)(&tree);
        if !breaches.is_empty() {
            broken += 1;
            eprint!("{}", report(rule, &breaches));
        }
    }
    if broken == 0 { Ok(()) } else { Err(format!("{broken} of {} rules broken", RULES.len())) }
}

fn report(rule: &Rule, breaches: &[Breach]) -> String {
    let lines: String = breaches.iter().map(|b| format!("  {}: {}\n", b.place, b.what)).collect();
    format!("tidy: {}\n{lines}  why: {}\n  fix: {}\n\n", rule.name, rule.reason, rule.fix)
}

/// For the tests of the rules: the breaches as lines.
#[cfg(test)]
fn lines(breaches: &[Breach]) -> Vec<String> {
    breaches.iter().map(|b| format!("{}: {}", b.place, b.what)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_is_tidy() {
        let tree = Tree::of_project();
        let reports: String = RULES
            .iter()
            .map(|rule| (rule, (rule.check)(&tree)))
            .filter(|(_, b)| !b.is_empty())
            .map(|(rule, breaches)| report(rule, &breaches))
            .collect();
        assert!(reports.is_empty(), "\n{reports}");
    }
}
