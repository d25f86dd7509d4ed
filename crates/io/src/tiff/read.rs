//! Reading TIFF: the first page that is no thumbnail.

use std::borrow::Cow;
use std::io::Cursor;

use selvedge_core::{Grid, Samples};
use tiff::TiffError;
use tiff::decoder::{BufferLayoutPreference, ChunkType, Decoder, DecodingSampleType, Limits};
use tiff::tags::Tag;

use super::channels::{Channels, Colors, Shown, alpha_of, picked};
use super::chosen::Chosen;
use super::directory::{PAGES, is_reduced};
use super::planes::{self, Planes};
use super::{colors, compression, palette};
use crate::codec::{Context, Decoded, Description, Input, METADATA_BYTES};
use crate::error::{Problem, subject};
use crate::header::Header;
use crate::metadata::Metadata;
use crate::provenance::Provenance;
use crate::samples::{deinterleave, from_native, unpack, zero_grid, zeros};
use crate::{Depth, Format, Warning};

/// Everything up to the samples.
pub(crate) fn describe(input: &mut dyn Input, context: &mut Context<'_>) -> Result<Description, Problem> {
    if let Some(wanted) = &context.options.channels {
        let mut file = Vec::new();
        input.read_to_end(&mut file).map_err(|e| Problem::file_system(e, 0))?;
        let (chosen, file) = Chosen::of(file, wanted)?;
        let all = with_decoder(&mut Cursor::new(file), context, |page| Ok(page.description()))?;
        return Ok(chosen.described(all));
    }
    with_decoder(input, context, |page| Ok(page.description()))
}

/// The first page.
pub(crate) fn decode(file: &[u8], context: &mut Context<'_>) -> Result<Decoded, Problem> {
    match &context.options.channels {
        Some(wanted) => {
            let (chosen, file) = Chosen::of(file.to_vec(), wanted)?;
            chosen.of_all(decode_whole(&file, context)?)
        }
        None => decode_whole(file, context),
    }
}

/// All of the first page of a file.
fn decode_whole(file: &[u8], context: &mut Context<'_>) -> Result<Decoded, Problem> {
    // Before anything else, what it will take is known from the header alone.
    let warnings = std::mem::take(&mut context.warnings);
    let (stored, all, bits) =
        with_decoder(&mut Cursor::new(file), context, |page| Ok((page.stored, page.all, page.bits)))?;
    context.warnings = warnings;
    let file = compression::unpacked(file, &stored, all, bits.into(), context)?.map_or(Cow::Borrowed(file), Cow::Owned);
    if !planes::are_tiled(&file) {
        let read = |page: &mut Page<'_, '_, '_>| Ok((page.description(), page.samples()?));
        return with_decoder(&mut Cursor::new(&*file), context, read);
    }
    let mut planes = Planes::of(file.into_owned(), all)?;
    let mut samples = zero_samples(&stored)?;
    for p in 0..stored.channels {
        let mut context = Context::new(context.options, context.file_bytes);
        let plane = with_decoder(&mut Cursor::new(planes.alone(p)?), &mut context, |page| page.samples())?;
        put(&mut samples, p, &plane);
    }
    let file = planes.whole();
    with_decoder(&mut Cursor::new(&file), context, |page| Ok((page.description(), page.converted(samples)?)))
}

fn zero_samples(header: &Header) -> Result<Samples<2>, Problem> {
    Ok(match header.depth {
        Depth::U8 => Samples::U8(zero_grid(header)?),
        Depth::U16 => Samples::U16(zero_grid(header)?),
        Depth::F16 => Samples::F16(zero_grid(header)?),
        Depth::F32 => Samples::F32(zero_grid(header)?),
    })
}

/// One plane of a picture.
fn put(samples: &mut Samples<2>, c: usize, plane: &Samples<2>) {
    match (samples, plane) {
        (Samples::U8(to), Samples::U8(from)) => to.plane_mut(c).copy_from_slice(from.plane(0)),
        (Samples::U16(to), Samples::U16(from)) => to.plane_mut(c).copy_from_slice(from.plane(0)),
        (Samples::F16(to), Samples::F16(from)) => to.plane_mut(c).copy_from_slice(from.plane(0)),
        (Samples::F32(to), Samples::F32(from)) => to.plane_mut(c).copy_from_slice(from.plane(0)),
        _ => unreachable!("all planes have the depth of the first"),
    }
}

/// Opens the file; one that the decoder gives only in part a second time, as grey.
fn with_decoder<T>(
    input: &mut dyn Input,
    context: &mut Context<'_>,
    f: impl FnOnce(&mut Page<'_, '_, '_>) -> Result<T, Problem>,
) -> Result<T, Problem> {
    let mut decoder = open(input, context)?;
    let samples = decoder.find_tag_unsigned::<u16>(Tag::SamplesPerPixel).ok().flatten();
    let shown = match decoder.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).map_err(complaint)? {
        Some(WHITE_IS_ZERO) if samples.is_some_and(|n| 1 < n) => {
            return Err(Problem::unsupported(Format::Tiff, "grey with white as 0 and other channels beside it"));
        }
        Some(palette::PALETTE) => Shown::Palette(decoder.get_tag_u16_vec(Tag::ColorMap).map_err(complaint)?),
        // It knows alpha only right after the colours.
        Some(RGB) if alpha_of(&extra(&mut decoder)).is_some_and(|(i, _)| 0 < i) => Shown::Rgb,
        _ => return f(&mut Page::new(decoder, Shown::AsItIs, context)?),
    };
    let mut file = Vec::new();
    input.rewind().and_then(|()| input.read_to_end(&mut file)).map_err(|e| Problem::file_system(e, 0))?;
    palette::show_as_grey(&mut file)?;
    let mut patched = Cursor::new(file);
    f(&mut Page::new(open(&mut patched, context)?, shown, context)?)
}

/// What the channels beside colour are.
fn extra(decoder: &mut PageDecoder<'_>) -> Vec<u64> {
    decoder.find_tag_unsigned_vec(Tag::ExtraSamples).ok().flatten().unwrap_or_default()
}

fn open<'a>(input: &'a mut dyn Input, context: &Context<'_>) -> Result<PageDecoder<'a>, Problem> {
    let mut decoder = Decoder::new(input).map_err(complaint)?;
    go_to_picture(&mut decoder)?;
    let (width, height) = decoder.dimensions().map_err(complaint)?;
    let smallest = Header { width: width.into(), height: height.into(), channels: 1, alpha: false, depth: Depth::U8 };
    context.check(&smallest)?;
    let mut limits = Limits::default();
    limits.ifd_value_size = METADATA_BYTES;
    // Strips and tiles may be padded, but not without end.
    let budget = context.options.limits.memory.min(smallest.bytes() * 64 + context.file_bytes + (16 << 20));
    limits.decoding_buffer_size = usize::try_from(budget).unwrap_or(usize::MAX);
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    Ok(decoder.with_limits(limits))
}

/// Passes over thumbnails; where there is nothing else the first is the picture.
fn go_to_picture(decoder: &mut PageDecoder<'_>) -> Result<(), Problem> {
    for passed in 0..PAGES {
        let kind = decoder.find_tag_unsigned::<u32>(Tag::NewSubfileType).ok().flatten();
        match (is_reduced(kind.map(u64::from)), passed) {
            (false, _) => return Ok(()),
            (true, _) if passed + 1 < PAGES && decoder.more_images() => decoder.next_image().map_err(complaint)?,
            (true, 0) => return Ok(()),
            (true, _) => break,
        }
    }
    decoder.seek_to_image(0).map_err(complaint)
}

/// Photometric interpretations: of grey whose white is 0, and of red, green and blue.
const WHITE_IS_ZERO: u16 = 0;
const RGB: u16 = 2;

pub(super) type PageDecoder<'a> = Decoder<&'a mut dyn Input>;

pub(super) struct Page<'a, 'c, 'o> {
    pub(super) decoder: PageDecoder<'a>,
    layout: BufferLayoutPreference,
    bits: u8,
    /// Channels of the file, those that are left out among them.
    all: usize,
    /// As stored; the picture's own header may have other channels.
    stored: Header,
    channels: Channels,
    /// Colours of a palette.
    map: Vec<u16>,
    /// Whether the decoder is shown another file than there is.
    shown: bool,
    pub(super) context: &'c mut Context<'o>,
}

impl<'a, 'c, 'o> Page<'a, 'c, 'o> {
    fn new(mut decoder: PageDecoder<'a>, shown: Shown, context: &'c mut Context<'o>) -> Result<Self, Problem> {
        let (width, height) = decoder.dimensions().map_err(complaint)?;
        let color = decoder.colortype().map_err(complaint)?;
        let layout = decoder.image_buffer_layout().map_err(complaint)?;
        let extra = extra(&mut decoder);
        let chosen = context.options.channels.is_some();
        let channels = Channels::of(color, &shown, &extra, chosen)?;
        let bits = color.bit_depth();
        let depth = depth(&layout, bits)?;
        let stored =
            Header { width: width.into(), height: height.into(), channels: channels.given, alpha: false, depth };
        context.check(&stored)?;
        let all = decoder.find_tag_unsigned::<u16>(Tag::SamplesPerPixel).ok().flatten().map_or(1, usize::from);
        channels.tell(all, context);
        let is_shown = !matches!(shown, Shown::AsItIs);
        let map = match shown {
            Shown::Palette(map) => map,
            _ => Vec::new(),
        };
        Ok(Self { decoder, layout, bits, all, stored, channels, map, shown: is_shown, context })
    }

    /// The header of the picture.
    fn header(&self) -> Header {
        Header { channels: self.channels.of_picture(), alpha: self.channels.alpha.is_some(), ..self.stored }
    }

    fn description(&mut self) -> Description {
        self.tell();
        let orientation = self.number(Tag::Orientation).and_then(|o| o.try_into().ok()).unwrap_or(1);
        let icc = if self.channels.colors == Colors::Cmyk { None } else { self.profile() };
        let software = self.bytes(Tag::Software);
        let provenance = software.and_then(|text| Provenance::parse(std::str::from_utf8(&text).ok()?));
        let metadata = Metadata {
            icc,
            chromaticities: self.chromaticities(),
            density: self.density(),
            provenance,
            ..Metadata::default()
        };
        let association = Some(self.channels.alpha.unwrap_or_default());
        let reading = Some(self.reading());
        Description { orientation, association, reading, ..Description::new(self.header(), metadata) }
    }

    /// Bytes that reading takes beside the picture: copies of the file, unpacked or of one plane, what the decoder
    /// answers, and samples that become others.
    fn reading(&mut self) -> u64 {
        let times = compression::times_held(self.number(Tag::Compression).unwrap_or(1));
        let packed = 0 < times;
        let tiled = self.decoder.get_chunk_type() == ChunkType::Tile;
        let again = packed || (tiled && 1 < self.layout.planes) || self.shown;
        let whole = |side: u64, piece: u32| if tiled { side.next_multiple_of(u64::from(piece.max(1))) } else { side };
        let (width, height) = self.decoder.chunk_dimensions();
        let pixels = whole(self.stored.width, width).saturating_mul(whole(self.stored.height, height));
        let unpacked = pixels.saturating_mul(self.all as u64 * u64::from(self.bits)).div_ceil(8);
        let others = self.bits < 8 || self.channels.kept.is_some() || self.channels.colors != Colors::AsStored;
        [
            self.context.file_bytes.saturating_mul(1 + u64::from(again) + u64::from(packed && self.shown)),
            unpacked.saturating_mul(times),
            self.layout.complete_len as u64,
            if others { self.stored.bytes() } else { 0 },
        ]
        .into_iter()
        .fold(0, u64::saturating_add)
    }

    fn samples(&mut self) -> Result<Samples<2>, Problem> {
        self.context.ask(&self.stored)?;
        let mut bytes = zeros(self.layout.complete_len)?;
        self.decoder.read_image_bytes(&mut bytes).map_err(complaint)?;
        let stored = self.stored_samples(bytes)?;
        self.converted(stored)
    }

    /// Planar samples, whether the file's are interleaved or planar.
    fn stored_samples(&mut self, mut bytes: Vec<u8>) -> Result<Samples<2>, Problem> {
        let Header { width, height, channels, .. } = self.stored;
        let planar = 1 < self.layout.planes;
        let across = if planar { width as usize } else { width as usize * channels };
        let down = if planar { height as usize * channels } else { height as usize };
        if self.bits < 8 {
            bytes = unpack(&bytes, self.bits, across, down)?;
            if self.channels.colors != Colors::Palette {
                let factor = u8::MAX / (u8::MAX >> (8 - self.bits));
                bytes.iter_mut().for_each(|v| *v *= factor);
            }
        }
        let shape = Header { width: across as u64, height: down as u64, channels: 1, ..self.stored };
        let read_as = if planar { shape } else { self.stored };
        let samples = if self.layout.sample_type == Some(DecodingSampleType::F64) {
            self.context.warn(Warning::Rounded);
            Samples::F32(deinterleave(&read_as, &bytes, |b| f64::from_ne_bytes(b) as f32)?)
        } else {
            from_native(&read_as, &bytes)?
        };
        if planar { reshape(samples, &self.stored) } else { Ok(samples) }
    }

    fn converted(&mut self, stored: Samples<2>) -> Result<Samples<2>, Problem> {
        let stored = match &self.channels.kept {
            Some(kept) => picked(&stored, &Header { channels: kept.len(), ..self.stored }, kept)?,
            None => stored,
        };
        Ok(match (self.channels.colors, stored) {
            (Colors::Palette, Samples::U8(grid)) => {
                let (grid, beyond) = palette::expand(&grid, &self.map)?;
                if 0 < beyond {
                    self.context.warn(Warning::BeyondPalette { count: beyond });
                }
                Samples::U8(grid)
            }
            (Colors::YCbCr, Samples::U8(grid)) => Samples::U8(colors::from_ycbcr(&grid)?),
            (Colors::Cmyk, Samples::U8(grid)) => {
                self.context.warn(Warning::CmykConverted);
                Samples::U8(colors::from_cmyk(&grid, 255, u32::from, |v| v as u8)?)
            }
            (Colors::Cmyk, Samples::U16(grid)) => {
                self.context.warn(Warning::CmykConverted);
                Samples::U16(colors::from_cmyk(&grid, 65_535, u32::from, |v| v as u16)?)
            }
            (Colors::AsStored, samples) => samples,
            _ => return Err(Problem::unsupported(Format::Tiff, "this depth in its colour space")),
        })
    }
}

fn depth(layout: &BufferLayoutPreference, bits: u8) -> Result<Depth, Problem> {
    use DecodingSampleType as Type;
    match (layout.sample_type, bits) {
        (Some(Type::U8), 1 | 2 | 4 | 8) => Ok(Depth::U8),
        (Some(Type::U16), 16) => Ok(Depth::U16),
        (Some(Type::F16), _) => Ok(Depth::F16),
        (Some(Type::F32 | Type::F64), _) => Ok(Depth::F32),
        _ => Err(Problem::unsupported(Format::Tiff, format!("{bits}-bit {:?} samples", layout.sample_format))),
    }
}

fn reshape(samples: Samples<2>, header: &Header) -> Result<Samples<2>, Problem> {
    let (domain, channels) = (header.domain(), header.channels);
    Ok(match samples {
        Samples::U8(grid) => Samples::U8(Grid::from_vec(domain, channels, grid.into_vec())?),
        Samples::U16(grid) => Samples::U16(Grid::from_vec(domain, channels, grid.into_vec())?),
        Samples::F16(grid) => Samples::F16(Grid::from_vec(domain, channels, grid.into_vec())?),
        Samples::F32(grid) => Samples::F32(Grid::from_vec(domain, channels, grid.into_vec())?),
    })
}

fn complaint(error: TiffError) -> Problem {
    match error {
        TiffError::UnsupportedError(e) => Problem::unsupported(Format::Tiff, subject(&e.to_string())),
        TiffError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Problem::ends_early(Format::Tiff),
        other => Problem::damaged(Format::Tiff, other),
    }
}
