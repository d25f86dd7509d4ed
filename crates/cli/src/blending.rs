//! `--feather`, `--spline` and `--fuse`: seams hidden where a map is rendered. `[Kwatra03 5]`

use std::fmt;
use std::str::FromStr;

use clap::Args;
use selvedge_blending::{Feathered, Fused, Splined};
use selvedge_core::{Bytes, Domain, Grid, Plane, Render, Samples, SourceMap};
use serde_json::Value;

use crate::failure::Failure;
use crate::harmonise::{Layout, OPAQUE, fill, widened};
use crate::used::Used;
use crate::wrong::Wrong;

/// How seams are hidden. Samples that no seam is near are exact.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct Blending {
    /// Feather seams with a Gaussian kernel of this many pixels (its sigma), up to 16.
    #[arg(help_heading = "How seams are hidden", long, value_name = "SIGMA", conflicts_with_all = ["spline", "fuse"])]
    feather: Option<f64>,
    /// Spline seams over this many bands of detail, up to 5, or 'auto': coarse detail is blended widely, fine detail
    /// closely.
    #[arg(help_heading = "How seams are hidden", long, value_name = "BANDS", conflicts_with = "fuse")]
    spline: Option<Bands>,
    /// Fuse patches: they are raised and lowered until they meet, and keep their detail.
    #[arg(help_heading = "How seams are hidden", long)]
    fuse: bool,
    /// Fuse patches, and across seams ask for the stronger step of both, not for their mean.
    #[arg(help_heading = "How seams are hidden", long, conflicts_with_all = ["feather", "spline"])]
    fuse_mixed: bool,
    /// Fuse patches, and copy what is more pixels than that away from every seam; by default all may change a little.
    #[arg(help_heading = "How seams are hidden", long, value_name = "N", conflicts_with_all = ["feather", "spline"])]
    fuse_reach: Option<u32>,
    /// Whether it is told how seams are hidden where they are not.
    #[arg(skip)]
    told: bool,
}

/// A number of bands.
#[derive(Clone, Copy, Debug)]
enum Bands {
    /// As wide as the map's patches allow.
    Auto,
    Of(u32),
}

impl FromStr for Bands {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let wrong = |_| Wrong::new(format!("'{text}' is no number of bands"), "write a number from 0 to 5, or auto");
        text.parse().map(Self::Of).map_err(wrong)
    }
}

impl fmt::Display for Bands {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Of(bands) => write!(f, "{bands}"),
        }
    }
}

impl Bands {
    fn levels<const D: usize>(self, map: &SourceMap<D>) -> u32 {
        match self {
            Self::Auto => Splined::levels_for(map),
            Self::Of(bands) => bands,
        }
    }

    fn most(self) -> u32 {
        if let Self::Of(bands) = self { bands } else { Splined::<2>::MOST }
    }
}

impl Blending {
    /// Seams splined as widely as patches allow.
    pub(crate) const SPLINED: Self = Self { spline: Some(Bands::Auto), ..Self::NONE };

    /// Samples copied, also where a command would hide seams if it were told nothing.
    pub(crate) const COPIED: Self = Self { spline: Some(Bands::Of(0)), ..Self::NONE };

    /// Patches fused.
    pub(crate) const FUSED: Self = Self { fuse: true, ..Self::NONE };

    const NONE: Self =
        Self { feather: None, spline: None, fuse: false, fuse_mixed: false, fuse_reach: None, told: false };

    /// Checks what can be checked without a file.
    pub(crate) fn validate(self) -> Result<(), Failure> {
        self.feather.map_or(Ok(()), Feathered::<2>::validate)?;
        Ok(self.spline.map_or(Ok(()), |bands| Splined::<2>::validate(bands.most()))?)
    }

    /// True if samples are copied.
    pub(crate) fn is_none(self) -> bool {
        self.feather.is_none() && self.spline.is_none() && !self.is_fused()
    }

    /// True if patches are fused.
    pub(crate) fn is_fused(self) -> bool {
        self.fuse || self.fuse_mixed || self.fuse_reach.is_some()
    }

    /// What is done, in a word for who waits: splines of many bands and fusing take longer than the weave.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self { feather: Some(_), .. } => "feather",
            Self { spline: Some(_), .. } => "spline",
            _ if self.is_fused() => "fuse",
            _ => "render",
        }
    }

    /// The same of what is whole; what is not is not blended: holes would darken what is around them.
    pub(crate) fn of_whole(self, complete: bool) -> Self {
        if complete { self } else { Self::default() }
    }

    /// The same for all frames of a clip, so that none is blended more widely than another: as widely as patches of
    /// each allow.
    pub(crate) fn of_frames(self, maps: &[SourceMap<2>]) -> Self {
        let Some(Bands::Auto) = self.spline else { return self };
        let levels = maps.iter().map(Splined::levels_for).min().unwrap_or(1);
        Self { spline: Some(Bands::Of(levels)), ..self }
    }

    /// The map laid over planes; `valid` says by source what may show, and what is `kept` stays as it is.
    pub(crate) fn render<const D: usize>(
        self,
        map: &SourceMap<D>,
        valid: Vec<Option<&Grid<bool, D>>>,
        kept: Option<&Grid<bool, D>>,
        planes: &[&Plane<D>],
    ) -> Result<Plane<D>, Failure> {
        macro_rules! rendered {
            ($renderer:expr) => {{
                let renderer = $renderer;
                let renderer = if let Some(kept) = kept { renderer.keeping(kept)? } else { renderer };
                Ok(renderer.render(planes)?)
            }};
        }
        match self {
            Self { feather: Some(sigma), .. } => rendered!(Feathered::new(map, valid, sigma)?),
            Self { spline: Some(bands), .. } => rendered!(Splined::new(map, valid, bands.levels(map))?),
            _ if self.is_fused() => {
                let fused = Fused::new(map, valid)?;
                let fused = if self.fuse_mixed { fused.stronger() } else { fused };
                rendered!(if let Some(reach) = self.fuse_reach { fused.within(reach) } else { fused })
            }
            _ => Ok(map.render(planes)?),
        }
    }

    /// The same where `holes` says that there may be some: were they black for the blend, they would darken what is
    /// around them.
    pub(crate) fn render_around_holes<const D: usize>(
        self,
        map: &SourceMap<D>,
        valid: Vec<Option<&Grid<bool, D>>>,
        kept: Option<&Grid<bool, D>>,
        (planes, holes): (&[&Plane<D>], bool),
    ) -> Result<Plane<D>, Failure> {
        if !holes || self.is_none() || planes[0].alpha {
            return self.render(map, valid, kept, planes);
        }
        let layout = Layout { colors: planes[0].color_channels(), alpha: true };
        let wide = planes.iter().map(|plane| widened((*plane).clone(), layout)).collect::<Result<Vec<_>, _>>()?;
        Ok(opaque(self.render(map, valid, kept, &wide.iter().collect::<Vec<_>>())?, map))
    }

    /// An upper bound of what blending takes besides the picture, of which some may be kept as it is.
    pub(crate) fn bytes<const D: usize>(self, output: Domain<D>, channels: usize, kept: bool) -> Bytes {
        match self {
            Self { feather: Some(sigma), .. } => Feathered::bytes(output, channels, sigma),
            Self { spline: Some(bands), .. } => Splined::bytes(output, channels, bands.most()),
            _ if self.is_fused() => Fused::bytes(output, channels, kept || self.fuse_reach.is_some()),
            _ => Bytes(0),
        }
    }

    /// The options as used; fusing is told where it is done.
    pub(crate) fn used(self, used: Used) -> Used {
        let spline = self.spline.map(|bands| match bands {
            Bands::Auto => Value::from("auto"),
            Bands::Of(bands) => bands.into(),
        });
        let used = used.set("spline", spline).unless("fuse-mixed", false).unless("fuse-reach", Value::Null);
        let used = used.unless("fuse-keep", Value::Null);
        if self.is_fused() { used.set("fuse", true) } else { used.without("fuse") }
    }

    /// The same for commands that do not tell what they did not do.
    pub(crate) fn used_if_any(self, used: Used) -> Used {
        let used = self.used(used);
        if self.is_none() && !self.told { used.without("feather").without("spline") } else { used }
    }

    /// For a command that tells it all the same.
    pub(crate) fn told(self) -> Self {
        Self { told: true, ..self }
    }
}

/// The same, opaque wherever something stands in the map.
fn opaque<const D: usize>(mut plane: Plane<D>, map: &SourceMap<D>) -> Plane<D> {
    let (alpha, stands) = (plane.color_channels(), |i: usize| map.ids.plane(0)[i].is_assigned());
    match &mut plane.samples {
        Samples::U8(grid) => fill(grid.plane_mut(alpha), stands, OPAQUE.0),
        Samples::U16(grid) => fill(grid.plane_mut(alpha), stands, OPAQUE.1),
        Samples::F16(grid) => fill(grid.plane_mut(alpha), stands, OPAQUE.2),
        Samples::F32(grid) => fill(grid.plane_mut(alpha), stands, OPAQUE.3),
    }
    plane
}
