//! Which way a clip goes on, and in what size.

use std::ops::RangeInclusive;

use clap::Args;
use selvedge_core::Domain;

use super::choices::ClipSize;
use crate::clips::ClipInput;
use crate::failure::{Failure, n};
use crate::size::Tile;

/// What the output is to be.
#[derive(Args, Clone, Debug)]
pub(super) struct ModeArgs {
    /// How the clip goes on.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = ModeArg::Auto)]
    mode: ModeArg,
    /// Frames to make. Default: what a jump gives, or twice as many as the clip has.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    pub(super) frames: Option<u32>,
    /// Width, height and frames to make: 210x160x100, or 210x160. Default: frames of the clip's size.
    #[arg(long, value_name = "WxHxN")]
    pub(super) size: Option<ClipSize>,
    /// Play the loop again and again, or by several loops in turn, for so many frames as --frames says.
    #[arg(long, value_enum, value_name = "HOW", requires = "frames", conflicts_with = "blend")]
    play: Option<PlayArg>,
    /// Make frames that tile along x, y or both.
    #[arg(long, value_enum, value_name = "AXES")]
    tile: Option<Tile>,
    /// Whether what is woven loops, and how.
    #[arg(long = "loop", value_enum, value_name = "HOW", default_value_t = LoopArg::Periodic)]
    pub(super) looping: LoopArg,
    /// Frames that --loop fixed begins and ends with. Default: 10, or a third of the clip or of the output where that
    /// is less.
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=65_534))]
    pub(super) keep: Option<u32>,
}

/// How a clip goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum ModeArg {
    /// Transition where frames keep their size and a jump closes, else temporal; spacetime for another size.
    Auto,
    /// By a jump back, made at each pixel when it is seen least.
    Transition,
    /// By the clip laid over itself again and again, moved in time.
    Temporal,
    /// By pieces of it, moved in space and time.
    Spacetime,
}

/// How what is woven loops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum LoopArg {
    /// Time has no end.
    Periodic,
    /// It begins and ends with the same frames of the clip.
    Fixed,
    /// It has a begin and an end.
    No,
}

/// How a loop is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum PlayArg {
    /// The same again and again.
    Loop,
    /// From jump to jump, each drawn by the seed: no period is seen.
    Random,
}

/// How many frames `--loop fixed` keeps. `[Kwatra03 7D]`
const KEEP: u32 = 10;

/// The way that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Way {
    /// Never auto.
    pub(super) mode: ModeArg,
    /// Weave in time alone if no jump closes.
    pub(super) or_woven: bool,
    /// What is woven.
    pub(super) output: Domain<3>,
    /// How what is cut is played, for all frames of the output.
    pub(super) play: Option<PlayArg>,
    /// Frames at both ends of it, for `--loop fixed`.
    pub(super) keep: u32,
    /// Frames that are woven at once, where that is not all of them.
    pub(super) at_once: Option<u32>,
    /// Whether the clip is read again for the frames that are written, and not held while they are woven.
    pub(super) is_read_again: bool,
    /// Why, where the program chose.
    pub(super) why: Option<String>,
}

impl ModeArgs {
    /// Chooses by what was typed: a first option that only jumps have, and one that only what is woven has.
    pub(super) fn way(
        &self,
        clip: &ClipInput,
        (filled, begun): (Option<u32>, Option<[u32; 3]>),
        (of_jumps, of_woven): (Option<&str>, Option<&str>),
    ) -> Result<Way, Failure> {
        let (keep, output) = self.output(clip, filled, begun)?;
        let of_jumps = of_jumps.or(self.play.is_some().then_some("--play"));
        let has = clip.domain().shape;
        let resized = output.shape[1..] != has[1..] || self.tile.is_some();
        let of_woven = of_woven.or((self.looping != LoopArg::Periodic).then_some("--loop"));
        let (mode, why) = match self.mode {
            ModeArg::Auto if resized => (ModeArg::Spacetime, Some("frames of another size".to_owned())),
            ModeArg::Auto => match (of_jumps, of_woven) {
                (Some(_), _) => (ModeArg::Transition, None),
                (None, Some(option)) => (ModeArg::Temporal, Some(format!("{option} is none of a jump's"))),
                (None, None) if has[0] < self.frames().or(filled).unwrap_or(0) => {
                    (ModeArg::Temporal, Some(format!("the clip has {}", n("frame", has[0] as usize))))
                }
                (None, None) => (ModeArg::Transition, None),
            },
            typed => (typed, None),
        };
        let or_woven = self.mode == ModeArg::Auto && mode == ModeArg::Transition && of_jumps.is_none();
        let play = self.play;
        let way = Way { mode, or_woven, output, play, keep, at_once: None, is_read_again: false, why };
        way.check(has, of_jumps, of_woven).map(|()| way)
    }

    /// Frames that were asked for.
    pub(super) fn frames(&self) -> Option<u32> {
        self.frames.or(self.size.and_then(|size| size.frames))
    }

    /// What is woven, and the frames at both ends; of the size that it was begun with.
    fn output(
        &self,
        clip: &ClipInput,
        filled: Option<u32>,
        begun: Option<[u32; 3]>,
    ) -> Result<(u32, Domain<3>), Failure> {
        if self.frames.is_some() && self.size.is_some_and(|size| size.frames.is_some()) {
            return Err(Failure::new(2, "--frames and --size both say how many frames").remedy("leave one of them out"));
        }
        if let (Some(keep), false) = (self.keep, self.looping == LoopArg::Fixed) {
            let what = format!("--keep {keep} says what --loop fixed begins and ends with");
            return Err(Failure::new(2, what).remedy("leave it out, or give --loop fixed"));
        }
        let [has, height, width] = clip.domain().shape;
        let frames = self.frames().or(filled).or(begun.map(|of| of[0])).unwrap_or(has.saturating_mul(2));
        let keep = self.keep.unwrap_or_else(|| KEEP.min(has / 3).min(frames / 3).max(1));
        let keep = if self.looping == LoopArg::Fixed { keep } else { 0 };
        if 0 < keep && has.min(frames) <= keep {
            let what = format!("--keep {keep} leaves nothing between, of {has} frames or of {frames}");
            return Err(Failure::new(2, what).remedy(format!("use --keep {} or less", has.min(frames) - 1)));
        }
        let of_start = begun.map_or([height, width], |[_, height, width]| [height, width]);
        let [height, width] = self.size.map_or(of_start, |size| size.frame);
        if let Some(of) = begun {
            check_begun(of, [frames, height, width], self.looping == LoopArg::Fixed)?;
        }
        let tiled = Tile::domain(self.tile, [height, width]);
        let periodic = [self.looping == LoopArg::Periodic, tiled.periodic[0], tiled.periodic[1]];
        Ok((keep, Domain { shape: [frames, height, width], periodic }))
    }
}

/// Refuses to go on from maps of other frames than those that are asked for.
fn check_begun(of: [u32; 3], asked: [u32; 3], keeps: bool) -> Result<(), Failure> {
    if keeps {
        let what = "--start has frames of its own at both ends, and --loop fixed others";
        return Err(Failure::new(2, what).remedy("leave one of them out"));
    }
    if of == asked {
        return Ok(());
    }
    let told = |[frames, h, w]: [u32; 3]| format!("{} of {w}x{h} px", n("frame", frames as usize));
    let what = format!("the maps of --start are of {}, not {}", told(of), told(asked));
    Err(Failure::new(3, what).remedy("leave --frames and --size out"))
}

impl Way {
    /// True for what is cut at jumps.
    pub(super) fn jumps(&self) -> bool {
        self.mode == ModeArg::Transition
    }

    /// True if patches are woven, or may be.
    pub(super) fn weaves(&self) -> bool {
        !self.jumps() || self.or_woven
    }

    /// True if what is made begins again after its last frame.
    pub(super) fn loops(&self) -> bool {
        match self.play {
            Some(_) => false,
            None => self.jumps() || self.output.periodic[0] || 0 < self.keep,
        }
    }

    /// Frames that a loop of one jump has to have.
    pub(super) fn period(&self, asked: bool) -> Option<u32> {
        (asked && self.play.is_none()).then_some(self.output.shape[0])
    }

    /// What is woven, with both of its ends.
    pub(super) fn with_ends(&self) -> Domain<3> {
        let Domain { shape: [frames, height, width], periodic } = self.output;
        Domain { shape: [frames.saturating_add(self.keep), height, width], periodic }
    }

    /// Frames of what is woven.
    pub(super) fn fixed(&self) -> RangeInclusive<u32> {
        self.output.shape[0]..=self.output.shape[0]
    }

    /// Weaves in time alone instead.
    pub(super) fn fall_back(&mut self, why: String) {
        (self.mode, self.why) = (ModeArg::Temporal, Some(why));
    }

    /// Frames, height and width of the output, or more.
    pub(super) fn most(&self, clip: Domain<3>) -> [u32; 3] {
        let [frames, height, width] = self.output.shape;
        match (self.jumps(), self.weaves()) {
            (false, _) => [frames, height, width],
            (true, woven) if woven || self.play.is_some() => [clip.shape[0].max(frames), height, width],
            (true, _) => clip.shape,
        }
    }

    /// Refuses options that do nothing.
    fn check(&self, has: [u32; 3], of_jumps: Option<&str>, of_woven: Option<&str>) -> Result<(), Failure> {
        let mode = crate::values::name_of(self.mode);
        let resized = self.output.shape[1..] != has[1..] || self.output.periodic[1..] != [false; 2];
        let [_, height, width] = has;
        let (idle, remedy) = match self.mode {
            ModeArg::Spacetime => (of_jumps, "use --mode transition"),
            _ if resized => {
                let tiles = if self.output.periodic[1..] == [false; 2] { "" } else { ", which do not tile" };
                let what = format!("--mode {mode} has frames of the clip's {width}x{height} px{tiles}");
                return Err(Failure::new(2, what).remedy("use --mode spacetime"));
            }
            ModeArg::Temporal => (of_jumps, "use --mode transition"),
            _ => (of_woven, "use --mode temporal or spacetime"),
        };
        match idle {
            Some(option) => Err(Failure::new(2, format!("{option} does nothing in --mode {mode}")).remedy(remedy)),
            None => Ok(()),
        }
    }
}
