//! Sizes of pictures and of memory, as people write them.

use std::str::FromStr;

use clap::ValueEnum;
use selvedge_core::{Bytes, Domain};

use crate::wrong::Wrong;

/// Size of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Size {
    /// Width and height.
    Pixels(u32, u32),
    /// A multiple of the first exemplar's sides.
    Factor(f64),
}

impl FromStr for Size {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let wrong = || Wrong::new(format!("'{text}' is no size"), "write 512, 512x384 or 2x");
        let side = |s: &str| s.parse::<u32>().ok().filter(|&n| 0 < n).ok_or_else(wrong);
        if let Some(factor) = text.strip_suffix(['x', 'X']) {
            let factor: f64 = factor.parse().map_err(|_| wrong())?;
            return if factor.is_finite() && 0.0 < factor { Ok(Self::Factor(factor)) } else { Err(wrong()) };
        }
        match text.split_once(['x', 'X']) {
            Some((w, h)) => Ok(Self::Pixels(side(w)?, side(h)?)),
            None => side(text).map(|n| Self::Pixels(n, n)),
        }
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Pixels(w, h) => write!(f, "{w}x{h}"),
            Self::Factor(factor) => write!(f, "{factor}x"),
        }
    }
}

impl Size {
    /// Height and width for an exemplar of this shape; a side is at least 1.
    pub(crate) fn shape(self, exemplar: [u32; 2]) -> [u32; 2] {
        match self {
            Self::Pixels(w, h) => [h, w],
            // `as` saturates, and the caps on outputs refuse what is too large.
            Self::Factor(factor) => exemplar.map(|side| ((f64::from(side) * factor).round() as u32).max(1)),
        }
    }
}

/// Axes along which an output tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Tile {
    /// Left to right.
    X,
    /// Top to bottom.
    Y,
    /// Both.
    Xy,
}

impl Tile {
    /// The domain of an output.
    pub(crate) fn domain(tile: Option<Self>, shape: [u32; 2]) -> Domain<2> {
        let periodic = [matches!(tile, Some(Self::Y | Self::Xy)), matches!(tile, Some(Self::X | Self::Xy))];
        Domain { shape, periodic }
    }

    /// The axes along which a domain tiles.
    pub(crate) fn of(domain: Domain<2>) -> Option<Self> {
        match domain.periodic {
            [false, false] => None,
            [false, true] => Some(Self::X),
            [true, false] => Some(Self::Y),
            [true, true] => Some(Self::Xy),
        }
    }
}

/// An amount of memory, as people write it.
pub(crate) fn bytes(text: &str) -> Result<Bytes, Wrong> {
    let wrong = || Wrong::new(format!("'{text}' is no amount of memory"), "write 500MiB or 2GiB");
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let scale: u32 = match text[digits.len()..].to_ascii_lowercase().as_str() {
        "" | "b" => 1,
        "k" | "kib" => 1 << 10,
        "m" | "mib" => 1 << 20,
        "g" | "gib" => 1 << 30,
        "kb" => 1000,
        "mb" => 1_000_000,
        "gb" => 1_000_000_000,
        _ => return Err(wrong()),
    };
    let number: f64 = digits.trim().parse().map_err(|_| wrong())?;
    let bytes = number * f64::from(scale);
    // Beyond 2^63 it is no amount of memory.
    if (0.0..9.2e18).contains(&bytes) { Ok(Bytes(bytes as u64)) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_as_written() {
        let size = |s: &str| s.parse::<Size>().unwrap().shape([30, 20]);
        assert_eq!(size("512"), [512, 512]);
        assert_eq!(size("512x384"), [384, 512]);
        assert_eq!(size("2x"), [60, 40]);
        assert_eq!(size("0.01x"), [1, 1]);
        for wrong in ["", "0", "x", "-1", "5x0", "nanx", "infx", "1x2x3", "12 px"] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn memory_is_read_as_written() {
        assert_eq!(bytes("2GiB"), Ok(Bytes(2 << 30)));
        assert_eq!(bytes("500 MB"), Ok(Bytes(500_000_000)));
        assert_eq!(bytes("1024"), Ok(Bytes(1024)));
        assert_eq!(bytes("1.5KiB"), Ok(Bytes(1536)));
        assert!(bytes("2 giraffes").is_err());
        assert!(bytes("-1").is_err());
        assert!(bytes("99999999999GiB").is_err());
    }
}
