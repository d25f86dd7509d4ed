//! Channels that were chosen by their numbers, such as those beside colour and alpha. The decoder gives no others of
//! an RGB picture, so it is shown all as channels that are nothing in particular.

use selvedge_core::Association;

use super::channels::{association, picked};
use super::directory::{Directory, EXTRA_SAMPLES, PHOTOMETRIC, SAMPLES};
use crate::Format;
use crate::codec::Decoded;
use crate::error::Problem;

/// What it is for RGB, and for white and black that is no colour.
const RGB: u64 = 2;
const GREY: u16 = 1;

/// Channels of a picture.
pub(super) struct Chosen {
    /// From 0.
    channels: Vec<usize>,
    /// How the last one and the others go together, if it is alpha.
    alpha: Option<Association>,
    /// Bytes of the file, which is held once more.
    len: u64,
}

impl Chosen {
    /// Channels by numbers from 1, as `1,2,3`, and the file with all of them.
    pub(super) fn of(mut file: Vec<u8>, wanted: &str) -> Result<(Self, Vec<u8>), Problem> {
        let directory = Directory::of(&file)?;
        let number = |tag| directory.first(&file, tag);
        let (all, photometric) = (number(SAMPLES).unwrap_or(1), number(PHOTOMETRIC).unwrap_or(1));
        let colors = match photometric {
            0 | 1 => 1,
            RGB => 3,
            _ => return Err(Problem::unsupported(Format::Tiff, "choosing channels of palettes, cmyk and luma")),
        };
        let missing = || Problem::NoChannel {
            wanted: format!("channels '{wanted}'"),
            found: (1..=all.min(64)).map(|c| c.to_string()).collect::<Vec<_>>().join(", "),
        };
        let one = |text: &str| text.trim().parse().ok().filter(|c| (1..=all).contains(c)).map(|c| c as usize - 1);
        let channels: Option<Vec<usize>> = wanted.split(',').map(one).collect();
        let channels = channels.ok_or_else(missing)?;
        let kinds = directory.numbers(&file, EXTRA_SAMPLES).unwrap_or_default();
        let last = channels.last().and_then(|last| kinds.get(last.checked_sub(colors)?));
        let alpha = last.filter(|_| 1 < channels.len()).and_then(|kind| association(*kind));
        if photometric == RGB {
            directory.set(&mut file, PHOTOMETRIC, GREY);
        }
        Ok((Self { channels, alpha, len: file.len() as u64 }, file))
    }

    /// The header of these channels alone.
    pub(super) fn described(&self, mut all: crate::codec::Description) -> crate::codec::Description {
        all.reading = all.reading.map(|bytes| bytes.saturating_add(all.header.bytes()).saturating_add(self.len));
        all.header.channels = self.channels.len();
        all.header.alpha = self.alpha.is_some();
        all.association = Some(self.alpha.unwrap_or(Association::Straight));
        all
    }

    /// These channels alone.
    pub(super) fn of_all(&self, (description, samples): Decoded) -> Result<Decoded, Problem> {
        let description = self.described(description);
        let picked = picked(&samples, &description.header, &self.channels)?;
        Ok((description, picked))
    }
}
