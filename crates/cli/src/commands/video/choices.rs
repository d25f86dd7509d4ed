//! What the options of `video` may be.

use std::ops::RangeInclusive;
use std::str::FromStr;

use selvedge_graphcut_textures::video::Jump;

use crate::wrong::Wrong;

/// How many frames a loop may have.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Period(pub(super) Option<RangeInclusive<u32>>);

impl FromStr for Period {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let wrong = || Wrong::new(format!("'{text}' is no period"), "write auto, 64 or 48..96, from 2 frames on");
        if text == "auto" {
            return Ok(Self(None));
        }
        let (least, most) = text.split_once("..").unwrap_or((text, text));
        let frames = |text: &str| text.parse::<u32>().map_err(|_| wrong());
        let (least, most) = (frames(least)?, frames(most)?);
        if least < 2 || most < least { Err(wrong()) } else { Ok(Self(Some(least..=most))) }
    }
}

/// A jump by the frames around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JumpArg(pub(super) Jump);

impl FromStr for JumpArg {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let wrong = || Wrong::new(format!("'{text}' is no jump"), "write LAST,FIRST, such as 57,3, counted from 0");
        let (from, to) = text.split_once(',').ok_or_else(wrong)?;
        let frame = |text: &str| text.parse::<u32>().map_err(|_| wrong());
        let (from, to) = (frame(from)?, frame(to)?);
        if from <= to { Err(wrong()) } else { Ok(Self(Jump { from, to, error: 0.0 })) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn periods_and_jumps_are_read() {
        let period = |text: &str| text.parse::<Period>().map(|period| period.0).ok();
        assert_eq!(
            [period("auto"), period("64"), period("48..96")],
            [Some(None), Some(Some(64..=64)), Some(Some(48..=96))]
        );
        for wrong in ["", "1", "0..5", "9..3", "a", "3..", "-4"] {
            assert_eq!(period(wrong), None, "{wrong}");
        }
        let jump = |text: &str| text.parse::<JumpArg>().ok().map(|jump| (jump.0.from, jump.0.to));
        assert_eq!([jump("57,3"), jump("3,57"), jump("3"), jump("3,3")], [Some((57, 3)), None, None, None]);
    }
}
