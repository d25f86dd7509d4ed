//! What can be written for some options of `hybrid`.

use std::fmt;

use selvedge_hybrid::{Layout, PixelSearch, Resynthesize, Split, Threshold};

use crate::values::choices;
use crate::wrong::Wrong;

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

choices!(LayoutArg for Layout {
    /// In rows and columns.
    Grid,
    /// Every other row moved by half a block.
    Brick,
});

choices!(SplitArg for Split {
    /// Where the seams of their parts are cheaper.
    Cheaper,
    /// Wherever they fit badly, as in the paper.
    Always,
});

choices!(SearchArg for PixelSearch {
    /// Those that continue what is around a pixel.
    Coherent,
    /// All of the exemplar, as in the paper.
    Exact,
});

choices!(ResynthesizeArg for Resynthesize {
    /// Near the cut, where that shows.
    Seam,
    /// All of the overlap that fits badly, as in the paper.
    Overlap,
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_read_as_they_are_written() {
        assert_eq!(["auto", "0.04", "7%"].map(|text| error(text).unwrap().to_string()), ["auto", "0.04", "7%"]);
        assert!(["", "much", "%"].into_iter().all(|text| error(text).is_err()));
    }
}
