//! Clips that are given beside each other, and pictures that are held over their frames.

use std::path::{Path, PathBuf};

use selvedge_io::clip::{ClipInfo, ClipOptions, ClipReader};
use selvedge_io::{Association, ReadOptions};

use crate::clips::{ClipInput, is_of_clips};
use crate::failure::{Failure, n, shown};
use crate::inputs::{self, Input};
use crate::session::Session;

/// What a name turned out to be.
pub(crate) enum Given {
    Clip(Box<ClipInput>),
    /// A picture, with its bytes where it came through a stream.
    Picture(PathBuf, Option<Vec<u8>>),
}

impl From<ClipInput> for Given {
    fn from(clip: ClipInput) -> Self {
        Self::Clip(Box::new(clip))
    }
}

impl Given {
    /// Looks at a name; a stream is read to its end.
    pub(crate) fn look(session: &Session<'_>, path: &Path, frame: &ReadOptions) -> Result<Self, Failure> {
        let Some(bytes) = Input::new(session, path)?.into_stream() else {
            let found = ClipInput::found(path, frame)?;
            return Ok(found.map_or_else(|| Self::Picture(path.to_path_buf(), None), Self::from));
        };
        let options = ClipOptions { frame: frame.clone(), ..ClipOptions::default() };
        if bytes.starts_with(b"YUV4MPEG2") {
            return Ok(Self::from(ClipInput::from(ClipReader::of_bytes(bytes, path, &options)?)));
        }
        match ClipReader::of_bytes(bytes.clone(), path, &options) {
            Ok(reader) if 1 < reader.info().frames => Ok(Self::from(ClipInput::from(reader))),
            Err(e) if is_of_clips(&e.problem) => Err(e.into()),
            _ => Ok(Self::Picture(path.to_path_buf(), Some(bytes))),
        }
    }

    /// A clip as it is, and a picture over so many frames.
    fn over(self, frames: u32, options: &ReadOptions) -> Result<ClipInput, Failure> {
        Ok(match self {
            Self::Clip(clip) => *clip,
            Self::Picture(path, None) => ClipReader::of_picture(path, frames, options)?.into(),
            Self::Picture(path, Some(bytes)) => ClipReader::of_picture_bytes(&bytes, path, frames, options)?.into(),
        })
    }
}

/// Opens clips; pictures are held over as many frames as the first clip has, or so many.
pub(crate) fn opened(
    session: &Session<'_>,
    paths: &[PathBuf],
    frames: Option<u32>,
    options: &ReadOptions,
) -> Result<Vec<ClipInput>, Failure> {
    let given = paths.iter().map(|path| Given::look(session, path, options)).collect::<Result<Vec<_>, _>>()?;
    let of_first = given.iter().find_map(|given| match given {
        Given::Clip(clip) => Some(clip.info().frames),
        Given::Picture(..) => None,
    });
    let frames = frames.or(of_first).ok_or_else(|| Failure::new(70, "no clip is given"))?;
    given.into_iter().map(|given| given.over(frames, options)).collect()
}

/// Refuses clips of other frames or samples than the first, or of another rate than the first that has one; tells of
/// other colours.
pub(crate) fn check_alike(session: &Session<'_>, clips: &[ClipInput]) -> Result<(), Failure> {
    let first = &clips[0];
    let paced = clips.iter().find(|clip| clip.info().rate.is_some()).unwrap_or(first);
    for clip in &clips[1..] {
        if let Some((found, of, expected)) = unlike(clip, first, paced) {
            let what = format!("has {found}, but '{}' has {expected}", shown(of));
            let failure = Failure::new(3, what).about(clip.path());
            return Err(failure.remedy("give what has the same frames, rate and samples"));
        }
    }
    inputs::tell_tags(session, first.path(), clips.iter().map(|clip| &clip.info().metadata), "clip");
    Ok(())
}

/// What a clip has, and which other one has something else.
fn unlike<'c>(clip: &ClipInput, first: &'c ClipInput, paced: &'c ClipInput) -> Option<(String, &'c Path, String)> {
    let (a, b) = (clip.info(), first.info());
    let of_first = |told: &dyn Fn(&ClipInfo) -> String| Some((told(a), first.path(), told(b)));
    if a.frames != b.frames {
        return of_first(&|info| n("frame", info.frames as usize));
    }
    if let (Some(rate), Some(of)) = (a.rate, paced.info().rate)
        && rate != of
    {
        return Some((format!("{rate} frames a second"), paced.path(), of.to_string()));
    }
    if (a.channels, a.alpha, a.depth) != (b.channels, b.alpha, b.depth) {
        return of_first(&|info| format!("{} of {}", n("channel", info.channels), info.depth.name()));
    }
    let multiplied = |info: &ClipInfo| info.association == Association::Premultiplied;
    if a.alpha && multiplied(a) != multiplied(b) {
        return of_first(&|info| if multiplied(info) { "premultiplied alpha" } else { "straight alpha" }.to_owned());
    }
    None
}
