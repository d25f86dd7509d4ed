//! Pictures as the tests hold them, planes of core, and the PNG files they are kept in.

use std::io::{self, Cursor};

use selvedge_core::{Depth, Domain, Grid, Plane, Role, Samples};

/// An 8-bit plane of one or three channels, planar.
///
/// # Panics
/// If the samples are no whole number of channels.
pub fn plane8(role: Role, width: u32, height: u32, samples: Vec<u8>) -> Plane<2> {
    let (domain, channels) = shape_of(width, height, samples.len());
    Plane::new(role, Samples::U8(Grid::from_vec(domain, channels, samples).expect("whole channels")))
}

/// A 16-bit plane, planar.
///
/// # Panics
/// If the samples are no whole number of channels.
pub fn plane16(role: Role, width: u32, height: u32, samples: Vec<u16>) -> Plane<2> {
    let (domain, channels) = shape_of(width, height, samples.len());
    Plane::new(role, Samples::U16(Grid::from_vec(domain, channels, samples).expect("whole channels")))
}

fn shape_of(width: u32, height: u32, samples: usize) -> (Domain<2>, usize) {
    let domain = Domain::open([height, width]);
    (domain, samples / domain.len().max(1))
}

/// The plane as a PNG file, packed as tightly as the encoder can.
///
/// # Panics
/// If it has floats, more than four channels, or no pixels: a PNG cannot hold it.
pub fn to_png(plane: &Plane<2>) -> Vec<u8> {
    let [height, width] = plane.domain().shape;
    let (depth, bytes) = match &plane.samples {
        Samples::U8(g) => (png::BitDepth::Eight, g.to_interleaved().expect("small")),
        Samples::U16(g) => {
            let wide = g.to_interleaved().expect("small");
            (png::BitDepth::Sixteen, wide.into_iter().flat_map(u16::to_be_bytes).collect())
        }
        other => panic!("a PNG has no samples of {}", other.depth().name()),
    };
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(color_type(plane));
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().expect("a picture of at least one pixel");
    writer.write_image_data(&bytes).expect("as many bytes as pixels");
    writer.finish().expect("writing to memory");
    file
}

/// Reads a PNG of 8 or 16 bits without a palette.
///
/// # Errors
/// What the decoder says, or that the kind of PNG is another.
pub fn from_png(role: Role, file: &[u8]) -> io::Result<Plane<2>> {
    let mut reader = png::Decoder::new(Cursor::new(file)).read_info().map_err(io::Error::other)?;
    let size = reader.output_buffer_size().ok_or_else(|| io::Error::other("too large"))?;
    let mut bytes = vec![0; size];
    let info = reader.next_frame(&mut bytes).map_err(io::Error::other)?;
    let domain = Domain::open([info.height, info.width]);
    let channels = info.color_type.samples();
    let samples = match info.bit_depth {
        png::BitDepth::Eight => Grid::from_interleaved(domain, channels, &bytes).map(Samples::U8),
        png::BitDepth::Sixteen => {
            let wide: Vec<u16> = bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect();
            Grid::from_interleaved(domain, channels, &wide).map(Samples::U16)
        }
        other => return Err(io::Error::other(format!("{other:?} bits a sample"))),
    };
    let alpha = channels.is_multiple_of(2);
    Ok(Plane { alpha, ..Plane::new(role, samples.map_err(io::Error::other)?) })
}

fn color_type(plane: &Plane<2>) -> png::ColorType {
    match (plane.color_channels(), plane.alpha) {
        (1, false) => png::ColorType::Grayscale,
        (1, true) => png::ColorType::GrayscaleAlpha,
        (3, false) => png::ColorType::Rgb,
        (3, true) => png::ColorType::Rgba,
        (n, _) => panic!("a PNG has 1 or 3 colour channels, not {n}"),
    }
}

/// The samples of an 8-bit plane.
///
/// # Panics
/// If it has another depth.
pub fn bytes(plane: &Plane<2>) -> &[u8] {
    match &plane.samples {
        Samples::U8(g) => g.samples(),
        other => panic!("8 bits wanted, {} found", other.depth().name()),
    }
}

/// True if both have the same shape, channels, depth and samples, whatever they mean.
pub fn same_samples(a: &Plane<2>, b: &Plane<2>) -> bool {
    a.alpha == b.alpha && a.samples == b.samples
}

/// Shape, channels and depth in words: `192x128, 3 x u8`.
pub fn describe(plane: &Plane<2>) -> String {
    let [height, width] = plane.domain().shape;
    format!("{width}x{height}, {} x {}", plane.samples.channels(), Depth::name(plane.samples.depth()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_keeps_every_sample() {
        let wide = plane16(Role::Height, 3, 2, vec![0, 1, 255, 256, 4_660, 65_535]);
        assert!(same_samples(&from_png(Role::Height, &to_png(&wide)).expect("our own file"), &wide));
        let color = plane8(Role::Color, 2, 1, vec![1, 2, 3, 4, 5, 6]);
        assert!(same_samples(&from_png(Role::Color, &to_png(&color)).expect("our own file"), &color));
    }

    #[test]
    fn what_is_no_png_is_an_error() {
        assert!(from_png(Role::Color, b"no picture").is_err());
    }
}
