//! Standard output and standard error, where whoever listens may leave at any time.

use std::fs;
use std::io::{self, ErrorKind, Write as _};
use std::path::Path;

use selvedge_io::{breaks_lines, one_line};
use serde_json::Value;

/// The name of standard input and standard output.
pub(crate) const STREAM: &str = "-";

/// Writes an answer to standard output. A reader that has left has what it wanted: that is no failure.
pub(crate) fn answer(bytes: &[u8]) -> io::Result<()> {
    match picture(bytes) {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// Writes the bytes of a picture, of which a part is of no use: a reader that has left did not get it.
pub(crate) fn picture(bytes: &[u8]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush())
}

/// Whether standard output was closed when the program began: the runtime then put `/dev/null` there, open for reading
/// as well, as no shell opens it to throw something away. Other systems than Linux do not tell.
pub(crate) fn leads_nowhere() -> bool {
    let null = fs::read_link("/proc/self/fd/1").is_ok_and(|to| to == Path::new("/dev/null"));
    let info = if null { fs::read_to_string("/proc/self/fdinfo/1").unwrap_or_default() } else { String::new() };
    let flags = info.lines().find_map(|line| u32::from_str_radix(line.strip_prefix("flags:")?.trim(), 8).ok());
    // The mode of access; 2 is reading and writing.
    flags.is_some_and(|flags| flags & 3 == 2)
}

/// A refusal of the system without its number.
pub(crate) fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    let words = text.split_once(" (os error").map_or(&text[..], |(words, _)| words);
    words[..1].to_lowercase() + &words[1..]
}

/// No line for people is longer: what is typed, or stands in a file, may be of any length.
pub(crate) const LONGEST: usize = 500;

/// A line for people, on standard error: the one gate, so that nothing from a file or a name reaches a terminal raw or
/// fills it. If nobody can be told, nobody is told.
pub(crate) fn tell(line: &str) {
    let _ = writeln!(io::stderr(), "{}", shortened(&one_line(line), LONGEST));
}

/// A line for programs, which know how to escape and how much they read.
pub(crate) fn tell_program(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// An object for programs. Its own escapes end at U+001F: a terminal that shows it would act on some signs beyond.
pub(crate) fn object(object: &Value) -> String {
    let escaped = |text: &mut String, c: char| match u32::from(c) {
        code @ ..=0xffff if breaks_lines(c) => text.push_str(&format!("\\u{code:04x}")),
        _ => text.push(c),
    };
    object.to_string().chars().fold(String::new(), |mut text, c| {
        escaped(&mut text, c);
        text
    })
}

/// A text of at most so many bytes: of a longer one both ends are kept.
pub(crate) fn shortened(text: &str, most: usize) -> String {
    const GAP: &str = " ... ";
    if text.len() <= most {
        return text.to_owned();
    }
    let room = most.saturating_sub(GAP.len());
    let (head, tail) = (text.floor_char_boundary(room / 2), text.ceil_char_boundary(text.len() - room / 2));
    format!("{}{GAP}{}", &text[..head], &text[tail..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_hold_no_sign_that_a_terminal_acts_on() {
        let name = "a\u{9b}31m\u{202e}gnp\u{2066}\u{7f}\n é";
        let object = super::object(&serde_json::json!({ "path": name }));
        assert_eq!(object, r#"{"path":"a\u009b31m\u202egnp\u2066\u007f\n é"}"#);
        assert_eq!(serde_json::from_str::<Value>(&object).unwrap()["path"], name);
    }

    #[test]
    fn long_texts_keep_both_ends() {
        assert_eq!(shortened("abc", 3), "abc");
        assert_eq!(shortened("abcdefghijkl", 9), "ab ... kl");
        let odd = shortened(&"é".repeat(400), 101);
        assert!(odd.len() <= 101 && odd.starts_with("é") && odd.ends_with("é"), "{odd}");
    }
}
