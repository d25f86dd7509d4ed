//! Pictures of the `image` crate as planes, and back (feature `image`).

use std::ops::Deref;

use image::{DynamicImage, ImageBuffer, Luma, Pixel};

use crate::{Domain, Error, Grid, Plane, Role, Samples};

/// A sample of a picture that a plane can hold: `u8`, `u16` and `f32`.
pub trait ImageSample: image::Primitive {
    /// A grid of them, as samples.
    fn samples(grid: Grid<Self, 2>) -> Samples<2>;
}

impl ImageSample for u8 {
    fn samples(grid: Grid<Self, 2>) -> Samples<2> {
        Samples::U8(grid)
    }
}

impl ImageSample for u16 {
    fn samples(grid: Grid<Self, 2>) -> Samples<2> {
        Samples::U16(grid)
    }
}

impl ImageSample for f32 {
    fn samples(grid: Grid<Self, 2>) -> Samples<2> {
        Samples::F32(grid)
    }
}

impl<P, C> TryFrom<&ImageBuffer<P, C>> for Plane<2>
where
    P: Pixel<Subpixel: ImageSample>,
    C: Deref<Target = [P::Subpixel]>,
{
    type Error = Error;

    /// The same samples as [`Role::Color`]: sRGB-encoded where they are integers, linear where they are floats. An
    /// alpha channel is straight. A map of something else is told so by its [`role`](Plane::role).
    ///
    /// ```
    /// use image::{GrayImage, Luma};
    /// use selvedge_core::{Exemplars, Plane};
    ///
    /// let picture = GrayImage::from_fn(3, 2, |x, y| Luma([(10 * y + x) as u8]));
    /// let plane = Plane::try_from(&picture)?;
    /// let exemplars = Exemplars::of(&[&[plane.clone()]])?;
    /// assert_eq!(exemplars.sources()[0].domain().shape, [2, 3]);
    /// let back = image::DynamicImage::try_from(&plane)?;
    /// assert_eq!(back.as_luma8(), Some(&picture));
    /// # Ok::<(), selvedge_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Allocation`].
    fn try_from(picture: &ImageBuffer<P, C>) -> Result<Self, Error> {
        let channels = usize::from(P::CHANNEL_COUNT);
        let domain = Domain::open([picture.height(), picture.width()]);
        // A picture's buffer may be longer than its picture.
        let used = domain.len() * channels;
        let samples = P::Subpixel::samples(Grid::from_interleaved(domain, channels, &picture.as_raw()[..used])?);
        // Grey and alpha, or three colours and alpha.
        let alpha = channels.is_multiple_of(2);
        Ok(if alpha { Self::with_alpha(Role::Color, samples) } else { Self::new(Role::Color, samples) })
    }
}

impl TryFrom<&DynamicImage> for Plane<2> {
    type Error = Error;

    /// As from an [`ImageBuffer`].
    ///
    /// # Errors
    /// [`Error::Allocation`]; [`Error::NotAnImage`] for a layout that this version of Selvedge does not know.
    fn try_from(picture: &DynamicImage) -> Result<Self, Error> {
        match picture {
            DynamicImage::ImageLuma8(p) => p.try_into(),
            DynamicImage::ImageLumaA8(p) => p.try_into(),
            DynamicImage::ImageRgb8(p) => p.try_into(),
            DynamicImage::ImageRgba8(p) => p.try_into(),
            DynamicImage::ImageLuma16(p) => p.try_into(),
            DynamicImage::ImageLumaA16(p) => p.try_into(),
            DynamicImage::ImageRgb16(p) => p.try_into(),
            DynamicImage::ImageRgba16(p) => p.try_into(),
            DynamicImage::ImageRgb32F(p) => p.try_into(),
            DynamicImage::ImageRgba32F(p) => p.try_into(),
            other => Err(Error::NotAnImage { layout: format!("{:?}", other.color()) }),
        }
    }
}

impl<C> TryFrom<&ImageBuffer<Luma<u8>, C>> for Grid<bool, 2>
where
    C: Deref<Target = [u8]>,
{
    type Error = Error;

    /// A mask: true where the picture is at least half light, 128.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    fn try_from(picture: &ImageBuffer<Luma<u8>, C>) -> Result<Self, Error> {
        let domain = Domain::open([picture.height(), picture.width()]);
        Grid::from_interleaved(domain, 1, &picture.as_raw()[..domain.len()])?.map(|light| light >= 128)
    }
}

impl TryFrom<&Plane<2>> for DynamicImage {
    type Error = Error;

    /// The same samples, whatever their role; premultiplied colours stay so.
    ///
    /// # Errors
    /// [`Error::Allocation`]; [`Error::NotAnImage`] where `image` has no picture of so many channels in this depth:
    /// half floats, floats that are not three colours, more than four channels.
    fn try_from(plane: &Plane<2>) -> Result<Self, Error> {
        let [height, width] = plane.domain().shape;
        let fit = |made: Option<Self>| made.ok_or_else(|| Error::NotAnImage { layout: plane.layout() });
        match (&plane.samples, plane.color_channels(), plane.alpha) {
            (Samples::U8(g), 1, false) => fit(of(g, width, height)?.map(Self::ImageLuma8)),
            (Samples::U8(g), 1, true) => fit(of(g, width, height)?.map(Self::ImageLumaA8)),
            (Samples::U8(g), 3, false) => fit(of(g, width, height)?.map(Self::ImageRgb8)),
            (Samples::U8(g), 3, true) => fit(of(g, width, height)?.map(Self::ImageRgba8)),
            (Samples::U16(g), 1, false) => fit(of(g, width, height)?.map(Self::ImageLuma16)),
            (Samples::U16(g), 1, true) => fit(of(g, width, height)?.map(Self::ImageLumaA16)),
            (Samples::U16(g), 3, false) => fit(of(g, width, height)?.map(Self::ImageRgb16)),
            (Samples::U16(g), 3, true) => fit(of(g, width, height)?.map(Self::ImageRgba16)),
            (Samples::F32(g), 3, false) => fit(of(g, width, height)?.map(Self::ImageRgb32F)),
            (Samples::F32(g), 3, true) => fit(of(g, width, height)?.map(Self::ImageRgba32F)),
            _ => fit(None),
        }
    }
}

/// A picture that owns its samples.
type Owned<P> = ImageBuffer<P, Vec<<P as Pixel>::Subpixel>>;

/// A picture of these samples.
fn of<P>(grid: &Grid<P::Subpixel, 2>, width: u32, height: u32) -> Result<Option<Owned<P>>, Error>
where
    P: Pixel<Subpixel: ImageSample>,
{
    Ok(ImageBuffer::from_vec(width, height, grid.to_interleaved()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_every_layout_come_back_as_they_were() {
        let color = image::Rgba32FImage::from_fn(5, 3, |x, y| image::Rgba([x as f32 / 4.0, y as f32 / 2.0, 0.25, 0.5]));
        let first = DynamicImage::ImageRgba32F(color);
        let all = [
            first.to_luma8().into(),
            first.to_luma_alpha8().into(),
            first.to_rgb8().into(),
            first.to_rgba8().into(),
            first.to_luma16().into(),
            first.to_luma_alpha16().into(),
            first.to_rgb16().into(),
            first.to_rgba16().into(),
            first.to_rgb32f().into(),
            first.clone(),
        ];
        for picture in all {
            let plane = Plane::try_from(&picture).unwrap();
            assert_eq!((plane.domain().shape, plane.alpha), ([3, 5], picture.color().has_alpha()));
            assert_eq!(DynamicImage::try_from(&plane).unwrap(), picture);
        }
        let plane = Plane::try_from(&first).unwrap();
        assert_eq!(
            [0, 1, 2, 3].map(|c| plane.samples.value(c, 14)),
            [1.0, 1.0, 0.25, 0.5],
            "the last pixel's channels"
        );
    }

    #[test]
    fn masks_are_true_from_half_light_on() {
        let picture = image::GrayImage::from_raw(2, 2, vec![0, 127, 128, 255]).unwrap();
        assert_eq!(Grid::<bool, 2>::try_from(&picture).unwrap().plane(0), [false, false, true, true]);
    }

    #[test]
    fn planes_that_are_no_picture_say_so() {
        let samples = Samples::F32(Grid::try_filled(Domain::open([2, 2]), 1, 0.5).unwrap());
        let words = DynamicImage::try_from(&Plane::new(Role::Height, samples)).unwrap_err().to_string();
        assert_eq!(words, "1 float channel(s) are no picture that the crate `image` has");
        // A buffer that is longer than its picture.
        let long = image::GrayImage::from_raw(2, 1, vec![1, 2, 3, 4]).unwrap();
        assert_eq!(Plane::try_from(&long).unwrap().samples.domain().shape, [1, 2]);
    }
}
