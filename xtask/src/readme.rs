//! `readme`: each crate's README.md, made of the first page of its documentation, whose example is a test there.

use std::fs;

use crate::outcome::Outcome;
use crate::tree::{Tree, root};

/// Written by hand: the program's is the project's.
const BY_HAND: [&str; 1] = ["cli"];

/// Writes them.
pub(crate) fn run(_: &[String]) -> Outcome {
    for (path, text) in wanted(&Tree::of_project()) {
        fs::write(root().join(&path), text).map_err(|e| format!("{path}: {e}"))?;
    }
    Ok(())
}

/// By path, what each has to hold.
pub(crate) fn wanted(tree: &Tree) -> Vec<(String, String)> {
    let crates = tree.crates().into_iter().filter(|name| !BY_HAND.contains(name));
    let of = |name| {
        let page = tree.text(&format!("crates/{name}/src/lib.rs"))?;
        Some((format!("crates/{name}/README.md"), readme(&tree.package_name(name).ok()?, page)))
    };
    crates.filter_map(of).collect()
}

/// The first page of a crate's documentation as a file of its own: no links into it, no lines that only tests need.
fn readme(package: &str, lib: &str) -> String {
    let mut text = format!("# {package}\n\n");
    let mut code = false;
    for line in lib.lines().map_while(|line| line.strip_prefix("//!")) {
        let line = line.strip_prefix(' ').unwrap_or(line);
        let fence = line.starts_with("```");
        if code && !fence && (line == "#" || line.starts_with("# ")) {
            continue;
        }
        text += &match (fence, code) {
            (true, false) if line == "```" => "```rust".to_owned(),
            (false, false) if line.starts_with('#') => format!("#{}", unlinked(line)),
            (false, false) => unlinked(line).replace("`DESIGN.md`", "[DESIGN.md](DESIGN.md)"),
            _ => line.to_owned(),
        };
        text.push('\n');
        code ^= fence;
    }
    text + "\n## Licence\nMIT or Apache 2.0, as you like.\n"
}

/// A line without links to items: their text alone.
fn unlinked(line: &str) -> String {
    let (mut out, mut rest) = (String::new(), line);
    while let Some((before, after)) = rest.split_once('[') {
        out += before;
        let Some((text, after)) = after.split_once(']') else { return out + "[" + after };
        let target = after.strip_prefix('(').and_then(|after| after.split_once(')'));
        rest = match target {
            Some((to, after)) if !to.contains("://") && !to.ends_with(".md") => {
                out += text;
                after
            }
            None if text.starts_with('`') => {
                out += text;
                after
            }
            _ => {
                out += &format!("[{text}]");
                after
            }
        };
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_page_is_the_readme() {
        let lib = "//! What it does with [`Grid`] and [grids](Grid) `[Kwatra03]`.\n//!\n//! ```\n//! # fn main() {\n//! let a = b[0];\n//! # }\n//! ```\n//! # Features\n//! See [DESIGN](DESIGN.md).\n#![forbid(unsafe_code)]\n";
        let expected = "# x\n\nWhat it does with `Grid` and grids `[Kwatra03]`.\n\n```rust\nlet a = b[0];\n```\n## Features\nSee [DESIGN](DESIGN.md).\n\n## Licence\nMIT or Apache 2.0, as you like.\n";
        assert_eq!(readme("x", lib), expected);
    }
}
