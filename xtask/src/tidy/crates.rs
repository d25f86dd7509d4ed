//! Rules about crates: their manifests, their place on the map, their promise to be safe.

use super::{Breach, edges};
use crate::tree::Tree;

/// The one crate with a SIMD module: it denies unsafe code at its root and allows it there.
const WITH_SIMD: &str = "crates/fft-ssd/";

/// Manifests that do not inherit from the root.
pub(super) fn manifests(tree: &Tree) -> Vec<Breach> {
    let mut breaches = Vec::new();
    for path in members(tree) {
        let manifest = match tree.manifest(&path) {
            Ok(manifest) => manifest,
            Err(why) => {
                breaches.push(Breach::new(path, why));
                continue;
            }
        };
        let inherits = |table: &str, key: &str| {
            let value = manifest.get(table).and_then(|t| t.get(key));
            value.is_some_and(|v| v.get("workspace").is_some_and(|w| w.as_bool() == Some(true)))
        };
        for key in ["version", "edition", "rust-version", "license", "publish"] {
            if !inherits("package", key) {
                breaches.push(Breach::new(&path, format!("`{key}` is not inherited")));
            }
        }
        if manifest.get("lints").and_then(|l| l.get("workspace")).and_then(toml::Value::as_bool) != Some(true) {
            breaches.push(Breach::new(&path, "the lints are not inherited"));
        }
        for table in ["dependencies", "dev-dependencies", "build-dependencies"] {
            for name in manifest.get(table).and_then(|t| t.as_table()).into_iter().flat_map(toml::Table::keys) {
                if !inherits(table, name) {
                    breaches.push(Breach::new(&path, format!("`{name}` is not inherited")));
                }
            }
        }
    }
    breaches
}

/// Crates whose README.md is not the first page of their documentation.
pub(super) fn readmes(tree: &Tree) -> Vec<Breach> {
    let differ = |(path, text): &(String, String)| tree.text(path) != Some(text);
    let stale = crate::readme::wanted(tree).into_iter().filter(differ);
    stale.map(|(path, _)| Breach::new(path, "is not the first page of src/lib.rs")).collect()
}

/// Crates without a paragraph in ARCHITECTURE.md, and names there without a crate.
pub(super) fn architecture(tree: &Tree) -> Vec<Breach> {
    let Some(text) = tree.text("ARCHITECTURE.md") else {
        return vec![Breach::new("ARCHITECTURE.md", "is not there")];
    };
    let mut named: Vec<&str> = text
        .split("crates/")
        .skip(1)
        .filter_map(|rest| rest.split(|c: char| !c.is_ascii_alphanumeric() && c != '-' && c != '_').next())
        .filter(|name| !name.is_empty())
        .collect();
    named.sort_unstable();
    named.dedup();
    let crates = tree.crates();
    let missing = crates.iter().filter(|c| !named.contains(c)).map(|c| format!("does not name `crates/{c}`"));
    let stale = named.iter().filter(|n| !crates.contains(n)).map(|n| format!("names `crates/{n}`, which is not there"));
    missing.chain(stale).map(|what| Breach::new("ARCHITECTURE.md", what)).collect()
}

/// Crates that stand in ARCHITECTURE.md above one that they depend on.
pub(super) fn ground_up(tree: &Tree) -> Vec<Breach> {
    let text = tree.text("ARCHITECTURE.md").unwrap_or_default();
    let place = |name: &str| text.find(&format!("\n- `crates/{name}`"));
    let packages: Vec<(String, &str)> =
        tree.crates().into_iter().filter_map(|c| Some((tree.package_name(c).ok()?, c))).collect();
    let mut breaches = Vec::new();
    for name in tree.crates() {
        for (dependency, _) in edges::dependencies(tree, name).into_iter().filter(|(_, for_tests)| !for_tests) {
            let Some((_, below)) = packages.iter().find(|(package, _)| *package == dependency) else { continue };
            if place(name) < place(below) {
                breaches.push(Breach::new("ARCHITECTURE.md", format!("has `{name}` above `{below}`, which it needs")));
            }
        }
    }
    breaches
}

/// Crate roots that do not forbid unsafe code.
pub(super) fn forbid_unsafe(tree: &Tree) -> Vec<Breach> {
    let is_root = |path: &str| path.ends_with("/src/lib.rs") || path.ends_with("/src/main.rs");
    tree.texts(".rs")
        .filter(|(path, _)| is_root(path) && !path.starts_with(WITH_SIMD) && !path.starts_with("fuzz/"))
        .filter(|(_, text)| !text.contains("#![forbid(unsafe_code)]"))
        .map(|(path, _)| Breach::new(path, "does not forbid unsafe code"))
        .collect()
}

/// Integration tests that are binaries of their own.
pub(super) fn test_binaries(tree: &Tree) -> Vec<Breach> {
    let is_binary = |path: &str| {
        let inside = path.strip_prefix("crates/").and_then(|rest| rest.split_once("/tests/"));
        inside.is_some_and(|(_, file)| !file.contains('/'))
    };
    let files = tree.texts(".rs").filter(|(path, _)| is_binary(path));
    files.map(|(path, _)| Breach::new(path, "is a binary of its own")).collect()
}

fn members(tree: &Tree) -> Vec<String> {
    let crates = tree.crates().into_iter().map(|c| format!("crates/{c}/Cargo.toml"));
    crates.chain(["xtask/Cargo.toml".to_owned()]).filter(|path| tree.text(path).is_some()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::lines;
    use super::*;

    #[test]
    fn a_manifest_of_its_own_mind_is_found() {
        let own = "[package]\nname = \"a\"\nversion = \"1.0.0\"\nedition.workspace = true\nrust-version.workspace = true\n\
                   license.workspace = true\npublish.workspace = true\n[dependencies]\npng = \"0.17\"";
        let breaches = manifests(&Tree::of(&[("crates/a/Cargo.toml", own)]));
        let what: Vec<&str> = breaches.iter().map(|b| b.what.as_str()).collect();
        assert_eq!(what, ["`version` is not inherited", "the lints are not inherited", "`png` is not inherited"]);
    }

    #[test]
    fn the_map_has_every_crate_and_no_ghost() {
        let map = "See `crates/core` and `crates/gone`.";
        let tree = Tree::of(&[("ARCHITECTURE.md", map), ("crates/core/Cargo.toml", ""), ("crates/io/Cargo.toml", "")]);
        assert_eq!(
            lines(&architecture(&tree)),
            ["ARCHITECTURE.md: does not name `crates/io`", "ARCHITECTURE.md: names `crates/gone`, which is not there"]
        );
    }

    #[test]
    fn a_test_beside_the_binary_of_tests_is_found() {
        let tree =
            Tree::of(&[("crates/a/tests/it/main.rs", ""), ("crates/a/tests/it/b.rs", ""), ("crates/a/tests/c.rs", "")]);
        assert_eq!(lines(&test_binaries(&tree)), ["crates/a/tests/c.rs: is a binary of its own"]);
    }

    #[test]
    fn a_crate_above_its_ground_is_found() {
        let map = "\n- `crates/b`\n- `crates/a`\n- `crates/c`\n";
        let b = "[package]\nname = \"b\"\n[dependencies]\na = {}\n[dev-dependencies]\nc = {}";
        let files = [("crates/a/Cargo.toml", "[package]\nname = \"a\""), ("crates/b/Cargo.toml", b)];
        let tree = Tree::of(&[files[0], files[1], ("ARCHITECTURE.md", map)]);
        assert_eq!(lines(&ground_up(&tree)), ["ARCHITECTURE.md: has `b` above `a`, which it needs"]);
    }

    #[test]
    fn only_the_simd_crate_may_leave_unsafe_open() {
        let tree = Tree::of(&[("crates/a/src/lib.rs", "//! A."), ("crates/fft-ssd/src/lib.rs", "//! B.")]);
        assert_eq!(lines(&forbid_unsafe(&tree)), ["crates/a/src/lib.rs: does not forbid unsafe code"]);
    }
}
