//! Payload: registered planes in the depth of their file. Methods never see one.

use half::f16;

use crate::{Domain, Error, Grid};

/// What a plane's channels mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Role {
    /// Grey or RGB: integers are sRGB-encoded, floats linear light.
    Color,
    /// A tangent-space normal: x right, y up. Integers span -1..1, floats are signed or span 0..1.
    Normal,
    /// The same with y down, as DirectX has it.
    NormalDown,
    /// A height, in any unit.
    Height,
    /// Roughness, metalness, occlusion, labels: anything else.
    Scalar,
}

impl Role {
    /// True for normals, whichever way their y points.
    pub const fn is_normal(self) -> bool {
        matches!(self, Self::Normal | Self::NormalDown)
    }
}

/// How samples are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Depth {
    /// 8-bit integers.
    U8,
    /// 16-bit integers.
    U16,
    /// 16-bit floats.
    F16,
    /// 32-bit floats.
    F32,
}

impl Depth {
    /// Its name on the command line and in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::U16 => "u16",
            Self::F16 => "half",
            Self::F32 => "float",
        }
    }

    /// Bytes of one sample.
    pub const fn bytes(self) -> u64 {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::F16 => 2,
            Self::F32 => 4,
        }
    }

    /// What full light and full alpha are as numbers: the greatest integer, or 1.
    pub const fn full(self) -> f64 {
        match self {
            Self::U8 => 255.0,
            Self::U16 => 65_535.0,
            Self::F16 | Self::F32 => 1.0,
        }
    }
}

/// Samples in one of the four depths.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples<const D: usize> {
    /// 8-bit integers.
    U8(Grid<u8, D>),
    /// 16-bit integers.
    U16(Grid<u16, D>),
    /// 16-bit floats, as their bits, so that copies stay exact.
    F16(Grid<u16, D>),
    /// 32-bit floats.
    F32(Grid<f32, D>),
}

/// Runs the same code on the grid of whichever depth.
macro_rules! each_depth {
    ($samples:expr, $grid:ident => $body:expr) => {
        match $samples {
            $crate::Samples::U8($grid) => $body,
            $crate::Samples::U16($grid) | $crate::Samples::F16($grid) => $body,
            $crate::Samples::F32($grid) => $body,
        }
    };
}
pub(crate) use each_depth;

impl<const D: usize> Samples<D> {
    /// Zeros of a depth.
    ///
    /// # Errors
    /// [`Allocation`](crate::Error::Allocation).
    pub fn try_zeros(domain: Domain<D>, channels: usize, depth: Depth) -> Result<Self, crate::Error> {
        Ok(match depth {
            Depth::U8 => Self::U8(Grid::try_filled(domain, channels, 0)?),
            Depth::U16 => Self::U16(Grid::try_filled(domain, channels, 0)?),
            Depth::F16 => Self::F16(Grid::try_filled(domain, channels, 0)?),
            Depth::F32 => Self::F32(Grid::try_filled(domain, channels, 0.0)?),
        })
    }

    /// Shape and topology.
    pub fn domain(&self) -> Domain<D> {
        each_depth!(self, g => g.domain())
    }

    /// Number of channels, alpha included.
    pub fn channels(&self) -> usize {
        each_depth!(self, g => g.channels())
    }

    /// How samples are stored.
    pub fn depth(&self) -> Depth {
        match self {
            Self::U8(_) => Depth::U8,
            Self::U16(_) => Depth::U16,
            Self::F16(_) => Depth::F16,
            Self::F32(_) => Depth::F32,
        }
    }

    /// One sample as a number: 0..=255, 0..=65,535, or the float.
    #[inline]
    pub fn value(&self, channel: usize, index: usize) -> f64 {
        match self {
            Self::U8(g) => f64::from(g.plane(channel)[index]),
            Self::U16(g) => f64::from(g.plane(channel)[index]),
            Self::F16(g) => f16::from_bits(g.plane(channel)[index]).to_f64(),
            Self::F32(g) => f64::from(g.plane(channel)[index]),
        }
    }

    /// Sets a sample from a number: integers are rounded and held in their range.
    #[inline]
    pub fn set_value(&mut self, channel: usize, index: usize, value: f64) {
        match self {
            Self::U8(g) => g.plane_mut(channel)[index] = (value + 0.5) as u8,
            Self::U16(g) => g.plane_mut(channel)[index] = (value + 0.5) as u16,
            Self::F16(g) => g.plane_mut(channel)[index] = f16::from_f32(value as f32).to_bits(),
            Self::F32(g) => g.plane_mut(channel)[index] = value as f32,
        }
    }
}

/// How colour and alpha of a sample go together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Association {
    /// The colour is that of the thing, whatever its alpha: PNG, WebP, most TIFF.
    #[default]
    Straight,
    /// The colour is the light that arrives, so it was multiplied by alpha. There may be light where alpha is 0: EXR.
    Premultiplied,
}

/// A picture or clip, or one map of a material, in the depth of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane<const D: usize> {
    /// What the channels mean.
    pub role: Role,
    /// The samples, alpha last.
    pub samples: Samples<D>,
    /// Whether the last channel is alpha. Where it is 0, the sample is not valid, unless there is light.
    pub alpha: bool,
    /// How colour and alpha go together; of no meaning without alpha.
    pub association: Association,
}

impl<const D: usize> Plane<D> {
    /// A plane without alpha.
    pub fn new(role: Role, samples: Samples<D>) -> Self {
        Self { role, samples, alpha: false, association: Association::Straight }
    }

    /// A plane whose last channel is alpha, with straight colours.
    pub fn with_alpha(role: Role, samples: Samples<D>) -> Self {
        Self { role, samples, alpha: true, association: Association::Straight }
    }

    /// A plane of bytes as most buffers hold them: row by row, `channels` of each sample side by side.
    ///
    /// ```
    /// use selvedge_core::{Exemplars, Plane, Role};
    ///
    /// let plane = Plane::of_bytes(Role::Color, [1, 2], 3, &[255, 0, 0, 0, 0, 255])?; // red, blue
    /// let exemplars = Exemplars::of(&[&[plane]])?;
    /// # Ok::<(), selvedge_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Length`] or [`Error::Allocation`].
    pub fn of_bytes(role: Role, shape: [u32; D], channels: usize, bytes: &[u8]) -> Result<Self, Error> {
        let grid = Grid::from_interleaved(Domain::open(shape), channels, bytes)?;
        Ok(Self::new(role, Samples::U8(grid)))
    }

    /// The bytes of an 8-bit plane: the inverse of [`of_bytes`](Self::of_bytes), with alpha as the last channel if
    /// there is any.
    ///
    /// # Errors
    /// [`Error::NotBytes`] for other depths; [`Error::Allocation`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        match &self.samples {
            Samples::U8(grid) => grid.to_interleaved(),
            _ => Err(Error::NotBytes { layout: self.layout() }),
        }
    }

    /// Shape and topology.
    pub fn domain(&self) -> Domain<D> {
        self.samples.domain()
    }

    /// Channels without alpha.
    pub fn color_channels(&self) -> usize {
        self.samples.channels() - usize::from(self.alpha)
    }

    /// Whether colours were multiplied by an alpha that there is.
    pub fn is_premultiplied(&self) -> bool {
        self.alpha && self.association == Association::Premultiplied
    }

    /// Whether alpha, if there is any, is whole everywhere: such a picture is straight and premultiplied.
    pub fn is_opaque(&self) -> bool {
        let (last, full) = (self.samples.channels() - 1, self.samples.depth().full());
        !self.alpha || (0..self.domain().len()).all(|i| self.samples.value(last, i) == full)
    }

    /// Whether a sample shows anything: its alpha is not 0, or there is light all the same.
    #[inline]
    pub(crate) fn shows(&self, index: usize) -> bool {
        let last = self.samples.channels() - 1;
        let lit = || (0..last).any(|c| self.samples.value(c, index) != 0.0);
        !self.alpha || self.samples.value(last, index) != 0.0 || (self.is_premultiplied() && lit())
    }

    /// Where alpha is not 0 or there is light all the same; `None` for a plane without alpha.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn validity(&self) -> Result<Option<Grid<bool, D>>, Error> {
        if !self.alpha {
            return Ok(None);
        }
        let mut valid = Grid::try_filled(self.domain(), 1, true)?;
        for (i, v) in valid.plane_mut(0).iter_mut().enumerate() {
            *v = self.shows(i);
        }
        Ok(Some(valid))
    }

    /// What has to agree between the exemplars of one run, in words.
    pub(crate) fn layout(&self) -> String {
        let alpha = match (self.alpha, self.association) {
            (false, _) => "",
            (true, Association::Straight) => " and alpha",
            (true, Association::Premultiplied) => " and premultiplied alpha",
        };
        format!("{} {} channel(s){alpha}", self.color_channels(), self.samples.depth().name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_and_other_depths_are_none() {
        let bytes: Vec<u8> = (0..24).collect();
        assert_eq!(Plane::of_bytes(Role::Color, [2, 4], 3, &bytes).unwrap().to_bytes(), Ok(bytes));
        let wide = Plane::new(Role::Color, Samples::U16(Grid::try_filled(Domain::open([2, 4]), 3, 7).unwrap()));
        assert_eq!(wide.to_bytes().unwrap_err().to_string(), "3 u16 channel(s) are not bytes");
    }

    #[test]
    fn light_without_alpha_is_valid_where_colours_are_premultiplied() {
        let values = vec![0.0, 3.0, 0.0, 0.0, 0.0, 0.5];
        let samples = Samples::F32(Grid::from_vec(Domain::open([1, 3]), 2, values).unwrap());
        let straight = Plane::with_alpha(Role::Color, samples);
        let premultiplied = Plane { association: Association::Premultiplied, ..straight.clone() };
        let valid = |plane: &Plane<2>| plane.validity().unwrap().map(Grid::into_vec);
        assert_eq!(valid(&straight), Some(vec![false, false, true]));
        assert_eq!(valid(&premultiplied), Some(vec![false, true, true]));
        assert_ne!(straight.layout(), premultiplied.layout(), "they do not mix");
    }
}
