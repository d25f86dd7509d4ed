//! What of a picture is followed, as it is typed: `--correspondence` and `--auto-guides`.

use std::str::FromStr;

use clap::ValueEnum as _;
use selvedge_core::Guide;
use selvedge_guides::{Error, blur, edge_distance, orientation, position};

use crate::wrong::Wrong;

/// Samples over which gradients are averaged for orientation, where no blur says more.
const LEAST_AVERAGE: f64 = 2.0;
/// What is blurred tells of what is larger than strokes and grains.
const LEAST_BLUR: f64 = 4.0;
/// Edges tell of what is nearer than that: a guess, more than the strokes of most pictures are wide. Farther ones would
/// make one ramp of a picture with few edges.
const FARTHEST: u32 = 32;

/// What of the target is followed, and how much it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Correspondence {
    pub(crate) what: What,
    pub(crate) weight: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum What {
    Luminance,
    Blur,
    Orientation,
    Edge,
    Position,
}

impl What {
    /// Channels of the guide at most.
    pub(crate) const CHANNELS: usize = 2;

    /// The guide that luminance makes, blurred by a Gaussian of so many samples at least.
    pub(crate) fn of(self, light: &Guide<2>, sigma: f64) -> Result<Guide<2>, Error> {
        match self {
            Self::Luminance => light.derive(|map| blur(map, sigma)),
            Self::Blur => light.derive(|map| blur(map, sigma.max(LEAST_BLUR))),
            Self::Orientation => light.derive(|map| orientation(map, sigma.max(LEAST_AVERAGE))),
            Self::Edge => light.derive(|map| edge_distance(&blur(map, sigma)?, FARTHEST)),
            Self::Position => light.derive(|map| position(map.domain())),
        }
    }
}

impl FromStr for Correspondence {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let remedy = "write luminance, blur, orientation, edge or position, or one of them with =WEIGHT";
        let wrong = || Wrong::new(format!("'{text}' is no correspondence"), remedy);
        let (what, weight) = text.split_once('=').unwrap_or((text, "1"));
        let what = What::from_str(what, false).map_err(|_| wrong())?;
        Ok(Self { what, weight: weight.parse().map_err(|_| wrong())? })
    }
}

impl std::fmt::Display for Correspondence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", format!("{:?}", self.what).to_lowercase(), self.weight)
    }
}
