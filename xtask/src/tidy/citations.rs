//! Citation keys such as `[Efros01 2.1]`: each one used has a row in PAPERS.md.

use std::collections::BTreeSet;

use super::Breach;
use crate::tree::Tree;

/// First words of the keys: the papers that this project implements.
const PAPERS: [&str; 6] = ["Efros01", "Kwatra03", "Kwatra05", "CMS", "Ding", "HTS"];

/// Keys in sources and documents that PAPERS.md does not list.
pub(super) fn check(tree: &Tree) -> Vec<Breach> {
    let Some(papers) = tree.text("PAPERS.md") else {
        return vec![Breach::new("PAPERS.md", "is not there")];
    };
    let known: BTreeSet<&str> = papers.lines().flat_map(keys).collect();
    let mut breaches = Vec::new();
    for (path, text) in [".rs", ".md", ".toml"].iter().flat_map(|ending| tree.texts(ending)) {
        if path == "PAPERS.md" || path.starts_with("xtask/src/tidy/") {
            continue;
        }
        for (number, line) in (1..).zip(text.lines()) {
            let unknown = keys(line).filter(|key| !known.contains(key));
            breaches.extend(unknown.map(|key| Breach::at_line(path, number, format!("`[{key}]` is not in PAPERS.md"))));
        }
    }
    breaches
}

/// Functions that PAPERS.md names and no crate has. A row is `| [key] | function | deviation |`.
pub(super) fn functions(tree: &Tree) -> Vec<Breach> {
    let papers = tree.text("PAPERS.md").unwrap_or_default();
    let mut breaches = Vec::new();
    for (number, line) in (1..).zip(papers.lines()).filter(|(_, line)| keys(line).next().is_some()) {
        let column = line.split('|').nth(2).unwrap_or_default();
        // Every second piece between back quotes is code.
        for path in column.split('`').skip(1).step_by(2).filter(|code| code.contains("::")) {
            let name = path.rsplit("::").next().unwrap_or(path);
            if !is_defined(tree, name) {
                breaches.push(Breach::at_line("PAPERS.md", number, format!("no crate defines `{path}`")));
            }
        }
    }
    breaches
}

fn is_defined(tree: &Tree, name: &str) -> bool {
    let word = |rest: &str| rest.split(|c: char| !c.is_alphanumeric() && c != '_').next() == Some(name);
    let defines = |line: &str| {
        let mut kinds = ["fn ", "struct ", "enum ", "trait ", "const ", "mod "].iter();
        kinds.any(|kind| line.split_once(kind).is_some_and(|(_, rest)| word(rest)))
    };
    tree.texts(".rs").any(|(path, text)| path.starts_with("crates/") && text.lines().any(defines))
}

/// The keys of a line: `[`, a paper, a blank, a section or equation, `]`.
fn keys(line: &str) -> impl Iterator<Item = &str> {
    line.split('[')
        .skip(1)
        .filter_map(|rest| rest.split(']').next())
        .filter(|key| key.split_once(' ').is_some_and(|(paper, place)| PAPERS.contains(&paper) && !place.is_empty()))
}

#[cfg(test)]
mod tests {
    use super::super::lines;
    use super::*;

    #[test]
    fn keys_without_a_row_are_found() {
        let tree = Tree::of(&[
            ("PAPERS.md", "| [Efros01 2.1] | `boundary_cut` | none |\n"),
            ("crates/a/src/lib.rs", "//! [Efros01 2.1], not [`Efros01`].\n// [CMS eq. 7] and a[i]\n"),
        ]);
        assert_eq!(lines(&check(&tree)), ["crates/a/src/lib.rs:2: `[CMS eq. 7]` is not in PAPERS.md"]);
        assert_eq!(functions(&tree), [], "`boundary_cut` alone is no path");
        assert_eq!(lines(&check(&Tree::default())), ["PAPERS.md: is not there"]);
    }

    #[test]
    fn functions_that_are_gone_are_found() {
        let tree = Tree::of(&[
            ("PAPERS.md", "| [Efros01 2] | `a::quilt`, `a::gone` | `b::other` |\n| see | `a::x` | |\n"),
            ("crates/a/src/lib.rs", "pub fn quilt(x: u8) {}\n"),
        ]);
        assert_eq!(lines(&functions(&tree)), ["PAPERS.md:1: no crate defines `a::gone`"]);
    }
}
