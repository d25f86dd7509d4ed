//! Which jumps are cut, and how.

use std::ops::RangeInclusive;

use selvedge_core::Domain;
use selvedge_graphcut_textures::video::{JumpOptions, LoopOptions};

use super::choices::JumpArg;
use super::transition::{MORE, TransitionArgs};
use crate::clips::ClipInput;
use crate::failure::Failure;

/// Frames of so many pixels tell at half the size which jumps are seen least: a tree of 320x240 takes the same jump of
/// eight in half of the time. Of one of 160x120 another one was taken.
const LARGE_FRAME: u64 = 320 * 240;

/// Windows of so many samples are cut at two sizes: 640x360 px in 60 frames take a third to four fifths of the time for
/// seams that are up to 2.1 % dearer, in the mean .4 (docs/video.md); with 29 frames as much, and smaller ones more.
const LARGE_WINDOW: u64 = 8_000_000;

impl TransitionArgs {
    /// At how many sizes seams are looked for, where that is typed.
    pub(super) fn levels(&self) -> Option<u32> {
        self.levels.0
    }

    /// The same as used for jumps, unless it is what a run takes by itself.
    pub(super) fn levels_of(&self, clip: Domain<3>) -> Option<u32> {
        self.levels().or(Some(self.options(clip).levels).filter(|levels| 1 < *levels))
    }

    /// Frames that a loop of so many of a clip may have, or of as many as are to be filled.
    pub(super) fn periods(&self, clip: &ClipInput, filled: Option<u32>) -> Result<RangeInclusive<u32>, Failure> {
        let frames = clip.info().frames;
        let periods = match &self.jump {
            Some(JumpArg(jump)) => jump.check(frames).map(|()| jump.period()..=jump.period()),
            None => self.asked(filled).periods(frames),
        };
        periods.map_err(|e| Failure::from(e).about(clip.path()))
    }

    /// Which jumps are asked for, where none is typed.
    pub(super) fn asked(&self, filled: Option<u32>) -> JumpOptions {
        let period = self.period.0.clone().or(filled.map(|frames| frames..=frames));
        JumpOptions { count: (self.jumps * MORE) as usize, period, ..JumpOptions::default() }
    }

    /// How jumps of a clip are cut.
    pub(super) fn options(&self, clip: Domain<3>) -> LoopOptions {
        let (pixels, held) = (clip.len() as u64 / u64::from(clip.shape[0]), self.window.min(clip.shape[0]));
        let is_large = LARGE_WINDOW <= pixels * u64::from(held);
        let levels = self.levels.0.unwrap_or(1 + u32::from(is_large));
        LoopOptions {
            window: self.window,
            seam: self.seams.measure(),
            // A jump that is typed is alone.
            jumps: if self.jump.is_some() { 1 } else { self.jumps as usize },
            levels,
            sifted: LARGE_FRAME <= pixels && self.levels.0 != Some(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::super::Video;
    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        video: Video,
    }

    #[test]
    fn large_frames_are_sifted_and_large_windows_cut_at_two_sizes() {
        let of = |line: &str, shape: [u32; 3]| {
            let line = Line::try_parse_from(["video", "clip", "-o", "out"].into_iter().chain(line.split_whitespace()))
                .unwrap()
                .video
                .transition;
            let LoopOptions { levels, sifted, jumps, .. } = line.options(Domain::open(shape));
            (levels, sifted, jumps, line.levels_of(Domain::open(shape)))
        };
        assert_eq!(of("", [100, 239, 320]), (1, false, 8, None));
        assert_eq!(of("", [100, 240, 320]), (1, true, 8, None));
        assert_eq!(of("", [100, 360, 640]), (2, true, 8, Some(2)));
        assert_eq!(of("", [20, 360, 640]), (1, true, 8, None), "there are no frames for a large window");
        assert_eq!(of("--window 20", [100, 360, 640]), (1, true, 8, None));
        assert_eq!(of("--levels 1", [100, 360, 640]), (1, false, 8, Some(1)));
        assert_eq!(of("--levels 3", [10, 60, 64]), (3, false, 8, Some(3)));
        assert_eq!(of("--levels 2", [10, 240, 320]), (2, true, 8, Some(2)));
        assert_eq!(of("--jump 70,3", [100, 360, 640]), (2, true, 1, Some(2)));
    }
}
