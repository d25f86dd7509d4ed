//! `--feather` and `--spline`: seams hidden where a map is rendered. `[Kwatra03 5]`

use clap::Args;
use selvedge_blending::{Feathered, Splined};
use selvedge_core::{Domain, Grid, Plane, Render, SourceMap};

use crate::failure::Failure;

/// How seams are hidden.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct Blending {
    /// Feather seams with a Gaussian kernel of this many pixels (its sigma), up to 16.
    #[arg(long, value_name = "SIGMA", conflicts_with = "spline")]
    feather: Option<f64>,
    /// Spline seams over this many bands of detail, up to 5: coarse detail is blended widely, fine detail closely.
    #[arg(long, value_name = "BANDS")]
    spline: Option<u32>,
}

impl Blending {
    /// Checks what can be checked without a file.
    pub(crate) fn validate(self) -> Result<(), Failure> {
        self.feather.map_or(Ok(()), Feathered::<2>::validate)?;
        Ok(self.spline.map_or(Ok(()), Splined::<2>::validate)?)
    }

    /// True if samples are copied.
    pub(crate) fn is_none(self) -> bool {
        self.feather.is_none() && self.spline.is_none()
    }

    /// The map laid over planes; `valid` says by source what may show, and what is `kept` stays as it is.
    pub(crate) fn render(
        self,
        map: &SourceMap<2>,
        valid: Vec<Option<&Grid<bool, 2>>>,
        kept: Option<&Grid<bool, 2>>,
        planes: &[&Plane<2>],
    ) -> Result<Plane<2>, Failure> {
        if let Some(sigma) = self.feather {
            let feathered = Feathered::new(map, valid, sigma)?;
            let feathered = if let Some(kept) = kept { feathered.keeping(kept)? } else { feathered };
            return Ok(feathered.render(planes)?);
        }
        if let Some(bands) = self.spline {
            let splined = Splined::new(map, valid, bands)?;
            let splined = if let Some(kept) = kept { splined.keeping(kept)? } else { splined };
            return Ok(splined.render(planes)?);
        }
        Ok(map.render(planes)?)
    }

    /// An upper bound of what blending takes besides the picture.
    pub(crate) fn memory(self, output: Domain<2>, channels: usize) -> u64 {
        let feathered = self.feather.map_or(0, |sigma| Feathered::bytes(output, channels, sigma));
        self.spline.map_or(feathered, |bands| Splined::bytes(output, channels, bands))
    }
}
