//! What a page says besides its samples. Tags that are missing or broken are left out: the picture is fine without
//! them.

use tiff::decoder::ifd::Value;
use tiff::tags::Tag;

use super::read::Page;
use crate::Warning;
use crate::codec::METADATA_BYTES;
use crate::exif;
use crate::metadata::Density;

/// Tags that the decoder has no names for: curves from samples to light, colours of white and of the primaries, and
/// pictures that lie behind each other in one page.
const TRANSFER: u16 = 301;
const SLICES: u16 = 32_997;
pub(super) const WHITE: u16 = 318;
pub(super) const PRIMARIES: u16 = 319;

impl Page<'_, '_, '_> {
    /// Tells of further pictures, and of what is not followed.
    pub(super) fn tell(&mut self) {
        if self.decoder.more_images() {
            self.context.warn(Warning::FirstPageOnly);
        } else if self.has(Tag::SubIfd) || self.number(Tag::Unknown(SLICES)).is_some_and(|slices| 1 < slices) {
            self.context.warn(Warning::FirstPictureOnly);
        }
        if self.has(Tag::Unknown(TRANSFER)) {
            self.context.warn(Warning::TagUnread { tag: "transfer function" });
        }
    }

    pub(super) fn number(&mut self, tag: Tag) -> Option<u16> {
        self.decoder.find_tag_unsigned(tag).ok().flatten()
    }

    pub(super) fn has(&mut self, tag: Tag) -> bool {
        self.decoder.image_ifd().find_entry(tag).is_some()
    }

    pub(super) fn chromaticities(&mut self) -> Option<[f64; 8]> {
        let (white, primaries) = (self.ratios(Tag::Unknown(WHITE)), self.ratios(Tag::Unknown(PRIMARIES)));
        exif::chromaticities(white, primaries)
    }

    fn ratios<const N: usize>(&mut self, tag: Tag) -> Option<[f64; N]> {
        let Value::List(all) = self.decoder.find_tag(tag).ok()?? else { return None };
        let ratio = |value: &Value| match value {
            Value::Rational(n, d) if *d != 0 => Some(f64::from(*n) / f64::from(*d)),
            _ => None,
        };
        all.iter().map(ratio).collect::<Option<Vec<f64>>>()?.try_into().ok()
    }

    pub(super) fn profile(&mut self) -> Option<Vec<u8>> {
        let found = self.bytes(Tag::IccProfile);
        if found.is_none() && self.has(Tag::IccProfile) {
            self.context.warn(Warning::ProfileLeftOut);
        }
        found
    }

    pub(super) fn bytes(&mut self, tag: Tag) -> Option<Vec<u8>> {
        let mut directory = self.decoder.image_ifd();
        let len = usize::try_from(directory.find_entry(tag)?.count()).ok().filter(|len| *len <= METADATA_BYTES)?;
        let mut bytes = vec![0; len];
        (directory.find_tag_bytes(tag, &mut bytes, 0).ok()?? == len).then_some(bytes)
    }

    pub(super) fn density(&mut self) -> Option<Density> {
        let mut ratio = |tag| match self.decoder.get_tag_u32_vec(tag).ok()?[..] {
            [n, d] if n != 0 && d != 0 => Some(f64::from(n) / f64::from(d)),
            _ => None,
        };
        let (x, y) = (ratio(Tag::XResolution)?, ratio(Tag::YResolution)?);
        let density = Density { x, y, unit: exif::unit(self.number(Tag::ResolutionUnit).unwrap_or(2)) };
        // Writers that know no density write the ratio 1:1.
        (density.per_metre().is_some() || x != y).then_some(density)
    }
}
