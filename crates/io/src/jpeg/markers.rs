//! Segments between markers, and what they say besides the picture [B.1.1].

use std::io::Read;

use super::frame::Frame;
use super::picture::Colors;
use super::{damaged, unsupported};
use crate::Warning;
use crate::codec::{Context, Input, METADATA_BYTES};
use crate::error::Problem;
use crate::exif::{Exif, pictures};
use crate::metadata::{Density, DensityUnit, Metadata};

pub(super) const FRAME_TABLES: [u8; 3] = [0xc4, 0xdb, 0xdd];
pub(super) const SCAN: u8 = 0xda;
pub(super) const END: u8 = 0xd9;

/// Walks from marker to marker.
pub(super) struct Segments<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
}

impl<'a> Segments<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 2 }
    }

    /// The next marker with its segment; `None` where the file ends. Whatever stands between is passed over.
    pub(super) fn next(&mut self) -> Option<(u8, &'a [u8])> {
        loop {
            self.at += self.bytes.get(self.at..)?.iter().position(|b| *b == 0xff)?;
            let marker = *self.bytes.get(self.at + 1)?;
            match marker {
                0xff => self.at += 1,
                0x00 | 0x01 | 0xd0..=0xd8 => self.at += 2,
                END => {
                    self.at += 2;
                    return Some((marker, &[]));
                }
                _ => {
                    let len = usize::from(u16::from_be_bytes(*self.bytes.get(self.at + 2..)?.first_chunk()?)).max(2);
                    let segment = self.bytes.get(self.at + 4..self.at + 2 + len)?;
                    self.at += 2 + len;
                    return Some((marker, segment));
                }
            }
        }
    }
}

/// The bytes up to the first scan, read one segment after the other.
pub(super) fn head(input: &mut dyn Input) -> Result<Vec<u8>, Problem> {
    let wrong = |e| Problem::file_system(e, 0);
    let mut bytes = Vec::new();
    loop {
        let mut segments = Segments::new(&bytes);
        let mut seen = 2;
        while let Some((marker, _)) = segments.next() {
            if marker == SCAN || marker == END {
                return Ok(bytes);
            }
            seen = segments.at;
        }
        // What follows a whole segment: marker and length, then as much as the length says.
        let missing = match bytes.get(seen..) {
            Some([0xff, marker, high, low, rest @ ..]) if !matches!(marker, 0 | 1 | 0xd0..=0xd8 | 0xff) => {
                usize::from(u16::from_be_bytes([*high, *low])).max(2) - 2 - rest.len()
            }
            _ => 4,
        };
        if 2 * METADATA_BYTES < bytes.len() {
            return Err(unsupported("metadata over 32 MiB"));
        }
        if Read::take(&mut *input, missing.max(1) as u64).read_to_end(&mut bytes).map_err(wrong)? == 0 {
            return Ok(bytes);
        }
    }
}

/// What application segments say.
#[derive(Default)]
pub(super) struct Notes {
    density: Option<Density>,
    jfif: bool,
    /// How Adobe's programs say that colours are stored.
    transform: Option<u8>,
    exif: Option<Exif>,
    /// Pictures in the file.
    pictures: u32,
    /// Parts of the profile by their number, and how many there should be.
    profile: Vec<(u8, u8, Vec<u8>)>,
}

impl Notes {
    pub(super) fn segment(&mut self, marker: u8, segment: &[u8]) {
        match (marker, segment) {
            (0xe0, [b'J', b'F', b'I', b'F', 0, rest @ ..]) => {
                self.jfif = true;
                if let [_, _, unit, x1, x0, y1, y0, ..] = rest {
                    let unit = match unit {
                        1 => DensityUnit::Inch,
                        2 => DensityUnit::Centimetre,
                        _ => DensityUnit::Aspect,
                    };
                    let [x, y] = [[*x1, *x0], [*y1, *y0]].map(|b| f64::from(u16::from_be_bytes(b)));
                    self.density = (0.0 < x && 0.0 < y).then_some(Density { x, y, unit });
                }
            }
            (0xe1, [b'E', b'x', b'i', b'f', 0, 0, ..]) => self.exif = self.exif.take().or(Some(Exif::parse(segment))),
            (0xe2, [b'M', b'P', b'F', 0, block @ ..]) => self.pictures = pictures(block),
            (0xe2, [b'I', b'C', b'C', b'_', b'P', b'R', b'O', b'F', b'I', b'L', b'E', 0, place, count, rest @ ..]) => {
                self.profile.push((*place, *count, rest.to_vec()));
            }
            (0xee, [b'A', b'd', b'o', b'b', b'e', _, _, _, _, _, _, transform, ..]) => {
                self.transform = Some(*transform)
            }
            _ => {}
        }
    }

    /// How the components become channels: what Adobe's segment says, else JFIF, else the components' names.
    pub(super) fn colors(&self, frame: &Frame) -> Result<Colors, Problem> {
        let ids: Vec<u8> = frame.components.iter().map(|c| c.id).collect();
        Ok(match (ids.len(), self.transform) {
            (1, _) => Colors::AsStored,
            (3, _) if self.jfif => Colors::YCbCr,
            (3, Some(0)) => Colors::AsStored,
            (3, None) if ids == *b"RGB" => Colors::AsStored,
            (3, _) => Colors::YCbCr,
            (4, Some(2)) => Colors::Ycck,
            (4, _) => Colors::Cmyk,
            _ => return Err(damaged("an impossible number of components")),
        })
    }

    /// Orientation and metadata.
    pub(super) fn complete(self, colors: Colors, context: &mut Context<'_>) -> (u8, Metadata) {
        let mut metadata = Metadata { density: self.density, ..Metadata::default() };
        let has_profile = !self.profile.is_empty();
        metadata.icc = whole(self.profile);
        if has_profile && metadata.icc.is_none() {
            context.warn(Warning::ProfileLeftOut);
        }
        let exif = self.exif.unwrap_or_default();
        let orientation = exif.orientation.unwrap_or(1);
        exif.complete(&mut metadata);
        if 1 < self.pictures {
            context.warn(Warning::FirstPictureOnly);
        }
        if matches!(colors, Colors::Cmyk | Colors::Ycck) {
            context.warn(Warning::CmykConverted);
            // The profile is one for CMYK.
            metadata.icc = None;
        }
        (orientation, metadata)
    }
}

/// The profile of its parts; `None` if one is missing or there twice.
fn whole(mut parts: Vec<(u8, u8, Vec<u8>)>) -> Option<Vec<u8>> {
    parts.sort_by_key(|part| part.0);
    let n = parts.len();
    let in_order = (1..).zip(&parts).all(|(place, part)| part.0 as usize == place && usize::from(part.1) == n);
    let profile: Vec<u8> = parts.into_iter().flat_map(|part| part.2).collect();
    (in_order && (1..=METADATA_BYTES).contains(&profile.len())).then_some(profile)
}
