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
        assert_eq!(lines(&check(&Tree::default())), ["PAPERS.md: is not there"]);
    }
}
