//! Writing clips, frame by frame.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use selvedge_core::Plane;

use super::apng::ApngWriter;
use super::container::Container;
use super::ffmpeg::Encoder;
use super::flipbook::{Flipbook, FlipbookWriter};
use super::gif::GifWriter;
use super::info::{FrameEncoder, Layout};
use super::manifest::Manifest;
use super::names::ClipName;
use super::problem::ClipProblem;
use super::rate::Rate;
use super::y4m::Y4mWriter;
use crate::error::{Error, Problem};
use crate::{Depth, Metadata, WriteOptions, display_name, encode, write_bytes};

/// How to write a clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipWriteOptions {
    /// How each of its frames is written.
    pub frame: WriteOptions,
    /// How fast it plays. Containers must say something: without a rate it is [`Rate::USUAL`].
    pub rate: Option<Rate>,
    /// Frames after which it begins again, for a loop.
    pub period: Option<u32>,
    /// All frames in one picture, which lie so.
    pub flipbook: Option<Flipbook>,
    /// What `ffmpeg` is told of codecs, argument by argument, where it writes the container. Default: what all players
    /// show, with loss, of 8 bits and without alpha.
    pub encode: Option<Vec<String>>,
}

/// A file of a clip, whole.
pub type ClipFile = (PathBuf, Vec<u8>);

/// A clip that is written frame by frame.
pub struct ClipWriter {
    target: Target,
    metadata: Metadata,
    options: ClipWriteOptions,
    frames: u32,
    /// Of the first frame.
    layout: Option<Layout>,
    /// Name and hash of each frame's file.
    written: Vec<(String, String)>,
    taken: u32,
}

/// Where frames go.
enum Target {
    Sequence(ClipName),
    File(PathBuf, Box<dyn FrameEncoder>),
}

impl ClipWriter {
    /// Begins a clip of so many frames: a sequence by its name, else the container of the name's extension; `-` is y4m.
    /// Nothing is written yet.
    ///
    /// # Errors
    /// [`ClipProblem::NoClip`], and those of a picture of the frames' name.
    pub fn create(
        path: impl AsRef<Path>,
        frames: u32,
        metadata: Metadata,
        options: ClipWriteOptions,
    ) -> Result<Self, Error> {
        let path = path.as_ref();
        let no_clip = || Error::new(path, ClipProblem::NoClip);
        let rate = options.rate.unwrap_or(Rate::USUAL);
        let container = if options.flipbook.is_none() { Container::of_name(path) } else { None };
        let foreign = container.filter(|container| container.muxer().is_some());
        if options.encode.is_some() && (foreign.is_none() || ClipName::parse(path).is_some()) {
            return Err(Error::new(path, ClipProblem::NoCodec));
        }
        let target = match (options.flipbook, ClipName::parse(path)) {
            (Some(layout), _) => {
                let Flipbook { columns, rows, .. } = layout;
                options.frame.format_of(path)?;
                if layout.cells() < frames {
                    return Err(Error::new(path, ClipProblem::Full { frames, columns, rows }));
                }
                let encoder = FlipbookWriter::new(path, layout, &options.frame, metadata.clone());
                Target::File(path.to_path_buf(), Box::new(encoder))
            }
            (None, Some(name)) => {
                let file = name.file(1).filter(|_| name.has_one_number()).ok_or_else(no_clip)?;
                if options.frame.format.is_none() && !name.has_ending() {
                    return Err(no_clip());
                }
                options.frame.format_of(file)?;
                Target::Sequence(name)
            }
            (None, None) => {
                let encoder: Box<dyn FrameEncoder> = match Container::of_name(path).ok_or_else(no_clip)? {
                    Container::Apng => Box::new(ApngWriter::new(frames, rate, metadata.clone())),
                    Container::Gif => Box::new(GifWriter::new(rate)),
                    Container::Y4m => Box::new(Y4mWriter::new(rate)),
                    Container::Webp => return Err(Error::new(path, ClipProblem::OnlyRead { container: "webp" })),
                    foreign => Box::new(Encoder::new((path, foreign), options.encode.clone(), rate)),
                };
                Target::File(path.to_path_buf(), encoder)
            }
        };
        Ok(Self { target, metadata, options, frames, layout: None, written: Vec::new(), taken: 0 })
    }

    /// Refuses frames of so many channels (alpha included), this depth, height and width, that are not held.
    ///
    /// # Errors
    /// Those of a picture, or [`ClipProblem::Unsupported`].
    pub fn check(&self, (channels, alpha): (usize, bool), depth: Depth, shape: [u32; 2]) -> Result<(), Error> {
        let colors = channels - usize::from(alpha);
        let (path, checked) = match &self.target {
            Target::Sequence(name) => {
                let file = name.file(1).unwrap_or_default();
                let format = self.options.frame.format_of(&file)?;
                (file, format.check(shape, colors, alpha, depth))
            }
            Target::File(path, _) => match self.options.flipbook {
                Some(layout) => {
                    let [width, height] = layout.size([shape[1], shape[0]]);
                    let format = self.options.frame.format_of(path)?;
                    (path.clone(), format.check([height, width], colors, alpha, depth))
                }
                None => {
                    let container = Container::of_name(path).unwrap_or(Container::Apng);
                    let checked = container.check(colors, alpha, depth, shape);
                    (path.clone(), checked.and_then(|()| self.check_encoder(container, (colors, alpha), depth, shape)))
                }
            },
        };
        checked.map_err(|p| Error::new(&path, p))
    }

    /// Refuses what the other program that is to encode it does not take.
    fn check_encoder(
        &self,
        container: Container,
        (colors, alpha): (usize, bool),
        depth: Depth,
        shape: [u32; 2],
    ) -> Result<(), Problem> {
        let Target::File(path, _) = &self.target else { return Ok(()) };
        if container.muxer().is_none() {
            return Ok(());
        }
        if self.options.encode.is_none() && (alpha || depth != Depth::U8) {
            let lost = if alpha { "alpha".to_owned() } else { format!("a clip of {} samples", depth.name()) };
            let what = format!("{lost}, without a codec that is named and keeps it,");
            return Err(ClipProblem::Unsupported { container: container.name(), what }.into());
        }
        let rate = self.options.rate.unwrap_or(Rate::USUAL);
        Encoder::new((path, container), self.options.encode.clone(), rate).tried((colors, alpha), depth, shape)
    }

    /// The file that holds all frames, or tells of them.
    fn path(&self) -> PathBuf {
        match &self.target {
            Target::Sequence(name) => name.manifest(),
            Target::File(path, _) => path.clone(),
        }
    }

    /// All files that will be there at the end.
    pub fn files(&self) -> Vec<PathBuf> {
        match &self.target {
            Target::Sequence(name) => {
                let frames = (1..=self.frames).filter_map(|number| name.file(number));
                frames.chain([name.manifest()]).collect()
            }
            Target::File(path, _) if self.options.flipbook.is_some() => {
                vec![path.clone(), path.with_extension("json")]
            }
            Target::File(path, _) => vec![path.clone()],
        }
    }

    /// Frames of a longer clip of this name, which nothing replaces.
    pub fn left_over(&self) -> Vec<PathBuf> {
        let Target::Sequence(name) = &self.target else { return Vec::new() };
        let found = name.found().unwrap_or_default();
        // Of a folder all pictures are frames of its clip, whatever their names.
        if let ClipName::Folder(_) = name {
            let own: BTreeSet<PathBuf> = (1..=self.frames).filter_map(|number| name.file(number)).collect();
            let mut left: Vec<_> = found.into_iter().map(|(_, file)| file).filter(|file| !own.contains(file)).collect();
            left.sort();
            return left;
        }
        let mut left: Vec<_> = found
            .into_iter()
            .filter_map(|(number, file)| Some((number?, file)))
            .filter(|(number, _)| !(1..=self.frames).contains(number))
            .collect();
        left.sort();
        left.into_iter().map(|(_, file)| file).collect()
    }

    /// Frames that were taken so far.
    pub fn taken(&self) -> u32 {
        self.taken
    }

    /// Name and BLAKE3 of the file of each frame of a sequence so far.
    pub fn written(&self) -> &[(String, String)] {
        &self.written
    }

    /// Goes on after frames of a sequence that are there, whose hashes [`written`](Self::written) told.
    pub fn go_on(&mut self, hashes: Vec<String>) {
        let Target::Sequence(name) = &self.target else { return };
        let name = |number: u32| display_name(&name.file(number).unwrap_or_default());
        self.written = (1..).map(name).zip(hashes).collect();
        self.taken = self.written.len() as u32;
    }

    /// Takes the next frame. Of a sequence it is a file at once, of a container it will be a part of one.
    ///
    /// # Errors
    /// Those of a picture; [`ClipProblem::Unsupported`] for what a container does not hold, [`ClipProblem::Differs`]
    /// for another size, depth or layout than that of the first frame.
    pub fn encoded(&mut self, plane: &Plane<2>) -> Result<Option<ClipFile>, Error> {
        let found = Layout::of(plane);
        let number = self.taken.saturating_add(1);
        let path = self.path();
        self.layout.get_or_insert(found).check(&path, number, &found)?;
        self.taken = number;
        match &mut self.target {
            Target::Sequence(name) => {
                let path = name.file(self.taken).unwrap_or_default();
                let bytes = encode(plane, &self.metadata, &path, &self.options.frame)?;
                self.written.push((display_name(&path), blake3::hash(&bytes).to_hex().to_string()));
                Ok(Some((path, bytes)))
            }
            Target::File(path, encoder) => encoder.frame(plane).map(|()| None).map_err(|p| Error::new(path, p)),
        }
    }

    /// Takes the next frame; of a sequence its file is written at once, whole or not at all.
    ///
    /// # Errors
    /// Those of [`encoded`](Self::encoded) and of [`write_bytes`].
    pub fn frame(&mut self, plane: &Plane<2>) -> Result<(), Error> {
        match self.encoded(plane)? {
            Some((path, bytes)) => write_bytes(&path, &bytes, self.options.frame.no_clobber),
            None => Ok(()),
        }
    }

    /// What is written after the last frame: the file that holds all of them, or one that tells of them, or both.
    ///
    /// # Errors
    /// [`ClipProblem::Count`], and what the encoder refuses.
    pub fn ended(self) -> Result<Vec<ClipFile>, Error> {
        let (found, expected) = (self.taken, self.frames);
        let manifest = Manifest {
            size: self.layout.map_or([0, 0], |layout| [layout.width, layout.height]),
            rate: self.options.rate,
            period: self.options.period,
            frames: self.written,
            more: Vec::new(),
        };
        let (path, encoder) = match self.target {
            Target::Sequence(name) => (name.manifest(), None),
            Target::File(path, encoder) => (path, Some(encoder)),
        };
        if found != expected {
            return Err(Error::new(&path, ClipProblem::Count { expected, found }));
        }
        let Some(encoder) = encoder else { return Ok(vec![(path, manifest.json().into_bytes())]) };
        let bytes = encoder.finish().map_err(|p| Error::new(&path, p))?;
        let Some(Flipbook { columns, rows, pad }) = self.options.flipbook else { return Ok(vec![(path, bytes)]) };
        let frames = vec![(display_name(&path), blake3::hash(&bytes).to_hex().to_string())];
        let more = [("frames", found), ("columns", columns), ("rows", rows), ("pad", pad)];
        let more = more.map(|(name, number)| (name, number.to_string())).into();
        let beside = path.with_extension("json");
        Ok(vec![(path, bytes), (beside, Manifest { frames, more, ..manifest }.json().into_bytes())])
    }

    /// The same of a clip that ends before its time: it has the frames that were taken.
    ///
    /// # Errors
    /// Those of [`ended`](Self::ended).
    pub fn cut_short(mut self) -> Result<Vec<ClipFile>, Error> {
        self.frames = self.taken;
        self.ended()
    }

    /// Writes what comes last.
    ///
    /// # Errors
    /// Those of [`ended`](Self::ended) and of [`write_bytes`].
    pub fn finish(self) -> Result<(), Error> {
        let no_clobber = self.options.frame.no_clobber;
        self.ended()?.iter().try_for_each(|(path, bytes)| write_bytes(path, bytes, no_clobber))
    }
}

impl std::fmt::Debug for ClipWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ClipWriter").field("files", &self.files()).field("taken", &self.taken).finish_non_exhaustive()
    }
}
