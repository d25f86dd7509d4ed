//! Names of outputs that stand for several.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// A name with `{name}` and `{stem}` filled in: a plane's name with and without its extension.
pub(crate) fn of_plane(pattern: &Path, plane: &Path) -> PathBuf {
    filled(pattern, &[("{name}", plane.file_name()), ("{stem}", plane.file_stem())])
}

/// Refuses a name that would be that of several planes' outputs.
pub(crate) fn check_apart(pattern: &Path, outputs: usize) -> Result<(), Failure> {
    let apart = pattern.to_str().is_some_and(|text| text.contains("{name}") || text.contains("{stem}"));
    if outputs < 2 || apart {
        return Ok(());
    }
    let what = format!("{outputs} outputs would have this name");
    Err(Failure::new(2, what).about(pattern).remedy("use '{name}' or '{stem}' in it"))
}

/// A name with words in it replaced, each where it stands; what was filled in is not looked at again.
pub(crate) fn filled(pattern: &Path, words: &[(&str, Option<&std::ffi::OsStr>)]) -> PathBuf {
    let Some(mut rest) = pattern.to_str() else { return pattern.to_path_buf() };
    let mut name = OsString::new();
    let first = |rest: &str| words.iter().filter_map(|(word, by)| Some((rest.find(word)?, *word, *by))).min();
    while let Some((at, word, by)) = first(rest) {
        name.push(&rest[..at]);
        name.push(by.unwrap_or_default());
        rest = &rest[at + word.len()..];
    }
    name.push(rest);
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_filled_in() {
        let name = |pattern: &str| of_plane(Path::new(pattern), Path::new("in/a.b.png"));
        assert_eq!(name("out/{name}"), Path::new("out/a.b.png"));
        assert_eq!(name("{stem}-{stem}.exr"), Path::new("a.b-a.b.exr"));
        assert_eq!(name("out.png"), Path::new("out.png"));
        // What was filled in is not looked at again.
        assert_eq!(of_plane(Path::new("{stem}/{name}"), Path::new("{name}.png")), Path::new("{name}/{name}.png"));
    }
}
