//! Reading clips, frame by frame.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, Cursor, Read, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use selvedge_core::Plane;

use super::animation::Animation;
use super::apng::Apng;
use super::container::Container;
use super::ffmpeg::Decoder;
use super::flipbook::{Cells, Flipbook};
use super::info::{ClipInfo, Frames};
use super::names::{ClipName, clip_files};
use super::problem::ClipProblem;
use super::range::Range;
use super::rate::Rate;
use super::sequence::Sequence;
use super::still::Still;
use super::y4m::Y4m;
use crate::atomic::{Part, part_beside};
use crate::error::{Error, Problem};
use crate::name::file_of;
use crate::read::{open, read_bytes};
use crate::{Fingerprint, Format, ReadOptions, Warning, display_name};

/// How to read a clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipOptions {
    /// How each of its frames is read.
    pub frame: ReadOptions,
    /// Which frames; default: all.
    pub range: Option<Range>,
    /// How fast it plays, whatever the file says.
    pub rate: Option<Rate>,
    /// The name is that of a picture of all frames, which lie so.
    pub flipbook: Option<Flipbook>,
}

/// A clip that is read frame by frame.
pub struct ClipReader {
    path: PathBuf,
    info: ClipInfo,
    frames: Box<dyn Frames>,
    /// Places of the frames that are wanted, of a container.
    range: Option<Range>,
    /// Frames taken from it, and those that were wanted.
    place: u32,
    read: u32,
    /// Where a stream is kept; gone with the reader.
    _spool: Option<Part>,
}

impl ClipReader {
    /// Looks at a clip: all headers are read and compared.
    ///
    /// # Errors
    /// [`Error`] that names the frame, or the whole clip.
    pub fn open(path: impl AsRef<Path>, options: &ClipOptions) -> Result<Self, Error> {
        let path = path.as_ref();
        if let Some(layout) = options.flipbook {
            let (info, frames) = Cells::open(path, layout, &options.frame)?;
            return Self::picked(path, info, Box::new(frames), options);
        }
        if ClipName::parse(file_of(path)).is_some() {
            let (info, frames) = Sequence::open(path, clip_files(path, options.range)?, &options.frame)?;
            return Ok(Self::new(path, info, Box::new(frames), None, options.rate));
        }
        let mut start = Vec::new();
        let begun = open(path).and_then(|(file, _)| {
            file.take(18).read_to_end(&mut start).map_err(|e| Problem::file_system(e, 0)).map(drop)
        });
        begun.map_err(|p| Error::new(path, p))?;
        match Container::of_content(&start) {
            Some(Container::Y4m) => {
                let (info, frames) = Y4m::open(path, None, &options.frame)?;
                return Self::picked(path, info, Box::new(frames), options);
            }
            // Of what is no clip no more is read.
            None => return Err(Error::new(path, no_clip(&start))),
            Some(foreign) if foreign.muxer().is_some() => {
                let last = options.range.map(|range| range.last);
                let (info, frames) = Decoder::open(path, foreign, (&options.frame, last))?;
                return Self::picked(path, info, Box::new(frames), options);
            }
            Some(_) => {}
        }
        let bytes = read_bytes(path, &options.frame.limits).map_err(|p| Error::new(path, p))?;
        Self::of_bytes(bytes, path, options)
    }

    /// Reads a picture as a clip of so many frames, all of which show it; it has no rate of its own.
    ///
    /// # Errors
    /// Those of [`read`](crate::read()).
    pub fn of_picture(path: impl AsRef<Path>, frames: u32, options: &ReadOptions) -> Result<Self, Error> {
        let path = path.as_ref();
        let (info, still) = Still::open(path, frames, options)?;
        Ok(Self::new(path, info, Box::new(still), None, None))
    }

    /// The same of a picture that was read as bytes, such as standard input.
    ///
    /// # Errors
    /// Those of [`decode`](crate::decode).
    pub fn of_picture_bytes(
        bytes: &[u8],
        path: impl AsRef<Path>,
        frames: u32,
        options: &ReadOptions,
    ) -> Result<Self, Error> {
        let path = path.as_ref();
        let (info, still) = Still::of_bytes(bytes, path, frames, options)?;
        Ok(Self::new(path, info, Box::new(still), None, None))
    }

    /// Looks at a clip that was read as bytes, such as standard input; a sequence has files and is none.
    ///
    /// # Errors
    /// [`Error`] that names the clip.
    pub fn of_bytes(bytes: Vec<u8>, path: impl AsRef<Path>, options: &ClipOptions) -> Result<Self, Error> {
        let (path, frame) = (path.as_ref(), &options.frame);
        let container = Container::of_content(&bytes);
        if container == Some(Container::Y4m) {
            let (info, frames) = Y4m::open(path, Some(Box::new(Cursor::new(bytes))), frame)?;
            return Self::picked(path, info, Box::new(frames), options);
        }
        let file: Arc<[u8]> = bytes.into();
        let (info, frames): (ClipInfo, Box<dyn Frames>) = match container {
            Some(Container::Gif) => boxed(Animation::open(path, &file, Format::Gif, (frame, options.range))?),
            Some(Container::Webp) => boxed(Animation::open(path, &file, Format::Webp, (frame, options.range))?),
            Some(Container::Apng) => {
                let still = || Error::new(path, ClipProblem::Still);
                boxed(Apng::open(path, &file, frame)?.ok_or_else(still)?)
            }
            // Of other programs' containers only files are read.
            _ => return Err(Error::new(path, no_clip(&file))),
        };
        Self::picked(path, info, frames, options)
    }

    /// Looks at a clip of y4m that is read once, of which `start` was read already: it is kept in a file beside a name
    /// for as long as the reader lives.
    ///
    /// # Errors
    /// [`Error`] that names the clip, or that name where it cannot be kept.
    pub fn of_stream(
        (start, rest): (&[u8], impl Read),
        beside: &Path,
        path: impl AsRef<Path>,
        options: &ClipOptions,
    ) -> Result<Self, Error> {
        let path = path.as_ref();
        if Container::of_content(start) != Some(Container::Y4m) {
            return Err(Error::new(path, no_clip(start)));
        }
        let len = start.len() as u64;
        let kept = part_beside(beside).and_then(|part| {
            let mut file = OpenOptions::new().write(true).open(part.file())?;
            file.write_all(start)?;
            io::copy(&mut { rest }, &mut file)?;
            Ok((File::open(part.file())?, part))
        });
        let (file, part) = kept.map_err(|e| Error::new(beside, Problem::file_system(e, len)))?;
        let (info, frames) = Y4m::open(path, Some(Box::new(BufReader::new(file))), &options.frame)?;
        Ok(Self { _spool: Some(part), ..Self::picked(path, info, Box::new(frames), options)? })
    }

    /// With the frames of a range alone: their places, from 1.
    fn picked(path: &Path, info: ClipInfo, frames: Box<dyn Frames>, options: &ClipOptions) -> Result<Self, Error> {
        let Some(range) = options.range else { return Ok(Self::new(path, info, frames, None, options.rate)) };
        if range.first == 0 || info.frames < range.last {
            let number = if range.first == 0 { 0 } else { range.first.max(info.frames + 1) };
            return Err(Error::new(path, ClipProblem::Place { number, frames: info.frames }));
        }
        let info = ClipInfo { frames: range.numbers().count() as u32, ..info };
        Ok(Self::new(path, info, frames, Some(range), options.rate))
    }

    fn new(path: &Path, info: ClipInfo, frames: Box<dyn Frames>, range: Option<Range>, rate: Option<Rate>) -> Self {
        let info = ClipInfo { rate: rate.or(info.rate), ..info };
        Self { path: path.to_path_buf(), info, frames, range, place: 0, read: 0, _spool: None }
    }

    /// What the clip is.
    pub fn info(&self) -> &ClipInfo {
        &self.info
    }

    /// The name it was opened by.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The next frame; `None` after the last.
    ///
    /// # Errors
    /// [`Error`] that names the frame.
    #[expect(clippy::should_implement_trait, reason = "an iterator would not answer with an error first")]
    pub fn next(&mut self) -> Result<Option<Plane<2>>, Error> {
        if self.read == self.info.frames {
            return Ok(None);
        }
        self.pass(self.read)?;
        (self.read, self.place) = (self.read + 1, self.place + 1);
        self.frames.next()
    }

    /// Goes to a frame, counted from 0, so that it is the next: of files that hold all frames by passing over those
    /// before it.
    ///
    /// # Errors
    /// Those of [`next`](Self::next).
    pub fn seek(&mut self, frame: u32) -> Result<(), Error> {
        if frame < self.read {
            self.rewind()?;
        }
        self.pass(frame)?;
        self.read = frame.min(self.info.frames);
        Ok(())
    }

    /// Passes over what comes before a frame, and of a range before its place.
    fn pass(&mut self, frame: u32) -> Result<(), Error> {
        let place = self.range.map_or(frame, |range| range.numbers().nth(frame as usize).unwrap_or(range.last) - 1);
        while self.place < place && self.frames.skip()? {
            self.place += 1;
        }
        Ok(())
    }

    /// Goes back to the first frame.
    ///
    /// # Errors
    /// What the file system refuses.
    pub fn rewind(&mut self) -> Result<(), Error> {
        (self.read, self.place) = (0, 0);
        self.frames.rewind()
    }

    /// The clip by name and content, once all frames were read.
    pub fn fingerprint(&self) -> Fingerprint {
        Fingerprint { name: display_name(file_of(&self.path)), blake3: self.frames.blake3() }
    }

    /// The file of each frame by name and content, once all were read: of a container the same for all.
    pub fn frame_fingerprints(&self) -> Vec<Fingerprint> {
        let files = self.frames.files();
        if files.is_empty() { vec![self.fingerprint(); self.info.frames as usize] } else { files }
    }

    /// What was odd in the frames read so far.
    pub fn warnings(&self) -> &[Warning] {
        self.frames.warnings()
    }
}

/// What a file that is no clip is.
fn no_clip(start: &[u8]) -> Problem {
    match Format::of_content(start) {
        _ if start.is_empty() => Problem::Empty,
        Some(_) => ClipProblem::Still.into(),
        None => ClipProblem::UnknownContainer.into(),
    }
}

fn boxed((info, frames): (ClipInfo, impl Frames + 'static)) -> (ClipInfo, Box<dyn Frames>) {
    (info, Box::new(frames))
}

impl fmt::Debug for ClipReader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ClipReader").field("path", &self.path).field("info", &self.info).finish_non_exhaustive()
    }
}
