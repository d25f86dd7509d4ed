//! Reading animated PNG.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use png::{BitDepth, BlendOp, Decoder, DisposeOp, FrameControl, Limits, Reader, Transformations};
use selvedge_core::{Association, Plane, Samples, try_vec};

use super::blend::{Canvas, Part};
use crate::clip::info::{ClipInfo, Frames};
use crate::clip::rate::Delays;
use crate::codec::{Context, METADATA_BYTES, guarded};
use crate::error::{Error, Problem};
use crate::header::{Header, afford};
use crate::png::{complaint, header, metadata};
use crate::samples::zeros;
use crate::{Depth, Format, ReadOptions, Warning};

type File = Cursor<Arc<[u8]>>;

/// A clock for delays: a multiple of all usual rates.
const TICKS: u64 = 705_600_000;

/// An animation, decoded frame by frame.
pub(in crate::clip) struct Apng {
    path: PathBuf,
    file: Arc<[u8]>,
    options: ReadOptions,
    header: Header,
    interlaced: bool,
    /// `None` before the first frame.
    reader: Option<Reader<File>>,
    canvas: Canvas,
    /// What the last frame leaves: where it lay, how it goes, and what was there before.
    last: Option<(Part, DisposeOp, Vec<u16>)>,
    frames: u32,
    at: u32,
    warnings: Vec<Warning>,
}

impl Apng {
    /// Looks at a file; `None` for a PNG that is no animation.
    pub(in crate::clip) fn open(
        path: &Path,
        file: &Arc<[u8]>,
        options: &ReadOptions,
    ) -> Result<Option<(ClipInfo, Self)>, Error> {
        guarded(Format::Png, || Self::looked_at(path, file, options)).map_err(|p| Error::new(path, p))
    }

    fn looked_at(path: &Path, file: &Arc<[u8]>, options: &ReadOptions) -> Result<Option<(ClipInfo, Self)>, Problem> {
        let mut reader = open(file, options)?;
        if reader.info().animation_control.is_none() {
            return Ok(None);
        }
        let delays = delays(file)?;
        let frames = delays.frames();
        let (header, metadata) = (header(reader.info()), metadata(reader.info()));
        let interlaced = reader.info().interlaced;
        let len = reader.output_buffer_size().unwrap_or(usize::MAX);
        let needed = (len as u64).saturating_mul(8).saturating_add(file.len() as u64);
        afford(&options.limits, needed)?;
        if reader.info().frame_control.is_none() {
            // The picture for those who know no animations is not one of its frames.
            reader.next_frame(&mut zeros(len)?).map_err(complaint)?;
        }
        let info = ClipInfo {
            width: header.width as u32,
            height: header.height as u32,
            frames,
            rate: delays.rate(TICKS),
            channels: header.channels,
            alpha: header.alpha,
            association: Association::Straight,
            depth: header.depth,
            metadata,
            container: "apng".to_owned(),
        };
        let opaque = if header.depth == Depth::U8 { 255 } else { u16::MAX };
        let (width, channels) = (header.width as usize, header.channels);
        let canvas = Canvas { width, channels, samples: try_vec(header.domain().len() * channels, 0)?, opaque };
        let (path, file, options) = (path.to_path_buf(), file.clone(), options.clone());
        let (reader, warnings) = (Some(reader), delays.uneven(TICKS / 1000).into_iter().collect());
        let own = Self { path, file, options, header, interlaced, reader, canvas, last: None, frames, at: 0, warnings };
        Ok(Some((info, own)))
    }

    fn decoded(&mut self) -> Result<Plane<2>, Problem> {
        let reader = match &mut self.reader {
            Some(reader) => reader,
            None => {
                let mut reader = open(&self.file, &self.options)?;
                if reader.info().frame_control.is_none() {
                    let len = reader.output_buffer_size().unwrap_or(usize::MAX);
                    reader.next_frame(&mut zeros(len)?).map_err(complaint)?;
                }
                self.reader.insert(reader)
            }
        };
        if let Some((part, how, before)) = self.last.take() {
            match how {
                DisposeOp::None => {}
                DisposeOp::Background => self.canvas.clear(part),
                // There was nothing before the first one.
                DisposeOp::Previous if self.at == 1 => self.canvas.clear(part),
                DisposeOp::Previous => self.canvas.samples = before,
            }
        }
        let mut bytes = zeros(reader.output_buffer_size().unwrap_or(usize::MAX))?;
        reader.next_frame(&mut bytes).map_err(complaint)?;
        let control =
            *reader.info().frame_control().ok_or_else(|| Problem::damaged(Format::Png, "a frame without place"))?;
        if self.at + 1 == self.frames {
            reader.finish().map_err(complaint)?;
        }
        let part = self.part(&control)?;
        let before = match control.dispose_op {
            DisposeOp::Previous => copied(&self.canvas.samples)?,
            _ => Vec::new(),
        };
        let rows = self.rows(part, &bytes)?;
        let over = control.blend_op == BlendOp::Over && self.header.alpha;
        self.canvas.lay(part, &rows, over);
        self.last = Some((part, control.dispose_op, before));
        self.at += 1;
        self.plane()
    }

    /// Where a frame lies; the decoder has checked that it is inside.
    fn part(&self, control: &FrameControl) -> Result<Part, Problem> {
        let FrameControl { width, height, x_offset, y_offset, .. } = *control;
        let fits = |at: u32, side: u32, whole: u64| 0 < side && u64::from(at) + u64::from(side) <= whole;
        if !fits(x_offset, width, self.header.width) || !fits(y_offset, height, self.header.height) {
            return Err(Problem::damaged(Format::Png, "a frame lies outside"));
        }
        Ok(Part { at: [x_offset, y_offset].map(|v| v as usize), size: [width, height].map(|v| v as usize) })
    }

    /// The rows of a part, each sample wide.
    fn rows(&self, part: Part, bytes: &[u8]) -> Result<Vec<u16>, Problem> {
        let (wide, [width, height]) = (usize::from(self.header.depth == Depth::U16) + 1, part.size);
        let row = width * self.header.channels * wide;
        // Rows of interlaced parts lie as far apart as those of the whole picture.
        let stride = if self.interlaced { self.canvas.width * self.header.channels * wide } else { row };
        let mut rows = Vec::new();
        selvedge_core::reserve(&mut rows, width * height * self.header.channels)?;
        for row in bytes.chunks(stride.max(1)).take(height).map(|all| &all[..row]) {
            if wide == 1 {
                rows.extend(row.iter().map(|v| u16::from(*v)));
            } else {
                rows.extend(row.as_chunks::<2>().0.iter().map(|v| u16::from_be_bytes(*v)));
            }
        }
        Ok(rows)
    }

    fn plane(&self) -> Result<Plane<2>, Problem> {
        let domain = self.header.domain();
        let wide = selvedge_core::Grid::from_interleaved(domain, self.header.channels, &self.canvas.samples)?;
        let samples = match self.header.depth {
            Depth::U8 => Samples::U8(wide.map(|v| v as u8)?),
            _ => Samples::U16(wide),
        };
        let alpha = self.header.alpha;
        Ok(Plane { role: self.options.role, samples, alpha, association: Association::Straight })
    }
}

impl Frames for Apng {
    fn next(&mut self) -> Result<Option<Plane<2>>, Error> {
        let decoded = guarded(Format::Png, || self.decoded());
        decoded.map(Some).map_err(|p| Error::new(&self.path, p))
    }

    fn rewind(&mut self) -> Result<(), Error> {
        (self.reader, self.last, self.at) = (None, None, 0);
        self.canvas.samples.fill(0);
        Ok(())
    }

    fn blake3(&self) -> String {
        blake3::hash(&self.file).to_hex().to_string()
    }

    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
}

fn copied(samples: &[u16]) -> Result<Vec<u16>, Problem> {
    let mut copy = try_vec(samples.len(), 0)?;
    copy.copy_from_slice(samples);
    Ok(copy)
}

/// The claimed size is checked before anything is made for it.
fn open(file: &Arc<[u8]>, options: &ReadOptions) -> Result<Reader<File>, Problem> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(file.clone()), Limits { bytes: METADATA_BYTES });
    let info = decoder.read_header_info().map_err(complaint)?;
    Context::new(options, file.len() as u64).check(&header(info))?;
    decoder.set_transformations(Transformations::EXPAND);
    let reader = decoder.read_info().map_err(complaint)?;
    debug_assert!(matches!(reader.output_color_type().1, BitDepth::Eight | BitDepth::Sixteen));
    Ok(reader)
}

/// How long the frames are shown: what stands in the frames' own chunks, up to the end.
fn delays(file: &[u8]) -> Result<Delays, Problem> {
    let (mut at, mut delays) = (8, Delays::default());
    loop {
        let ends = || Problem::ends_early(Format::Png);
        let head: &[u8; 8] = file.get(at..).and_then(|rest| rest.first_chunk()).ok_or_else(ends)?;
        let [l3, l2, l1, l0, kind @ ..] = *head;
        let len = u32::from_be_bytes([l3, l2, l1, l0]) as usize;
        let data = file.get(at + 8..).and_then(|rest| rest.get(..len)).ok_or_else(ends)?;
        match &kind {
            b"fcTL" => {
                let word = |at: usize| data.get(at..at + 2).map_or(0, |w| u64::from(u16::from_be_bytes([w[0], w[1]])));
                // A denominator of 0 stands for hundredths.
                let (num, den) = (word(20), if word(22) == 0 { 100 } else { word(22) });
                delays.add(num * TICKS / den);
            }
            b"IEND" if at + 12 <= file.len() => return Ok(delays),
            _ => {}
        }
        at = at + 12 + len;
    }
}
