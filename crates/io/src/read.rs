//! Reading: from a name or bytes to a picture, with every check before the decoding.

use std::any::Any;
use std::fs::File;
use std::io::{BufRead, Cursor, Read as _, Seek};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use selvedge_core::{Limits, Plane, Role, Samples};

use crate::error::{Error, Problem};
use crate::header::Header;
use crate::metadata::Metadata;
use crate::{Format, Warning, png};

/// Metadata of one file may not take more bytes than this, packed or unpacked.
pub(crate) const METADATA_BYTES: usize = 16 << 20;

/// How to read a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// Caps on sides and samples, and the memory that reading may take. Default: 65,535 a side, 2^28 samples, all
    /// the memory there is.
    pub limits: Limits,
    /// What the plane's channels mean; no file says it. Default: colour.
    pub role: Role,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { limits: Limits::default(), role: Role::Color }
    }
}

/// A picture as read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Picture {
    /// The samples, in the depth of the file.
    pub plane: Plane<2>,
    /// What the file says besides.
    pub metadata: Metadata,
    /// The format, by content.
    pub format: Format,
    /// BLAKE3 of the file's bytes, in hexadecimal.
    pub blake3: String,
    /// What was odd, but could be read.
    pub warnings: Vec<Warning>,
}

/// What every decoder is handed: limits in, warnings out.
pub(crate) struct Context<'a> {
    pub(crate) options: &'a ReadOptions,
    pub(crate) file_bytes: u64,
    pub(crate) warnings: Vec<Warning>,
}

impl Context<'_> {
    pub(crate) fn check(&self, header: &Header) -> Result<(), Problem> {
        header.check(&self.options.limits, self.file_bytes)
    }

    pub(crate) fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }
}

/// What every decoder answers.
pub(crate) struct Decoded {
    pub(crate) samples: Samples<2>,
    pub(crate) alpha: bool,
    pub(crate) metadata: Metadata,
}

/// What decoders read from.
pub(crate) trait Input: BufRead + Seek {}
impl<T: BufRead + Seek> Input for T {}

/// Reads a picture file. The format follows its content; sizes are checked before anything is decoded.
///
/// # Errors
/// [`Error`] with the file, the numbers and a remedy.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Picture, Error> {
    let path = path.as_ref();
    let bytes = read_bytes(path, &options.limits).map_err(|p| Error::new(path, p))?;
    decode(&bytes, path, options)
}

/// Reads a picture from the bytes of its file. `name` stands in errors, and its extension is compared with the content.
///
/// # Errors
/// [`Error`] with the name, the numbers and a remedy.
pub fn decode(bytes: &[u8], name: impl AsRef<Path>, options: &ReadOptions) -> Result<Picture, Error> {
    let name = name.as_ref();
    decode_content(bytes, name, options).map_err(|p| Error::new(name, p))
}

fn decode_content(bytes: &[u8], name: &Path, options: &ReadOptions) -> Result<Picture, Problem> {
    let mut context = Context { options, file_bytes: bytes.len() as u64, warnings: Vec::new() };
    let format = format_of(bytes, name, &mut context)?;
    let mut input = Cursor::new(bytes);
    let decoded = guarded(format, || match format {
        Format::Png => png::decode(&mut input, &mut context),
    })?;
    let Decoded { samples, alpha, metadata } = decoded;
    let plane = Plane { role: options.role, samples, alpha };
    let blake3 = blake3::hash(bytes).to_hex().to_string();
    Ok(Picture { plane, metadata, format, blake3, warnings: context.warnings })
}

/// The format by content, with a warning where the name says another one.
fn format_of(start: &[u8], name: &Path, context: &mut Context<'_>) -> Result<Format, Problem> {
    if start.is_empty() {
        return Err(Problem::Empty);
    }
    let content = Format::of_content(start).ok_or(Problem::UnknownContent)?;
    match Format::of_name(name) {
        Some(named) if named != content => context.warn(Warning::Misnamed { content, named }),
        _ => {}
    }
    Ok(content)
}

/// Decoders come from others: should one panic on a damaged file, that is a damaged file and not our end.
fn guarded<T>(format: Format, decode: impl FnOnce() -> Result<T, Problem>) -> Result<T, Problem> {
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|panic| Err(Problem::damaged(format, words(&*panic))))
}

fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!("the decoder gave up: {}", text.unwrap_or("no reason"))
}

/// A regular file's bytes, within the memory budget.
pub(crate) fn read_bytes(path: &Path, limits: &Limits) -> Result<Vec<u8>, Problem> {
    let (mut file, len) = open(path)?;
    if limits.memory < len {
        return Err(Problem::Memory { needed: len, budget: limits.memory });
    }
    let mut bytes = Vec::new();
    let refused = |_| selvedge_core::Error::Allocation { bytes: len };
    bytes.try_reserve_exact(usize::try_from(len).unwrap_or(usize::MAX)).map_err(refused)?;
    // A file that grows while it is read ends where it ended when it was opened.
    file.by_ref().take(len).read_to_end(&mut bytes).map_err(|e| Problem::file_system(e, len))?;
    Ok(bytes)
}

/// Opens a regular file. Looking first keeps pipes and devices from hanging or never ending.
pub(crate) fn open(path: &Path) -> Result<(File, u64), Problem> {
    let wrong = |e| Problem::file_system(e, 0);
    let metadata = std::fs::metadata(path).map_err(wrong)?;
    if metadata.is_dir() {
        return Err(Problem::Folder);
    }
    if !metadata.is_file() {
        return Err(Problem::Special);
    }
    Ok((File::open(path).map_err(wrong)?, metadata.len()))
}
