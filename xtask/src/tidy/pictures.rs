//! Rules about files that are not text: fixtures and the references of the end-to-end suite.

use std::collections::BTreeSet;

use super::Breach;
use crate::fixtures::{self, Entry};
use crate::tree::Tree;

/// Bytes that all of fixtures/ may take.
const FIXTURES: usize = 4 << 20;
/// Bytes that one reference picture, and all of them, may take.
const REFERENCE: usize = 32 << 10;
const REFERENCES: usize = 3 << 20;
/// Licences under which a fixture may be in the tree.
const LICENCES: [&str; 3] = ["MIT OR Apache-2.0", "CC0-1.0", "public domain"];

/// Files that the manifest does not have, or has otherwise; missing origins; strange licences; too many bytes.
pub(super) fn fixtures(tree: &Tree) -> Vec<Breach> {
    let entries = match fixtures::entries(tree) {
        Ok(entries) => entries,
        Err(why) => return vec![Breach::new(fixtures::MANIFEST, why)],
    };
    let mut breaches: Vec<Breach> = entries.iter().flat_map(|entry| entry_breaches(tree, entry)).collect();
    let listed: BTreeSet<&str> = entries.iter().map(|e| e.path.as_str()).collect();
    let files: Vec<(&str, usize)> =
        tree.files().filter_map(|(p, b)| Some((p.strip_prefix("fixtures/")?, b.len()))).collect();
    let stray = files.iter().map(|(path, _)| *path).filter(|path| *path != "MANIFEST.toml" && !listed.contains(path));
    breaches.extend(stray.map(|path| Breach::new(format!("fixtures/{path}"), "is not in the manifest")));
    let total: usize = files.iter().map(|(_, len)| len).sum();
    if FIXTURES < total {
        breaches.push(Breach::new("fixtures", format!("{total} bytes, {FIXTURES} at most")));
    }
    breaches
}

fn entry_breaches(tree: &Tree, entry: &Entry) -> Vec<Breach> {
    let place = format!("fixtures/{}", entry.path);
    let mut breaches = Vec::new();
    match tree.files().find(|(path, _)| *path == place) {
        None => breaches.push(Breach::new(&place, "is in the manifest and not there")),
        Some((_, bytes)) if entry.bytes != bytes.len() || entry.blake3 != fixtures::hash(bytes) => {
            breaches.push(Breach::new(&place, "is not the file that the manifest describes"));
        }
        Some(_) => {}
    }
    if entry.origin.is_empty() || entry.shows.is_empty() {
        breaches.push(Breach::new(&place, "has no origin, or does not say what it shows"));
    }
    if !LICENCES.contains(&entry.licence.as_str()) {
        let allowed = LICENCES.join(", ");
        breaches.push(Breach::new(&place, format!("has the licence `{}`; allowed: {allowed}", entry.licence)));
    }
    breaches
}

/// Reference pictures above their budget.
pub(super) fn references(tree: &Tree) -> Vec<Breach> {
    let pictures = || tree.files().filter(|(path, _)| path.starts_with("tests/ref/") && path.ends_with(".png"));
    let large = pictures().filter(|(_, bytes)| REFERENCE < bytes.len());
    let mut breaches: Vec<Breach> =
        large.map(|(path, bytes)| Breach::new(path, format!("{} bytes, {REFERENCE} at most", bytes.len()))).collect();
    let total: usize = pictures().map(|(_, bytes)| bytes.len()).sum();
    if REFERENCES < total {
        breaches.push(Breach::new("tests/ref", format!("{total} bytes of PNG, {REFERENCES} at most")));
    }
    breaches
}

/// References `NAME.snap` without a recipe `tests/suite/NAME.toml`, and `NAME.png` whose recipe keeps no picture.
pub(super) fn dead(tree: &Tree) -> Vec<Breach> {
    let recipe = |name: &str| tree.text(&format!("tests/suite/{name}.toml"));
    let lives = |path: &str| match path.strip_prefix("tests/ref/").and_then(|file| file.rsplit_once('.')) {
        Some((name, "snap")) => recipe(name).is_some(),
        Some((name, "png")) => recipe(name).is_some_and(|text| text.lines().any(|line| line.starts_with("picture"))),
        _ => false,
    };
    tree.files()
        .filter(|(path, _)| path.starts_with("tests/ref/") && !lives(path))
        .map(|(path, _)| Breach::new(path, "belongs to no recipe in tests/suite"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::lines;
    use super::*;

    const ENTRY: &str = "[[file]]\npath = \"a.png\"\nbytes = 3\nshows = \"x\"\norigin = \"y\"\nlicence = \"CC0-1.0\"\n";

    fn manifest(entry: &str) -> String {
        format!("{entry}blake3 = \"{}\"\n", fixtures::hash(b"abc"))
    }

    #[test]
    fn a_listed_file_is_fine_and_any_other_is_not() {
        let good = manifest(ENTRY);
        let tree =
            |extra: (&str, &str)| Tree::of(&[("fixtures/MANIFEST.toml", &good), ("fixtures/a.png", "abc"), extra]);
        assert_eq!(fixtures(&tree(("README.md", ""))), []);
        assert_eq!(lines(&fixtures(&tree(("fixtures/b.png", "")))), ["fixtures/b.png: is not in the manifest"]);
        assert_eq!(fixtures(&tree(("fixtures/a.png", "abd"))).len(), 1);
        let heavy = "x".repeat(FIXTURES);
        assert!(lines(&fixtures(&tree(("fixtures/b.png", &heavy))))[1].ends_with("4194304 at most"));
    }

    #[test]
    fn licences_and_missing_files_are_found() {
        let odd = manifest(&ENTRY.replace("CC0-1.0", "unknown"));
        let found = lines(&fixtures(&Tree::of(&[("fixtures/MANIFEST.toml", &odd)])));
        assert!(found[0].ends_with("not there") && found[1].contains("`unknown`"), "{found:?}");
        assert_eq!(fixtures(&Tree::default()).len(), 1);
    }

    #[test]
    fn large_and_dead_references_are_found() {
        let large = "x".repeat(REFERENCE + 1);
        let tree = Tree::of(&[
            ("tests/suite/a.toml", ""),
            ("tests/ref/a.png", &large),
            ("tests/ref/a.snap", ""),
            ("tests/ref/b.snap", ""),
            ("tests/suite/c.toml", "picture = \"out.png\"\n"),
            ("tests/ref/c.png", ""),
        ]);
        assert_eq!(lines(&references(&tree)), ["tests/ref/a.png: 32769 bytes, 32768 at most"]);
        let dead: Vec<String> = dead(&tree).into_iter().map(|breach| breach.place).collect();
        assert_eq!(dead, ["tests/ref/a.png", "tests/ref/b.snap"]);
    }
}
