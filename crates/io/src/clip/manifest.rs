//! What stands beside the frames of a clip: how many, how fast, and what each of them is.

use std::fmt::Write as _;
use std::path::Path;

use super::rate::Rate;
use crate::path_text;

/// The file `OUT.json` beside the frames of `OUT.####.EXT`, or beside a flipbook: for game engines and scripts.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// Samples along x and y of a frame.
    pub size: [u32; 2],
    /// How fast it plays.
    pub rate: Option<Rate>,
    /// Frames after which it begins again; `None` for a clip that is no loop.
    pub period: Option<u32>,
    /// Name without folder, and BLAKE3 in hexadecimal, of each frame's file.
    pub frames: Vec<(String, String)>,
    /// More members, as JSON text by name.
    pub more: Vec<(&'static str, String)>,
}

impl Manifest {
    /// The text of the file.
    pub fn json(&self) -> String {
        let [width, height] = self.size;
        let mut text = format!("{{\n  \"frames\": {},\n  \"width\": {width},\n  \"height\": {height}", self.count());
        if let Some(rate) = self.rate {
            write!(text, ",\n  \"rate\": [{}, {}]", rate.num(), rate.den()).expect("a string takes any text");
        }
        if let Some(period) = self.period {
            write!(text, ",\n  \"period\": {period}").expect("a string takes any text");
        }
        for (name, value) in self.more.iter().filter(|(name, _)| *name != "frames") {
            write!(text, ",\n  \"{name}\": {value}").expect("a string takes any text");
        }
        text.push_str(",\n  \"files\": [");
        for (i, (name, hash)) in self.frames.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            let name = quoted(&path_text(Path::new(name)));
            write!(text, "{comma}\n    {{\"name\": {name}, \"blake3\": \"{hash}\"}}").expect("a string takes any text");
        }
        text.push_str("\n  ]\n}\n");
        text
    }

    /// One file may hold all frames.
    fn count(&self) -> String {
        let more = self.more.iter().find(|(name, _)| *name == "frames");
        more.map_or_else(|| self.frames.len().to_string(), |(_, frames)| frames.clone())
    }
}

/// A JSON string.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => write!(out, "\\u{:04x}", c as u32).expect("a string takes any text"),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
