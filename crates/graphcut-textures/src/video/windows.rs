//! Clips woven some frames at a time. `[Kwatra03 7B]` `[Kwatra03 7C]`

use selvedge_core::{
    Bytes, Domain, Error as CoreError, Event, Exemplars, Grid, Observer, Run, SampleId, SeamCosts, SourceMap, Start,
    Woven,
};

use crate::error::Error;
use crate::estimate::estimate_clip;
use crate::options::Options;
use crate::plan::plan;
use crate::regions::longest_region;
use crate::stats::Stats;

/// Weaves a clip of so many frames that they are not woven at once: by windows of `at_once` frames at most, one after
/// the other. Each begins with frames of the one before, the length of a region: the first half of them stays, the
/// others may be changed, so that its first seam lies where it would in a run over all frames. Of a loop the last one
/// ends with the first frames in the same way. An output of no more frames is woven as ever.
///
/// # Errors
/// Those of [`graphcut`](crate::graphcut()), and a range for fewer than [`least_at_once`] frames.
///
/// # Complexity
/// Memory is that of a run over a window, and 4 bytes a sample of the output. Time: one and a half to three times that
/// of a run over all frames, the shorter windows are the more.
///
/// # Determinism
/// The map follows from what that of [`graphcut`](crate::graphcut()) does, and from `at_once`: window number `i` draws
/// by `"video/window"`, `i`.
pub fn woven_in_windows(
    exemplars: &Exemplars<3>,
    output: Domain<3>,
    at_once: u32,
    options: &Options<3>,
    run: &Run<'_, 3>,
) -> Result<Woven<SourceMap<3>, Stats<3>>, Error> {
    let frames = output.shape[0];
    if frames <= at_once {
        return plan(exemplars, output, None, options, &run.limits)?.weave(Start::empty(exemplars, output)?, run);
    }
    run.limits.admit(output, Bytes::of_samples(output, 4))?;
    let window = |frames| Domain { shape: [frames, output.shape[1], output.shape[2]], ..opened(output) };
    let planned = plan(exemplars, window(at_once), None, options, &run.limits)?;
    let half = half(planned.settings.region[0]);
    CoreError::within(
        "at_once",
        at_once,
        f64::from(least(half))..=f64::from(frames),
        "twice as many frames as a region has, and three more",
    )?;
    let (options, mut stats) = (planned.chosen(), Stats::of(&planned.settings));
    let mut whole = SourceMap::unassigned(exemplars, output)?;
    let mut done = 0;
    for (number, Span { before, new, after }) in (0..).zip(spans(frames, at_once, half, output.periodic[0])) {
        let start = start(&whole, window(before + new + after), (done - before, before, after))?;
        let part = Part { observer: run.observer, done, new, of: frames };
        let seed = run.seed.derive("video/window", number);
        let own = &Run { observer: &part, seed, ..*run };
        let woven = plan(exemplars, start.map.domain(), None, &options, &run.limits)?.weave(start, own)?;
        lay(&mut whole, &woven.result, (done - before, before + new, after));
        stats.add(&woven.stats);
        if !woven.complete {
            return Ok(Woven { result: whole, stats, complete: false });
        }
        done += new;
    }
    let energy = SeamCosts::new(exemplars, options.seam)?.total(&whole);
    stats.settled.push(energy);
    Ok(Woven { result: whole, stats, complete: true })
}

/// The fewest frames that [`woven_in_windows`] weaves at once, of a clip of so many, whatever it shows.
pub fn least_at_once(clip: u32, options: &Options<3>) -> u32 {
    least(half(options.region.map_or_else(|| longest_region(clip), |region| region[0])))
}

/// What that holds at most beside a clip of this domain, of which something may be masked, or nothing.
pub fn estimate_in_windows(
    clip: (Domain<3>, bool),
    channels: usize,
    output: Domain<3>,
    at_once: u32,
    options: &Options<3>,
) -> Bytes {
    let window = Domain { shape: [at_once, output.shape[1], output.shape[2]], ..opened(output) };
    // What stands is there at every size.
    estimate_clip(clip, channels, window, options) + Bytes::of_samples(window, 2 * 5) + Bytes::of_samples(output, 4)
}

fn opened(output: Domain<3>) -> Domain<3> {
    Domain { periodic: [false, output.periodic[1], output.periodic[2]], ..output }
}

/// Of the frames of a region that two windows share, those that stay.
fn half(region: u32) -> u32 {
    region.div_ceil(2)
}

/// What two windows share, at both ends of the last one of a loop, and a frame between.
fn least(half: u32) -> u32 {
    half.saturating_mul(4).saturating_add(1)
}

/// Frames of a window: those that were there before, new ones, and the first ones of the loop again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Span {
    before: u32,
    new: u32,
    after: u32,
}

/// The windows of so many frames, each of `at_once` at most.
fn spans(frames: u32, at_once: u32, half: u32, loops: bool) -> Vec<Span> {
    let (shared, most) = (2 * half, at_once - 2 * half);
    let last = if loops { most - shared } else { most };
    let (mut spans, mut left) = (Vec::new(), frames);
    while 0 < left {
        let before = if left == frames { 0 } else { shared };
        let (new, after) = match left <= last {
            true => (left, if loops { shared } else { 0 }),
            // The last one is no sliver.
            false => (most.min(left - last.min(left / 2)), 0),
        };
        spans.push(Span { before, new, after });
        left -= new;
    }
    spans
}

/// What a window begins with: frames of the output from `first` on, and its first ones behind those that are missing.
fn start(whole: &SourceMap<3>, window: Domain<3>, (first, before, after): (u32, u32, u32)) -> Result<Start<3>, Error> {
    let frame = window.strides()[0];
    let mut ids = Grid::try_filled(window, 1, SampleId::UNASSIGNED)?;
    let mut fixed = Grid::try_filled(window, 1, false)?;
    let (all, all_fixed) = (ids.plane_mut(0), fixed.plane_mut(0));
    let count = |frames: u32| frames as usize * frame;
    let end = all.len() - count(after);
    for (to, from, frames, stays) in [(0, first, before, 0), (end, 0, after, after / 2)] {
        all[to..][..count(frames)].copy_from_slice(&whole.ids.plane(0)[count(from)..][..count(frames)]);
        all_fixed[to + count(stays)..][..count(frames / 2)].fill(true);
    }
    let fixed = (0 < before + after).then_some(fixed);
    Ok(Start { map: SourceMap::new(ids, whole.table.clone())?, fixed, sources: None })
}

/// What a window came to, in its place: frames from `first` on, and behind them the first of the output.
fn lay(whole: &mut SourceMap<3>, window: &SourceMap<3>, (first, frames, after): (u32, u32, u32)) {
    let frame = window.domain().strides()[0];
    let (to, from) = (whole.ids.plane_mut(0), window.ids.plane(0));
    let (own, again) = from.split_at(frames as usize * frame);
    to[first as usize * frame..][..own.len()].copy_from_slice(own);
    to[..after as usize * frame].copy_from_slice(again);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_cover_all_frames_and_none_is_too_long() {
        for half in 1..5 {
            for at_once in least(half)..least(half) + 12 {
                for (frames, loops) in (at_once + 1..at_once + 60).flat_map(|frames| [(frames, false), (frames, true)])
                {
                    let spans = spans(frames, at_once, half, loops);
                    assert!(spans.iter().all(|s| 0 < s.new && s.before + s.new + s.after <= at_once), "{spans:?}");
                    assert_eq!(spans.iter().map(|s| s.new).sum::<u32>(), frames);
                    assert!(2 * half <= spans[0].new, "what the second begins with, and what the last ends with");
                    let after = |i: usize| if loops && i + 1 == spans.len() { 2 * half } else { 0 };
                    assert!(spans.iter().enumerate().all(|(i, s)| s.after == after(i)), "{spans:?}");
                    assert!(1 < spans.len());
                }
            }
        }
    }
}
