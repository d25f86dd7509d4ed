//! How alike frames are.

use std::borrow::Cow;
use std::ops::Range;

use selvedge_core::{Bytes, Domain, Run, Source, par};

use super::bounds::Bounded;
use super::footage::{Footage, neighbours, parts, the_clip};
use crate::error::Error;
use crate::squares::squares;

/// Options of [`FrameDistances::new`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DistanceOptions {
    /// Frames that are held at once, and compared with all that come after them, read again for each such part of the
    /// clip. It changes nothing but memory and time. At least 1, and no more than may be held at all
    /// ([`Limits::samples`](selvedge_core::Limits)). Default: all.
    pub held: u32,
}

impl Default for DistanceOptions {
    fn default() -> Self {
        Self { held: u32::MAX }
    }
}

/// Sums of squared differences between all frames of a clip, exact.
///
/// Differences are of features, channels weighed. A sample that may not be used in one of two frames, or in both,
/// differs as much as samples can: what is masked there is shown all the same. A pixel that no frame may use does not
/// count.
///
/// Of a clip of 300 frames or more that is held, and has no mask, frames are compared when that is asked for:
/// [`best`](Self::best) asks for few of them, and answers what it does of all.
#[derive(Clone, Debug)]
pub struct FrameDistances<'c> {
    frames: u32,
    /// Samples of a frame.
    samples: u64,
    /// For each frame but the last, its distances to all later ones, or less.
    later: Vec<Vec<u64>>,
    /// What knows more than these bounds.
    exact: Option<Bounded<'c>>,
    closes: bool,
}

/// From so many frames on bounds take less than all distances.
const BOUNDED: u32 = 300;

impl<'c> FrameDistances<'c> {
    /// The bytes that distances of a clip hold while they are ranked: 8 a pair, a jump of 24 in a list, and where
    /// bounds are held, what these are made of, and 8 more a pair that is compared.
    pub fn bytes(clip: Domain<3>, channels: usize) -> Bytes {
        let frames = clip.shape[0];
        let of_two = if frames < BOUNDED { 16 } else { 20 };
        Bytes(of_two) * u64::from(frames).saturating_mul(frames.into()) + Bounded::bytes(clip, channels)
    }

    /// Compares all frames.
    ///
    /// # Errors
    /// [`Error::OneClip`] unless there is exactly one source, [`Error::Frames`] unless it has 2 to 65,535 frames,
    /// [`Error::Cancelled`], what the frames are refused by, and what [`Limits::admit`](selvedge_core::Limits::admit)
    /// refuses of [what that takes](Self::bytes).
    ///
    /// # Complexity
    /// Time `O(frames^2 samples)`, with bounds a 64th of it, and then `O(frames samples)` to tell whether the clip
    /// closes; space `O(frames^2)` beside the frames that are [held](DistanceOptions::held).
    pub fn new(clip: &'c (impl Footage + ?Sized), options: &DistanceOptions, run: &Run<'_, 3>) -> Result<Self, Error> {
        Self::bounded_from(BOUNDED, clip, options, run)
    }

    /// The same with bounds from so many frames on.
    fn bounded_from(
        frames: u32,
        clip: &'c (impl Footage + ?Sized),
        options: &DistanceOptions,
        run: &Run<'_, 3>,
    ) -> Result<Self, Error> {
        let domain = the_clip(clip)?;
        let [n, height, width] = domain.shape;
        let most = u32::try_from(run.limits.samples / domain.strides()[0] as u64).unwrap_or(u32::MAX);
        let held = options.held.min(most).clamp(1, n);
        run.limits.admit(Domain::open([held, height, width]), Self::bytes(domain, clip.weights().len()))?;
        let measure = Measure { weights: clip.weights(), used: used(clip, domain)? };
        let samples = u64::from(height) * u64::from(width);
        let distances = Self { frames: n, samples, later: Vec::new(), exact: None, closes: false };
        if frames <= n
            && n <= held.min(clip.together())
            && let Cow::Borrowed(whole) = clip.stretch(0..n)?
            && whole.valid.is_none()
        {
            let bounded = Bounded::new(whole, clip.weights());
            let later = bounded.all();
            if run.observer.cancelled() {
                return Err(Error::Cancelled);
            }
            return Self { later, exact: Some(bounded), ..distances }.closing(clip, &measure);
        }
        let mut later: Vec<Vec<u64>> = (0..n).map(|i| Vec::with_capacity((n - 1 - i) as usize)).collect();
        for part in parts(0..n, held) {
            let held = clip.stretch(part.clone())?;
            let mut compare = |others: Range<u32>, that: &Source<3>| {
                let row = |i: usize| {
                    let after = (part.start + i as u32 + 1).max(others.start)..others.end;
                    let other = |j: u32| measure.frames((&held, i), (that, (j - others.start) as usize));
                    (!run.observer.cancelled()).then(|| after.map(other).collect::<Vec<u64>>())
                };
                let rows = par::map_indexed(part.len(), row).into_iter().collect::<Option<Vec<_>>>();
                let rows = later[part.start as usize..].iter_mut().zip(rows.ok_or(Error::Cancelled)?);
                rows.for_each(|(all, more)| all.extend(more));
                Ok::<_, Error>(())
            };
            compare(part.clone(), &held)?;
            for others in parts(part.end..n, clip.together()) {
                compare(others.clone(), &*clip.stretch(others)?)?;
            }
        }
        Self { later, ..distances }.closing(clip, &measure)
    }

    /// The same, which knows whether the clip closes.
    fn closing(self, clip: &(impl Footage + ?Sized), measure: &Measure<'_>) -> Result<Self, Error> {
        Ok(Self { closes: self.steps_close() && measure.blocks_close(clip)?, ..self })
    }

    /// Frames of the clip.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// Pixels of a frame.
    pub fn pixels(&self) -> u64 {
        self.samples
    }

    /// The sum of squared differences of two frames.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn between(&self, a: u32, b: u32) -> u64 {
        match &self.exact {
            Some(Bounded { clip, weights, .. }) => {
                Measure { weights, used: Vec::new() }.frames((clip, a as usize), (clip, b as usize))
            }
            None => self.least(a, b),
        }
    }

    /// Whether that takes a comparison, and [`least`](Self::least) is less.
    pub(super) fn is_bounded(&self) -> bool {
        self.exact.is_some()
    }

    /// No more than that: known at once.
    pub(super) fn least(&self, a: u32, b: u32) -> u64 {
        let (first, second) = (a.min(b) as usize, a.max(b) as usize);
        if first == second { 0 } else { self.later[first][second - first - 1] }
    }

    /// True if the clip closes as it is: the step from its last frame to its first is none that would be noticed among
    /// its own steps, over the whole frame and in each block of 16 x 16 pixels.
    pub fn closes(&self) -> bool {
        self.closes
    }

    /// True if frames come again after `period` exactly, all through the clip.
    pub fn repeats(&self, period: u32) -> bool {
        let is_same = |a, b| self.least(a, b) == 0 && self.between(a, b) == 0;
        0 < period && period < self.frames && (period..self.frames).all(|t| is_same(t - period, t))
    }

    /// Steps of one and of two frames over the end are within nine tenths of those inside. Two frames, since a movement
    /// that turns back at the end has small steps as well.
    fn steps_close(&self) -> bool {
        let n = self.frames;
        let usual = |lag: u32, a: u32, b: u32| {
            let step = self.between(a, b);
            let below = (lag..n).filter(|&t| self.between(t - lag, t) < step).count() as u64;
            below * 10 <= u64::from(n - lag) * 9
        };
        4 <= n && usual(1, n - 1, 0) && usual(2, n - 2, 0) && usual(2, n - 1, 1)
    }
}

/// Sides of the blocks in which a clip has to close: a jump of a small thing is lost in the mean of a whole frame, and
/// in smaller blocks the camera's noise would count as a jump.
const BLOCK: usize = 16;
/// Sides of boxes whose means tell a jump that is lost in noise: of a candle in a palette with dither the worst block
/// stepped 1.3 times as much over the end as inside, 2.3 times over means; of an ocean that closes 1.06 and 1.08.
const BOX: usize = 4;

/// By pixel of a masked clip, whether any frame may use it; of others none.
fn used(clip: &(impl Footage + ?Sized), domain: Domain<3>) -> Result<Vec<bool>, Error> {
    let pixels = domain.strides()[0];
    let mut used = Vec::new();
    for part in parts(0..domain.shape[0], clip.together()) {
        let Some(valid) = &clip.stretch(part)?.valid else { return Ok(Vec::new()) };
        used.resize(pixels, false);
        let frames = valid.plane(0).chunks(pixels);
        frames.for_each(|frame| used.iter_mut().zip(frame).for_each(|(used, valid)| *used |= valid));
    }
    Ok(used)
}

/// How frames are compared.
struct Measure<'a> {
    weights: &'a [u8],
    /// See [`used`].
    used: Vec<bool>,
}

/// A frame: what holds it, and its number there.
type Frame<'a> = (&'a Source<3>, usize);

/// A part of a frame.
fn part<'a>((clip, t): Frame<'a>, channel: usize, from: usize, len: usize) -> &'a [u8] {
    &clip.features.plane(channel)[t * clip.domain().strides()[0] + from..][..len]
}

impl Measure<'_> {
    fn frames(&self, a: Frame<'_>, b: Frame<'_>) -> u64 {
        self.difference(a, b, 0, a.0.domain().strides()[0])
    }

    /// The sum of squared differences over samples that stand side by side.
    fn difference(&self, a: Frame<'_>, b: Frame<'_>, from: usize, len: usize) -> u64 {
        let pixels = a.0.domain().strides()[0];
        let weighed = self.weights.iter().enumerate();
        if self.used.is_empty() {
            let of = |(c, &w): (usize, &u8)| squares(part(a, c, from, len), part(b, c, from, len)) * u64::from(w);
            return weighed.map(of).sum();
        }
        let most: u64 = self.weights.iter().map(|&w| u64::from(w) * 255 * 255).sum();
        let valid = |(clip, t): Frame<'_>, i: usize| {
            clip.valid.as_deref().is_none_or(|valid| valid.plane(0)[t * pixels + from + i])
        };
        let sample = |i: usize| match (valid(a, i), valid(b, i)) {
            (true, true) => {
                let of = |(c, &w): (usize, &u8)| {
                    let [here, there] = [a, b].map(|frame| part(frame, c, from + i, 1)[0]);
                    u64::from(here.abs_diff(there)).pow(2) * u64::from(w)
                };
                self.weights.iter().enumerate().map(of).sum()
            }
            _ if self.used[from + i] => most,
            _ => 0,
        };
        (0..len).map(sample).sum()
    }

    /// The same over means of boxes in a block that begins at a corner; of masked clips nothing.
    fn coarse(&self, a: Frame<'_>, b: Frame<'_>, [rows, columns]: [Range<usize>; 2]) -> u64 {
        let width = a.0.domain().shape[2] as usize;
        let weights = if self.used.is_empty() { self.weights } else { &[] };
        let mut all = 0;
        for (c, &weight) in weights.iter().enumerate() {
            for y in rows.clone().step_by(BOX) {
                for x in columns.clone().step_by(BOX) {
                    let (down, len) = (y..(y + BOX).min(rows.end), BOX.min(columns.end - x));
                    let sum = |frame| -> u64 {
                        down.clone().flat_map(|y| part(frame, c, y * width + x, len)).map(|&v| u64::from(v)).sum()
                    };
                    all += sum(a).abs_diff(sum(b)).pow(2) / (down.len() * len) as u64 * u64::from(weight);
                }
            }
        }
        all
    }

    /// In no block the step over the end is more than a fourth larger than the largest inside, sample by sample, or a
    /// half over means of [`BOX`], of which a block has few. (Of a clip that is a period of itself the step over the
    /// end is the largest of a block by chance, one time in as many as there are frames.) A candle's GIF has 2.31
    /// there, a fire 1.76.
    fn blocks_close(&self, clip: &(impl Footage + ?Sized)) -> Result<bool, Error> {
        let [frames, height, width] = the_clip(clip)?.shape;
        let (height, width) = (height as usize, width as usize);
        let corners = (0..height).step_by(BLOCK).flat_map(|y| (0..width).step_by(BLOCK).map(move |x| (y, x)));
        let corners: Vec<(usize, usize)> = corners.collect();
        let block = |a: Frame<'_>, b: Frame<'_>, (y, x): (usize, usize)| -> [u64; 2] {
            let (rows, columns) = (y..(y + BLOCK).min(height), x..(x + BLOCK).min(width));
            let fine = rows.clone().map(|row| self.difference(a, b, row * width + x, columns.len())).sum();
            [fine, self.coarse(a, b, [rows, columns])]
        };
        let mut inside = vec![[0_u64; 2]; corners.len()];
        neighbours(clip, |a, b| {
            for (most, at) in inside.iter_mut().zip(&corners) {
                let step = block(a, b, *at);
                *most = [0, 1].map(|i| most[i].max(step[i]));
            }
        })?;
        let (first, last) = (clip.stretch(0..1)?, clip.stretch(frames - 1..frames)?);
        let grain = (BLOCK * BLOCK) as u64;
        let closes = |(at, most): (&(usize, usize), [u64; 2])| {
            let over_end = block((&last, 0), (&first, 0), *at);
            (0..2).all(|i| over_end[i] <= (most[i] + grain) * [25, 36][i] / 16)
        };
        Ok(corners.iter().zip(inside).all(closes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::video::JumpOptions;
    use selvedge_core::{Exemplars, Grid, Origin, Seed, Transform};

    #[test]
    fn few_frames_that_are_compared_tell_what_all_do() {
        let mut closing = 0;
        for seed in 0..60 {
            let mut rng = Seed(seed).rng();
            let [frames, height, width] = [12 + rng.below(20), 1 + rng.below(20), 1 + rng.below(20)];
            let domain = Domain::open([frames, height, width]);
            // Noise, what moves, what comes again, and what does not change.
            let period = [frames, 9, 5, 1][seed as usize % 4];
            let noise: Vec<u8> = (0..period * height * width * 2).map(|_| rng.below(256) as u8).collect();
            let moves = |t: u32, x: u32| if (x + t) % 7 < 3 { 90 } else { 0 };
            let shown = (0..2).flat_map(|c| domain.positions().map(move |at| (c, at)));
            let samples = shown.map(|(c, [t, y, x])| {
                let at = (((c * period + t % period) * height + y) * width + x) as usize;
                noise[at] / 2 + if seed % 3 == 0 { moves(t, x) } else { 0 }
            });
            let features = Grid::from_vec(domain, 2, samples.collect()).unwrap();
            let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
            let clip = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1, 3]).unwrap();
            let from = |least| {
                FrameDistances::bounded_from(least, &clip, &DistanceOptions::default(), &Run::seeded(0)).unwrap()
            };
            let (all, few, run) = (from(u32::MAX), from(2), Run::seeded(0));
            assert!(all.exact.is_none() && few.exact.is_some());
            for (a, b) in (0..frames).flat_map(|a| (0..frames).map(move |b| (a, b))) {
                assert_eq!(few.between(a, b), all.between(a, b));
                assert!(few.least(a, b) <= all.between(a, b), "{a} {b}");
            }
            assert_eq!(few.closes(), all.closes());
            closing += u32::from(all.closes());
            for (taps, spread, count) in [(4, 4, 24), (1, 1, 1000), (2, 3, 8)] {
                let options = JumpOptions { taps, spread, count, ..JumpOptions::default() };
                assert_eq!(
                    few.best(&options, &run).unwrap(),
                    all.best(&options, &run).unwrap(),
                    "seed {seed}, {taps} taps"
                );
            }
        }
        assert!(0 < closing);
    }

    #[test]
    fn a_clip_closes_where_steps_over_its_end_are_usual() {
        let mut closing = 0;
        for seed in 0..300 {
            let mut rng = Seed(seed).rng();
            let most = [3, 40, 256][seed as usize % 3];
            let shown: Vec<u8> = (0..12).map(|_| rng.below(most) as u8).collect();
            let step = |a: usize, b: usize| u32::from(shown[a].abs_diff(shown[b])).pow(2);
            let is_usual = |lag: usize, a: usize, b: usize| {
                let smaller = (lag..12).filter(|&t| step(t - lag, t) < step(a, b)).count();
                smaller as f64 / (12 - lag) as f64 <= 0.9
            };
            let largest = (1..12).map(|t| step(t - 1, t)).max().unwrap();
            let of_block = f64::from(step(11, 0)).sqrt() <= 1.25 * f64::from(largest + 256).sqrt();
            let expected = is_usual(1, 11, 0) && is_usual(2, 10, 0) && is_usual(2, 11, 1) && of_block;
            let features = Grid::from_vec(Domain::open([12, 1, 1]), 1, shown.clone()).unwrap();
            let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
            let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
            let found = FrameDistances::new(&exemplars, &DistanceOptions::default(), &Run::seeded(0)).unwrap();
            assert_eq!(found.closes(), expected, "{shown:?}");
            closing += u32::from(expected);
        }
        assert!((30..270).contains(&closing), "{closing} of 300");
    }
}
