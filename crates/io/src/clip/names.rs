//! What the name of a clip stands for.

use std::fs;
use std::path::{Path, PathBuf};

use super::order::{Numbered, last_number, ordered};
use super::problem::ClipProblem;
use super::range::Range;
use crate::Format;
use crate::error::{Error, Problem};
use crate::name::selector;

/// What the name of a clip stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClipName {
    /// Files with a number in their name.
    Sequence(Pattern),
    /// All pictures in a folder.
    Folder(PathBuf),
    /// All files that match, by `*` and `?` in the last part of the name.
    Glob(PathBuf),
}

/// A name with a number in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    folder: PathBuf,
    before: String,
    /// At least so many.
    digits: usize,
    after: String,
}

impl ClipName {
    /// Reads a name; `None` for one that is that of a single file. A file of just this name is one.
    pub fn parse(path: &Path) -> Option<Self> {
        if path.is_dir() || path.as_os_str().as_encoded_bytes().ends_with(b"/") {
            return Some(Self::Folder(path.to_path_buf()));
        }
        if path.is_file() {
            return None;
        }
        let name = path.file_name()?.to_str()?;
        let folder = path.parent().map_or(PathBuf::new(), Path::to_path_buf);
        if let Some((before, digits, after)) = hashes(name).or_else(|| printf(name)) {
            return Some(Self::Sequence(Pattern { folder, before: before.into(), digits, after: after.into() }));
        }
        name.contains(['*', '?']).then(|| Self::Glob(path.to_path_buf()))
    }

    /// The file of a frame that is to be written; `None` where names cannot be made.
    pub fn file(&self, number: u32) -> Option<PathBuf> {
        match self {
            Self::Sequence(pattern) => Some(pattern.file(number)),
            Self::Folder(folder) => Some(folder.join(format!("{number:04}.png"))),
            Self::Glob(_) => None,
        }
    }

    /// Whether no other number is asked for than that of the frame.
    pub(super) fn has_one_number(&self) -> bool {
        !matches!(self, Self::Sequence(pattern) if printf(&pattern.before).is_some())
    }

    /// Whether something follows the number that may say a format.
    pub(super) fn has_ending(&self) -> bool {
        !matches!(self, Self::Sequence(pattern) if !pattern.after.contains('.'))
    }

    /// The name of a picture for all frames: `name.exr` for `name.####.exr`.
    pub fn without_number(&self) -> PathBuf {
        match self {
            Self::Sequence(Pattern { folder, before, after, .. }) => {
                let before = before.trim_end_matches(['.', '_', '-', ' ']);
                folder.join(if before.is_empty() { format!("clip{after}") } else { format!("{before}{after}") })
            }
            Self::Folder(folder) => folder.join("clip.png"),
            Self::Glob(path) => path.clone(),
        }
    }

    /// The file beside the frames that tells of them all.
    pub(crate) fn manifest(&self) -> PathBuf {
        match self {
            Self::Sequence(Pattern { folder, before, after, .. }) => {
                let stem = after.rsplit_once('.').map_or("", |(stem, _)| stem);
                let name = format!("{}{stem}", before.trim_end_matches(['.', '_', '-', ' ']));
                folder.join(format!("{}.json", if name.is_empty() { "clip" } else { &name }))
            }
            Self::Folder(folder) => folder.join("clip.json"),
            Self::Glob(path) => path.with_extension("json"),
        }
    }

    /// All frames there are, by number where they have one.
    pub(crate) fn found(&self) -> Result<Vec<Numbered>, Problem> {
        match self {
            Self::Sequence(pattern) => {
                let numbered = |name: &str| pattern.number(name).map(Some);
                listed(&pattern.folder, numbered)
            }
            Self::Folder(folder) => {
                let picture = |name: &str| Format::of_name(Path::new(name)).map(|_| last_number(name));
                listed(folder, picture)
            }
            Self::Glob(path) => {
                let glob = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
                let matched = |name: &str| matches(glob.as_bytes(), name.as_bytes()).then(|| last_number(name));
                listed(path.parent().unwrap_or(Path::new("")), matched)
            }
        }
    }
}

impl Pattern {
    fn file(&self, number: u32) -> PathBuf {
        let Self { folder, before, digits, after } = self;
        folder.join(format!("{before}{number:0digits$}{after}"))
    }

    /// The number of a name that this pattern makes.
    fn number(&self, name: &str) -> Option<u32> {
        let text = name.strip_prefix(&self.before)?.strip_suffix(self.after.as_str())?;
        let digits = text.bytes().all(|b| b.is_ascii_digit()) && self.digits <= text.len();
        // More digits than asked for are no padding: otherwise two names would be the same frame.
        let number = text.parse().ok().filter(|_| digits)?;
        (self.file(number).file_name()? == name).then_some(number)
    }
}

/// The files of a clip, in order, checked for gaps: what a run must not overwrite.
///
/// # Errors
/// [`ClipProblem`] for a frame that is missing or twice there, and what the file system refuses.
pub fn clip_files(path: &Path, range: Option<Range>) -> Result<Vec<PathBuf>, Error> {
    let (files, choice) = match selector(path) {
        Some((file, choice)) => (file, format!("[{choice}]")),
        None => (path, String::new()),
    };
    let name = ClipName::parse(files).ok_or_else(|| Error::new(path, ClipProblem::NoClip))?;
    let found = name.found().map_err(|p| Error::new(path, p))?;
    let frames = ordered(path, found, range, matches!(name, ClipName::Sequence(_)))?;
    let chosen = |file: PathBuf| {
        let mut file = file.into_os_string();
        file.push(&choice);
        PathBuf::from(file)
    };
    Ok(frames.into_iter().map(chosen).collect())
}

/// The regular files of a folder that are wanted.
fn listed(folder: &Path, wanted: impl Fn(&str) -> Option<Option<u32>>) -> Result<Vec<Numbered>, Problem> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut files = Vec::new();
    for entry in fs::read_dir(here).map_err(|e| Problem::file_system(e, 0))? {
        let entry = entry.map_err(|e| Problem::file_system(e, 0))?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        let hidden = name.starts_with('.');
        let file = folder.join(&name);
        match wanted(&name) {
            Some(number) if !hidden && file.is_file() => files.push((number, file)),
            _ => {}
        }
    }
    Ok(files)
}

/// `name.####.exr` parted around its last run of hashes.
fn hashes(name: &str) -> Option<(&str, usize, &str)> {
    let end = name.rfind('#')? + 1;
    let start = name[..end].trim_end_matches('#').len();
    Some((&name[..start], end - start, &name[end..]))
}

/// `name.%04d.exr` parted around its number.
fn printf(name: &str) -> Option<(&str, usize, &str)> {
    let (before, rest) = name.rsplit_once('%')?;
    let (width, after) = rest.split_once('d')?;
    let digits = if width.is_empty() { 1 } else { width.strip_prefix('0')?.parse().ok()? };
    (1..=9).contains(&digits).then_some((before, digits, after))
}

/// Whether `*` (any text) and `?` (one byte) of a glob stand for what a name has there.
fn matches(glob: &[u8], name: &[u8]) -> bool {
    let (mut g, mut n) = (0, 0);
    // After the last star, and where in the name it is tried next: earlier stars need not be tried again.
    let mut star = None;
    while n < name.len() {
        match glob.get(g) {
            Some(b'*') => {
                g += 1;
                star = Some((g, n));
            }
            Some(&letter) if letter == b'?' || letter == name[n] => (g, n) = (g + 1, n + 1),
            _ => match star {
                Some((after, at)) => {
                    star = Some((after, at + 1));
                    (g, n) = (after, at + 1);
                }
                None => return false,
            },
        }
    }
    glob[g..].iter().all(|letter| *letter == b'*')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(name: &str) -> Option<(String, usize, String)> {
        match ClipName::parse(Path::new(name))? {
            ClipName::Sequence(p) => Some((p.before, p.digits, p.after)),
            _ => None,
        }
    }

    #[test]
    fn patterns_are_parted_around_their_number() {
        let part = |a: &str, n, b: &str| Some((a.to_owned(), n, b.to_owned()));
        assert_eq!(parsed("no/a.####.exr"), part("a.", 4, ".exr"));
        assert_eq!(parsed("a#b##.png"), part("a#b", 2, ".png"));
        assert_eq!(parsed("a%04d.png"), part("a", 4, ".png"));
        assert_eq!(parsed("%d.png"), part("", 1, ".png"));
        for single in ["a.png", "a%4d.png", "a%s.png", "100%.png"] {
            assert_eq!(ClipName::parse(Path::new(single)), None, "{single}");
        }
        assert!(matches!(ClipName::parse(Path::new("a*.png")), Some(ClipName::Glob(_))));
    }

    #[test]
    fn each_number_has_one_name() {
        let Some(ClipName::Sequence(p)) = ClipName::parse(Path::new("a.##.png")) else { panic!() };
        for (name, number) in [
            ("a.07.png", Some(7)),
            ("a.107.png", Some(107)),
            ("a.7.png", None),
            ("a.007.png", None),
            ("a.+7.png", None),
        ] {
            assert_eq!(p.number(name), number, "{name}");
        }
        assert_eq!(p.file(5), Path::new("a.05.png"));
        assert_eq!(ClipName::Sequence(p).manifest(), Path::new("a.json"));
    }

    #[test]
    fn globs_match_whole_names() {
        for (glob, name, fits) in [
            ("a*.png", "a.1.png", true),
            ("a*.png", "ba.png", false),
            ("a?c", "abc", true),
            ("*", "", true),
            ("?", "", false),
            ("*b*d", "abcbd", true),
            ("*bb", "babab", false),
        ] {
            assert_eq!(matches(glob.as_bytes(), name.as_bytes()), fits, "{glob} {name}");
        }
    }
}
