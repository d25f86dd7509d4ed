//! What of a target is followed, and how widely its light is spread.

use std::str::FromStr;

use selvedge_core::Grid;

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

/// Levels between the darkest and the lightest twentieth.
pub(super) fn spread<'m>(maps: impl Iterator<Item = &'m Grid<u8, 2>>) -> usize {
    let mut counts = [0_u64; 256];
    maps.flat_map(|map| map.samples()).for_each(|v| counts[usize::from(*v)] += 1);
    let rest = counts.iter().sum::<u64>() / 20;
    let skipped = |levels: &mut dyn Iterator<Item = &u64>| {
        let mut passed = 0;
        levels
            .take_while(|n| {
                passed += **n;
                passed <= rest
            })
            .count()
    };
    let (dark, light) = (skipped(&mut counts.iter()), skipped(&mut counts.iter().rev()));
    255_usize.saturating_sub(dark + light)
}
