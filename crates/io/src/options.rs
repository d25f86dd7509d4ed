//! How to read a picture.

use selvedge_core::{Limits, Role};

/// How to read a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// Caps on sides and samples, and the memory that reading may take. Default: 65,535 a side, 2^28 samples, all
    /// the memory there is.
    pub limits: Limits,
    /// What the plane's channels mean; no file says it. Default: colour.
    pub role: Role,
    /// What becomes of float samples that are no numbers. Default: an error.
    pub nonfinite: NonFinite,
    /// A layer, or channels separated by commas, of an EXR file. Default: its colour outside of
    /// layers, else that of its only layer, else its only channel.
    pub channels: Option<String>,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { limits: Limits::default(), role: Role::Color, nonfinite: NonFinite::Error, channels: None }
    }
}

/// What becomes of float samples that are infinite or no numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NonFinite {
    /// The picture is refused, with their count and the first position.
    #[default]
    Error,
    /// Each becomes 0.
    Zero,
    /// Infinities become the greatest and the least finite value, what is no number 0.
    Clamp,
}
