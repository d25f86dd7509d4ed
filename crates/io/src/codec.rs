//! What every decoder is handed and answers with, whichever its format.

use std::any::Any;
use std::io::{BufRead, Seek};
use std::panic::{AssertUnwindSafe, catch_unwind};

use selvedge_core::{Association, Samples};

use crate::error::Problem;
use crate::header::Header;
use crate::metadata::Metadata;
use crate::options::ReadOptions;
use crate::{Format, Warning};

/// Metadata of one file may not take more bytes than this, packed or unpacked: profiles of a few MiB are the largest
/// that are made, and a file of some bytes must not unpack to gigabytes.
pub(crate) const METADATA_BYTES: usize = 16 << 20;

/// What decoders read from.
pub(crate) trait Input: BufRead + Seek {}
impl<T: BufRead + Seek> Input for T {}

/// What every decoder is handed: options in, warnings out.
pub(crate) struct Context<'a> {
    pub(crate) options: &'a ReadOptions,
    pub(crate) file_bytes: u64,
    pub(crate) warnings: Vec<Warning>,
}

impl<'a> Context<'a> {
    pub(crate) fn new(options: &'a ReadOptions, file_bytes: u64) -> Self {
        Self { options, file_bytes, warnings: Vec::new() }
    }

    /// Every decoder asks before it decodes.
    pub(crate) fn check(&self, header: &Header) -> Result<(), Problem> {
        header.check(&self.options.limits, self.file_bytes)
    }

    /// Asks for what a decoder of others may take for itself and gives it back: it would abort where this fails.
    pub(crate) fn ask(&self, header: &Header) -> Result<(), Problem> {
        // The canvas, a frame, and what both are made of, over some room of its own.
        let bytes = header.bytes().saturating_mul(4).saturating_add(self.file_bytes).saturating_add(8 << 20);
        let asked = Vec::<u8>::new().try_reserve_exact(usize::try_from(bytes).unwrap_or(usize::MAX));
        asked.map_err(|_| selvedge_core::Error::Allocation { bytes }.into())
    }

    pub(crate) fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }
}

/// A file without its samples.
pub(crate) struct Description {
    /// As stored, before it is turned.
    pub(crate) header: Header,
    /// EXIF orientation, 1..=8.
    pub(crate) orientation: u8,
    pub(crate) metadata: Metadata,
    /// How colour and alpha go together, in files that say so.
    pub(crate) association: Option<Association>,
    /// All channels of a file that has names for them.
    pub(crate) channel_names: Vec<String>,
    /// Bytes that reading takes beside the picture, where that is not as usual.
    pub(crate) reading: Option<u64>,
}

impl Description {
    pub(crate) fn new(header: Header, metadata: Metadata) -> Self {
        Self { header, orientation: 1, metadata, association: None, channel_names: Vec::new(), reading: None }
    }
}

/// A file with its samples, as stored.
pub(crate) type Decoded = (Description, Samples<2>);

/// Decoders come from others: should one panic on a damaged file, that is a damaged file and not our end.
pub(crate) fn guarded<T>(format: Format, decode: impl FnOnce() -> Result<T, Problem>) -> Result<T, Problem> {
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|panic| Err(Problem::damaged(format, words(&*panic))))
}

fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!("the decoder gave up: {}", text.unwrap_or("no reason"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_a_decoder_is_a_damaged_file() {
        let caught = guarded::<()>(Format::Png, || panic!("row {}", 7));
        let Err(Problem::Damaged { cause, .. }) = caught else { unreachable!() };
        assert_eq!(cause, "the decoder gave up: row 7");
    }
}
