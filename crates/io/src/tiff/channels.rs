//! Which channels of a page are the picture: its colours, and alpha wherever it stands beside them.

use selvedge_core::{Association, Samples};
use tiff::ColorType;

use crate::codec::Context;
use crate::error::Problem;
use crate::header::Header;
use crate::samples::zero_grid;
use crate::{Format, Warning};

/// How the file's samples become ours.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Colors {
    AsStored,
    Palette,
    YCbCr,
    Cmyk,
}

/// What a file is that the decoder is shown as grey with channels beside it.
pub(super) enum Shown {
    AsItIs,
    Rgb,
    /// With its colours.
    Palette(Vec<u16>),
}

/// Channels of a page.
pub(super) struct Channels {
    /// How many the decoder gives.
    pub(super) given: usize,
    /// Those of the picture, if not all that are given.
    pub(super) kept: Option<Vec<usize>>,
    pub(super) colors: Colors,
    /// How colours stand to the last one, if that is alpha.
    pub(super) alpha: Option<Association>,
}

impl Channels {
    /// By the decoder's word and the kinds of those beside colour; all that are given where some were `chosen`.
    pub(super) fn of(color: ColorType, shown: &Shown, extra: &[u64], chosen: bool) -> Result<Self, Problem> {
        let given = |given, colors| Self { given, kept: None, colors, alpha: None };
        Ok(match color {
            ColorType::Gray(_) if matches!(shown, Shown::Palette(_)) => given(1, Colors::Palette),
            ColorType::Gray(_) => given(1, Colors::AsStored),
            ColorType::RGB(_) => given(3, Colors::AsStored),
            ColorType::RGBA(_) => {
                let alpha = alpha_of(extra).map_or(Association::Straight, |(_, alpha)| alpha);
                Self { alpha: Some(alpha), ..given(4, Colors::AsStored) }
            }
            ColorType::YCbCr(8) => given(3, Colors::YCbCr),
            ColorType::CMYK(8 | 16) => given(4, Colors::Cmyk),
            ColorType::Multiband { num_samples, .. } if chosen => given(num_samples.into(), Colors::AsStored),
            ColorType::Multiband { num_samples, .. } => Self::beside(num_samples.into(), shown, extra),
            other => return Err(Problem::unsupported(Format::Tiff, format!("colour type {other:?}"))),
        })
    }

    /// Colours, and others beside them.
    fn beside(given: usize, shown: &Shown, extra: &[u64]) -> Self {
        let (n, colors) = match shown {
            Shown::AsItIs => (1, Colors::AsStored),
            Shown::Rgb => (3, Colors::AsStored),
            Shown::Palette(_) => (1, Colors::Palette),
        };
        let alpha = alpha_of(extra).filter(|(i, _)| n + i < given && colors == Colors::AsStored);
        let kept: Vec<usize> = (0..n).chain(alpha.map(|(i, _)| n + i)).collect();
        Self { given, kept: (kept.len() < given).then_some(kept), colors, alpha: alpha.map(|(_, alpha)| alpha) }
    }

    /// Those of the picture, once they are colours.
    pub(super) fn of_picture(&self) -> usize {
        match self.colors {
            Colors::AsStored => self.kept.as_ref().map_or(self.given, Vec::len),
            _ => 3,
        }
    }

    /// Tells which of `all` that the file has are not in the picture.
    pub(super) fn tell(&self, all: usize, context: &mut Context<'_>) {
        let kept = |c: &usize| self.kept.as_ref().map_or(*c < self.given, |kept| kept.contains(c));
        let mut left = (0..all).filter(|c| !kept(c));
        let Some(first) = left.next() else { return };
        let (more, are, reads) = match left.count() {
            0 => (1, "is", "it"),
            others => (1 + others, "are", "the first"),
        };
        let what = format!(
            "{more} of its {all} channels {are} neither colour nor alpha and left out; 'file.tif[{}]' reads {reads}",
            first + 1
        );
        context.warn(Warning::ChannelsLeftOut { what });
    }
}

/// Some channels of a picture, in this order; `header` is that of them.
pub(super) fn picked(samples: &Samples<2>, header: &Header, channels: &[usize]) -> Result<Samples<2>, Problem> {
    macro_rules! picked {
        ($depth:ident, $grid:ident) => {{
            let mut picked = zero_grid(header)?;
            for (to, &from) in channels.iter().enumerate() {
                picked.plane_mut(to).copy_from_slice($grid.plane(from));
            }
            Samples::$depth(picked)
        }};
    }
    Ok(match samples {
        Samples::U8(grid) => picked!(U8, grid),
        Samples::U16(grid) => picked!(U16, grid),
        Samples::F16(grid) => picked!(F16, grid),
        Samples::F32(grid) => picked!(F32, grid),
    })
}

/// Which of the channels beside colour is alpha, from 0, and how colours stand to it.
pub(super) fn alpha_of(extra: &[u64]) -> Option<(usize, Association)> {
    extra.iter().enumerate().find_map(|(i, kind)| Some((i, association(*kind)?)))
}

/// How colours stand to a channel of this kind [TIFF 6.0 18], if it is alpha.
pub(super) fn association(kind: u64) -> Option<Association> {
    match kind {
        1 => Some(Association::Premultiplied),
        2 => Some(Association::Straight),
        _ => None,
    }
}
