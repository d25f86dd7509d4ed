//! Which codec a format has: a description of the header, the samples, and the file's bytes.

use std::io::Cursor;

use selvedge_core::Plane;

use crate::codec::{Context, Decoded, Description, Input, guarded};
use crate::error::Problem;
use crate::metadata::Metadata;
use crate::{Format, exr, image, jpeg, png, tiff};

/// Reads what stands before the samples.
pub(crate) fn describe(
    format: Format,
    input: &mut dyn Input,
    context: &mut Context<'_>,
) -> Result<Description, Problem> {
    guarded(format, || match format {
        Format::Png => png::describe(input, context),
        Format::Tiff => tiff::describe(input, context),
        Format::Exr => exr::describe(input, context),
        Format::Jpeg => jpeg::describe(input, context),
        Format::Hdr => image::hdr::describe(input, context),
        Format::Webp => image::webp::describe(input, context),
        Format::Gif => image::gif::describe(input, context),
        Format::Bmp => image::bmp::describe(input, context),
        Format::Tga => image::tga::describe(input, context),
    })
}

/// Reads everything.
pub(crate) fn decode(format: Format, file: &[u8], context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let input = &mut Cursor::new(file);
    guarded(format, || match format {
        Format::Png => png::decode(input, context),
        Format::Tiff => tiff::decode(file, context),
        Format::Exr => exr::decode(input, context),
        Format::Jpeg => jpeg::decode(input, context),
        Format::Hdr => image::hdr::decode(input, context),
        Format::Webp => image::webp::decode(input, context),
        Format::Gif => image::gif::decode(file, context),
        Format::Bmp => image::bmp::decode(input, context),
        Format::Tga => image::tga::decode(input, context),
    })
}

/// The whole file.
pub(crate) fn encode(format: Format, plane: &Plane<2>, metadata: &Metadata, quality: u8) -> Result<Vec<u8>, Problem> {
    match format {
        Format::Png => png::encode(plane, metadata),
        Format::Tiff => tiff::encode(plane, metadata),
        Format::Exr => exr::encode(plane, metadata),
        Format::Jpeg => jpeg::encode(plane, metadata, quality),
        Format::Hdr => image::hdr::encode(plane, metadata),
        Format::Webp => image::webp::encode(plane, metadata),
        Format::Tga => image::tga::encode(plane, metadata),
        Format::Gif | Format::Bmp => Err(Problem::UnknownFormat { extension: format.name().to_owned() }),
    }
}
