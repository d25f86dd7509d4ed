//! Circles of files inside a crate: a file that needs another, which needs the first.
//!
//! A module and the files below it are one thing in parts, so that a part may need its whole: what several parts share
//! stands in the whole's file. The crate's root is no such whole, or all of a crate would be one thing.

use std::collections::{BTreeMap, BTreeSet};

use super::Breach;
use super::paths::Names;
use crate::tree::Tree;

/// Every arrow between files that lie in a circle.
pub(super) fn check(tree: &Tree) -> Vec<Breach> {
    let mut breaches = Vec::new();
    let crates = tree.crates().into_iter().map(|name| format!("crates/{name}/src"));
    for folder in crates.chain(["xtask/src".to_owned()]) {
        let files = Files::of(tree, &folder);
        breaches.extend(files.circles().iter().flat_map(|circle| files.breaches(circle)));
    }
    breaches
}

/// The modules of a crate that have files, the root first.
#[derive(Default)]
struct Files {
    paths: Vec<String>,
    parents: Vec<usize>,
    children: Vec<BTreeMap<String, usize>>,
    names: Vec<Names>,
}

/// What a path leads to.
#[derive(Clone, Copy)]
enum Target {
    Module(usize),
    /// Something that stands in this file.
    Item(usize),
}

impl Files {
    fn of(tree: &Tree, folder: &str) -> Self {
        let mut files = Self::default();
        let root = ["lib.rs", "main.rs"].map(|root| format!("{folder}/{root}"));
        if let Some(root) = root.into_iter().find(|path| tree.text(path).is_some()) {
            files.add(tree, root, folder.to_owned(), 0);
        }
        files
    }

    /// Adds a file and the modules below it, which stand in `folder`.
    fn add(&mut self, tree: &Tree, path: String, folder: String, parent: usize) -> usize {
        let (here, names) = (self.paths.len(), Names::of(tree.text(&path).unwrap_or_default()));
        let modules = names.modules.clone();
        self.paths.push(path);
        self.parents.push(parent);
        self.children.push(BTreeMap::new());
        self.names.push(names);
        for module in modules {
            let below = format!("{folder}/{module}");
            let file = [format!("{below}.rs"), format!("{below}/mod.rs")].into_iter().find(|p| tree.text(p).is_some());
            if let Some(file) = file {
                let child = self.add(tree, file, below, here);
                self.children[here].insert(module, child);
            }
        }
        here
    }

    /// Follows a path from a file; `None` if it leads out of the crate.
    fn follow(&self, from: usize, path: &[String], steps: usize) -> Option<Target> {
        let (first, rest) = path.split_first()?;
        let mut at = match first.as_str() {
            "crate" => Target::Module(0),
            "self" => Target::Module(from),
            "super" => Target::Module(self.parents[from]),
            _ => self.named(from, first, steps)?,
        };
        for name in rest {
            let Target::Module(module) = at else { break };
            at = match name.as_str() {
                "super" => Target::Module(self.parents[module]),
                _ => self.named(module, name, steps).unwrap_or(Target::Item(module)),
            };
        }
        Some(at)
    }

    /// What a module calls so, if that stands in another file.
    fn named(&self, module: usize, name: &str, steps: usize) -> Option<Target> {
        if let Some(child) = self.children[module].get(name) {
            return Some(Target::Module(*child));
        }
        let import = self.names[module].imports.iter().find(|import| import.name == name && steps != 0)?;
        // `use a::a` means another `a` than the one that it makes.
        let is_itself = import.path.len() == 1 && import.path[0] == name;
        if is_itself { None } else { self.follow(module, &import.path, steps - 1) }
    }

    /// What a file needs of each other file. What it only hands on is no need of its own.
    fn needs(&self, file: usize) -> BTreeMap<usize, BTreeSet<String>> {
        let names = &self.names[file];
        let imports = names.imports.iter().filter(|i| !i.public || names.used.contains(&i.name)).map(|i| &i.path);
        let mut needs: BTreeMap<usize, BTreeSet<String>> = BTreeMap::new();
        for path in imports.chain(&names.paths) {
            if let Some(Target::Item(to)) = self.follow(file, path, 8)
                && to != file
                && !self.is_whole(to, file)
            {
                needs.entry(to).or_default().extend(path.iter().rfind(|name| *name != "*").cloned());
            }
        }
        needs
    }

    /// True for a module, other than the root, that a file stands below.
    fn is_whole(&self, module: usize, file: usize) -> bool {
        let above = |file: &usize| Some(self.parents[*file]).filter(|&parent| parent != 0);
        std::iter::successors(above(&file), above).any(|parent| parent == module)
    }

    /// Sets of files each of which needs all others, by way of files between them.
    fn circles(&self) -> Vec<BTreeSet<usize>> {
        let needs: Vec<BTreeSet<usize>> =
            (0..self.paths.len()).map(|file| self.needs(file).into_keys().collect()).collect();
        let reached: Vec<BTreeSet<usize>> = (0..needs.len()).map(|file| reach(&needs, file)).collect();
        let circle = |file: usize| reached[file].iter().copied().filter(|&to| reached[to].contains(&file)).collect();
        let circles: BTreeSet<BTreeSet<usize>> = (0..needs.len()).map(circle).collect();
        circles.into_iter().filter(|circle| 1 < circle.len()).collect()
    }

    /// Every arrow that stays within a circle.
    fn breaches(&self, circle: &BTreeSet<usize>) -> Vec<Breach> {
        let mut breaches = Vec::new();
        for &file in circle {
            for (to, names) in self.needs(file).into_iter().filter(|(to, _)| circle.contains(to)) {
                let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
                let what = format!("needs {} of {}", names.join(", "), self.paths[to]);
                breaches.push(Breach::new(&self.paths[file], what));
            }
        }
        breaches
    }
}

/// All that can be reached from a file.
fn reach(needs: &[BTreeSet<usize>], file: usize) -> BTreeSet<usize> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![file]);
    while let Some(at) = open.pop() {
        open.extend(needs[at].iter().filter(|&&to| reached.insert(to)));
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::super::lines;
    use super::*;

    fn tree(a: &str, b: &str) -> Tree {
        let root = "mod a;\nmod b;\npub use a::A;\n#[cfg(test)]\nmod tests;\n";
        Tree::of(&[
            ("crates/x/Cargo.toml", ""),
            ("crates/x/src/lib.rs", root),
            ("crates/x/src/a.rs", a),
            ("crates/x/src/b/mod.rs", b),
            ("crates/x/src/b/c.rs", "use crate::A;\nfn c() -> A { b::d() }\n"),
            ("crates/x/src/tests.rs", "use crate::{a, b};"),
        ])
    }

    #[test]
    fn a_circle_is_found_by_way_of_what_is_handed_on() {
        let found = lines(&check(&tree("use crate::b::c;\nfn a() { c::c() }\n", "pub(crate) mod c;\n")));
        let expected = ["a.rs: needs `c` of crates/x/src/b/c.rs", "b/c.rs: needs `A` of crates/x/src/a.rs"];
        assert_eq!(found, expected.map(|line| format!("crates/x/src/{line}")));
    }

    #[test]
    fn parents_hand_on_and_need_nothing_by_that() {
        assert_eq!(check(&tree("use crate::b::d;\n", "mod c;\npub(crate) use c::c as e;\npub(crate) fn d() {}\n")), []);
        assert_eq!(check(&tree("use crate::b::d;\n", "mod c;\npub(crate) use c::c as d;\nfn e() { d() }\n")).len(), 2);
    }

    #[test]
    fn a_part_may_need_its_whole_unless_that_is_the_root() {
        let found = check(&tree("mod z;\n", "mod c;\nuse c::c;\npub(crate) use super::a::A;\nfn d() { c() }\n"));
        assert_eq!(found, []);
        let files = [("crates/x/Cargo.toml", ""), ("crates/x/src/main.rs", "mod a;\nfn f() { a::g() }\n")];
        let child = ("crates/x/src/a.rs", "use super::f;\npub(crate) fn g() { f() }\n");
        assert_eq!(check(&Tree::of(&[files[0], files[1], child])).len(), 2);
    }
}
