//! What is shown of a loop beside its frames: when each pixel jumps, and which jumps there were.

use selvedge_core::par;
use selvedge_graphcut_textures::video::{FrameDistances, Jump, Loop};

use crate::clip_look::{Panel, RED};

/// Of other jumps.
const YELLOW: [u8; 3] = [255, 210, 0];
/// Longer clips have every so many frames in the matrix of distances.
const MATRIX: u32 = 256;

/// A loop of one jump.
pub(super) struct Cut<'a> {
    pub(super) looped: &'a Loop,
    pub(super) distances: &'a FrameDistances<'a>,
    pub(super) jumps: &'a [Jump],
}

impl Cut<'_> {
    /// All of that.
    pub(super) fn panels(&self) -> Vec<Panel> {
        vec![self.times(), self.matrix()]
    }

    /// When each pixel jumps: the earlier the darker.
    fn times(&self) -> Panel {
        let time = &self.looped.surface.time;
        let [height, width] = time.domain().shape;
        let (least, most) = time.samples().iter().fold((u16::MAX, 0), |(a, b), v| (a.min(*v), b.max(*v)));
        let grey = |v: u16| (u32::from(v - least) * 255 / u32::from(most - least).max(1)) as u8;
        Panel::of([width, height], |x, y| [grey(time.get(0, [y, x])); 3])
    }

    /// How much frames differ, the more the brighter, and the jumps.
    fn matrix(&self) -> Panel {
        let frames = self.distances.frames();
        let every = frames.div_ceil(MATRIX);
        let side = frames.div_ceil(every);
        // Frames may have to be compared for each.
        let between = |a: u32, b: u32| self.distances.between(a, b);
        let across = par::map_indexed(frames as usize / 2, |a| between(a as u32, frames - 1 - a as u32));
        let greatest = across.into_iter().max().unwrap_or(0).max(1);
        let row = |y: usize| (0..y as u32).map(|x| between(x * every, y as u32 * every)).collect::<Vec<u64>>();
        let rows = par::map_indexed(side as usize, row);
        let grey = |x: u32, y: u32| {
            let known = rows[x.max(y) as usize].get(x.min(y) as usize).copied().unwrap_or(0);
            [((known as f64 / greatest as f64).sqrt() * 255.0).min(255.0) as u8; 3]
        };
        let mut panel = Panel::of([side, side], grey);
        let chosen = std::iter::once((&self.looped.jump, RED));
        for (jump, color) in self.jumps.iter().map(|jump| (jump, YELLOW)).chain(chosen) {
            let (x, y) = ((jump.from / every) as usize, (jump.to / every) as usize);
            panel.set([x, y], color);
        }
        panel
    }
}
