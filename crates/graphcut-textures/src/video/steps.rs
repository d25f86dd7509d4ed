//! How much frames of a clip differ from their next ones: whether a loop closes.

use selvedge_core::{Bytes, Domain, Grid, SourceMap, par};

use super::footage::{Footage, neighbours};
use super::sides::Sides;
use super::surface::Surface;
use super::transition::Stretches;
use crate::error::Error;

/// Sides of the blocks that are looked at by themselves: a jump of a small thing is lost in the mean of a whole frame.
const BLOCK: u32 = 16;

/// A seam of which no step of a whole frame is larger than what is usual by more than this is as good as none: less is
/// not told from chance with a hundredth of some dozens of steps.
pub const CLOSES: f64 = 1.05;

/// Squared differences between a frame and another, summed over the frame and over each of its blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    whole: u64,
    blocks: Vec<u64>,
}

impl Step {
    /// That of the whole frame.
    pub fn whole(&self) -> u64 {
        self.whole
    }

    /// Between two frames, channel by channel.
    fn of<V: AsRef<[u8]>>([height, width]: [u32; 2], channels: impl Iterator<Item = (V, V)>) -> Self {
        let columns = width.div_ceil(BLOCK);
        let mut blocks = vec![0_u64; (columns * height.div_ceil(BLOCK)) as usize];
        for (a, b) in channels {
            let rows = a.as_ref().chunks(width as usize).zip(b.as_ref().chunks(width as usize));
            for (y, (row, other)) in (0..).zip(rows) {
                for (x, (v, w)) in row.chunks(BLOCK as usize).zip(other.chunks(BLOCK as usize)).enumerate() {
                    let off = v.iter().zip(w).map(|(v, w)| u64::from(v.abs_diff(*w)).pow(2));
                    blocks[(y / BLOCK * columns) as usize + x] += off.sum::<u64>();
                }
            }
        }
        Self { whole: blocks.iter().sum(), blocks }
    }

    /// From a frame of one clip to one of another.
    fn between((from, a): (&Grid<u8, 3>, usize), (to, b): (&Grid<u8, 3>, usize)) -> Self {
        let [_, height, width] = from.domain().shape;
        let n = height as usize * width as usize;
        let both = |c: usize| (&from.plane(c)[a * n..][..n], &to.plane(c)[b * n..][..n]);
        Self::of([height, width], (0..from.channels()).map(both))
    }
}

/// The median step of a clip's frames, of which there are at least two.
pub fn median(features: &Grid<u8, 3>) -> u64 {
    let mut steps: Vec<u64> = (1..features.domain().shape[0]).map(|t| step(features, t - 1, t).whole).collect();
    steps.sort_unstable();
    steps.get(steps.len() / 2).copied().unwrap_or(0)
}

/// What is usual in a clip: 99 of 100 steps are no larger.
#[derive(Clone, Debug, PartialEq)]
pub struct Usual(Step);

/// How the steps over a seam compare with what is usual; 1 is the largest that is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    /// Steps that were looked at.
    pub steps: u32,
    /// The largest of a whole frame.
    pub whole: f64,
    /// The largest of a block.
    pub block: f64,
}

impl Closure {
    /// Whether nothing is larger than what is usual.
    pub fn closes(&self) -> bool {
        self.whole <= 1.0 && self.block <= 1.0
    }

    /// By how much it is more than usual, the whole frame first: what is no larger is as good as nothing. Blocks are
    /// many, and the largest of them is chance in one direction alone, so that they are given no room.
    pub(super) fn excess(&self) -> [f64; 2] {
        [self.whole.max(CLOSES), self.block.max(1.0)]
    }

    /// Whether a loop whose worst block steps so much may be better.
    pub(super) fn may_yield(&self, block: f64) -> bool {
        let [whole, own] = self.excess();
        CLOSES < whole || block <= own
    }

    /// Whether nothing could be better.
    pub(super) fn is_best(&self) -> bool {
        self.excess() == [CLOSES, 1.0]
    }
}

/// The step from frame `a` to frame `b` of features. Channels count alike.
///
/// # Panics
/// If there is no such frame.
pub fn step(features: &Grid<u8, 3>, a: u32, b: u32) -> Step {
    Step::between((features, a as usize), (features, b as usize))
}

/// The steps of a loop over its seam: one for each time at which any pixel jumps, all of them in the window.
pub(super) fn over_surface(around: &Stretches, surface: &Surface) -> Vec<Step> {
    let (period, ends) = (around.period, surface.time.plane(0));
    let mut times: Vec<u32> = ends.iter().map(|&end| u32::from(end) % period).collect();
    times.sort_unstable();
    times.dedup();
    let shown = |channel: usize, frame: u32| -> Vec<u8> {
        let pixels = ends.iter().enumerate();
        pixels.map(|(p, &end)| around.shown(Surface::frame(end, period, frame), p)[channel]).collect()
    };
    par::map_indexed(times.len(), |i| {
        // The frame before the jump, and the one after it.
        let both = |c: usize| (shown(c, times[i] + period - 1), shown(c, times[i] + period));
        Step::of(surface.time.domain().shape, (0..around.channels).map(both))
    })
}

impl Usual {
    /// The bytes that a clip's steps take while they are sorted.
    pub(super) fn bytes(clip: Domain<3>) -> Bytes {
        let [frames, height, width] = clip.shape;
        let blocks = Domain::open([frames, height.div_ceil(BLOCK), width.div_ceil(BLOCK)]);
        Bytes::of_samples(blocks, 24) + Bytes(64) * u64::from(frames)
    }

    /// The largest step of a whole frame that is usual.
    pub fn whole(&self) -> u64 {
        self.0.whole
    }

    /// Of all steps of a clip but the one from its end to its begin; `None` for fewer than two frames.
    pub fn of(features: &Grid<u8, 3>) -> Option<Self> {
        let frames = features.domain().shape[0];
        Self::of_steps(&(1..frames).map(|t| step(features, t - 1, t)).collect::<Vec<_>>())
    }

    /// The same of a clip that passes by frame by frame.
    ///
    /// # Errors
    /// [`Error::OneClip`], [`Error::Frames`], and what the frames are refused by.
    pub fn read(clip: &(impl Footage + ?Sized)) -> Result<Self, Error> {
        let mut steps = Vec::new();
        neighbours(clip, |(a, i), (b, j)| steps.push(Step::between((&a.features, i), (&b.features, j))))?;
        Self::of_steps(&steps).ok_or(Error::Frames { frames: 1 })
    }

    fn of_steps(steps: &[Step]) -> Option<Self> {
        let first = steps.first()?;
        let whole = percentile(steps.iter().map(|step| step.whole).collect());
        let block = |i: usize| percentile(steps.iter().map(|step| step.blocks[i]).collect());
        Some(Self(Step { whole, blocks: (0..first.blocks.len()).map(block).collect() }))
    }

    /// The step of the worst block over a jump beside what is usual, where each block jumps before that frame of the
    /// window, or after the last, before which it steps least.
    pub(super) fn least_block(&self, sides: &Sides) -> f64 {
        let times = sides.window.end + 1 - sides.window.start;
        let [_, height, width] = sides.both.sources()[0].domain().shape;
        let steps = par::map_indexed(times as usize, |i| {
            let next = sides.window.start + i as u32;
            let both = |c: usize| (sides.frame(0, c, next - 1), sides.frame(1, c, next - sides.period));
            Step::of([height, width], (0..sides.both.channels()).map(both))
        });
        let least = |i: usize| steps.iter().map(|step| step.blocks[i]).min().unwrap_or(0);
        let blocks = self.0.blocks.iter().enumerate().map(|(i, usual)| beside(least(i), *usual));
        blocks.fold(0.0, f64::max)
    }

    /// Steps beside what is usual.
    pub fn closure(&self, steps: impl Iterator<Item = Step>) -> Closure {
        let mut closure = Closure { steps: 0, whole: 0.0, block: 0.0 };
        for step in steps {
            closure.steps += 1;
            closure.whole = closure.whole.max(step.whole as f64 / self.0.whole.max(1) as f64);
            for (is, usual) in step.blocks.iter().zip(&self.0.blocks) {
                closure.block = closure.block.max(beside(*is, *usual));
            }
        }
        closure
    }
}

/// The step of a block beside the usual one. Where nothing ever moves, one step of a value in each sample is as good as
/// none.
fn beside(is: u64, usual: u64) -> f64 {
    is as f64 / usual.max(u64::from(BLOCK * BLOCK)) as f64
}

fn percentile(mut values: Vec<u64>) -> u64 {
    values.sort_unstable();
    let last = values.len() - 1;
    values[last - last / 100]
}

/// Pairs of frames of a looped output between which a seam lies, and the features of the output.
pub fn over_seams<'m>(map: &'m SourceMap<3>, output: &'m Grid<u8, 3>) -> impl Iterator<Item = Step> + 'm {
    let [frames, height, width] = map.domain().shape;
    let n = height * width;
    let crosses = move |t: &u32| (0..n).any(|i| map.is_seam([*t, i / width, i % width], 0));
    (0..frames).filter(crosses).map(move |t| step(output, t, (t + 1) % frames))
}

#[cfg(test)]
mod tests {
    use selvedge_core::Domain;

    use super::*;

    /// A bright line that goes right by one column a frame.
    fn moving(frames: u32, width: u32) -> Grid<u8, 3> {
        let domain = Domain::open([frames, 20, width]);
        let samples = domain.positions().map(|[t, _, x]| if x == t % width { 200 } else { 10 }).collect();
        Grid::from_vec(domain, 1, samples).unwrap()
    }

    #[test]
    fn what_goes_on_closes_and_what_jumps_does_not() {
        let closure = |frames: u32| {
            let clip = moving(frames, 40);
            Usual::of(&clip).unwrap().closure(std::iter::once(step(&clip, frames - 1, 0)))
        };
        assert!(closure(40).closes(), "{:?}", closure(40));
        // Whole frames differ as usual, but the first block does not: it grows lighter step by step beside what
        // flickers.
        let domain = Domain::open([30, 20, 40]);
        let flicker = |t: u32| [0, if t == 11 { 255 } else { 200 }][t as usize % 2];
        let samples = domain.positions().map(|[t, _, x]| if x < 16 { t as u8 } else { flicker(t) }).collect();
        let clip = Grid::from_vec(domain, 1, samples).unwrap();
        let early = Usual::of(&clip).unwrap().closure(std::iter::once(step(&clip, 29, 0)));
        assert!(early.whole <= 1.0 && 1.0 < early.block && !early.closes(), "{early:?}");
    }

    #[test]
    fn blocks_add_up_to_the_whole() {
        let clip = moving(3, 37);
        let found = step(&clip, 0, 1);
        assert_eq!((found.whole, found.blocks.len()), (20 * 2 * 190 * 190, 6));
        assert_eq!(found.blocks.iter().sum::<u64>(), found.whole);
        assert!(Usual::of(&moving(1, 4)).is_none());
    }
}
