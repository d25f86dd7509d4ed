//! What can be written for some options of `hybrid`.

use std::fmt;

use clap::ValueEnum;
use selvedge_hybrid::{Layout, PixelSearch, Resynthesize, Threshold};

use crate::wrong::Wrong;

/// Height and width of start blocks, or a choice by the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block(pub(super) Option<[u32; 2]>);

pub(super) fn block(text: &str) -> Result<Block, Wrong> {
    let number = |s: &str| s.parse::<u32>().ok();
    let both = || match text.split_once(['x', 'X']) {
        Some((across, down)) => Some([number(down)?, number(across)?]),
        None => Some([number(text)?; 2]),
    };
    match text {
        "auto" => Ok(Block(None)),
        _ => both()
            .map(|sides| Block(Some(sides)))
            .ok_or_else(|| Wrong::new(format!("'{text}' is no block"), "write 32, 64x32 (width by height), or auto")),
    }
}

/// As blocks are written.
pub(super) fn typed([down, across]: [u32; 2]) -> String {
    if down == across { down.to_string() } else { format!("{across}x{down}") }
}

/// How large an error may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Error(pub(super) Threshold);

pub(super) fn error(text: &str) -> Result<Error, Wrong> {
    let wrong = |_| {
        let remedy = "write an error from 0 to 1, a part of that of random samples such as 20%, or auto";
        Wrong::new(format!("'{text}' is no error"), remedy)
    };
    Ok(Error(match (text, text.strip_suffix('%')) {
        ("auto", _) => Threshold::Auto,
        (_, Some(percent)) => Threshold::OfRandom(percent.parse::<f64>().map_err(wrong)? / 100.0),
        _ => Threshold::Absolute(text.parse().map_err(wrong)?),
    }))
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Threshold::Auto => f.write_str("auto"),
            // As it was typed: 7 % of one is 7.000000000000001 hundredths.
            Threshold::OfRandom(part) => write!(f, "{}%", (part * 1e8).round() / 1e6),
            Threshold::Absolute(error) => write!(f, "{error}"),
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum LayoutArg {
    /// In rows and columns.
    Grid,
    /// Every other row moved by half a block.
    Brick,
}

impl From<LayoutArg> for Layout {
    fn from(layout: LayoutArg) -> Self {
        match layout {
            LayoutArg::Grid => Self::Grid,
            LayoutArg::Brick => Self::Brick,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum SearchArg {
    /// Those that continue what is around a pixel.
    Coherent,
    /// All of the exemplar, as in the paper.
    Exact,
}

impl From<SearchArg> for PixelSearch {
    fn from(search: SearchArg) -> Self {
        match search {
            SearchArg::Coherent => Self::Coherent,
            SearchArg::Exact => Self::Exact,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum ResynthesizeArg {
    /// Near the cut, where that shows.
    Seam,
    /// All of the overlap that fits badly, as in the paper.
    Overlap,
}

impl From<ResynthesizeArg> for Resynthesize {
    fn from(what: ResynthesizeArg) -> Self {
        match what {
            ResynthesizeArg::Seam => Self::Seam,
            ResynthesizeArg::Overlap => Self::Overlap,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_and_errors_are_read_as_they_are_written() {
        assert_eq!(block("auto").unwrap().0, None);
        assert_eq!([block("32"), block("64x32")].map(|b| b.unwrap().0.map(typed).unwrap()), ["32", "64x32"]);
        assert_eq!(["auto", "0.04", "7%"].map(|text| error(text).unwrap().to_string()), ["auto", "0.04", "7%"]);
        for text in ["", "x", "3x", "1x2x3", "-4"] {
            assert!(block(text).is_err(), "{text}");
        }
        assert!(["", "much", "%"].into_iter().all(|text| error(text).is_err()));
    }
}
