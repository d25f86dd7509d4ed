//! Which crate may know which: the table of the design, and who owns what comes from outside.

use super::Breach;
use crate::tree::Tree;

/// Each crate of `crates/` and the crates of the workspace that it may depend on, from the ground up; `*` stands for
/// all.
const EDGES: [(&str, &[&str]); 17] = [
    ("core", &[]),
    ("io", &["core"]),
    ("maxflow", &[]),
    ("fft-ssd", &["core"]),
    ("expansion", &["core", "maxflow"]),
    ("blending", &["core"]),
    ("guides", &["core"]),
    ("analysis", &["core", "fft-ssd"]),
    ("metrics", &["core", "fft-ssd", "analysis"]),
    ("quilting", &["core", "fft-ssd", "analysis"]),
    ("hybrid", &["core", "fft-ssd", "analysis", "quilting"]),
    ("graphcut-textures", &["core", "fft-ssd", "maxflow", "expansion", "analysis"]),
    ("cms-analogies", &["core", "fft-ssd", "maxflow", "expansion", "guides", "analysis"]),
    ("texture-optimization", &["core", "fft-ssd", "guides", "analysis"]),
    (
        "synthesis",
        &[
            "core",
            "analysis",
            "metrics",
            "quilting",
            "hybrid",
            "graphcut-textures",
            "cms-analogies",
            "texture-optimization",
        ],
    ),
    ("testkit", &["core"]),
    ("cli", &["*"]),
];

/// Dependencies that have an owner: nobody else names them, not even for tests (testkit writes PNG for them).
const OWNED: [(&str, &[&str]); 13] = [
    ("rayon", &["core", "maxflow", "cli"]),
    // core has planes from its buffers behind a feature, and no codec.
    ("image", &["core", "io"]),
    ("png", &["io", "testkit"]),
    ("exr", &["io"]),
    ("tiff", &["io"]),
    ("rustfft", &["fft-ssd", "blending"]),
    ("realfft", &["fft-ssd", "blending"]),
    ("petgraph", &["maxflow", "expansion", "graphcut-textures"]),
    ("clap", &["cli"]),
    ("indicatif", &["cli"]),
    ("serde", &["cli"]),
    ("serde_json", &["cli"]),
    ("rand", &[]),
];

/// Edges inside the workspace that the table does not have. Any crate may use testkit in its tests.
pub(super) fn inside(tree: &Tree) -> Vec<Breach> {
    let packages: Vec<(String, &str)> =
        tree.crates().into_iter().filter_map(|c| Some((tree.package_name(c).ok()?, c))).collect();
    let mut breaches = Vec::new();
    for name in tree.crates() {
        let place = format!("crates/{name}/Cargo.toml");
        let Some((_, allowed)) = EDGES.iter().find(|(from, _)| *from == name) else {
            breaches.push(Breach::new(place, format!("crate `{name}` is not in the table of edges")));
            continue;
        };
        for (dependency, for_tests) in dependencies(tree, name) {
            let Some((_, to)) = packages.iter().find(|(package, _)| *package == dependency) else { continue };
            let known = allowed.contains(to) || allowed.contains(&"*") || (for_tests && *to == "testkit");
            if !known {
                breaches.push(Breach::new(&place, format!("`{name}` must not know `{to}`")));
            }
        }
    }
    breaches
}

/// Dependencies from outside in a crate that does not own them.
pub(super) fn outside(tree: &Tree) -> Vec<Breach> {
    let mut breaches = Vec::new();
    for name in tree.crates() {
        for (dependency, for_tests) in dependencies(tree, name) {
            // Tests of any crate make pools, to show that the number of threads does not matter.
            if for_tests && dependency == "rayon" {
                continue;
            }
            let owners = OWNED.iter().find(|(owned, _)| *owned == dependency).map(|(_, owners)| *owners);
            if owners.is_some_and(|owners| !owners.contains(&name)) {
                let who = owners.map_or(String::new(), |o| o.join(", "));
                let what = format!("`{dependency}` is for {}", if who.is_empty() { "nobody" } else { &who });
                breaches.push(Breach::new(format!("crates/{name}/Cargo.toml"), what));
            }
        }
    }
    breaches
}

/// Names of a crate's dependencies, and whether each is for its tests alone.
pub(super) fn dependencies(tree: &Tree, name: &str) -> Vec<(String, bool)> {
    let Ok(manifest) = tree.manifest(&format!("crates/{name}/Cargo.toml")) else { return Vec::new() };
    let mut tables = vec![&manifest];
    let targets = manifest.get("target").and_then(|t| t.as_table());
    tables.extend(targets.into_iter().flat_map(|t| t.values()).filter_map(|t| t.as_table()));
    let mut found = Vec::new();
    for table in tables {
        for (key, for_tests) in [("dependencies", false), ("build-dependencies", false), ("dev-dependencies", true)] {
            let names = table.get(key).and_then(|d| d.as_table()).into_iter().flat_map(toml::Table::keys);
            found.extend(names.map(|n| (n.clone(), for_tests)));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::lines;
    use super::*;

    fn tree(maxflow: &str) -> Tree {
        Tree::of(&[
            ("crates/core/Cargo.toml", "[package]\nname = \"selvedge-core\""),
            ("crates/testkit/Cargo.toml", "[package]\nname = \"selvedge-testkit\""),
            ("crates/maxflow/Cargo.toml", &format!("[package]\nname = \"selvedge-maxflow\"\n{maxflow}")),
        ])
    }

    #[test]
    fn a_forbidden_edge_is_found() {
        let bad = tree("[dependencies]\nselvedge-core = {}");
        assert_eq!(lines(&inside(&bad)), ["crates/maxflow/Cargo.toml: `maxflow` must not know `core`"]);
        let hidden = tree("[target.'cfg(unix)'.dependencies]\nselvedge-core = {}");
        assert_eq!(inside(&hidden).len(), 1);
    }

    #[test]
    fn tests_may_use_testkit_and_code_may_not() {
        assert_eq!(inside(&tree("[dev-dependencies]\nselvedge-testkit = {}")), []);
        assert_eq!(inside(&tree("[dependencies]\nselvedge-testkit = {}")).len(), 1);
    }

    #[test]
    fn unknown_crates_and_foreign_codecs_are_found() {
        let new = Tree::of(&[("crates/new/Cargo.toml", "[package]\nname = \"new\"")]);
        assert_eq!(inside(&new).len(), 1);
        assert_eq!(
            lines(&outside(&tree("[dependencies]\nimage = {}"))),
            ["crates/maxflow/Cargo.toml: `image` is for core, io"]
        );
        assert_eq!(outside(&tree("[dev-dependencies]\npetgraph = {}")), []);
    }
}
