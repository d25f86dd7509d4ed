//! What the options of `video` may be.

use std::ops::RangeInclusive;
use std::str::FromStr;

use selvedge_graphcut_textures::video::Jump;

use crate::values::parsed;
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

/// Width and height of an output, and its frames where they are typed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClipSize {
    pub(super) frame: [u32; 2],
    pub(super) frames: Option<u32>,
}

impl FromStr for ClipSize {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let wrong = || {
            Wrong::new(
                format!("'{text}' is no size of a clip"),
                "write 210x160x100, with 2 to 1000000 frames, or 210x160",
            )
        };
        let sides: Option<Vec<u32>> = text.split(['x', 'X']).map(|side| side.parse().ok().filter(|&n| 0 < n)).collect();
        match sides.as_deref() {
            Some(&[width, height]) => Ok(Self { frame: [height, width], frames: None }),
            Some(&[width, height, frames]) if (2..=1_000_000).contains(&frames) => {
                Ok(Self { frame: [height, width], frames: Some(frames) })
            }
            _ => Err(wrong()),
        }
    }
}

/// Frames, height and width: a cube's side, or width by height by frames.
pub(super) fn volume(text: &str) -> Option<[u32; 3]> {
    let sides: Option<Vec<u32>> = text.split(['x', 'X']).map(parsed).collect();
    match *sides? {
        [side] => Some([side; 3]),
        [width, height, frames] => Some([frames, height, width]),
        _ => None,
    }
}

/// The same as far as anything goes.
pub(super) fn reach(text: &str) -> Option<[u32; 3]> {
    // What is beyond the longest side there is was meant otherwise.
    let sane = |sides: &[u32; 3]| sides.iter().all(|&side| side <= u32::from(u16::MAX));
    if text == "all" { Some([u32::MAX; 3]) } else { volume(text).filter(sane) }
}

/// As volumes are typed.
pub(super) fn typed([frames, height, width]: [u32; 3]) -> String {
    format!("{width}x{height}x{frames}")
}

/// The same of a reach.
pub(super) fn typed_reach(sides: [u32; 3]) -> String {
    if sides.iter().all(|&side| u32::from(u16::MAX) < side) { "all".into() } else { typed(sides) }
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
        let size = |text: &str| text.parse::<ClipSize>().ok().map(|size| (size.frame, size.frames));
        assert_eq!(
            [size("210x160x100"), size("20x30"), size("20"), size("0x1"), size("1x2x3x4"), size("x")],
            [Some(([160, 210], Some(100))), Some(([30, 20], None)), None, None, None, None]
        );
        assert_eq!(
            [volume("40x30x20"), volume("8"), volume("8x8"), reach("all")].map(|v| v.map(typed)),
            [Some("40x30x20".into()), Some("8x8x8".into()), None, Some(typed([u32::MAX; 3]))]
        );
        let jump = |text: &str| text.parse::<JumpArg>().ok().map(|jump| (jump.0.from, jump.0.to));
        assert_eq!([jump("57,3"), jump("3,57"), jump("3"), jump("3,3")], [Some((57, 3)), None, None, None]);
    }
}
