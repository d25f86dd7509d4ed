//! What stands behind the samples: the extension area, and the developer's directory of tags [TGA 2.0].

use std::io::SeekFrom;

use crate::codec::{Input, METADATA_BYTES};
use crate::error::Problem;
use crate::provenance::Provenance;

/// Ends a file that has areas after its samples.
pub(super) const SIGNATURE: &[u8; 18] = b"TRUEVISION-XFILE.\0";
/// Bytes of a footer: where the extension and the developer's directory begin, and the signature.
const FOOTER: usize = 4 + 4 + SIGNATURE.len();
/// Our tag in the directory, one of those for anybody.
pub(super) const MADE: u16 = 0x5e1f;
/// Bytes of an extension area, and where in it the gamma and the kind of alpha stand.
const EXTENSION: usize = 495;
const GAMMA: usize = 478;
const ALPHA: usize = 494;

/// What the areas say; what is missing or broken is left out, since a picture is fine without it.
#[derive(Default)]
pub(super) struct Areas {
    /// How the picture was made.
    pub(super) made: Option<Provenance>,
    /// Attributes type: 0 to 2 are no alpha, 3 is straight, 4 premultiplied.
    pub(super) alpha: Option<u8>,
    /// The exponent that makes light of samples.
    pub(super) gamma: Option<f64>,
}

impl Areas {
    /// Leaves the input at its start.
    pub(super) fn of(input: &mut dyn Input) -> Result<Self, Problem> {
        let mut file = File { end: input.seek(SeekFrom::End(0)).map_err(|e| Problem::file_system(e, 0))?, input };
        let areas = file.areas().unwrap_or_default();
        file.input.rewind().map_err(|e| Problem::file_system(e, 0))?;
        Ok(areas)
    }
}

struct File<'a> {
    input: &'a mut dyn Input,
    end: u64,
}

impl File<'_> {
    fn read(&mut self, at: u64, len: usize) -> Option<Vec<u8>> {
        if self.end < at.checked_add(len as u64)? || METADATA_BYTES < len {
            return None;
        }
        let mut bytes = vec![0; len];
        self.input.seek(SeekFrom::Start(at)).ok()?;
        self.input.read_exact(&mut bytes).ok()?;
        Some(bytes)
    }

    fn areas(&mut self) -> Option<Areas> {
        let footer = self.read(self.end.checked_sub(FOOTER as u64)?, FOOTER)?;
        if !footer.ends_with(SIGNATURE) {
            return None;
        }
        let made = self.tagged(number(&footer[4..8]));
        let made = made.and_then(|text| Provenance::parse(std::str::from_utf8(&text).ok()?));
        let extension = Some(number(&footer[..4])).filter(|at| *at != 0);
        let extension = extension.and_then(|at| self.read(at, EXTENSION));
        Some(Areas {
            made,
            alpha: extension.as_ref().map(|area| area[ALPHA]),
            gamma: extension.and_then(|area| exponent(&area[GAMMA..])),
        })
    }

    /// The bytes of our tag.
    fn tagged(&mut self, directory: u64) -> Option<Vec<u8>> {
        if directory == 0 {
            return None;
        }
        let count = number(&self.read(directory, 2)?) as usize;
        let tags = self.read(directory + 2, count * 10)?;
        let tag = tags.chunks_exact(10).find(|tag| number(&tag[..2]) == u64::from(MADE))?;
        self.read(number(&tag[2..6]), number(&tag[6..]) as usize)
    }
}

fn number(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b))
}

/// The format has 1 for what is linear and 2.2 for most pictures; some write the reciprocal, and no picture is encoded
/// the other way around.
fn exponent(ratio: &[u8]) -> Option<f64> {
    let [n, d] = [number(&ratio[..2]), number(&ratio[2..4])].map(|v| v as f64);
    (n != 0.0 && d != 0.0).then(|| (n / d).max(d / n))
}
