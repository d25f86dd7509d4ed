//! What can be written for some options of `graphcut`.

use clap::ValueEnum;
use selvedge_core::SeamMeasure;
use selvedge_graphcut_textures::Placement;

/// A number, or a choice by the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Auto(pub(super) Option<u32>);

/// The same, or the whole exemplar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach(pub(super) Option<u32>);

/// What is written instead of a number, and what it stands for.
pub(super) trait Words {
    const WORDS: &[(&str, Option<u32>)];
    fn of(value: Option<u32>) -> Self;
}

impl Words for Auto {
    const WORDS: &[(&str, Option<u32>)] = &[("auto", None)];
    fn of(value: Option<u32>) -> Self {
        Self(value)
    }
}

impl Words for Reach {
    const WORDS: &[(&str, Option<u32>)] = &[("auto", None), ("all", Some(u32::MAX))];
    fn of(value: Option<u32>) -> Self {
        Self(value)
    }
}

pub(super) fn number_or<W: Words>(text: &str) -> Result<W, String> {
    if let Some((_, value)) = W::WORDS.iter().find(|(word, _)| *word == text) {
        return Ok(W::of(*value));
    }
    let words: Vec<&str> = W::WORDS.iter().map(|(word, _)| *word).collect();
    text.parse().map(|n| W::of(Some(n))).map_err(|_| format!("write a number, or {}", words.join(" or ")))
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
