//! The words of others, as they stand in our lines.

use std::path::Path;

use crate::Format;
use crate::name::{file_of, quoted};

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
