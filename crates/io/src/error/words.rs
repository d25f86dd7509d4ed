//! The words of others, as they stand in our lines.

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
