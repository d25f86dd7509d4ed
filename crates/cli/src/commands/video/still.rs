//! `--fixed`: parts of the picture that stand still.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Exemplars, Grid, SeamMeasure, SourceMap};
use selvedge_graphcut_textures::video::{estimate_still, hold_still};

use crate::clips::ClipInput;
use crate::failure::{Failure, n};
use crate::ground::frame_mask;
use crate::report::Report;
use crate::session::Session;

/// What stands still.
#[derive(Args, Clone, Debug)]
pub(super) struct StillArgs {
    /// Where this picture is white, all frames show one frame of the clip; the cut finds where stillness ends.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath, conflicts_with = "blend")]
    fixed: Option<PathBuf>,
    /// The frame that --fixed shows, counted from 0. Default: 0.
    #[arg(long, value_name = "N", requires = "fixed")]
    still_frame: Option<u32>,
}

/// A mask that was read, and the frame to show there.
pub(super) struct Still {
    pub(super) mask: Grid<bool, 2>,
    frame: u32,
}

impl StillArgs {
    /// A file that is read.
    pub(super) fn file(&self) -> Option<&PathBuf> {
        self.fixed.as_ref()
    }

    /// Refuses what does not fit the clip, or frames of this height and width.
    pub(super) fn check(&self, clip: &ClipInput, output: Domain<3>) -> Result<(), Failure> {
        let (has, [frames, ..]) = (clip.domain().shape, clip.domain().shape);
        if self.fixed.is_some() && (output.shape[1..] != has[1..] || output.periodic[1..] != [false; 2]) {
            let what = "--fixed needs frames of the clip's size, which do not tile";
            return Err(Failure::new(2, what).remedy("leave out --size and --tile"));
        }
        match self.still_frame {
            Some(frame) if frames <= frame => {
                let what = format!("--still-frame {frame} of a clip of {}", n("frame", frames as usize));
                Err(Failure::new(2, what).remedy(format!("use 0 to {}", frames - 1)))
            }
            _ => Ok(()),
        }
    }

    /// Bytes beside those of the map.
    pub(super) fn bytes(&self, clip: Domain<3>, channels: usize, output: Domain<3>) -> Bytes {
        if self.fixed.is_some() { estimate_still(clip, channels, output) } else { Bytes(0) }
    }

    /// Reads the mask.
    pub(super) fn read(
        &self,
        session: &Session<'_>,
        clip: [u32; 3],
        report: &mut Report,
    ) -> Result<Option<Still>, Failure> {
        let Some(path) = &self.fixed else { return Ok(None) };
        let [_, height, width] = clip;
        let (mask, _) = frame_mask(session, path, ([height, width], "the clip has"), report)?;
        Ok(Some(Still { mask, frame: self.still_frame.unwrap_or(0) }))
    }
}

impl Still {
    /// The map with these pixels still.
    pub(super) fn held(
        &self,
        session: &Session<'_>,
        exemplars: &Exemplars<3>,
        map: &SourceMap<3>,
        seam: SeamMeasure,
    ) -> Result<SourceMap<3>, Failure> {
        hold_still(exemplars, map, (&self.mask, self.frame), seam, &session.run()).or_else(|e| {
            // A signal is why, or nothing is.
            session.check_signal()?;
            Err(e.into())
        })
    }
}
