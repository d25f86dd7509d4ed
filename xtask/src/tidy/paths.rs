//! Which names a Rust file brings in and which paths it follows: as much of the language as that takes.

/// What one file says of others. Code for tests alone is left out.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Names {
    /// Modules in files of their own.
    pub(super) modules: Vec<String>,
    pub(super) imports: Vec<Import>,
    /// Paths of two names or more outside of imports.
    pub(super) paths: Vec<Vec<String>>,
    /// Every name outside of imports.
    pub(super) used: Vec<String>,
}

/// One name of a `use`.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Import {
    pub(super) path: Vec<String>,
    /// What it is called here.
    pub(super) name: String,
    /// Others may have it from here.
    pub(super) public: bool,
}

impl Names {
    /// Reads a file.
    pub(super) fn of(text: &str) -> Self {
        let words = without_tests(&words(text));
        let mut names = Self::default();
        let mut i = 0;
        while i < words.len() {
            i = match (words[i].as_str(), words.get(i + 1..i + 3)) {
                ("use", _) => names.import(&words, i),
                ("mod", Some([module, end])) if end == ";" => {
                    names.modules.push(module.clone());
                    i + 3
                }
                (word, _) if is_name(word) => names.path(&words, i),
                _ => i + 1,
            };
        }
        names
    }

    /// Takes a path that begins at a word, and answers with where it ends.
    fn path(&mut self, words: &[String], start: usize) -> usize {
        let mut path = vec![words[start].clone()];
        let mut i = start + 1;
        while let Some([colons, name]) = words.get(i..i + 2)
            && colons == "::"
            && is_name(name)
        {
            path.push(name.clone());
            i += 2;
        }
        self.used.extend(path.iter().cloned());
        if 1 < path.len() {
            self.paths.push(path);
        }
        i
    }

    /// Takes an import whose `use` stands at a word, and answers with where it ends.
    fn import(&mut self, words: &[String], start: usize) -> usize {
        let public = start.checked_sub(1).is_some_and(|i| words[i] == "pub" || words[i] == ")");
        let end = start + words[start..].iter().position(|w| w == ";").unwrap_or(words.len() - start);
        let mut leaves = Vec::new();
        tree(&words[start + 1..end], &[], &mut leaves);
        self.imports.extend(leaves.into_iter().map(|(path, name)| Import { path, name, public }));
        end
    }
}

/// The leaves of a tree of imports, each with its path and name.
fn tree(words: &[String], before: &[String], leaves: &mut Vec<(Vec<String>, String)>) {
    let mut path = before.to_vec();
    let mut rest = words;
    while let Some((word, after)) = rest.split_first() {
        match word.as_str() {
            "::" => {}
            "{" => return branches(&after[..after.len().saturating_sub(1)], &path, leaves),
            "as" => return leaves.extend(after.first().map(|name| (path, name.clone()))),
            // `{self, ..}`: the module itself.
            "self" if !before.is_empty() => {}
            _ => path.push(word.clone()),
        }
        rest = after;
    }
    leaves.extend(path.last().cloned().map(|name| (path, name)));
}

/// What stands between braces, at its outermost commas.
fn branches(words: &[String], path: &[String], leaves: &mut Vec<(Vec<String>, String)>) {
    let mut depth = 0;
    let parts = words.split(|word| {
        depth += i32::from(word == "{") - i32::from(word == "}");
        word == "," && depth == 0
    });
    parts.filter(|part| !part.is_empty()).for_each(|part| tree(part, path, leaves));
}

fn is_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Without each item below a `#[cfg(test)]`.
fn without_tests(words: &[String]) -> Vec<String> {
    const TEST: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let mut kept = Vec::new();
    let mut i = 0;
    while i < words.len() {
        if words[i..].iter().take(TEST.len()).eq(TEST.iter()) {
            i += TEST.len() + item(&words[i + TEST.len()..]);
        } else {
            kept.push(words[i].clone());
            i += 1;
        }
    }
    kept
}

/// How many words an item has: up to its `;`, or to the end of its first braces.
fn item(words: &[String]) -> usize {
    let mut depth = 0;
    let end = words.iter().position(|word| {
        depth += i32::from(word == "{") - i32::from(word == "}");
        depth == 0 && (word == ";" || word == "}")
    });
    end.map_or(words.len(), |end| end + 1)
}

/// Names, `::` and other signs, without comments, literals and lifetimes.
fn words(text: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let len = match c {
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
            '"' => quoted(rest),
            'r' if rest.starts_with("r\"") || rest.starts_with("r#\"") => raw(rest),
            '\'' => letter(rest),
            c if c.is_alphanumeric() || c == '_' => {
                let len = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
                words.push(rest[..len].to_owned());
                len
            }
            c => {
                let len = if rest.starts_with("::") { 2 } else { c.len_utf8() };
                words.extend((!c.is_whitespace()).then(|| rest[..len].to_owned()));
                len
            }
        };
        rest = &rest[len..];
    }
    words
}

/// How long a string is, quotes and all.
fn quoted(text: &str) -> usize {
    let mut escaped = true;
    let end = text.find(|c| {
        let ends = c == '"' && !escaped;
        escaped = c == '\\' && !escaped;
        ends
    });
    end.map_or(text.len(), |end| end + 1)
}

/// How long a raw string is.
fn raw(text: &str) -> usize {
    let end = if text.starts_with("r#") { "\"#" } else { "\"" };
    text[3..].find(end).map_or(text.len(), |at| 3 + at + end.len())
}

/// How long a letter in quotes is, or the quote of a lifetime.
fn letter(text: &str) -> usize {
    let mut letters = text.char_indices().skip(1);
    match (letters.next(), letters.next()) {
        (Some((_, '\\')), Some((at, _))) => text[at + 1..].find('\'').map_or(1, |end| at + 1 + end + 1),
        (Some(_), Some((at, '\''))) => at + 1,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn imports_are_read_leaf_by_leaf() {
        let names = Names::of("pub(crate) use super::{a::{self, B}, c::D as E, F};\nuse std::fs;\nmod g;\nmod h { }\n");
        let told: Vec<String> =
            names.imports.iter().map(|i| format!("{} {} {}", i.path.join("::"), i.name, i.public)).collect();
        let expected = ["super::a a true", "super::a::B B true", "super::c::D E true", "super::F F true"];
        assert_eq!(told[..4], expected);
        assert_eq!(told[4..], ["std::fs fs false"]);
        assert_eq!(names.modules, ["g"]);
    }

    #[test]
    fn paths_are_found_and_comments_literals_and_tests_are_not() {
        let text = "// crate::a\nfn f<'a>(x: &'a crate::b::C) -> char { g(\"d::e \\\" h::i\", r#\"j::\"k\"#); '\\'' }\n\
                    #[cfg(test)]\nmod tests { use crate::l; fn m() { n::o() } }\nfn p() { q::<r::S>() }\n";
        let names = Names::of(text);
        assert_eq!(names.paths, [vec!["crate", "b", "C"], vec!["r", "S"]]);
        assert_eq!(names.imports, []);
        assert!(names.used.contains(&"q".to_owned()) && !names.used.contains(&"n".to_owned()));
    }
}
