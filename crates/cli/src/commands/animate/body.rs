//! `--within`: a body that flows, and does not fill the frames.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Grid, Plane};
use selvedge_io::Fingerprint;

use crate::clips;
use crate::failure::{Failure, n};
use crate::ground::frame_mask;
use crate::harmonise::hidden;
use crate::report::Report;
use crate::session::Session;

/// Where the texture is.
#[derive(Args, Clone, Debug)]
pub(super) struct BodyArgs {
    /// The texture is where this picture is white; elsewhere frames are transparent, and nothing flows in from there.
    /// One of the frames' size for all, or one a frame as 'name.####.png'.
    #[arg(long, value_name = "MASK|MASKS", value_hint = ValueHint::FilePath)]
    within: Option<PathBuf>,
}

/// Masks that were read: one, or one a frame.
pub(super) struct Body {
    masks: Vec<Grid<bool, 2>>,
    /// Of their files.
    pub(super) fingerprint: Fingerprint,
}

impl BodyArgs {
    /// True if some of the frames shows nothing.
    pub(super) fn is_some(&self) -> bool {
        self.within.is_some()
    }

    /// The files that are read: one, or as many as frames, or more.
    pub(super) fn files(&self) -> Result<Vec<PathBuf>, Failure> {
        self.within.as_deref().map_or(Ok(Vec::new()), |path| clips::files(path, None))
    }

    /// Refuses masks that are too few.
    pub(super) fn check(&self, files: &[PathBuf], frames: u32) -> Result<(), Failure> {
        let Some(within) = self.within.as_ref().filter(|_| 1 < files.len() && files.len() < frames as usize) else {
            return Ok(());
        };
        let what = format!("{} for {}", n("mask", files.len()), n("frame", frames as usize));
        Err(Failure::new(3, what)
            .about(within)
            .remedy(format!("use --frames {}, or give one mask for all", files.len())))
    }

    /// Bytes of so many masks, and of one that is read.
    pub(super) fn bytes(&self, output: Domain<2>, files: usize) -> Bytes {
        if files == 0 { Bytes(0) } else { Bytes::of_samples(output, 1) * files as u64 + Bytes::of_samples(output, 32) }
    }

    /// Reads them, those beyond the last frame not.
    pub(super) fn read(
        &self,
        session: &Session<'_>,
        files: &[PathBuf],
        (output, frames): (Domain<2>, u32),
        report: &mut Report,
    ) -> Result<Option<Body>, Failure> {
        let Some(within) = &self.within else { return Ok(None) };
        let (mut masks, mut each) = (Vec::new(), Vec::new());
        for path in files.iter().take(frames as usize) {
            let (mask, fingerprint) = frame_mask(session, path, (output.shape, "the frames have"), report)?;
            each.push(fingerprint);
            masks.push(mask.with_periodic(output.periodic));
        }
        if masks.iter().all(|mask| !mask.samples().contains(&true)) {
            session.warn(within, &"nothing of it is white: frames will show nothing");
        }
        Ok(Some(Body { masks, fingerprint: clips::fingerprint(within, &each) }))
    }
}

impl Body {
    /// Where it is in a frame.
    pub(super) fn at(&self, frame: u32) -> &Grid<bool, 2> {
        &self.masks[(frame as usize).min(self.masks.len() - 1)]
    }

    /// A frame as it shows the body alone.
    pub(super) fn shown(&self, frame: u32, plane: Plane<2>) -> Result<Plane<2>, Failure> {
        let mask = self.at(frame).samples();
        hidden(plane, |i| !mask[i])
    }
}
