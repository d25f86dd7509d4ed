//! The files of the project, read once, so that rules are pure functions of them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What belongs to the project at its root; the rest (build output, editors' droppings) is nobody's concern.
const ROOTS: [&str; 14] = [
    ".cargo",
    ".ci",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "Cargo.toml",
    "PAPERS.md",
    "README.md",
    "clippy.toml",
    "crates",
    "docs",
    "fixtures",
    "fuzz",
    "tests",
    "xtask",
];
/// Folders with output inside those.
const SKIPPED: [&str; 4] = ["target", "out", "artifacts", "coverage"];

/// Files by their path from the root, `/` between folders.
#[derive(Debug, Default)]
pub(crate) struct Tree(BTreeMap<String, Vec<u8>>);

impl Tree {
    /// Reads the project.
    pub(crate) fn of_project() -> Self {
        let mut tree = Self::default();
        for name in ROOTS {
            tree.take(&root().join(name), name.to_owned());
        }
        tree
    }

    /// A tree made up by a test.
    #[cfg(test)]
    pub(crate) fn of(files: &[(&str, &str)]) -> Self {
        Self(files.iter().map(|(path, text)| ((*path).to_owned(), text.as_bytes().to_vec())).collect())
    }

    fn take(&mut self, path: &Path, name: String) {
        if path.is_dir() {
            for entry in fs::read_dir(path).into_iter().flatten().flatten() {
                let file = entry.file_name().to_string_lossy().into_owned();
                if !SKIPPED.contains(&file.as_str()) {
                    self.take(&entry.path(), format!("{name}/{file}"));
                }
            }
        } else if let Ok(bytes) = fs::read(path) {
            self.0.insert(name, bytes);
        }
    }

    /// All paths and their bytes.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.0.iter().map(|(path, bytes)| (path.as_str(), bytes.as_slice()))
    }

    /// Paths and texts of the files with this ending.
    pub(crate) fn texts(&self, ending: &str) -> impl Iterator<Item = (&str, &str)> {
        self.files()
            .filter(move |(path, _)| path.ends_with(ending))
            .filter_map(|(path, bytes)| Some((path, std::str::from_utf8(bytes).ok()?)))
    }

    /// One file's text.
    pub(crate) fn text(&self, path: &str) -> Option<&str> {
        std::str::from_utf8(self.0.get(path)?).ok()
    }

    /// Names of the folders in `crates/` that hold a manifest.
    pub(crate) fn crates(&self) -> Vec<&str> {
        let name = |path: &'_ str| -> Option<usize> {
            let rest = path.strip_prefix("crates/")?.strip_suffix("/Cargo.toml")?;
            (!rest.contains('/')).then_some(rest.len())
        };
        self.0.keys().filter_map(|path| name(path).map(|len| &path[7..7 + len])).collect()
    }

    /// A manifest, parsed.
    pub(crate) fn manifest(&self, path: &str) -> Result<toml::Table, String> {
        let text = self.text(path).ok_or("is not there")?;
        text.parse().map_err(|e| format!("is no TOML: {e}"))
    }

    /// The package that stands in `crates/NAME`.
    pub(crate) fn package_name(&self, name: &str) -> Result<String, String> {
        let path = format!("crates/{name}/Cargo.toml");
        let manifest = self.manifest(&path).map_err(|why| format!("{path} {why}"))?;
        let package = manifest.get("package").and_then(|p| p.get("name")).and_then(|n| n.as_str());
        package.map(str::to_owned).ok_or_else(|| format!("{path} names no package"))
    }
}

/// The root of the project.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask stands in the project's root").to_owned()
}
