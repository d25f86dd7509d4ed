//! The windows of a clip that is woven some frames at a time, and what each begins with.

use selvedge_core::{Domain, Grid, SampleId, SourceMap, Start};

use crate::error::Error;

/// Frames of a window: those that were there before, new ones, and what comes after the last one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    /// Where the new ones begin.
    pub(super) done: u32,
    pub(super) before: u32,
    pub(super) new: u32,
    pub(super) after: u32,
}

/// The windows of so many frames, each of `at_once` at most, of which two share twice a half, and the last one ends
/// with so many more.
fn spans(frames: u32, at_once: u32, half: u32, after: u32) -> Vec<Span> {
    let (shared, most) = (2 * half, at_once - 2 * half);
    let last = most - after;
    let (mut spans, mut done) = (Vec::new(), 0);
    while done < frames {
        let (before, left) = (if done == 0 { 0 } else { shared }, frames - done);
        // The last one is no sliver.
        let span = match left <= last {
            true => Span { done, before, new: left, after },
            false => Span { done, before, new: most.min(left - last.min(left / 2)), after: 0 },
        };
        spans.push(span);
        done += span.new;
    }
    spans
}

/// All windows of an output.
pub(super) struct Spans {
    pub(super) spans: Vec<Span>,
    /// Of the frames that two windows share, those that stay.
    half: u32,
    loops: bool,
    /// Where the frames are that come after the last window: the first ones of a loop, or those that an output ends
    /// with.
    end: u32,
}

impl Spans {
    /// Of a loop the last window ends with the first frames, and what goes on into frames that stand with some of
    /// these.
    pub(super) fn of(start: &Start<3>, at_once: u32, half: u32) -> Self {
        let Domain { shape: [frames, ..], periodic: [loops, ..] } = start.map.domain();
        let stands = if loops || start.map.holes() == 0 { 0 } else { standing(&start.map).min(2 * half) };
        let end = if loops { 0 } else { frames - stands };
        let spans = if loops { spans(frames, at_once, half, 2 * half) } else { spans(end, at_once, half, stands) };
        Self { spans, half, loops, end }
    }

    /// Frames that are new in a window.
    pub(super) fn frames(&self) -> u32 {
        self.spans.iter().map(|span| span.new).sum()
    }

    /// What a window begins with: what stands by now, of which the frames at its borders stay where others lie beyond.
    pub(super) fn start(&self, number: usize, whole: &Start<3>) -> Result<Start<3>, Error> {
        let map = SourceMap::new(self.cut(number, &whole.map.ids, SampleId::UNASSIGNED)?, whole.map.table.clone())?;
        let window = map.domain();
        let fixed = whole.fixed.as_ref().map(|fixed| self.cut(number, fixed, false));
        let mut fixed = fixed.unwrap_or_else(|| Ok(Grid::try_filled(window, 1, false)?))?;
        let (ids, border) = (map.ids.plane(0), self.half as usize * window.strides()[0]);
        let begins = if 0 < number || self.loops { 0..border } else { 0..0 };
        let ends = if number + 1 < self.spans.len() || self.loops { ids.len() - border..ids.len() } else { 0..0 };
        begins.chain(ends).filter(|&i| ids[i].is_assigned()).for_each(|i| fixed.plane_mut(0)[i] = true);
        let fixed = fixed.samples().contains(&true).then_some(fixed);
        let sources = whole.sources.as_ref().map(|sources| self.cut(number, sources, 0)).transpose()?;
        Ok(Start { map, fixed, sources })
    }

    /// What a window came to, in its place.
    pub(super) fn lay(&self, number: usize, whole: &mut SourceMap<3>, window: &SourceMap<3>) {
        for (of_window, of_whole) in self.places(number, whole.domain()) {
            whole.ids.plane_mut(0)[of_whole].copy_from_slice(&window.ids.plane(0)[of_window]);
        }
    }

    /// The part of a window.
    fn cut<T: Copy>(&self, number: usize, of: &Grid<T, 3>, fill: T) -> Result<Grid<T, 3>, Error> {
        let Span { before, new, after, .. } = self.spans[number];
        let Domain { shape: [_, height, width], periodic: [_, y, x] } = of.domain();
        let window = Domain { shape: [before + new + after, height, width], periodic: [false, y, x] };
        let mut cut = Grid::try_filled(window, 1, fill)?;
        for (of_window, of_whole) in self.places(number, of.domain()) {
            cut.plane_mut(0)[of_window].copy_from_slice(&of.plane(0)[of_whole]);
        }
        Ok(cut)
    }

    /// Samples of a window and where these are in the output: its own, and those that come after the last one.
    fn places(&self, number: usize, output: Domain<3>) -> [(std::ops::Range<usize>, std::ops::Range<usize>); 2] {
        let Span { done, before, new, after } = self.spans[number];
        let frame = output.strides()[0];
        let of = |first: u32, frames: u32| first as usize * frame..(first + frames) as usize * frame;
        [(of(0, before + new), of(done - before, before + new)), (of(before + new, after), of(self.end, after))]
    }
}

/// Frames at the end of which nothing is missing.
fn standing(map: &SourceMap<3>) -> u32 {
    let frames = map.ids.plane(0).rchunks(map.domain().strides()[0]);
    frames.take_while(|frame| frame.iter().all(|id| id.is_assigned())).count() as u32
}

#[cfg(test)]
mod tests {
    use selvedge_core::{Exemplars, Plane, Role};

    use super::*;
    use crate::video::windows::least;

    #[test]
    fn windows_cover_all_frames_and_none_is_too_long() {
        for half in 1..5 {
            for at_once in least(half)..least(half) + 12 {
                let all = at_once + 1..at_once + 60;
                for (frames, after) in all.flat_map(|frames| (0..=2 * half).map(move |after| (frames - after, after))) {
                    let spans = spans(frames, at_once, half, after);
                    assert!(spans.iter().all(|s| 0 < s.new && s.before + s.new + s.after <= at_once), "{spans:?}");
                    assert_eq!(spans.iter().map(|s| s.new).sum::<u32>(), frames);
                    assert!(2 * half <= spans[0].new, "what the second begins with, and what a loop ends with");
                    let is_last = |i: usize| i + 1 == spans.len();
                    assert!(spans.iter().enumerate().all(|(i, s)| s.after == if is_last(i) { after } else { 0 }));
                    assert!(1 < spans.len());
                    assert!(spans.windows(2).all(|two| two[0].done + two[0].new == two[1].done));
                }
            }
        }
    }

    #[test]
    fn the_last_window_ends_with_what_stands_at_the_end() {
        let clip = Plane::of_bytes(Role::Color, [4, 3, 3], 1, &[7; 36]).unwrap();
        let exemplars = Exemplars::of(&[std::slice::from_ref(&clip)]).unwrap();
        let of = |stands: std::ops::Range<usize>, loops: bool| {
            let output = Domain { shape: [90, 3, 3], periodic: [loops, false, false] };
            let mut start = Start::empty(&exemplars, output).unwrap();
            start.map.ids.plane_mut(0)[stands.start * 9..stands.end * 9].fill(SampleId::new(0));
            let spans = Spans::of(&start, 30, 5);
            let last = spans.spans[spans.spans.len() - 1];
            (last.after, spans.end, spans.frames())
        };
        // No more than two windows share.
        assert_eq!([of(84..90, false), of(60..90, false)], [(6, 84, 84), (10, 80, 80)]);
        assert_eq!([of(0..89, false), of(0..90, false)], [(0, 90, 90); 2], "nothing stands there, or all");
        assert_eq!([of(0..0, true), of(84..90, true)], [(10, 0, 90); 2]);
    }
}
