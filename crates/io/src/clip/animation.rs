//! GIF and WebP animations, read: each frame as it is seen, with what earlier ones leave under it.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::AnimationDecoder as _;
use selvedge_core::{Association, Domain, Grid, Plane, Samples};

use super::info::{ClipInfo, Frames};
use super::problem::ClipProblem;
use super::rate::Rate;
use crate::codec::{Context, guarded};
use crate::error::{Error, Problem};
use crate::header::Header;
use crate::image::{complaint, gif, webp};
use crate::{Depth, Format, Metadata, ReadOptions, Warning};

/// A clock for delays: both formats tell whole milliseconds.
const TICKS: u64 = 1000;

/// An animation, decoded frame by frame.
pub(super) struct Animation {
    path: PathBuf,
    file: Arc<[u8]>,
    format: Format,
    options: ReadOptions,
    alpha: bool,
    frames: Option<image::Frames<'static>>,
}

impl Animation {
    /// Decodes a file once, to see what it holds: no header says how many frames there are and whether any of them is
    /// transparent.
    pub(super) fn open(
        path: &Path,
        file: &Arc<[u8]>,
        format: Format,
        options: &ReadOptions,
    ) -> Result<(ClipInfo, Self), Error> {
        let looked = guarded(format, || Self::looked_at(path, file, format, options));
        looked.map_err(|p| Error::new(path, p))
    }

    fn looked_at(
        path: &Path,
        file: &Arc<[u8]>,
        format: Format,
        options: &ReadOptions,
    ) -> Result<(ClipInfo, Self), Problem> {
        let (path, file, options) = (path.to_path_buf(), file.clone(), options.clone());
        let mut own = Self { path, file, format, options, alpha: true, frames: None };
        let (header, metadata) = own.begin()?;
        let (mut count, mut ticks, mut transparent) = (0_u32, 0_u64, false);
        while let Some(frame) = own.decoded()? {
            let (num, den) = frame.delay().numer_denom_ms();
            count = count.saturating_add(1);
            ticks = ticks.saturating_add(u64::from(num) / u64::from(den.max(1)));
            transparent |= frame.buffer().pixels().any(|p| p.0[3] != u8::MAX);
        }
        if count == 0 {
            return Err(ClipProblem::Still.into());
        }
        (own.alpha, own.frames) = (transparent, None);
        let info = ClipInfo {
            width: header.width as u32,
            height: header.height as u32,
            frames: count,
            rate: Rate::of_ticks(count.into(), ticks, TICKS),
            channels: 3 + usize::from(transparent),
            alpha: transparent,
            association: Association::Straight,
            depth: Depth::U8,
            metadata,
            container: format.name().to_owned(),
        };
        Ok((info, own))
    }

    /// Begins to decode, with what the file claims checked first.
    fn begin(&mut self) -> Result<(Header, Metadata), Problem> {
        let mut context = Context::new(&self.options, self.file.len() as u64);
        let input = Cursor::new(self.file.clone());
        let (frames, description) = match self.format {
            Format::Gif => {
                let (decoder, description) = gif::animation(input, &self.file, &mut context)?;
                (decoder.into_frames(), description)
            }
            _ => {
                let (decoder, description) = webp::animation(input, &mut context)?;
                if !decoder.has_animation() {
                    return Err(ClipProblem::Still.into());
                }
                (decoder.into_frames(), description)
            }
        };
        self.frames = Some(frames);
        Ok((description.header, description.metadata))
    }

    fn decoded(&mut self) -> Result<Option<image::Frame>, Problem> {
        if self.frames.is_none() {
            self.begin()?;
        }
        let context = Context::new(&self.options, self.file.len() as u64);
        let next = self.frames.as_mut().and_then(Iterator::next);
        next.transpose().map_err(|e| complaint(e, self.format, &context))
    }

    fn plane(&self, frame: &image::Frame) -> Result<Plane<2>, Problem> {
        let buffer = frame.buffer();
        let domain = Domain::open([buffer.height(), buffer.width()]);
        let channels = 3 + usize::from(self.alpha);
        let mut grid = Grid::try_filled(domain, channels, 0_u8)?;
        for c in 0..channels {
            grid.plane_mut(c).iter_mut().zip(buffer.pixels()).for_each(|(to, from)| *to = from.0[c]);
        }
        let (role, samples) = (self.options.role, Samples::U8(grid));
        Ok(Plane { role, samples, alpha: self.alpha, association: Association::Straight })
    }
}

impl Frames for Animation {
    fn next(&mut self) -> Result<Option<Plane<2>>, Error> {
        let format = self.format;
        let next = guarded(format, || self.decoded()?.map(|frame| self.plane(&frame)).transpose());
        next.map_err(|p| Error::new(&self.path, p))
    }

    fn rewind(&mut self) -> Result<(), Error> {
        self.frames = None;
        Ok(())
    }

    fn blake3(&self) -> String {
        blake3::hash(&self.file).to_hex().to_string()
    }

    fn warnings(&self) -> &[Warning] {
        &[]
    }
}
