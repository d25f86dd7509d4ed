//! Which frames of a clip are meant.

use std::fmt;
use std::str::FromStr;

use super::problem::ClipProblem;

/// Frames from `first` to `last`, every `step`-th: `1-100`, `1-100x2`, `7`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Range {
    /// Number of the first frame: that in its name, or its place in a container, from 1.
    pub first: u32,
    /// No frame has a greater number.
    pub last: u32,
    /// From one frame to the next; at least 1.
    pub step: u32,
}

impl Range {
    /// The numbers that are meant.
    pub fn numbers(self) -> impl Iterator<Item = u32> {
        (self.first..=self.last).step_by(self.step as usize)
    }

    /// Whether a number is meant.
    pub(crate) fn holds(self, number: u32) -> bool {
        (self.first..=self.last).contains(&number) && (number - self.first).is_multiple_of(self.step)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.first, self.last)?;
        if self.step == 1 { Ok(()) } else { write!(f, "x{}", self.step) }
    }
}

impl FromStr for Range {
    type Err = ClipProblem;

    fn from_str(text: &str) -> Result<Self, ClipProblem> {
        parsed(text).ok_or_else(|| ClipProblem::Range { text: text.to_owned() })
    }
}

fn parsed(text: &str) -> Option<Range> {
    let number = |text: &str| text.bytes().all(|b| b.is_ascii_digit()).then(|| text.parse::<u32>().ok()).flatten();
    let (span, step) = text.split_once('x').map_or((text, Some(1)), |(span, step)| (span, number(step)));
    let (first, last) = span.split_once('-').unwrap_or((span, span));
    let range = Range { first: number(first)?, last: number(last)?, step: step? };
    (range.first <= range.last && 0 < range.step).then_some(range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_as_they_are_shown() {
        for (text, shown, numbers) in
            [("1-7x3", "1-7x3", vec![1, 4, 7]), ("5", "5-5", vec![5]), ("0-1x1", "0-1", vec![0, 1])]
        {
            let range: Range = text.parse().unwrap();
            assert_eq!((range.to_string().as_str(), range.numbers().collect::<Vec<_>>()), (shown, numbers.clone()));
            assert_eq!((0..20).filter(|n| range.holds(*n)).collect::<Vec<_>>(), numbers);
        }
        for wrong in ["", "-", "2-1", "1-2x0", "1-2x", "x2", "a-b", "1-2-3", "+1-2", "1-99999999999"] {
            assert!(wrong.parse::<Range>().is_err(), "{wrong}");
        }
    }
}
