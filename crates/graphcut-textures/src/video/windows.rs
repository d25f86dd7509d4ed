//! Clips woven some frames at a time. `[Kwatra03 7B]` `[Kwatra03 7C]`

use selvedge_core::{Bytes, Domain, Event, Exemplars, Observer, Run, SeamCosts, SourceMap, Start, Woven};

use super::kept::WindowsCheckpoint;
use super::spans::Spans;
use crate::error::Error;
use crate::estimate::estimate_clip;
use crate::options::Options;
use crate::plan::{may_be_halved, plan};
use crate::regions::longest_region;
use crate::stats::Stats;

/// Weaves a clip of so many frames that they are not woven at once: by windows of `at_once` frames at most, one after
/// the other. Each begins with frames of the one before, the length of a region: the first half of them stays, the
/// others may be changed, so that its first seam lies where it would in a run over all frames. Of a loop the last one
/// ends with the first frames in the same way, and where frames stand at the end ([`Ends`](super::Ends)) with these.
/// An output of no more frames is woven as ever.
///
/// Where nothing is missing at the start, seams are made better, window by window: half a region's frames at the
/// borders of each stay for its time, so that no seam becomes dearer.
///
/// # Errors
/// Those of [`graphcut_from`](crate::graphcut_from()), and [`Error::AtOnce`] for fewer than [`least_at_once`] frames.
///
/// # Complexity
/// Memory is that of a run over a window, and what stands of the output. Time: one and a half to three times that
/// of a run over all frames, the shorter windows are the more.
///
/// # Determinism
/// The map follows from what that of [`graphcut_from`](crate::graphcut_from()) does, and from `at_once`: window number
/// `i` draws by `"video/window"`, `i`.
pub fn woven_in_windows(
    exemplars: &Exemplars<3>,
    start: Start<3>,
    at_once: u32,
    options: &Options<3>,
    run: &Run<'_, 3>,
) -> Result<Woven<SourceMap<3>, Stats<3>>, Error> {
    woven_in_windows_on(exemplars, start, (at_once, None), options, run, &mut |_| ())
}

/// The same, which lets `keep` make a [`WindowsCheckpoint`] before the first window and after each. With one it goes on
/// from there, where `start` is what the run began with. What is woven as ever makes none.
///
/// # Errors
/// Those of [`woven_in_windows`], and [`Error::Checkpoint`] for a checkpoint of another run, as far as is seen.
pub fn woven_in_windows_on(
    exemplars: &Exemplars<3>,
    start: Start<3>,
    (at_once, from): (u32, Option<&WindowsCheckpoint>),
    options: &Options<3>,
    run: &Run<'_, 3>,
    keep: &mut dyn FnMut(&dyn Fn() -> WindowsCheckpoint),
) -> Result<Woven<SourceMap<3>, Stats<3>>, Error> {
    let output = start.map.domain();
    let frames = output.shape[0];
    if frames <= at_once {
        return plan(exemplars, output, start.sources.as_ref(), options, &run.limits)?.weave(start, run);
    }
    start.check(exemplars)?;
    run.limits.admit(output, Bytes::of_samples(output, 4))?;
    let planned = plan(exemplars, window(output, at_once), None, options, &run.limits)?.on(&start)?;
    let half = half(planned.settings.region[0]);
    if at_once < least(half) {
        return Err(Error::AtOnce { frames: at_once, least: least(half).min(frames) });
    }
    let spans = Spans::of(&start, at_once, half);
    let (options, mut stats, mut whole) = (planned.chosen(), Stats::of(&planned.settings), start);
    let begun = from.map_or(Ok(0), |from| from.resume(&mut whole.map, &mut stats, (at_once, spans.spans.len())))?;
    for number in begun..spans.spans.len() {
        keep(&|| WindowsCheckpoint::of(&whole.map, &stats, (at_once, number)));
        let woven = one(exemplars, &whole, (&spans, number), &options, run)?;
        spans.lay(number, &mut whole.map, &woven.result);
        stats.add(&woven.stats);
        if !woven.complete {
            return Ok(Woven { result: whole.map, stats, complete: false });
        }
    }
    let energy = SeamCosts::new(exemplars, options.seam)?.total(&whole.map);
    stats.settled.push(energy);
    Ok(Woven { result: whole.map, stats, complete: true })
}

/// Weaves a window.
fn one(
    exemplars: &Exemplars<3>,
    whole: &Start<3>,
    (spans, number): (&Spans, usize),
    options: &Options<3>,
    run: &Run<'_, 3>,
) -> Result<Woven<SourceMap<3>, Stats<3>>, Error> {
    let start = spans.start(number, whole)?;
    // One in which nothing is missing is made better at its own size.
    let levels = if may_be_halved(&start) { options.levels } else { Some(1) };
    let options = Options { levels, ..*options };
    let span = spans.spans[number];
    let part = Part { observer: run.observer, done: span.done, new: span.new, of: spans.frames() };
    let seed = run.seed.derive("video/window", number as u64);
    let own = &Run { observer: &part, seed, ..*run };
    plan(exemplars, start.map.domain(), start.sources.as_ref(), &options, &run.limits)?.weave(start, own)
}

/// The fewest frames that [`woven_in_windows`] weaves at once, of a clip of so many, whatever it shows.
pub fn least_at_once(clip: u32, options: &Options<3>) -> u32 {
    least(half(options.region.map_or_else(|| longest_region(clip), |region| region[0])))
}

/// What that holds at most beside a clip of this domain, of which something may be masked, or nothing, and beside a
/// start.
pub fn estimate_in_windows(
    clip: (Domain<3>, bool),
    channels: usize,
    output: Domain<3>,
    at_once: u32,
    options: &Options<3>,
) -> Bytes {
    let window = window(output, at_once);
    // What stands is there at every size.
    estimate_clip(clip, channels, window, options) + Bytes::of_samples(window, 2 * 5) + Bytes::of_samples(output, 4)
}

/// So many frames of an output.
fn window(output: Domain<3>, frames: u32) -> Domain<3> {
    let Domain { shape: [_, height, width], periodic: [_, y, x] } = output;
    Domain { shape: [frames, height, width], periodic: [false, y, x] }
}

/// Of the frames of a region that two windows share, those that stay.
fn half(region: u32) -> u32 {
    region.div_ceil(2)
}

/// What two windows share, at both ends of the last one of a loop, and a frame between.
pub(super) fn least(half: u32) -> u32 {
    half.saturating_mul(4).saturating_add(1)
}

/// A window of a run: how far all of it is.
struct Part<'a> {
    observer: &'a dyn Observer<3>,
    /// Frames before it, and its own, of so many.
    done: u32,
    new: u32,
    of: u32,
}

/// Parts of a frame's work that are told.
const PARTS: u64 = 1000;

impl Observer<3> for Part<'_> {
    fn event(&self, event: &Event<'_, 3>) {
        let [done, of] = event.work.unwrap_or([event.done, event.of]);
        let own = u64::from(self.new) * PARTS * done.min(of) / of.max(1);
        let work = Some([u64::from(self.done) * PARTS + own, u64::from(self.of) * PARTS]);
        self.observer.event(&Event { work, energy: None, so_far: None, ..*event });
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }
}
