//! Writing TIFF: one page in strips, packed with deflate.

use std::borrow::Cow;
use std::marker::PhantomData;

use selvedge_core::{Grid, Plane, Samples};
use tiff::TiffError;
use tiff::encoder::colortype::ColorType;
use tiff::encoder::{Compression, ImageEncoder, Rational, TiffEncoder, TiffKind, TiffValue};
use tiff::tags::{ExtraSamples, PhotometricInterpretation, ResolutionUnit, SampleFormat, Tag, Type};

use super::said::{PRIMARIES, WHITE};
use crate::Format;
use crate::error::Problem;
use crate::metadata::{DensityUnit, Metadata};
use crate::sink::{Sink, encoded};

/// Classic TIFF counts bytes in 32 bits; what may come near is written as BigTIFF.
const CLASSIC_BYTES: usize = 4_000_000_000;

/// The whole file.
pub(crate) fn encode(plane: &Plane<2>, metadata: &Metadata) -> Result<Vec<u8>, Problem> {
    match &plane.samples {
        Samples::U8(grid) => with_channels::<u8, false>(grid, plane, metadata),
        Samples::U16(grid) => with_channels::<u16, false>(grid, plane, metadata),
        Samples::F16(grid) => with_channels::<u16, true>(grid, plane, metadata),
        Samples::F32(grid) => with_channels::<f32, true>(grid, plane, metadata),
    }
}

/// The layout of a page, for the encoder; alpha comes on top.
struct Layout<T, const CHANNELS: usize, const FLOAT: bool>(PhantomData<T>);

impl<T: TiffValue + Clone, const CHANNELS: usize, const FLOAT: bool> ColorType for Layout<T, CHANNELS, FLOAT> {
    type Inner = T;
    const TIFF_VALUE: PhotometricInterpretation =
        if CHANNELS == 3 { PhotometricInterpretation::RGB } else { PhotometricInterpretation::BlackIsZero };
    const BITS_PER_SAMPLE: &'static [u16] = &[T::BYTE_LEN as u16 * 8; CHANNELS];
    const SAMPLE_FORMAT: &'static [SampleFormat] =
        &[if FLOAT { SampleFormat::IEEEFP } else { SampleFormat::Uint }; CHANNELS];

    fn horizontal_predict(row: &[T], result: &mut Vec<T>) {
        result.extend_from_slice(row);
    }
}

fn with_channels<T: TiffValue + Copy, const FLOAT: bool>(
    grid: &Grid<T, 2>,
    plane: &Plane<2>,
    metadata: &Metadata,
) -> Result<Vec<u8>, Problem>
where
    [T]: TiffValue,
{
    match plane.color_channels() {
        1 => with_size::<Layout<T, 1, FLOAT>>(grid, plane, metadata),
        3 => with_size::<Layout<T, 3, FLOAT>>(grid, plane, metadata),
        channels => Err(Problem::ChannelsNotHeld { format: Format::Tiff, channels, alpha: plane.alpha }),
    }
}

fn with_size<C: ColorType>(grid: &Grid<C::Inner, 2>, plane: &Plane<2>, metadata: &Metadata) -> Result<Vec<u8>, Problem>
where
    C::Inner: Copy,
    [C::Inner]: TiffValue,
{
    let samples = grid.to_interleaved()?;
    encoded(Format::Tiff, |file| {
        if size_of_val(&samples[..]) < CLASSIC_BYTES {
            page::<C, _>(TiffEncoder::new(file)?, &samples, plane, metadata)
        } else {
            page::<C, _>(TiffEncoder::new_big(file)?, &samples, plane, metadata)
        }
    })
}

fn page<C: ColorType, K: TiffKind>(
    encoder: TiffEncoder<&mut Sink, K>,
    samples: &[C::Inner],
    plane: &Plane<2>,
    metadata: &Metadata,
) -> Result<(), TiffError>
where
    [C::Inner]: TiffValue,
{
    let [height, width] = plane.domain().shape;
    let mut encoder = encoder.with_compression(Compression::Deflate(Default::default()));
    let mut image = encoder.new_image::<C>(width, height)?;
    if plane.alpha {
        let associated = plane.is_premultiplied();
        image.extra_samples(&[if associated {
            ExtraSamples::AssociatedAlpha
        } else {
            ExtraSamples::UnassociatedAlpha
        }])?;
    }
    describe(&mut image, plane, metadata)?;
    image.write_data(samples)
}

fn describe<C: ColorType, K: TiffKind>(
    image: &mut ImageEncoder<'_, &mut Sink, C, K>,
    plane: &Plane<2>,
    metadata: &Metadata,
) -> Result<(), TiffError> {
    if let Some(icc) = metadata.icc_for(plane.color_channels()) {
        image.encoder().write_tag(Tag::IccProfile, icc)?;
    }
    if let Some([wx, wy, primaries @ ..]) = metadata.chromaticities_beside(Format::Tiff, plane.color_channels()) {
        let tag = |tag: u16| Tag::Unknown(tag);
        image.encoder().write_tag(tag(WHITE), &[wx, wy].map(fraction)[..])?;
        image.encoder().write_tag(tag(PRIMARIES), &primaries.map(fraction)[..])?;
    }
    if let Some(made) = &metadata.provenance {
        image.encoder().write_tag(Tag::Software, Text(made.to_string().into_bytes()))?;
    }
    if let Some(density) = metadata.density {
        let (unit, factor) = match density.unit {
            DensityUnit::Aspect => (ResolutionUnit::None, 1.0),
            DensityUnit::Inch => (ResolutionUnit::Inch, 1.0),
            DensityUnit::Centimetre => (ResolutionUnit::Centimeter, 1.0),
            DensityUnit::Metre => (ResolutionUnit::Centimeter, 0.01),
        };
        image.resolution_unit(unit);
        image.x_resolution(rational(density.x * factor));
        image.y_resolution(rational(density.y * factor));
    }
    Ok(())
}

/// A number from 0 to 1, as PNG has them.
fn fraction(v: f64) -> Rational {
    Rational { n: (v * 100_000.0).round() as u32, d: 100_000 }
}

fn rational(v: f64) -> Rational {
    const PARTS: u32 = 10_000;
    if v.fract() == 0.0 {
        return Rational { n: v as u32, d: 1 };
    }
    Rational { n: (v * f64::from(PARTS)).round() as u32, d: PARTS }
}

/// Text of the tag type ASCII; like everyone else we put UTF-8 into it.
struct Text(Vec<u8>);

impl TiffValue for Text {
    const BYTE_LEN: u8 = 1;
    const FIELD_TYPE: Type = Type::ASCII;

    fn count(&self) -> usize {
        self.0.len() + 1
    }

    fn data(&self) -> Cow<'_, [u8]> {
        [&self.0[..], &[0]].concat().into()
    }
}
