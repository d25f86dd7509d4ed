//! `--correspondence` as it is typed.

use std::str::FromStr;

use crate::wrong::Wrong;

/// What of the target is followed, and how much it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Correspondence {
    pub(super) what: What,
    pub(super) weight: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum What {
    Luminance,
    Orientation,
}

impl FromStr for Correspondence {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let remedy = "write luminance, orientation, or either with =WEIGHT";
        let wrong = || Wrong::new(format!("'{text}' is no correspondence"), remedy);
        let (what, weight) = text.split_once('=').unwrap_or((text, "1"));
        let what = match what {
            "luminance" => What::Luminance,
            "orientation" => What::Orientation,
            _ => return Err(wrong()),
        };
        Ok(Self { what, weight: weight.parse().map_err(|_| wrong())? })
    }
}

impl std::fmt::Display for Correspondence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", format!("{:?}", self.what).to_lowercase(), self.weight)
    }
}
