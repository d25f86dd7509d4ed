//! GIF and WebP animations, read: each frame as it is seen, with what earlier ones leave under it.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::AnimationDecoder as _;
use selvedge_core::{Association, Domain, Grid, Plane, Samples};

use super::info::{ClipInfo, Frames};
use super::problem::{ClipProblem, check_samples};
use super::range::Range;
use super::rate::Delays;
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
    warnings: Vec<Warning>,
}

impl Animation {
    /// Decodes a file once, as far as its frames are wanted: no header says whether any of them is transparent.
    pub(super) fn open(
        path: &Path,
        file: &Arc<[u8]>,
        format: Format,
        (options, range): (&ReadOptions, Option<Range>),
    ) -> Result<(ClipInfo, Self), Error> {
        let looked = guarded(format, || Self::looked_at(path, file, format, (options, range)));
        looked.map_err(|p| Error::new(path, p))
    }

    fn looked_at(
        path: &Path,
        file: &Arc<[u8]>,
        format: Format,
        (options, range): (&ReadOptions, Option<Range>),
    ) -> Result<(ClipInfo, Self), Problem> {
        let wanted = range.as_ref().map_or(u32::MAX, |range| range.last);
        let (path, file, options) = (path.to_path_buf(), file.clone(), options.clone());
        let mut own = Self { path, file, format, options, alpha: true, frames: None, warnings: Vec::new() };
        let (header, metadata) = own.begin()?;
        let there = if format == Format::Gif { gif::count(&own.file) } else { webp::count(&own.file) };
        // Others are decoded one by one and let go.
        let kept = range.as_ref().map_or(there, |range| range.numbers().take_while(|&n| n <= there).count() as u32);
        check_samples((header.width, header.height), kept, &own.options.limits)?;
        let (mut count, mut delays, mut transparent) = (0_u32, Delays::default(), false);
        while let Some(frame) = if count < wanted { own.decoded()? } else { None } {
            let (num, den) = frame.delay().numer_denom_ms();
            count = count.saturating_add(1);
            delays.add(u64::from(num) / u64::from(den.max(1)));
            transparent |= frame.buffer().pixels().any(|p| p.0[3] != u8::MAX);
        }
        // Hundredths of seconds in GIF: a rate that is none of them makes its delays differ by one.
        own.warnings.extend(delays.uneven(if format == Format::Gif { 10 } else { 1 }));
        // Frames that are not wanted may be damaged.
        let count = if count < wanted { count } else { there.max(count) };
        if count == 0 {
            return Err(ClipProblem::Still.into());
        }
        (own.alpha, own.frames) = (transparent, None);
        let info = ClipInfo {
            width: header.width as u32,
            height: header.height as u32,
            frames: count,
            rate: delays.rate(TICKS),
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
        &self.warnings
    }
}
