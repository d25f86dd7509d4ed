//! Writing animated PNG.

use std::cell::RefCell;
use std::io::{self, Write};
use std::rc::Rc;

use png::{Encoder, Writer};
use selvedge_core::{Plane, Samples};

use crate::clip::info::FrameEncoder;
use crate::clip::rate::Rate;
use crate::error::Problem;
use crate::png::info_of;
use crate::sink::Sink;
use crate::{Format, Metadata};

/// A file in memory that its writer shares with us.
#[derive(Clone, Default)]
struct Shared(Rc<RefCell<Sink>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// An animation that grows by frames.
pub(in crate::clip) struct ApngWriter {
    file: Shared,
    /// `None` before the first frame.
    writer: Option<Writer<Shared>>,
    metadata: Metadata,
    /// Frames announced, and taken.
    frames: u32,
    taken: u32,
    rate: Rate,
}

impl ApngWriter {
    pub(in crate::clip) fn new(frames: u32, rate: Rate, metadata: Metadata) -> Self {
        Self { file: Shared::default(), writer: None, metadata, frames, taken: 0, rate }
    }

    fn begin(&self, plane: &Plane<2>) -> Result<Writer<Shared>, Problem> {
        let info = info_of(plane, &self.metadata)?;
        let mut encoder = Encoder::with_info(self.file.clone(), info).map_err(complaint)?;
        encoder.set_animated(self.frames, 0).map_err(complaint)?;
        // The fastest levels make animations twice as large.
        encoder.set_compression(png::Compression::Balanced);
        let (num, den) = halved(self.rate.den(), self.rate.num());
        encoder.set_frame_delay(num, den).map_err(complaint)?;
        if let Some(made) = &self.metadata.provenance {
            encoder.add_itxt_chunk(crate::png::KEYWORD.to_owned(), made.to_string()).map_err(complaint)?;
        }
        encoder.write_header().map_err(complaint)
    }
}

impl FrameEncoder for ApngWriter {
    fn frame(&mut self, plane: &Plane<2>) -> Result<(), Problem> {
        let mut writer = match self.writer.take() {
            Some(writer) => writer,
            None => self.begin(plane)?,
        };
        let bytes = match &plane.samples {
            Samples::U8(grid) => grid.to_interleaved()?,
            Samples::U16(grid) => grid.to_interleaved()?.into_iter().flat_map(u16::to_be_bytes).collect(),
            floats => return Err(Problem::DepthNotHeld { format: Format::Png, depth: floats.depth() }),
        };
        self.file.0.borrow_mut().ask_for(2 * bytes.len()).map_err(|e| Problem::file_system(e, bytes.len() as u64))?;
        writer.write_image_data(&bytes).map_err(complaint)?;
        (self.writer, self.taken) = (Some(writer), self.taken + 1);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Vec<u8>, Problem> {
        if let Some(writer) = self.writer {
            writer.finish().map_err(complaint)?;
        }
        let sink = Rc::try_unwrap(self.file.0).map_err(|_| Problem::encoder(Format::Png, "its file is in use"))?;
        let mut bytes = sink.into_inner().into_bytes();
        if self.taken < self.frames {
            recount(&mut bytes, self.taken);
        }
        Ok(bytes)
    }
}

/// Writes another number of frames into the chunk that announces them, which comes before all that have pixels.
fn recount(file: &mut [u8], frames: u32) {
    let Some(at) = file.windows(4).position(|name| name == b"acTL") else { return };
    // Name, frames, plays, and the sum over these.
    if let Some(chunk) = file.get_mut(at..at + 16) {
        chunk[4..8].copy_from_slice(&frames.to_be_bytes());
        let sum = crc(&chunk[..12]);
        chunk[12..].copy_from_slice(&sum.to_be_bytes());
    }
}

/// The sum of a chunk.
fn crc(bytes: &[u8]) -> u32 {
    let bit = |sum: u32, _| if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 };
    !bytes.iter().fold(!0, |sum, &byte| (0..8).fold(sum ^ u32::from(byte), bit))
}

/// A fraction whose parts have 16 bits.
fn halved(mut num: u32, mut den: u32) -> (u16, u16) {
    while u32::from(u16::MAX) < num.max(den) {
        (num, den) = (num / 2, den / 2);
    }
    (num as u16, den.max(1) as u16)
}

fn complaint(error: png::EncodingError) -> Problem {
    match error {
        png::EncodingError::IoError(e) => Problem::file_system(e, 0),
        other => Problem::encoder(Format::Png, other),
    }
}
