//! Clips as commands read and write them.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::Args;
use selvedge_core::{Bytes, Depth, Domain, Exemplars, Grid, Plane};
use selvedge_graphcut_textures::video::Usual;
use selvedge_io::clip::{
    ClipInfo, ClipName, ClipOptions, ClipProblem, ClipReader, ClipWriter, Flipbook, Range, Rate, read_clip,
};
use selvedge_io::{Fingerprint, Problem, ReadOptions};
use serde_json::{Value, json};

use crate::failure::{Failure, n};
use crate::inputs::{self, Input};
use crate::memory;
use crate::report::Report;
use crate::session::Session;
use crate::wrong::Wrong;

/// How another program encodes a clip.
#[derive(Args, Clone, Debug)]
pub(crate) struct Encode {
    /// What ffmpeg is told of codecs where it writes the clip, such as "-c:v prores_ks -profile:v 4444 -pix_fmt
    /// yuva444p10le". Default: with loss, of 8 bits, for all players.
    #[arg(help_heading = "Files that are written", long, value_name = "ARGS", allow_hyphen_values = true)]
    encode: Option<String>,
}

impl Encode {
    /// Word by word: no shell sees them.
    pub(crate) fn arguments(&self) -> Option<Vec<String>> {
        Some(self.encode.as_ref()?.split_whitespace().map(str::to_owned).collect())
    }
}

/// A clip whose headers were read.
pub(crate) struct ClipInput {
    reader: ClipReader,
    /// Bytes of a stream.
    held: u64,
}

/// A clip that was read whole.
pub(crate) struct Clip {
    pub(crate) path: PathBuf,
    pub(crate) info: ClipInfo,
    pub(crate) plane: Plane<3>,
    pub(crate) fingerprint: Fingerprint,
    /// By frame, the file that it comes from.
    pub(crate) frames: Vec<Fingerprint>,
}

impl Clip {
    /// The clip as the one source of what is made from it.
    pub(crate) fn exemplars(&self) -> Result<Exemplars<3>, Failure> {
        Exemplars::of(&[std::slice::from_ref(&self.plane)]).map_err(|e| Failure::from(e).about(&self.path))
    }

    /// What steps of its features are usual.
    pub(crate) fn usual(&self, features: &Grid<u8, 3>) -> Result<Usual, Failure> {
        let one = || {
            Failure::new(3, "has one frame, which is no loop").about(&self.path).remedy("give a clip of more frames")
        };
        Usual::of(features).ok_or_else(one)
    }
}

impl From<ClipReader> for ClipInput {
    fn from(reader: ClipReader) -> Self {
        Self { reader, held: 0 }
    }
}

impl ClipInput {
    /// Looks at a clip; a stream is read to its end.
    pub(crate) fn open(session: &Session<'_>, path: &Path, options: &ClipOptions) -> Result<Self, Failure> {
        let reader = match Input::new(session, path)?.into_stream() {
            Some(bytes) => ClipReader::of_bytes(bytes, path, options),
            None => ClipReader::open(path, options),
        };
        Ok(Self { reader: reader?, held: 0 })
    }

    /// The same; what a stream brings beyond an eighth of the budget is kept in a file beside a name.
    pub(crate) fn spooled(
        session: &Session<'_>,
        path: &Path,
        options: &ClipOptions,
        beside: &Path,
    ) -> Result<Self, Failure> {
        let Some((start, mut rest)) = inputs::begun(path, session.limits.memory / 8)? else {
            return Self::open(session, path, options);
        };
        if let (Some(rest), true) = (&mut rest, start.starts_with(b"YUV4MPEG2")) {
            return Ok(Self { reader: ClipReader::of_stream((&start, rest), beside, path, options)?, held: 0 });
        }
        // Of other containers all bytes are held in any case.
        let rest = rest.unwrap_or_else(|| Box::new(std::io::empty()));
        let bytes = inputs::read_stream(path, start.as_slice().chain(rest), session.limits.memory)?;
        let held = bytes.len() as u64;
        Ok(Self { reader: ClipReader::of_bytes(bytes, path, options)?, held })
    }

    /// What has frames: a name that stands for them, or a file that holds several; `None` for a picture. Files of other
    /// programs are refused with how they hand their frames over.
    pub(crate) fn found(path: &Path, frame: &ReadOptions) -> Result<Option<Self>, Failure> {
        let options = ClipOptions { frame: frame.clone(), ..ClipOptions::default() };
        let extension = path.extension().map(|e| e.to_ascii_lowercase());
        let is_foreign =
            extension.is_some_and(|e| ["mp4", "mov", "webm", "mkv", "avi"].iter().any(|foreign| e == *foreign));
        match ClipReader::open(path, &options) {
            Ok(reader) if is_foreign || is_pattern(path) || 1 < reader.info().frames => {
                Ok(Some(Self { reader, held: 0 }))
            }
            // What no picture can be wrong by is told; else the picture says what is wrong with it.
            Err(e) if is_foreign || is_pattern(path) || is_of_clips(&e.problem) => Err(e.into()),
            _ => Ok(None),
        }
    }

    /// What it is.
    pub(crate) fn info(&self) -> &ClipInfo {
        self.reader.info()
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        self.reader.path()
    }

    /// Its domain, once it is read.
    pub(crate) fn domain(&self) -> Domain<3> {
        let info = self.info();
        Domain::open([info.frames, info.height, info.width])
    }

    /// Bytes that it holds before it is read.
    pub(crate) fn held(&self) -> Bytes {
        Bytes(self.held)
    }

    /// Bytes of its samples.
    pub(crate) fn bytes(&self) -> Bytes {
        memory::picture(self.domain(), self.info().channels, self.info().depth)
    }

    /// Refuses a pass that has other frames than the clip that decides.
    pub(crate) fn check_like(&self, first: &Self) -> Result<(), Failure> {
        let size = |info: &ClipInfo| [info.frames, info.width, info.height];
        let ([frames, w, h], [of, fw, fh]) = (size(self.info()), size(first.info()));
        if [frames, w, h] == [of, fw, fh] {
            return Ok(());
        }
        let what = format!("{} of {w}x{h} px, but the clip has {of} of {fw}x{fh} px", n("frame", frames as usize));
        Err(Failure::new(3, what).about(self.reader.path()).remedy("give a pass of the same frames"))
    }

    /// What its frames come from.
    pub(crate) fn into_reader(self) -> ClipReader {
        self.reader
    }

    /// Its entry in the report's inputs; what it holds is not known before it was read.
    pub(crate) fn noted(&self, blake3: Option<&str>) -> Value {
        noted(self.path(), self.info(), blake3)
    }

    /// Hands on each frame, says what is odd about them, and notes the clip in the report, as [`read`](Self::read).
    pub(crate) fn each(
        mut self,
        session: &Session<'_>,
        report: &mut Report,
        taken: &mut dyn FnMut(Plane<2>) -> Result<(), Failure>,
    ) -> Result<Fingerprint, Failure> {
        while let Some(frame) = self.reader.next()? {
            session.check_signal()?;
            taken(frame)?;
        }
        for warning in self.reader.warnings() {
            session.warn(self.reader.path(), warning);
        }
        let fingerprint = self.reader.fingerprint();
        session.expect(&fingerprint)?;
        report.inputs.push(self.noted(Some(&fingerprint.blake3)));
        Ok(fingerprint)
    }

    /// Reads all frames, says what is odd about them, and notes them in the report.
    pub(crate) fn read(mut self, session: &Session<'_>, report: &mut Report) -> Result<Clip, Failure> {
        session.check_signal()?;
        let plane = read_clip(&mut self.reader, &session.limits)?;
        let path = self.reader.path().to_path_buf();
        for warning in self.reader.warnings() {
            session.warn(&path, warning);
        }
        let (info, fingerprint) = (self.reader.info().clone(), self.reader.fingerprint());
        session.expect(&fingerprint)?;
        let frames = self.reader.frame_fingerprints();
        report.inputs.push(self.noted(Some(&fingerprint.blake3)));
        Ok(Clip { path, info, plane, fingerprint, frames })
    }
}

/// The entry of a clip in the report's inputs.
pub(crate) fn noted(path: &Path, info: &ClipInfo, blake3: Option<&str>) -> Value {
    json!({
        "path": selvedge_io::path_text(path),
        "frames": info.frames,
        "width": info.width,
        "height": info.height,
        "channels": info.channels,
        "depth": info.depth.name(),
        "rate": info.rate.map(|rate| rate.to_string()),
        "container": info.container,
        "blake3": blake3,
    })
}

/// True for what is wrong with a clip, and for one that is too large.
pub(crate) fn is_of_clips(problem: &Problem) -> bool {
    let is_none = matches!(problem, Problem::Clip(ClipProblem::Still | ClipProblem::UnknownContainer));
    !is_none && matches!(problem, Problem::Clip(_) | Problem::Memory { .. })
}

/// True for a name that stands for frames.
pub(crate) fn is_pattern(path: &Path) -> bool {
    ClipName::parse(selvedge_io::file_of(path)).is_some()
}

/// Refuses, before any work, frames that the clip's files do not hold: clips keep their depth.
pub(crate) fn check_held(
    writer: &ClipWriter,
    channels: (usize, bool),
    depth: Depth,
    shape: [u32; 2],
) -> Result<(), Failure> {
    use ClipProblem::{Failed, Hangs, NoFfmpeg};
    writer.check(channels, depth, shape).map_err(|e| match e.problem {
        Problem::Clip(NoFfmpeg { .. } | Failed { .. } | Hangs { .. }) => e.into(),
        Problem::Clip(ClipProblem::Unsupported { container, .. }) if !matches!(container, "gif" | "y4m") => {
            Failure::from(e).remedy("name a codec with --encode, or write a sequence that holds it")
        }
        _ => Failure::from(e).remedy("write a sequence of png, tiff or exr that holds it"),
    })
}

/// Tells of frames of a longer clip that nothing replaces.
pub(crate) fn tell_left_over(session: &Session<'_>, writer: &ClipWriter) {
    let left = writer.left_over();
    if let Some((first, others)) = left.split_first() {
        let others = if others.is_empty() { String::new() } else { format!(", as are {} more", others.len()) };
        session.warn(first, &format!("is left over from a longer run{others}"));
    }
}

/// Tells of a GIF that browsers play slower than it says: what is shown for less than a fiftieth of a second they show
/// for a tenth.
pub(crate) fn tell_rate(session: &Session<'_>, output: &Path, rate: Option<Rate>) {
    let is_gif = !is_pattern(output) && output.extension().is_some_and(|e| e.eq_ignore_ascii_case("gif"));
    if let Some(rate) = rate.filter(|rate| is_gif && u64::from(rate.den()) * 50 < u64::from(rate.num())) {
        let what = format!("browsers play no GIF faster than 50 frames a second, and this one has {rate}: use --rate");
        session.warn(output, &what);
    }
}

/// Tells of a flipbook that is read as other columns and rows than the file beside it says.
pub(crate) fn tell_cells(session: &Session<'_>, path: &Path, book: Flipbook) {
    let beside = std::fs::read(path.with_extension("json")).ok();
    let Some(told) = beside.and_then(|text| serde_json::from_slice::<Value>(&text).ok()) else { return };
    let [columns, rows, pad] = ["columns", "rows", "pad"].map(|side| told[side].as_u64());
    let (Some(columns), Some(rows), Some(pad)) = (columns, rows, pad) else { return };
    if [columns, rows, pad] != [book.columns, book.rows, book.pad].map(u64::from) {
        let what = format!("is a flipbook of {columns}x{rows} with {pad} px around frames by what its .json says");
        session.warn(path, &what);
    }
}

/// What a clip's name is filled into an output's name as: that of a picture without its frames' numbers.
pub(crate) fn plane_name(path: &Path) -> PathBuf {
    let path = selvedge_io::file_of(path);
    ClipName::parse(path).map_or_else(|| path.to_path_buf(), |name| name.without_number())
}

/// What tells files that belong together: that of the only one, or one of all.
pub(crate) fn fingerprint(path: &Path, files: &[Fingerprint]) -> Fingerprint {
    if let [only] = files {
        return only.clone();
    }
    let mut hasher = blake3::Hasher::new();
    files.iter().for_each(|file| {
        hasher.update(file.blake3.as_bytes());
    });
    Fingerprint { name: selvedge_io::display_name(path), blake3: hasher.finalize().to_hex().to_string() }
}

/// The files of a clip that is read, so that none of them is written.
pub(crate) fn files(path: &Path, range: Option<Range>) -> Result<Vec<PathBuf>, Failure> {
    if ClipName::parse(selvedge_io::file_of(path)).is_none() {
        return Ok(vec![path.to_path_buf()]);
    }
    Ok(selvedge_io::clip::clip_files(path, range)?)
}

/// A rate as it is typed.
pub(crate) fn rate(text: &str) -> Result<Rate, Wrong> {
    text.parse().map_err(|_| Wrong::new(format!("'{text}' is no rate"), "write 25 or 30000/1001"))
}

/// A flipbook as it is typed.
pub(crate) fn flipbook(text: &str) -> Result<Flipbook, Wrong> {
    text.parse().map_err(|_| Wrong::new(format!("'{text}' is no flipbook"), "write columns and rows, such as 8x8"))
}

/// A range of frames as it is typed.
pub(crate) fn range(text: &str) -> Result<Range, Wrong> {
    text.parse().map_err(|_| Wrong::new(format!("'{text}' is no range of frames"), "write 1-100 or 1-100x2"))
}
