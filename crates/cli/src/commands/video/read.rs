//! What `video` reads.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::Role;
use selvedge_io::clip::{ClipOptions, Flipbook, Range, Rate};
use serde_json::Value;

use crate::clips::{self, ClipInput};
use crate::failure::{Failure, shown};
use crate::inputs;
use crate::options::NonFinite;
use crate::session::Session;

/// The clip, its other passes, and how they are read.
#[derive(Args, Clone, Debug)]
pub(super) struct ReadArgs {
    /// The clip.
    #[arg(
        help = "The clip: 'name.####.png', a folder, a quoted glob, an animation, '-' for y4m, or a video by ffmpeg"
    )]
    #[arg(value_name = "CLIP", value_hint = ValueHint::FilePath)]
    pub(super) clip: PathBuf,
    /// Other passes of the same frames, such as normals or velocities: the same seam on each, bit for bit.
    #[arg(long, value_name = "CLIP", value_delimiter = ',', value_hint = ValueHint::FilePath)]
    pub(super) with: Vec<PathBuf>,
    /// Frames to use, such as 1-100 or 1-100x2: by their numbers, or by their places from 1 in an animation.
    #[arg(long, value_name = "RANGE", value_parser = clips::range)]
    pub(super) range: Option<Range>,
    /// The clip is one picture of so many columns and rows of frames.
    #[arg(long, value_name = "COLSxROWS", value_parser = clips::flipbook, conflicts_with = "range")]
    pub(super) from_flipbook: Option<Flipbook>,
    /// Pixels around each frame of --from-flipbook that are no part of it.
    #[arg(long, value_name = "PX", requires = "from_flipbook")]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=4096))]
    pub(super) from_pad: Option<u32>,
    #[command(flatten)]
    pub(super) nonfinite: NonFinite,
}

impl ReadArgs {
    /// The clip and its other passes.
    pub(super) fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        std::iter::once(&self.clip).chain(&self.with)
    }

    /// Looks at them: passes have the clip's frames, of which there are at least two. What streams bring may be kept
    /// beside a name.
    pub(super) fn open(
        &self,
        session: &Session<'_>,
        rate: Option<Rate>,
        beside: &Path,
    ) -> Result<Vec<ClipInput>, Failure> {
        let options = self.options(session, rate);
        let open = |path: &PathBuf| ClipInput::spooled(session, path, &options, beside);
        let clips = self.paths().map(open).collect::<Result<Vec<_>, _>>()?;
        if let Some(book) = options.flipbook {
            self.paths().for_each(|path| clips::tell_cells(session, path, book));
        }
        clips[1..].iter().try_for_each(|pass| pass.check_like(&clips[0]))?;
        if clips[0].info().frames < 2 {
            let failure = Failure::new(3, "has one frame, of which no loop is made");
            return Err(failure.about(&self.clip).remedy("give a clip of more frames"));
        }
        Ok(clips)
    }

    /// How they are read.
    pub(super) fn options(&self, session: &Session<'_>, rate: Option<Rate>) -> ClipOptions {
        ClipOptions {
            frame: inputs::options(session.limits, Role::Color, self.nonfinite),
            range: self.range,
            rate,
            flipbook: self.from_flipbook.map(|book| Flipbook { pad: self.from_pad.unwrap_or(0), ..book }),
        }
    }

    /// The files of the frames that a jump goes to and from, which are told by their places, where each has one.
    pub(super) fn between(&self, jump: &Value) -> String {
        let files = self.files(&self.clip).unwrap_or_default();
        let file = |of: &str| files.get(jump[of].as_u64()? as usize);
        match (file("to"), file("from")) {
            (Some(first), Some(last)) if 1 < files.len() => {
                format!(", '{}' to '{}'", shown(file_name(first)), shown(file_name(last)))
            }
            _ => String::new(),
        }
    }

    /// The files of one of them.
    pub(super) fn files(&self, path: &Path) -> Result<Vec<PathBuf>, Failure> {
        if self.from_flipbook.is_some() { Ok(vec![path.to_path_buf()]) } else { clips::files(path, self.range) }
    }
}

/// A file without its folder.
fn file_name(path: &Path) -> &Path {
    path.file_name().map_or(path, Path::new)
}
