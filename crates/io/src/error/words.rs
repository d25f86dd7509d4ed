//! The words of others, as they stand in our lines.

use std::fmt;
use std::path::Path;

use super::Problem;
use crate::Format;
use crate::name::{file_of, quoted};

impl Problem {
    /// A decoder's complaint.
    pub(crate) fn damaged(format: Format, cause: impl fmt::Display) -> Self {
        Self::Damaged { format, cause: plain(&cause.to_string()) }
    }

    /// The most frequent damage.
    pub(crate) fn ends_early(format: Format) -> Self {
        Self::damaged(format, "it ends early")
    }

    /// An encoder's complaint about samples that were checked.
    pub(crate) fn encoder(format: Format, cause: impl ToString) -> Self {
        Self::Encoder { format, cause: cause.to_string() }
    }

    /// Something that a format has and we do not read.
    pub(crate) fn unsupported(format: Format, what: impl Into<String>) -> Self {
        Self::Unsupported { format, what: what.into() }
    }
}

/// A decoder's words without the quotes, full stops and insides of types that some of them have.
pub(super) fn plain(cause: &str) -> String {
    let mut text = cause.trim_matches(|c: char| c == '"' || c == '.' || c.is_whitespace()).to_owned();
    while let Some((before, rest)) = text.split_once("ChunkType { type: ")
        && let Some((kind, after)) = rest.split_once(", critical")
        && let Some((_, after)) = after.split_once(" }")
    {
        text = format!("{before}{kind}{after}");
    }
    let text = text.replace("Reason:", "reason: ");
    // A sentence begins with a plain word; names and abbreviations stay as they are.
    let first = text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("");
    let rest = first.strip_prefix(|c: char| c.is_ascii_uppercase()).filter(|rest| !rest.is_empty());
    let sentence = rest.is_some_and(|rest| rest.chars().all(char::is_lowercase));
    if sentence { text[..1].to_lowercase() + &text[1..] } else { text }
}

/// What a decoder does not support, of its sentence that says so: ours says it once more.
pub(crate) fn subject(sentence: &str) -> &str {
    let ends = [" is unsupported", " is not supported", " not supported"];
    let begins = ["unsupported ", "yet unimplemented ", "The image format "];
    let sentence = sentence.trim_end_matches(" yet").trim_end_matches('.');
    let sentence = ends.iter().find_map(|end| sentence.strip_suffix(end)).unwrap_or(sentence);
    // As `image` has it: which of its decoders, and then what.
    let sentence = sentence.split_once(" does not support the format features ").map_or(sentence, |(_, what)| what);
    begins.iter().find_map(|begin| sentence.strip_prefix(begin)).unwrap_or(sentence)
}

/// Whether what is not supported is one or several things.
pub(crate) fn verb(what: &str) -> &'static str {
    let is_one = ["a ", "an ", "choosing ", "compression "].iter().any(|begin| what.starts_with(begin));
    let head = [" of ", " over ", " other "].iter().fold(what, |what, end| what.split(end).next().unwrap_or(what));
    if !is_one && head.ends_with('s') { "are" } else { "is" }
}

/// How channels of a file are chosen.
pub(super) fn chosen_by(path: &Path) -> String {
    let file = file_of(path);
    let name = quoted(file);
    let own = name.trim_end_matches('\'');
    let ways = if Format::of_name(file) == Some(Format::Tiff) { "[4]'" } else { "[layer]' or as [R,G,B]" };
    format!("choose with {own}{ways}")
}

/// A file that nobody may write.
#[derive(Debug, thiserror::Error)]
#[error("is write-protected")]
pub(crate) struct WriteProtected;

/// A folder that is a link to nothing.
#[derive(Debug, thiserror::Error)]
#[error("its folder is a link that leads nowhere")]
pub(crate) struct LostFolder;
