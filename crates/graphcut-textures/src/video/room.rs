//! What loops take, and how many jumps are cut at once.

use selvedge_core::{Bytes, Domain, par};

use super::banded::tiled;
use super::options::LoopOptions;
use super::steps::Usual;

/// What a cut takes however small it is: allocations are given whole pages, and some stay with the allocator. With 64
/// KiB nine of forty runs over 200 frames of 16x16 held up to 104,448 bytes more than were told, with 256 one in some
/// dozens 832 bytes; since steps are measured beside the prices, nine of ten up to 150,336 more with 320.
/// Code that is paged in counts: with 640 the same runs held 2.0, 2.3, 2.4 and 2.9 MB in test programs of 41, 45, 46
/// and 49 MB, the last 187,200 to 314,176 bytes more than were told.
const A_CUT: u64 = 20 << 16;

/// The bytes that [`looped`](super::looped) holds at most besides the exemplars themselves.
pub fn estimate(clip: Domain<3>, channels: usize, options: &LoopOptions) -> Bytes {
    a_cut(clip, channels, options) + Usual::bytes(clip)
}

/// What the cut of one jump takes.
fn a_cut(clip: Domain<3>, channels: usize, options: &LoopOptions) -> Bytes {
    // Measured: see `tests/it/memory.rs`. Features twice, links and gradients of both sides of the window with two
    // frames around each; then the graph, which takes 51 bytes a node, and the answer.
    let frames = |n: u32| Domain::open([n.min(clip.shape[0]), clip.shape[1], clip.shape[2]]);
    let side = Bytes::of_samples(frames(options.window.saturating_add(4)), 2 * channels as u64 + 1 + 12);
    let whole = Bytes::of_samples(frames(options.window), 56);
    let cut = if options.levels == 1 { whole } else { whole.min(tiled(frames(options.window))) };
    // All smaller frames together are a third.
    let smaller = Bytes::of_samples(frames(options.window.saturating_add(4)), 2 * channels as u64)
        * u64::from(1 < options.levels);
    // By pixel what is shown, between which frames it may change, and how often it does.
    Bytes(A_CUT) + side * 2 + cut + smaller + Bytes::of_samples(frames(1), 64 + 40)
}

/// What jumps that are cut at once may take together: what one may whose window is whole, so that it is told without
/// knowing the jumps, and no limit is met later on more threads.
#[derive(Clone, Copy)]
pub(super) struct Room<'a> {
    clip: Domain<3>,
    channels: usize,
    options: &'a LoopOptions,
    most: Bytes,
}

impl<'a> Room<'a> {
    pub(super) fn of(clip: Domain<3>, channels: usize, options: &'a LoopOptions) -> Self {
        Self { clip, channels, options, most: a_cut(clip, channels, options) }
    }

    /// The same room for cuts of other frames.
    pub(super) fn of_frames(self, clip: Domain<3>, options: &'a LoopOptions) -> Self {
        Self { clip, options, ..self }
    }

    /// How many jumps, by the frames of their windows, are cut at once, the first of them in any case.
    pub(super) fn fits(&self, windows: impl Iterator<Item = usize>) -> usize {
        let cut =
            |window: usize| a_cut(self.clip, self.channels, &LoopOptions { window: window as u32, ..*self.options });
        let all = windows.take(par::threads()).scan(Bytes(0), |sum, window| {
            *sum += cut(window);
            Some(*sum)
        });
        all.take_while(|sum| *sum <= self.most).count().max(1)
    }
}
