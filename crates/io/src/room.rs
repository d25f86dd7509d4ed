//! What encoding takes, known before anything is encoded.

use selvedge_core::Bytes;

use crate::png::packing_room;
use crate::{Depth, Format};

impl Format {
    /// An upper bound of what encoding a picture of this height and width takes beside its samples: the file, as if
    /// nothing could be packed, with a quarter by which it grows too far while it is written, and what the encoder
    /// holds. That of PNG follows the number of threads.
    pub fn encoding(self, [height, width]: [u32; 2], channels: usize, depth: Depth) -> Bytes {
        let pixels = Bytes(u64::from(height)) * u64::from(width);
        let row = Bytes(u64::from(width)) * channels as u64 * depth.bytes();
        let picture = row * u64::from(height);
        let grown = |file: Bytes| file + Bytes(file.0 / 4);
        let held = match self {
            Self::Png => grown(picture) + Bytes(packing_room(height as usize, row.0 as usize) as u64),
            // Blocks of 16 rows, as they are and packed.
            Self::Exr => grown(picture) + row * 64,
            // Samples of a pixel beside each other, and what they become.
            Self::Webp => picture + pixels * 8 + grown(picture),
            Self::Hdr => pixels * 12 + grown(pixels * 4),
            // A byte a pixel tells that the next one is another.
            Self::Tga => picture + grown(picture + pixels),
            Self::Tiff | Self::Jpeg | Self::Gif | Self::Bmp => picture + grown(picture),
        };
        held + ENCODER
    }
}

/// What every encoder takes: tables and small buffers.
const ENCODER: Bytes = Bytes(3 << 19);

#[cfg(test)]
mod tests {
    use selvedge_core::{Domain, Grid, Plane, Role, Samples, Seed};

    use super::*;
    use crate::{Metadata, WriteOptions, encode};

    /// Samples that nothing packs.
    fn noise(channels: usize, depth: Depth, shape: [u32; 2]) -> Plane<2> {
        let domain = Domain::open(shape);
        let mut rng = Seed(1).rng();
        let mut word = || rng.below(1 << 15) as u16;
        let n = domain.len() * channels;
        let mut words = || -> Vec<u16> { (0..n).map(|_| word()).collect() };
        let samples = match depth {
            Depth::U8 => {
                let bytes = words().into_iter().map(|v| v as u8).collect();
                Samples::U8(Grid::from_vec(domain, channels, bytes).unwrap())
            }
            Depth::U16 => Samples::U16(Grid::from_vec(domain, channels, words()).unwrap()),
            Depth::F16 => {
                Samples::F16(Grid::from_vec(domain, channels, words().iter().map(|v| v & 0x3bff).collect()).unwrap())
            }
            Depth::F32 => {
                let floats = words().into_iter().map(|v| f32::from(v).sqrt()).collect();
                Samples::F32(Grid::from_vec(domain, channels, floats).unwrap())
            }
        };
        Plane::new(Role::Color, samples)
    }

    #[test]
    fn no_file_is_larger_than_it_was_told() {
        for format in Format::ALL.into_iter().filter(|f| !f.depths().is_empty()) {
            for (depth, channels) in format.depths().iter().flat_map(|&d| [(d, 1), (d, 3)]) {
                let shape = [300, 700];
                let plane = noise(channels, depth, shape);
                let options = WriteOptions { format: Some(format), quality: 100, ..WriteOptions::default() };
                let file = encode(&plane, &Metadata::default(), "a", &options).unwrap();
                let told = format.encoding(shape, channels, depth);
                assert!(Bytes(file.len() as u64) + ENCODER <= told, "{format} {depth:?} {channels}: {}", file.len());
            }
        }
    }
}
