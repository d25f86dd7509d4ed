//! Looking at a file without decoding its samples.

use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use crate::by_format;
use crate::codec::{Context, Input};
use crate::error::{Error, Problem};
use crate::metadata::Metadata;
use crate::options::ReadOptions;
use crate::read::{format_of, open, split_selector};
use crate::{Association, Depth, Format, Warning};

/// What a file holds, by its header.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Info {
    /// Samples along x, the right way up.
    pub width: u32,
    /// Samples along y, the right way up.
    pub height: u32,
    /// Channels of the picture that [`read()`](crate::read()) would give, alpha included.
    pub channels: usize,
    /// Whether the last channel is alpha.
    pub alpha: bool,
    /// How colour and alpha go together.
    pub association: Association,
    /// How samples are stored.
    pub depth: Depth,
    /// The format, by content.
    pub format: Format,
    /// All channels of an EXR file, `layer.channel`; empty for other formats.
    pub channel_names: Vec<String>,
    /// An upper bound of the bytes that [`read()`](crate::read()) takes beside the samples that it gives: the file, and
    /// what the decoder holds.
    pub reading: u64,
    /// What the file says besides.
    pub metadata: Metadata,
    /// What is odd.
    pub warnings: Vec<Warning>,
}

/// Reads a file's header. Takes the same names and applies the same limits as [`read()`](crate::read()), and does not
/// see damage beyond the header.
///
/// # Errors
/// [`Error`] with the file, the numbers and a remedy.
pub fn probe(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Info, Error> {
    let named = path.as_ref();
    let (path, options) = split_selector(named, options);
    let opened = open(&path).and_then(|(file, len)| describe(&mut BufReader::new(file), len, &path, &options));
    opened.map_err(|p| Error::new(named, p))
}

/// Reads the header of a file from its bytes; see [`probe`].
///
/// # Errors
/// [`Error`] with the name, the numbers and a remedy.
pub fn probe_bytes(bytes: &[u8], name: impl AsRef<Path>, options: &ReadOptions) -> Result<Info, Error> {
    let name = name.as_ref();
    describe(&mut Cursor::new(bytes), bytes.len() as u64, name, options).map_err(|p| Error::new(name, p))
}

fn describe(input: &mut dyn Input, len: u64, name: &Path, options: &ReadOptions) -> Result<Info, Problem> {
    let mut context = Context::new(options, len);
    let mut start = Vec::new();
    Read::take(&mut *input, 18).read_to_end(&mut start).map_err(|e| Problem::file_system(e, len))?;
    input.rewind().map_err(|e| Problem::file_system(e, len))?;
    let format = format_of(&start, name, &mut context)?;
    let found = by_format::describe(format, input, &mut context)?;
    context.check(&found.header)?;
    let (mut width, mut height) = (found.header.width as u32, found.header.height as u32);
    if matches!(found.orientation, 5..=8) {
        (width, height) = (height, width);
    }
    // The file, and samples as the decoder gives them or before they are turned.
    let bytes = found.header.bytes();
    let usual = bytes.saturating_mul(2).max(bytes.saturating_add(len));
    Ok(Info {
        width,
        height,
        channels: found.header.channels,
        alpha: found.header.alpha,
        association: found.association.or(format.association()).unwrap_or_default(),
        depth: found.header.depth,
        format,
        channel_names: found.channel_names,
        reading: found.reading.unwrap_or(usual),
        metadata: found.metadata,
        warnings: context.warnings,
    })
}
