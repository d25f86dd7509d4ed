//! Writing: from a plane to bytes or a file.

use std::path::Path;

use selvedge_core::Plane;

use crate::atomic::write_bytes;
use crate::error::{Error, Problem};
use crate::metadata::Metadata;
use crate::{Format, png};

/// How to write a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WriteOptions {
    /// The format, or `None` to follow the name's extension. Default: `None`.
    pub format: Option<Format>,
    /// Refuses to replace a file. Default: off.
    pub no_clobber: bool,
}

impl WriteOptions {
    /// The format in which a file of this name would be written.
    ///
    /// # Errors
    /// [`Problem::UnknownFormat`].
    pub fn format_of(&self, path: impl AsRef<Path>) -> Result<Format, Error> {
        let path = path.as_ref();
        self.format.or_else(|| Format::of_name(path)).ok_or_else(|| {
            let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            Error::new(path, Problem::UnknownFormat { extension })
        })
    }
}

/// Writes a picture file, whole or not at all: on failure the old file, or none, is left.
///
/// # Errors
/// [`Error`] with the file, the numbers and a remedy.
pub fn write(
    path: impl AsRef<Path>,
    plane: &Plane<2>,
    metadata: &Metadata,
    options: &WriteOptions,
) -> Result<(), Error> {
    let path = path.as_ref();
    let bytes = encode(plane, metadata, path, options)?;
    write_bytes(path, &bytes, options.no_clobber)
}

/// The bytes of a picture file. `name` stands in errors, and decides the format unless the options do. Equal planes
/// and metadata give equal bytes.
///
/// # Errors
/// [`Error`] with the name, the numbers and a remedy.
pub fn encode(
    plane: &Plane<2>,
    metadata: &Metadata,
    name: impl AsRef<Path>,
    options: &WriteOptions,
) -> Result<Vec<u8>, Error> {
    let name = name.as_ref();
    let format = options.format_of(name)?;
    let encoded = match format {
        Format::Png => png::encode(plane, metadata),
    };
    encoded.map_err(|p| Error::new(name, p))
}
