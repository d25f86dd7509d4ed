//! How fast a clip plays.

use std::fmt;
use std::str::FromStr;

use super::problem::ClipProblem;
use crate::Warning;

/// Frames a second, as a fraction in its lowest terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate {
    num: u32,
    den: u32,
}

impl Rate {
    /// 25 frames a second: what is written where nobody says how fast a clip plays, and a container has to.
    pub const USUAL: Self = Self { num: 25, den: 1 };

    /// `num / den` frames a second; `None` for 0 and for a denominator of 0.
    pub fn new(num: u32, den: u32) -> Option<Self> {
        let by = gcd(num, den);
        (num != 0 && den != 0).then(|| Self { num: num / by, den: den / by })
    }

    /// Frames in `den` seconds.
    pub const fn num(self) -> u32 {
        self.num
    }

    /// Seconds in which `num` frames are shown.
    pub const fn den(self) -> u32 {
        self.den
    }

    /// The rate of so many frames in so many ticks of a clock, rounded where the fraction has too many digits.
    pub fn of_ticks(frames: u64, ticks: u64, ticks_a_second: u64) -> Option<Self> {
        let (mut num, mut den) = (frames.checked_mul(ticks_a_second)?, ticks);
        let by = gcd_64(num, den).max(1);
        (num, den) = (num / by, den / by);
        while u64::from(u32::MAX) < num.max(den) {
            (num, den) = (num / 2, den / 2);
        }
        Self::new(num as u32, den as u32)
    }

    /// How many ticks of a clock frame number `frame`, from 0, lasts: each begins at the tick nearest to its time, so
    /// that no error adds up.
    pub fn ticks(self, frame: u32, ticks_a_second: u32) -> u32 {
        let begins = |frame: u32| {
            let ticks = u128::from(frame) * u128::from(self.den) * u128::from(ticks_a_second);
            (2 * ticks + u128::from(self.num)) / (2 * u128::from(self.num))
        };
        (begins(frame + 1) - begins(frame)) as u32
    }
}

/// How long frames are shown, in ticks of a clock.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Delays {
    frames: u64,
    ticks: u64,
    least: Option<u64>,
    most: u64,
}

impl Delays {
    /// One more frame.
    pub(super) fn add(&mut self, ticks: u64) {
        self.frames += 1;
        self.ticks = self.ticks.saturating_add(ticks);
        self.least = Some(self.least.map_or(ticks, |least| least.min(ticks)));
        self.most = self.most.max(ticks);
    }

    /// How many there are.
    pub(super) fn frames(&self) -> u32 {
        u32::try_from(self.frames).unwrap_or(u32::MAX)
    }

    /// The rate in the mean.
    pub(super) fn rate(&self, ticks_a_second: u64) -> Option<Rate> {
        Rate::of_ticks(self.frames, self.ticks, ticks_a_second)
    }

    /// Says that frames are not shown equally long, by more than a tick of the format, which rounding explains.
    pub(super) fn uneven(&self, tick: u64) -> Option<Warning> {
        let least = self.least.unwrap_or(0);
        (tick < self.most - least.min(self.most)).then_some(Warning::UnevenDelays)
    }
}

const fn gcd(a: u32, b: u32) -> u32 {
    gcd_64(a as u64, b as u64) as u32
}

const fn gcd_64(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// `30`, or `30000/1001`.
impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.num)?;
        if self.den == 1 { Ok(()) } else { write!(f, "/{}", self.den) }
    }
}

/// `30`, `30000/1001` and `12.5`.
impl FromStr for Rate {
    type Err = ClipProblem;

    fn from_str(text: &str) -> Result<Self, ClipProblem> {
        parsed(text).ok_or_else(|| ClipProblem::Rate { text: text.to_owned() })
    }
}

fn parsed(text: &str) -> Option<Rate> {
    if let Some((num, den)) = text.split_once(['/', ':']) {
        return Rate::new(num.parse().ok()?, den.parse().ok()?);
    }
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    let digits = format!("{whole}{part}");
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    Rate::new(digits.parse().ok()?, 10_u32.checked_pow(part.len() as u32)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_read_as_they_are_shown() {
        for (text, shown) in [("30", "30"), ("30000/1001", "30000/1001"), ("12.5", "25/2"), ("50:2", "25")] {
            assert_eq!(text.parse::<Rate>().unwrap().to_string(), shown);
        }
        for wrong in ["", "0", "1/0", "0/1", "-1", "x", "1e3", "+5", "1.2.3", "99999999999", ".", "1/2/3"] {
            assert!(wrong.parse::<Rate>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn ticks_average_to_the_rate() {
        let ticks = |rate: &str, n| (0..n).map(|i| rate.parse::<Rate>().unwrap().ticks(i, 100)).collect::<Vec<_>>();
        assert_eq!(ticks("30", 6), [3, 4, 3, 3, 4, 3]);
        assert_eq!(ticks("30", 3000).iter().sum::<u32>(), 10_000);
        assert_eq!(ticks("25", 3), [4, 4, 4]);
        assert_eq!(Rate::of_ticks(3, 10, 100), Rate::new(30, 1));
        assert_eq!(Rate::of_ticks(3, 0, 100), None);
    }
}
