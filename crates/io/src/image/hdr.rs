//! Radiance HDR: three channels that share an exponent; read as float.

use std::io::Read;

use half::f16;
use image::Rgb;
use image::codecs::hdr::{HdrDecoder, HdrEncoder, HdrMetadata};
use selvedge_core::{Plane, Samples, try_vec};

use super::complaint;
use crate::codec::{Context, Decoded, Description, Input};
use crate::error::Problem;
use crate::exif::chromaticities;
use crate::metadata::{Density, DensityUnit, Metadata};
use crate::provenance::Provenance;
use crate::sink::encoded;
use crate::{Format, Warning};

const SIGNATURE: &str = "#?RADIANCE\n";

pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    let comments = comments(input)?;
    let mut decoder = HdrDecoder::with_strictness(input, false).map_err(|e| complaint(e, Format::Hdr, context))?;
    let mut description = super::describe(&mut decoder, Format::Hdr, context)?;
    complete(&mut description, &comments, decoder.metadata(), context);
    Ok(description)
}

pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let comments = comments(input)?;
    let decoder = HdrDecoder::with_strictness(input, false).map_err(|e| complaint(e, Format::Hdr, context))?;
    let said = decoder.metadata();
    let (mut description, samples) = super::decode(decoder, Format::Hdr, context)?;
    complete(&mut description, &comments, said, context);
    Ok((description, samples))
}

/// What the header says. Light stays as it is stored, as nearly everyone shows it: an exposure, by which it would be
/// divided, is told.
fn complete(description: &mut Description, comments: &str, said: HdrMetadata, context: &mut Context<'_>) {
    let metadata = &mut description.metadata;
    metadata.provenance = Provenance::parse(comments);
    let named = |key: &str| said.custom_attributes.iter().rev().find(|(k, _)| k == key).map(|(_, value)| value);
    let numbers = named("PRIMARIES").map(|text| text.split_whitespace().filter_map(|v| v.parse().ok()).collect());
    if let Some([primaries @ .., x, y]) = numbers.and_then(|v: Vec<f64>| <[f64; 8]>::try_from(v).ok()) {
        metadata.chromaticities = chromaticities(Some([x, y]), Some(primaries));
    }
    // Height by width, of one pixel.
    let aspect = said.pixel_aspect_ratio.map(f64::from).filter(|aspect| aspect.is_normal() && 0.0 < *aspect);
    let shaped = aspect.filter(|aspect| *aspect != 1.0);
    metadata.density = shaped.map(|aspect| Density { x: 1.0, y: 1.0 / aspect, unit: DensityUnit::Aspect });
    let is_one = |text: &String| text.trim().parse() == Ok(1.0_f32);
    for (said, tag) in [
        (said.exposure.is_some_and(|e| e != 1.0), "exposure"),
        (said.color_correction.is_some_and(|c| c != (1.0, 1.0, 1.0)), "colour correction"),
        (named("GAMMA").is_some_and(|gamma| !is_one(gamma)), "gamma"),
    ] {
        if said {
            context.warn(Warning::TagUnread { tag });
        }
    }
}

/// Our lines among the comments of the header. Leaves the input at its start.
fn comments(input: &mut dyn Input) -> Result<String, Problem> {
    let wrong = |e| Problem::file_system(e, 0);
    let mut head = Vec::new();
    Read::take(&mut *input, 1 << 16).read_to_end(&mut head).map_err(wrong)?;
    input.rewind().map_err(wrong)?;
    let lines = head.split(|b| *b == b'\n').take_while(|line| !line.is_empty());
    let ours = lines.filter_map(|line| std::str::from_utf8(line.strip_prefix(b"# ")?).ok());
    Ok(ours.skip_while(|line| !line.starts_with("selvedge ")).collect::<Vec<_>>().join("\n"))
}

/// Samples that become 0 because they are less.
pub(crate) fn negative(plane: &Plane<2>) -> u64 {
    let (channels, n) = (plane.color_channels(), plane.domain().len());
    (0..channels).map(|c| (0..n).filter(|i| plane.samples.value(c, *i) < 0.0).count() as u64).sum()
}

/// The whole file. Each sample is rounded to 8 bits of its pixel's largest; negative ones become 0.
pub(crate) fn encode(plane: &Plane<2>, metadata: &Metadata) -> Result<Vec<u8>, Problem> {
    let format = Format::Hdr;
    let (channels, alpha) = (plane.color_channels(), plane.alpha);
    if alpha || !matches!(channels, 1 | 3) {
        return Err(Problem::ChannelsNotHeld { format, channels, alpha });
    }
    let value = |c: usize, i: usize| match &plane.samples {
        Samples::F16(grid) => f16::from_bits(grid.plane(c)[i]).to_f32(),
        Samples::F32(grid) => grid.plane(c)[i],
        integers => integers.value(c, i) as f32,
    };
    let mut pixels = try_vec(plane.domain().len(), Rgb([0.0; 3]))?;
    for (i, pixel) in pixels.iter_mut().enumerate() {
        for c in 0..3 {
            pixel.0[c] = value(c.min(channels - 1), i).max(0.0);
        }
    }
    let [height, width] = plane.domain().shape;
    encoded(format, |file| {
        HdrEncoder::new(&mut *file).encode(&pixels, width as usize, height as usize).map_err(|e| e.to_string())?;
        let Some(made) = &metadata.provenance else { return Ok(()) };
        let comments: String = made.to_string().lines().map(|line| format!("# {line}\n")).collect();
        let after = file.bytes().starts_with(SIGNATURE.as_bytes()).then_some(SIGNATURE.len());
        file.insert(after.ok_or("unknown signature")?, comments.as_bytes()).map_err(|e| e.to_string())
    })
}
