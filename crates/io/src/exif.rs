//! The few EXIF tags that concern us: orientation, density, software. An EXIF block is a small TIFF file.

use crate::metadata::{Density, DensityUnit, Metadata};
use crate::provenance::Provenance;

const ORIENTATION: u16 = 274;
const X_RESOLUTION: u16 = 282;
const Y_RESOLUTION: u16 = 283;
const RESOLUTION_UNIT: u16 = 296;
const SOFTWARE: u16 = 305;

/// What a block says; missing and broken tags are left out, since a picture is fine without them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Exif {
    /// 1..=8; see [`orient`](crate::samples::orient).
    pub(crate) orientation: Option<u8>,
    pub(crate) density: Option<Density>,
    pub(crate) software: Option<String>,
}

impl Exif {
    /// Reads a block, with or without the `Exif\0\0` of JPEG before it.
    pub(crate) fn parse(block: &[u8]) -> Self {
        Block::new(block.strip_prefix(b"Exif\0\0").unwrap_or(block)).and_then(Block::tags).unwrap_or_default()
    }

    /// Fills what the format itself does not say.
    pub(crate) fn complete(self, metadata: &mut Metadata) {
        metadata.density = metadata.density.or(self.density);
        let parsed = self.software.as_deref().and_then(Provenance::parse);
        metadata.provenance = metadata.provenance.take().or(parsed);
    }
}

/// The unit of TIFF's and EXIF's resolutions.
pub(crate) fn unit(code: u16) -> DensityUnit {
    match code {
        1 => DensityUnit::Aspect,
        3 => DensityUnit::Centimetre,
        _ => DensityUnit::Inch,
    }
}

/// A block that names the software; `None` if there is no provenance.
pub(crate) fn software(metadata: &Metadata) -> Option<Vec<u8>> {
    let mut text = metadata.provenance.as_ref()?.to_string().into_bytes();
    // Values of up to four bytes would have to stand in the entry; ours are longer.
    text.push(0);
    let mut block = b"II\x2a\0\x08\0\0\0\x01\0".to_vec();
    block.extend(SOFTWARE.to_le_bytes());
    block.extend(2_u16.to_le_bytes());
    block.extend((text.len() as u32).to_le_bytes());
    block.extend(26_u32.to_le_bytes());
    block.extend([0; 4]);
    block.extend(text);
    Some(block)
}

#[derive(Clone, Copy)]
struct Block<'a> {
    bytes: &'a [u8],
    little: bool,
}

impl<'a> Block<'a> {
    fn new(bytes: &'a [u8]) -> Option<Self> {
        let little = match bytes.get(..4)? {
            b"II\x2a\0" => true,
            b"MM\0\x2a" => false,
            _ => return None,
        };
        Some(Self { bytes, little })
    }

    fn u16(self, at: usize) -> Option<u16> {
        let bytes = self.bytes.get(at..)?.first_chunk()?;
        Some(if self.little { u16::from_le_bytes(*bytes) } else { u16::from_be_bytes(*bytes) })
    }

    fn u32(self, at: usize) -> Option<u32> {
        let bytes = self.bytes.get(at..)?.first_chunk()?;
        Some(if self.little { u32::from_le_bytes(*bytes) } else { u32::from_be_bytes(*bytes) })
    }

    /// The tags of the first directory.
    fn tags(self) -> Option<Exif> {
        let directory = self.u32(4)? as usize;
        let entries = usize::from(self.u16(directory)?);
        let (mut found, mut x, mut y, mut code) = (Exif::default(), None, None, 2);
        for entry in (0..entries).map(|i| directory + 2 + 12 * i) {
            let Some(tag) = self.u16(entry) else { break };
            match tag {
                ORIENTATION => found.orientation = self.u16(entry + 8).and_then(|o| o.try_into().ok()),
                X_RESOLUTION => x = self.rational(entry),
                Y_RESOLUTION => y = self.rational(entry),
                RESOLUTION_UNIT => code = self.u16(entry + 8).unwrap_or(code),
                SOFTWARE => found.software = self.text(entry),
                _ => {}
            }
        }
        found.density = x.zip(y).map(|(x, y)| Density { x, y, unit: unit(code) });
        Some(found)
    }

    fn rational(self, entry: usize) -> Option<f64> {
        let at = self.u32(entry + 8)? as usize;
        let (n, d) = (self.u32(at)?, self.u32(at.checked_add(4)?)?);
        (d != 0).then(|| f64::from(n) / f64::from(d))
    }

    fn text(self, entry: usize) -> Option<String> {
        let len = self.u32(entry + 4)? as usize;
        let at = if len <= 4 { entry + 8 } else { self.u32(entry + 8)? as usize };
        let bytes = self.bytes.get(at..at.checked_add(len)?)?;
        Some(std::str::from_utf8(bytes).ok()?.trim_end_matches('\0').to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described() -> Metadata {
        let provenance = Provenance { version: "1".into(), command: "é".into(), ..Provenance::default() };
        Metadata { provenance: Some(provenance), ..Metadata::default() }
    }

    #[test]
    fn software_is_read_again() {
        let block = software(&described()).unwrap();
        let mut found = Metadata::default();
        Exif::parse(&block).complete(&mut found);
        assert_eq!(found, described());
        assert_eq!(software(&Metadata::default()), None);
    }

    #[test]
    fn no_cut_and_no_flip_panics() {
        let block = software(&described()).unwrap();
        for end in 0..block.len() {
            Exif::parse(&block[..end]);
        }
        for at in 0..block.len() {
            for value in [0, 1, 127, 255] {
                let mut other = block.clone();
                other[at] = value;
                Exif::parse(&other);
            }
        }
    }

    #[test]
    fn big_endian_orientation_and_density() {
        let mut block = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x04".to_vec();
        block.extend(b"\x01\x12\0\x03\0\0\0\x01\0\x06\0\0");
        block.extend(b"\x01\x1a\0\x05\0\0\0\x01\0\0\0\x3e");
        block.extend(b"\x01\x1b\0\x05\0\0\0\x01\0\0\0\x3e");
        block.extend(b"\x01\x28\0\x03\0\0\0\x01\0\x03\0\0\0\0\0\0");
        block.extend(b"\0\0\0\x60\0\0\0\x02");
        let found = Exif::parse(&block);
        assert_eq!(found.orientation, Some(6));
        assert_eq!(found.density, Some(Density { x: 48.0, y: 48.0, unit: DensityUnit::Centimetre }));
    }
}
