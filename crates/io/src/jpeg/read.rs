//! Reading JPEG.

use selvedge_core::Samples;

use super::frame::{Frame, Tables};
use super::markers::{END, FRAME_TABLES, Notes, SCAN, Segments, head};
use super::picture::{Colors, picture};
use super::{damaged, scan, unsupported};
use crate::codec::{Context, Decoded, Description, Input};
use crate::error::Problem;
use crate::header::Header;
use crate::{Depth, Format, Warning};

/// No encoder makes more scans: each coefficient of four components alone, bit by bit, would be 3,584.
const SCANS: usize = 4_000;

/// Everything up to the samples.
pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    let bytes = head(input)?;
    let mut segments = Segments::new(&bytes);
    let (mut frame, mut notes) = (None, Notes::default());
    while let Some((marker, segment)) = segments.next() {
        match marker {
            SCAN | END => break,
            _ if Frame::begins_with(marker) => frame = Some(Frame::parse(marker, segment)?),
            _ => notes.segment(marker, segment),
        }
    }
    let frame = frame.ok_or_else(|| Problem::ends_early(Format::Jpeg))?;
    Ok(description(&frame, notes, context)?.0)
}

fn description(frame: &Frame, notes: Notes, context: &mut Context<'_>) -> Result<(Description, Colors), Problem> {
    let colors = notes.colors(frame)?;
    let (orientation, metadata) = notes.complete(colors, context);
    Ok((Description { orientation, ..Description::new(header(frame), metadata) }, colors))
}

fn header(frame: &Frame) -> Header {
    let channels = if frame.components.len() == 1 { 1 } else { 3 };
    Header { width: frame.width.into(), height: frame.height.into(), channels, alpha: false, depth: Depth::U8 }
}

/// The picture. What is missing is refused, but for the end marker alone.
pub(crate) fn decode(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Decoded, Problem> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes).map_err(|e| Problem::file_system(e, 0))?;
    let mut segments = Segments::new(&bytes);
    let (mut frame, mut notes, mut tables) = (None, Notes::default(), Tables::default());
    let (mut ended, mut scans) = (false, 0);
    while let Some((marker, segment)) = segments.next() {
        match marker {
            END => {
                ended = true;
                break;
            }
            SCAN => {
                let frame = frame.as_mut().ok_or_else(|| damaged("a scan before its frame"))?;
                segments.at = scan::read(frame, &tables, segment, &bytes, segments.at)?;
                scans += 1;
                if SCANS < scans {
                    return Err(unsupported(&format!("a file of more than {SCANS} scans")));
                }
            }
            0xdc => return Err(unsupported("a height that is told after the samples")),
            0xcc => return Err(unsupported("arithmetic coding")),
            _ if FRAME_TABLES.contains(&marker) => match marker {
                0xc4 => tables.huffman(segment)?,
                0xdb => tables.quantization(segment)?,
                _ => tables.restart(segment)?,
            },
            _ if Frame::begins_with(marker) => {
                let new = Frame::parse(marker, segment)?;
                check(&new, context)?;
                if frame.replace(new).is_some() {
                    return Err(damaged("a second frame"));
                }
            }
            _ => notes.segment(marker, segment),
        }
    }
    finish(frame, notes, (ended, scans), context)
}

/// Coefficients of progressive frames, and samples by component, are held besides the picture.
fn check(frame: &Frame, context: &Context<'_>) -> Result<(), Problem> {
    let blocks = frame.components.iter().map(|c| u64::from(c.padded[0]) * u64::from(c.padded[1]));
    let more = if frame.progressive { 2 * 64 * blocks.sum::<u64>() } else { 0 };
    header(frame).check(&context.options.limits, context.file_bytes + more)
}

fn finish(
    frame: Option<Frame>,
    notes: Notes,
    (ended, scans): (bool, usize),
    context: &mut Context<'_>,
) -> Result<Decoded, Problem> {
    let missing = || match (ended, scans) {
        (false, _) => Problem::ends_early(Format::Jpeg),
        (true, 0) => damaged("it has no picture"),
        (true, _) => damaged("one of its components has no samples"),
    };
    let mut frame = frame.ok_or_else(missing)?;
    for component in &mut frame.components {
        // Progress may stop before the last bits, as long as the file says that it ends there.
        if component.missing[0] == u8::MAX || (!ended && component.missing != [0; 64]) {
            return Err(missing());
        }
        if frame.progressive {
            component.finish()?;
        }
    }
    if !ended {
        context.warn(Warning::EndMarkerMissing);
    }
    let (description, colors) = description(&frame, notes, context)?;
    let samples = Samples::U8(picture(&frame, colors, &description.header)?);
    Ok((description, samples))
}
