//! How a picture was made, carried inside its file.

use std::fmt;

use crate::name::escaped;

/// A file by name and content.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fingerprint {
    /// Its name without folder; see [`display_name`](crate::display_name).
    pub name: String,
    /// BLAKE3 of its bytes, in hexadecimal.
    pub blake3: String,
}

/// How a picture was made. Nothing in it depends on time, place or machine, so equal runs give equal files.
///
/// PNG carries it as `iTXt` under the keyword `selvedge`; EXR, TIFF, JPEG and WebP (the latter two in their EXIF) as
/// *Software*; Radiance HDR as comments.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// The program's version.
    pub version: String,
    /// The run's seed.
    pub seed: u64,
    /// The inputs, in order.
    pub inputs: Vec<Fingerprint>,
    /// The canonical command: what changes samples, and nothing else.
    pub command: String,
}

/// The lines in which it is stored.
impl fmt::Display for Provenance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = |text: &str| escaped(text.as_bytes());
        write!(f, "selvedge {}\nseed {}\n", line(&self.version), self.seed)?;
        for Fingerprint { name, blake3 } in &self.inputs {
            writeln!(f, "input {} {}", line(blake3), line(name))?;
        }
        write!(f, "command {}", line(&self.command))
    }
}

impl Provenance {
    /// Reads the lines again; `None` if they are someone else's.
    pub fn parse(text: &str) -> Option<Self> {
        let mut lines = text.trim_end_matches('\0').lines();
        let mut found = Self { version: lines.next()?.strip_prefix("selvedge ")?.to_owned(), ..Self::default() };
        for line in lines {
            match line.split_once(' ')? {
                ("seed", seed) => found.seed = seed.parse().ok()?,
                ("input", input) => {
                    let (blake3, name) = input.split_once(' ')?;
                    found.inputs.push(Fingerprint { name: name.to_owned(), blake3: blake3.to_owned() });
                }
                ("command", command) => found.command = command.to_owned(),
                // A later version may say more.
                _ => {}
            }
        }
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(name: &str, blake3: &str) -> Fingerprint {
        Fingerprint { name: name.into(), blake3: blake3.into() }
    }

    #[test]
    fn lines_are_read_again() {
        let made = Provenance {
            version: "0.1.0".into(),
            seed: u64::MAX,
            inputs: vec![input("a b é.png", "00ff"), input("c.png", "11")],
            command: "selvedge quilt 'a b é.png' c.png --size 64".into(),
        };
        assert_eq!(Provenance::parse(&made.to_string()), Some(made));
    }

    #[test]
    fn foreign_and_broken_texts_are_none() {
        for text in ["", "GIMP 2.10", "selvedge 1\nseed x", "selvedge 1\ninput onlyhash", "selvedge 1\n\n"] {
            assert_eq!(Provenance::parse(text), None, "{text:?}");
        }
        assert!(Provenance::parse("selvedge 9\nnew field").is_some());
    }

    #[test]
    fn a_name_cannot_forge_a_line() {
        let made = Provenance { inputs: vec![input("a\nseed 5", "00")], ..Provenance::default() };
        assert_eq!(Provenance::parse(&made.to_string()).unwrap().seed, 0);
    }
}
