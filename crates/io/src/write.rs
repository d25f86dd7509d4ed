//! Writing: from a plane to bytes or a file.

use std::borrow::Cow;
use std::path::Path;

use selvedge_core::{Association, Plane};

use crate::alpha::associate;
use crate::atomic::write_bytes;
use crate::convert::convert;
use crate::error::{Error, Problem};
use crate::image::hdr;
use crate::metadata::Metadata;
use crate::{Depth, Format, Warning, by_format, exr};

/// How to write a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct WriteOptions {
    /// The format, or `None` to follow the name's extension. Default: `None`.
    pub format: Option<Format>,
    /// The depth to [`convert`] to, or `None` to keep the plane's, which the format may not hold. Default: `None`.
    pub depth: Option<Depth>,
    /// JPEG quality, 1..=100. Default: 95.
    pub quality: u8,
    /// Refuses to replace a file. Default: off.
    pub no_clobber: bool,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self { format: None, depth: None, quality: 95, no_clobber: false }
    }
}

impl WriteOptions {
    /// The format in which a file of this name would be written.
    ///
    /// # Errors
    /// [`Problem::UnknownFormat`], [`Problem::Quality`], and [`Problem::DepthNotHeld`] for a chosen depth: what is
    /// wrong before any work.
    pub fn format_of(&self, path: impl AsRef<Path>) -> Result<Format, Error> {
        let path = path.as_ref();
        let known = self.format.or_else(|| Format::of_name(path)).filter(|f| !f.depths().is_empty());
        let Some(format) = known else {
            let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            return Err(Error::new(path, Problem::UnknownFormat { extension }));
        };
        if format == Format::Jpeg && !(1..=100).contains(&self.quality) {
            return Err(Error::new(path, Problem::Quality { quality: self.quality }));
        }
        match self.depth {
            Some(depth) if !format.depths().contains(&depth) => {
                Err(Error::new(path, Problem::DepthNotHeld { format, depth }))
            }
            _ => Ok(format),
        }
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
    encode_as(format, plane, metadata, options).map_err(|p| Error::new(name, p))
}

/// What a file of this format will say otherwise than the picture, or not at all: told before it is written.
pub fn changes(plane: &Plane<2>, metadata: &Metadata, format: Format) -> Vec<Warning> {
    let association = format.association().filter(|a| plane.alpha && *a != plane.association);
    let alpha = association.map(|a| match a {
        Association::Straight => Warning::Divided { format },
        Association::Premultiplied => Warning::Multiplied { format },
    });
    let negative = if format == Format::Hdr { hdr::negative(plane) } else { 0 };
    let negative = (0 < negative).then_some(Warning::Negative { count: negative, format });
    let renamed = (format == Format::Exr).then(|| exr::renamed(plane, metadata)).flatten();
    let renamed = renamed.map(|(from, to)| Warning::Renamed { from, to });
    let tags = metadata.left_out(format, plane.color_channels());
    alpha
        .into_iter()
        .chain(negative)
        .chain(renamed)
        .chain(tags.into_iter().map(|tag| Warning::TagLeftOut { tag, format }))
        .collect()
}

fn encode_as(
    format: Format,
    plane: &Plane<2>,
    metadata: &Metadata,
    options: &WriteOptions,
) -> Result<Vec<u8>, Problem> {
    let from = plane.samples.depth();
    let (mut plane, metadata) = match options.depth {
        Some(to) if to != from => (Cow::Owned(convert(plane, to, metadata)?.plane), metadata.converted(from, to)),
        _ => (Cow::Borrowed(plane), metadata.clone()),
    };
    format.check(plane.domain().shape, plane.color_channels(), plane.alpha, plane.samples.depth())?;
    if let Some(association) = format.association().filter(|a| plane.alpha && *a != plane.association) {
        plane = Cow::Owned(associate(&plane, association)?.plane);
    }
    by_format::encode(format, &plane, &metadata, options.quality)
}
