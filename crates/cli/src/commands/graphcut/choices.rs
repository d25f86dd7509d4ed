//! What can be written for some options of `graphcut`.

use clap::ValueEnum;
use selvedge_core::SeamMeasure;
use selvedge_graphcut_textures::Placement;
use serde_json::Value;

use crate::wrong::Wrong;

/// A number, or a choice by the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Auto(pub(super) Option<u32>);

/// A number of pixels down and one across, or a choice by the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sides(pub(super) Option<[u32; 2]>);

pub(super) fn number(text: &str) -> Result<Auto, Wrong> {
    match text {
        "auto" => Ok(Auto(None)),
        _ => text.parse().map(|n| Auto(Some(n))).map_err(|_| wrong(text, "write a number, or auto")),
    }
}

/// The sides of a region.
pub(super) fn sides(text: &str) -> Result<Sides, Wrong> {
    match text {
        "auto" => Ok(Sides(None)),
        _ => pixels(text).ok_or_else(|| wrong(text, "write 32, 48x32 (width by height), or auto")),
    }
}

/// How far from a region.
pub(super) fn reach(text: &str) -> Result<Sides, Wrong> {
    match text {
        "auto" => Ok(Sides(None)),
        "all" => Ok(Sides(Some([u32::MAX; 2]))),
        _ => pixels(text).ok_or_else(|| wrong(text, "write 16, 24x16 (across by down), auto or all")),
    }
}

fn wrong(text: &str, remedy: &str) -> Wrong {
    Wrong::new(format!("'{text}' is no number"), remedy)
}

fn pixels(text: &str) -> Option<Sides> {
    let number = |s: &str| s.parse::<u32>().ok();
    let both = match text.split_once(['x', 'X']) {
        Some((across, down)) => [number(down)?, number(across)?],
        None => [number(text)?; 2],
    };
    Some(Sides(Some(both)))
}

/// As [`pixels`] are written.
pub(super) fn typed([down, across]: [u32; 2]) -> Value {
    if down == across { down.into() } else { format!("{across}x{down}").into() }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum PlacementArg {
    /// Entire where the exemplar repeats itself, else sub.
    Auto,
    /// Anywhere.
    Random,
    /// Where the whole exemplar agrees with what is there.
    Entire,
    /// Where the exemplar agrees with what is there in the region.
    Sub,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum SeamArg {
    /// By the difference of the two patches.
    Difference,
    /// By that difference over their gradients.
    Gradient,
}

impl From<PlacementArg> for Placement {
    fn from(placement: PlacementArg) -> Self {
        match placement {
            PlacementArg::Auto => Self::Auto,
            PlacementArg::Random => Self::Random,
            PlacementArg::Entire => Self::Entire,
            PlacementArg::Sub => Self::Sub,
        }
    }
}

impl From<SeamArg> for SeamMeasure {
    fn from(seam: SeamArg) -> Self {
        match seam {
            SeamArg::Difference => Self::Difference,
            SeamArg::Gradient => Self::Gradient,
        }
    }
}
