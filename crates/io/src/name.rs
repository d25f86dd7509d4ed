//! File names in messages: quoted, in one line, whatever bytes they hold.

use std::fmt::Write as _;
use std::path::Path;

/// A path in single quotes, with control characters, quotes and bytes that are no text escaped.
///
/// ```
/// assert_eq!(selvedge_io::quoted("dir/a\nb.png".as_ref()), r"'dir/a\nb.png'");
/// ```
pub fn quoted(path: &Path) -> String {
    format!("'{}'", escaped(path.as_os_str().as_encoded_bytes()).replace('\'', r"\'"))
}

/// A file's name without its folder, escaped as in [`quoted`]: how provenance names an input.
pub fn display_name(path: &Path) -> String {
    escaped(path.file_name().unwrap_or(path.as_os_str()).as_encoded_bytes())
}

/// A path as text for data such as JSON: only bytes that are no text are escaped, as `\xNN`.
pub fn path_text(path: &Path) -> String {
    let mut out = String::new();
    for chunk in path.as_os_str().as_encoded_bytes().utf8_chunks() {
        out.push_str(chunk.valid());
        push_bytes(&mut out, chunk.invalid());
    }
    out
}

/// Text in one line: control characters, and what turns the direction of writing, are escaped.
pub fn one_line(text: &str) -> String {
    escaped(text.as_bytes())
}

/// One line of text from any bytes.
pub(crate) fn escaped(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        for c in chunk.valid().chars() {
            if breaks_lines(c) { out.extend(c.escape_default()) } else { out.push(c) }
        }
        push_bytes(&mut out, chunk.invalid());
    }
    out
}

fn push_bytes(out: &mut String, bytes: &[u8]) {
    for byte in bytes {
        write!(out, r"\x{byte:02x}").expect("a string takes any text");
    }
}

/// Control characters, and those that end a line or turn its direction on a terminal.
pub fn breaks_lines(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Parts `file.exr[R,G,B]` into the file and the choice; `None` for a name that chooses nothing, or that is a file's
/// whole name.
pub(crate) fn selector(path: &Path) -> Option<(&Path, &str)> {
    let (file, choice) = path.to_str()?.strip_suffix(']')?.rsplit_once('[')?;
    if file.is_empty() || path.exists() { None } else { Some((Path::new(file), choice)) }
}

/// The file of a name that may choose channels: `file.exr` of `file.exr[R,G,B]`, unless there is a file of the whole
/// name.
pub fn file_of(path: &Path) -> &Path {
    selector(path).map_or(path, |(file, _)| file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_becomes_one_line() {
        assert_eq!(quoted(Path::new("a b.png")), "'a b.png'");
        assert_eq!(quoted(Path::new("it's\r.png")), r"'it\'s\r.png'");
        assert_eq!(escaped(b"a\xff\xfeb\x1b[31m"), r"a\xff\xfeb\u{1b}[31m");
        assert_eq!(escaped("\u{202e}gnp".as_bytes()), r"\u{202e}gnp");
        assert_eq!(one_line("a\nb"), r"a\nb");
        assert_eq!(display_name(Path::new("some/where/é.png")), "é.png");
    }

    #[test]
    #[cfg(unix)]
    fn data_hold_names_as_they_are() {
        use std::os::unix::ffi::OsStrExt as _;
        let name = std::ffi::OsStr::from_bytes(b"a\n\xff b.png");
        assert_eq!(path_text(Path::new(name)), "a\n\\xff b.png");
    }
}
