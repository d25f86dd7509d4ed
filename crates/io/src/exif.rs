//! The few EXIF tags that concern us: orientation, density, colours, software. An EXIF block is a small TIFF file.

use crate::metadata::{Density, DensityUnit, Metadata};
use crate::provenance::Provenance;

const ORIENTATION: u16 = 274;
const X_RESOLUTION: u16 = 282;
const Y_RESOLUTION: u16 = 283;
const RESOLUTION_UNIT: u16 = 296;
const SOFTWARE: u16 = 305;
const WHITE: u16 = 318;
const PRIMARIES: u16 = 319;
/// The type of a value that is two whole numbers.
const RATIO: u16 = 5;
/// Where two more directories begin: of the picture, and of what it may be exchanged with.
const PICTURE: u16 = 0x8769;
const EXCHANGE: u16 = 0xa005;
const GAMMA: u16 = 0xa500;
/// `R03` is Adobe RGB, for which a picture's own colour space has no number [DCF 2.0].
const RULE: u16 = 1;
const ADOBE_RGB: [f64; 8] = [0.3127, 0.329, 0.64, 0.33, 0.21, 0.71, 0.15, 0.06];
/// In several pictures in one file: how many there are [CIPA DC-007].
const PICTURES: u16 = 0xb001;

/// What a block says; missing and broken tags are left out, since a picture is fine without them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Exif {
    /// 1..=8; see [`orient`](crate::samples::orient).
    pub(crate) orientation: Option<u8>,
    pub(crate) density: Option<Density>,
    pub(crate) software: Option<String>,
    /// White, red, green and blue.
    pub(crate) chromaticities: Option<[f64; 8]>,
    /// The exponent that makes light of samples.
    pub(crate) gamma: Option<f64>,
}

impl Exif {
    /// Reads a block, with or without the `Exif\0\0` of JPEG before it.
    pub(crate) fn parse(block: &[u8]) -> Self {
        Block::new(block.strip_prefix(b"Exif\0\0").unwrap_or(block)).and_then(Block::tags).unwrap_or_default()
    }

    /// Fills what the format itself does not say.
    pub(crate) fn complete(self, metadata: &mut Metadata) {
        metadata.density = metadata.density.or(self.density);
        if metadata.icc.is_none() && metadata.cicp.is_none() && metadata.srgb.is_none() {
            metadata.chromaticities = metadata.chromaticities.or(self.chromaticities);
            metadata.gamma = metadata.gamma.or(self.gamma.and_then(encoding));
        }
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

/// Colours of a white, that of daylight if it is not told, and of primaries.
pub(crate) fn chromaticities(white: Option<[f64; 2]>, primaries: Option<[f64; 6]>) -> Option<[f64; 8]> {
    let all = [white.unwrap_or([0.3127, 0.329]).as_slice(), &primaries?].concat();
    all.iter().all(|v| (0.0..=1.0).contains(v)).then(|| all.try_into().expect("two and six"))
}

/// PNG's gamma of an exponent that makes light of samples; `None` for what is none.
pub(crate) fn encoding(exponent: f64) -> Option<u32> {
    (0.01..100.0).contains(&exponent).then(|| (100_000.0 / exponent).round() as u32)
}

/// How many pictures a file holds, as its block about them says.
pub(crate) fn pictures(block: &[u8]) -> u32 {
    let count = || {
        let block = Block::new(block)?;
        let mut all = block.entries(block.u32(4)? as usize)?;
        all.find(|(tag, _)| *tag == PICTURES).and_then(|(_, entry)| block.u32(entry + 8))
    };
    count().unwrap_or(1)
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

    /// The entries of a directory, by tag.
    fn entries(self, directory: usize) -> Option<impl Iterator<Item = (u16, usize)> + 'a> {
        let count = usize::from(self.u16(directory)?);
        let places = (0..count).map_while(move |i| directory.checked_add(2 + 12 * i));
        Some(places.map_while(move |entry| Some((self.u16(entry)?, entry))))
    }

    /// The tags of the first directory, and of those that it leads to.
    fn tags(self) -> Option<Exif> {
        let (mut found, mut x, mut y, mut code) = (Exif::default(), None, None, 2);
        let (mut white, mut primaries) = (None, None);
        for (tag, entry) in self.entries(self.u32(4)? as usize)? {
            match tag {
                ORIENTATION => found.orientation = self.u16(entry + 8).and_then(|o| o.try_into().ok()),
                X_RESOLUTION => x = self.rational(entry, 0),
                Y_RESOLUTION => y = self.rational(entry, 0),
                RESOLUTION_UNIT => code = self.u16(entry + 8).unwrap_or(code),
                SOFTWARE => found.software = self.text(entry),
                WHITE => white = self.rationals::<2>(entry),
                PRIMARIES => primaries = self.rationals::<6>(entry),
                PICTURE => self.colours(entry, &mut found).unwrap_or_default(),
                _ => {}
            }
        }
        found.density = x.zip(y).map(|(x, y)| Density { x, y, unit: unit(code) });
        found.chromaticities = chromaticities(white, primaries).or(found.chromaticities);
        Some(found)
    }

    /// What the directory of the picture says of its colours.
    fn colours(self, entry: usize, found: &mut Exif) -> Option<()> {
        for (tag, entry) in self.entries(self.u32(entry + 8)? as usize)? {
            match tag {
                GAMMA => found.gamma = self.rational(entry, 0),
                EXCHANGE => {
                    let mut all = self.entries(self.u32(entry + 8)? as usize)?;
                    let rule = all.find(|(tag, _)| *tag == RULE).and_then(|(_, entry)| self.text(entry));
                    found.chromaticities = rule.filter(|rule| rule == "R03").map(|_| ADOBE_RGB);
                }
                _ => {}
            }
        }
        Some(())
    }

    fn rationals<const N: usize>(self, entry: usize) -> Option<[f64; N]> {
        let all: Option<Vec<f64>> = (0..N).map(|i| self.rational(entry, i)).collect();
        all?.try_into().ok()
    }

    /// One of the ratios that an entry leads to.
    fn rational(self, entry: usize, i: usize) -> Option<f64> {
        let at = (self.u32(entry + 8)? as usize).checked_add(8 * i).filter(|_| self.u16(entry + 2) == Some(RATIO))?;
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
