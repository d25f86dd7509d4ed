//! Files and standard input, read once and noted in the report.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use selvedge_core::{Bytes, Grid, Limits, Plane, Role};
use selvedge_io::{Fingerprint, Info, MapFile, MaskChannel, Metadata, Picture, Problem, ReadOptions};
use serde_json::{Value, json};

use crate::args::NonFiniteArg;
use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;
use crate::stdio::{self, STREAM};

/// A file, or standard input or a pipe, which are read to their end at once.
pub(crate) struct Input {
    pub(crate) path: PathBuf,
    stream: Option<Vec<u8>>,
    /// Whether it is a frame of a container, which is told of as a whole.
    is_part: bool,
}

impl Input {
    /// Looks at a name; nothing is read but a stream.
    pub(crate) fn new(session: &Session<'_>, path: &Path) -> Result<Self, Failure> {
        let budget = session.limits.memory;
        if let Some(frame) = session.held(path) {
            return Ok(Self { path: path.to_path_buf(), stream: Some(frame), is_part: true });
        }
        let stream = if path.as_os_str() == STREAM {
            Some(read_stream(path, std::io::stdin().lock(), budget)?)
        } else if is_pipe(path) {
            let opened = File::open(path).map_err(|e| unreadable(path, &e))?;
            Some(read_stream(path, opened, budget)?)
        } else {
            None
        };
        Ok(Self { path: path.to_path_buf(), stream, is_part: false })
    }

    /// Bytes of what was read already.
    pub(crate) fn held(&self) -> Bytes {
        Bytes(self.stream.as_ref().map_or(0, Vec::len) as u64)
    }

    /// The bytes of a stream; `None` for a file.
    pub(crate) fn into_stream(self) -> Option<Vec<u8>> {
        self.stream
    }

    /// What the header says.
    pub(crate) fn probe(&self, options: &ReadOptions) -> Result<Info, Failure> {
        Ok(match &self.stream {
            Some(bytes) => selvedge_io::probe_bytes(bytes, &self.path, options),
            None => selvedge_io::probe(&self.path, options),
        }?)
    }

    /// Reads a picture, says what is odd about it, and notes it in the report.
    pub(crate) fn read(
        &self,
        session: &Session<'_>,
        options: &ReadOptions,
        report: &mut Report,
    ) -> Result<Picture, Failure> {
        session.check_signal()?;
        let picture = match &self.stream {
            Some(bytes) => selvedge_io::decode(bytes, &self.path, options),
            None => selvedge_io::read(&self.path, options),
        }?;
        if self.is_part {
            return Ok(picture);
        }
        session.expect(&fingerprint(&self.path, &picture))?;
        for warning in &picture.warnings {
            session.warn(&self.path, &warning.of(&self.path));
        }
        let [height, width] = picture.plane.domain().shape;
        let samples = &picture.plane.samples;
        let depth = samples.depth().name();
        report.inputs.push(noted(&self.path, [width, height], samples.channels(), depth, &picture.blake3));
        Ok(picture)
    }

    /// Reads a source map.
    pub(crate) fn read_map(&self, session: &Session<'_>) -> Result<ReadMap, Failure> {
        let read = self.noted_map(self.map(session)??);
        session.expect(&read.fingerprint)?;
        Ok(read)
    }

    /// A source map by name and content, and as the report has it.
    fn noted_map(&self, file: MapFile) -> ReadMap {
        let [height, width] = file.map.domain().shape;
        let blake3 = self.hash();
        let entry = noted(&self.path, [width, height], 3, "u32", &blake3);
        ReadMap { file, fingerprint: Fingerprint { name: selvedge_io::display_name(&self.path), blake3 }, entry }
    }

    /// Reads a source map; the inner error says whether it is one at all.
    fn map(&self, session: &Session<'_>) -> Result<Result<MapFile, selvedge_io::Error>, Failure> {
        session.check_signal()?;
        Ok(match &self.stream {
            Some(bytes) => selvedge_io::decode_map(bytes, &self.path, &session.limits),
            None => selvedge_io::read_map(&self.path, &session.limits),
        })
    }

    /// Looks at a file that may be a picture or a source map.
    pub(crate) fn look(&self, session: &Session<'_>, report: &mut Report) -> Result<Either, Failure> {
        let header = self.probe(&options(session.limits, Role::Color, NonFiniteArg::Error));
        let may_be_map = header.as_ref().map_or(true, |h| h.channel_names.iter().any(|name| name == "source"));
        if may_be_map {
            match self.map(session)? {
                Err(e) if matches!(e.problem, Problem::NotAMap { .. }) => {}
                found => {
                    let map = self.noted_map(found?);
                    report.inputs.push(map.entry);
                    return Ok(Either::Map(map.file));
                }
            }
        }
        let header = header?;
        for warning in &header.warnings {
            session.warn(&self.path, &warning.of(&self.path));
        }
        let size = [header.width, header.height];
        report.inputs.push(noted(&self.path, size, header.channels, header.depth.name(), &self.hash()));
        Ok(Either::Picture(header))
    }

    /// The file's BLAKE3 in hexadecimal; empty where it cannot be read again.
    pub(crate) fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let file = || File::open(selvedge_io::file_of(&self.path));
        let read = match &self.stream {
            Some(bytes) => hasher.update_reader(bytes.as_slice()).map(drop),
            None => file().and_then(|file| hasher.update_reader(file).map(drop)),
        };
        read.map_or(String::new(), |()| hasher.finalize().to_hex().to_string())
    }
}

/// Tells of colours that mean something else than those of the first file, the tags of which are kept.
pub(crate) fn tell_tags<'m>(
    session: &Session<'_>,
    first: &Path,
    all: impl IntoIterator<Item = &'m Metadata>,
    another: &str,
) {
    let mut tags = all.into_iter().map(|metadata| (&metadata.icc, metadata.gamma, metadata.cicp));
    let of_first = tags.next();
    if tags.any(|tags| Some(tags) != of_first) {
        session.warn(first, &format!("its colour tags are kept, but another {another} has others"));
    }
}

/// Where a picture is white.
pub(crate) fn white(picture: &Plane<2>, path: &Path) -> Result<Grid<bool, 2>, Failure> {
    selvedge_io::mask(picture, MaskChannel::Light).map_err(|p| Failure::from_problem(path, p))
}

/// A source map that was read.
pub(crate) struct ReadMap {
    pub(crate) file: MapFile,
    /// By name and content.
    pub(crate) fingerprint: Fingerprint,
    /// Its entry in the report's inputs.
    pub(crate) entry: Value,
}

/// What a file turned out to be.
pub(crate) enum Either {
    /// The header of a picture.
    Picture(Info),
    /// A source map.
    Map(MapFile),
}

/// An entry of the report's inputs.
pub(crate) fn noted(path: &Path, [width, height]: [u32; 2], channels: usize, depth: &str, blake3: &str) -> Value {
    json!({
        "path": selvedge_io::path_text(path),
        "width": width,
        "height": height,
        "channels": channels,
        "depth": depth,
        "blake3": blake3,
    })
}

/// A file by name and content, as provenance has it.
pub(crate) fn fingerprint(path: &Path, picture: &Picture) -> Fingerprint {
    Fingerprint { name: selvedge_io::display_name(path), blake3: picture.blake3.clone() }
}

/// How pictures are read in this run.
pub(crate) fn options(limits: Limits, role: Role, nonfinite: impl Into<NonFiniteArg>) -> ReadOptions {
    ReadOptions { limits, role, nonfinite: nonfinite.into().into(), ..ReadOptions::default() }
}

/// Standard input and pipes can be read once.
pub(crate) fn check_streams<'a>(paths: impl IntoIterator<Item = &'a PathBuf>) -> Result<(), Failure> {
    let mut streams: Vec<&PathBuf> = Vec::new();
    for path in paths {
        let again = |other: &&PathBuf| path == *other || selvedge_io::same_file(path, other);
        if streams.iter().any(again) {
            let twice = if path.as_os_str() == STREAM {
                Failure::new(2, "standard input is named twice")
            } else {
                Failure::new(2, "is a pipe that is named twice").about(path)
            };
            return Err(twice.remedy("give the others as files"));
        }
        if is_stream(path) {
            streams.push(path);
        }
    }
    Ok(())
}

/// Whether a name is that of standard input or of a pipe.
pub(crate) fn is_stream(path: &Path) -> bool {
    path.as_os_str() == STREAM || is_pipe(path)
}

/// What a stream begins with, and what follows if there is more.
pub(crate) type Begun = (Vec<u8>, Option<Box<dyn Read>>);

/// The first bytes of a stream, so many at most; `None` for a file.
pub(crate) fn begun(path: &Path, most: u64) -> Result<Option<Begun>, Failure> {
    let mut stream: Box<dyn Read> = if path.as_os_str() == STREAM {
        Box::new(std::io::stdin())
    } else if is_pipe(path) {
        Box::new(File::open(path).map_err(|e| unreadable(path, &e))?)
    } else {
        return Ok(None);
    };
    let mut start = Vec::new();
    stream.by_ref().take(most).read_to_end(&mut start).map_err(|e| unreadable(path, &e))?;
    let more = start.len() as u64 == most;
    Ok(Some((start, more.then_some(stream))))
}

/// Whether a name is that of a pipe, such as `/dev/stdin` behind another program.
#[cfg(unix)]
pub(crate) fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    std::fs::metadata(path).is_ok_and(|m| m.file_type().is_fifo())
}

/// Elsewhere pipes have no names.
#[cfg(not(unix))]
pub(crate) fn is_pipe(_: &Path) -> bool {
    false
}

pub(crate) fn read_stream(path: &Path, stream: impl std::io::Read, budget: u64) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    stream.take(budget.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| unreadable(path, &e))?;
    if budget < bytes.len() as u64 {
        let budget = Bytes(budget);
        let failure = Failure::new(6, format!("is more than the {budget} allowed"));
        return Err(failure.remedy("raise --max-memory").about(path));
    }
    Ok(bytes)
}

fn unreadable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(4, stdio::plain(error)).remedy("give a file").about(path)
}
