//! Windows bitmaps, read.

use std::io::{Read as _, SeekFrom};

use image::codecs::bmp::BmpDecoder;

use super::complaint;
use crate::codec::{Context, Decoded, Description, Input, METADATA_BYTES};
use crate::error::Problem;
use crate::exif::{chromaticities, encoding};
use crate::{Format, Warning};

pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    let colours = Colours::of(input)?;
    let mut description = super::describe(&mut open(input, context)?, Format::Bmp, context)?;
    colours.complete(&mut description, context);
    Ok(description)
}

pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let colours = Colours::of(input)?;
    let (mut description, samples) = super::decode(open(input, context)?, Format::Bmp, context)?;
    colours.complete(&mut description, context);
    Ok((description, samples))
}

fn open<'a>(input: &'a mut dyn Input, context: &Context<'_>) -> Result<BmpDecoder<&'a mut dyn Input>, Problem> {
    BmpDecoder::new(input).map_err(|e| complaint(e, Format::Bmp, context))
}

/// Bytes before the second header, and of that one in its fourth and fifth version [BITMAPV5HEADER].
const FILE_HEADER: usize = 14;
const VERSION_4: u32 = 108;
const VERSION_5: u32 = 124;

/// What the second header says of colours.
enum Colours {
    /// Nothing, or that they are those of sRGB.
    Usual,
    /// White and primaries, and the exponents that make light of red, green and blue.
    Calibrated(Option<[f64; 8]>, [f64; 3]),
    /// A profile, if it lies within the file.
    Profile(Option<Vec<u8>>),
}

impl Colours {
    /// Leaves the input at its start.
    fn of(input: &mut dyn Input) -> Result<Self, Problem> {
        let wrong = |e| Problem::file_system(e, 0);
        let mut head = Vec::new();
        (&mut *input).take(FILE_HEADER as u64 + u64::from(VERSION_5)).read_to_end(&mut head).map_err(wrong)?;
        let found = Self::said(head.get(FILE_HEADER..).unwrap_or_default(), input);
        input.rewind().map_err(wrong)?;
        Ok(found.unwrap_or(Self::Usual))
    }

    fn said(header: &[u8], input: &mut dyn Input) -> Option<Self> {
        let number = |at: usize| Some(u32::from_le_bytes(*header.get(at..)?.first_chunk()?));
        let size = number(0)?;
        if size < VERSION_4 {
            return None;
        }
        match &number(56)?.to_be_bytes() {
            [0, 0, 0, 0] => {
                // Parts of XYZ with 30 bits after the point: x, y and z of red, then green, then blue.
                let part =
                    |c: usize, axis: usize| Some(f64::from(number(60 + 12 * c + 4 * axis)?) / f64::from(1 << 30));
                let gamma = |c: usize| Some(f64::from(number(96 + 4 * c)?) / 65_536.0);
                let [red, green, blue] = [0, 1, 2].map(|c| Some([part(c, 0)?, part(c, 1)?, part(c, 2)?]));
                Some(Self::Calibrated(points([red?, green?, blue?]), [gamma(0)?, gamma(1)?, gamma(2)?]))
            }
            b"LINK" => Some(Self::Profile(None)),
            b"MBED" if VERSION_5 <= size => {
                let (at, len) = (FILE_HEADER as u64 + u64::from(number(112)?), number(116)? as usize);
                let mut profile = Vec::new();
                input.seek(SeekFrom::Start(at)).ok()?;
                input.take(len.min(METADATA_BYTES + 1) as u64).read_to_end(&mut profile).ok()?;
                Some(Self::Profile((profile.len() == len && (1..=METADATA_BYTES).contains(&len)).then_some(profile)))
            }
            _ => None,
        }
    }

    fn complete(self, description: &mut Description, context: &mut Context<'_>) {
        let metadata = &mut description.metadata;
        match self {
            Self::Usual => {}
            Self::Profile(None) => context.warn(Warning::ProfileLeftOut),
            Self::Profile(icc) => metadata.icc = icc,
            Self::Calibrated(points, gammas) => {
                metadata.chromaticities = points;
                let [red, green, blue] = gammas.map(encoding);
                metadata.gamma = red.filter(|_| red == green && green == blue);
                if [red, green, blue].iter().any(|gamma| *gamma != metadata.gamma) {
                    context.warn(Warning::TagUnread { tag: "gammas" });
                }
            }
        }
    }
}

/// White, red, green and blue of the parts of XYZ that each primary has: white is their sum. Where parts of each sum up
/// to 1 they are parts of colours alone, as most have it, and white is daylight.
fn points(primaries: [[f64; 3]; 3]) -> Option<[f64; 8]> {
    let sum = |axis: usize| primaries.iter().map(|p| p[axis]).sum();
    let alone = primaries.iter().all(|p| (p.iter().sum::<f64>() - 1.0).abs() < 1e-3);
    let white = if alone { [0.3127, 0.329, 0.3583] } else { [0, 1, 2].map(sum) };
    let [white, red, green, blue] = [white, primaries[0], primaries[1], primaries[2]].map(|[x, y, z]: [f64; 3]| {
        let sum = x + y + z;
        (0.0 < sum).then(|| [x / sum, y / sum])
    });
    chromaticities(Some(white?), [red?, green?, blue?].concat().try_into().ok())
}
