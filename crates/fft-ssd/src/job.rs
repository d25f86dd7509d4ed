//! One template over one source.

use crate::Cover;
use crate::kernel::Kernel;
use crate::placement::Range;
use crate::prepared::Prepared;
use crate::source::SourceView;
use crate::template::Checked;
use selvedge_core::par;

/// What takes fewer nanoseconds is not split: it takes half of them to wake a thread. Measured on two threads: searches
/// of 0.07 ms gain nothing, of 0.11 ms a fifth for half as much processor time again, which searches side by side use
/// better.
const ALONE: f64 = 1.0e5;

/// What an engine needs to know.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub(crate) source: &'a SourceView<'a>,
    pub(crate) weights: &'a [u8],
    pub(crate) prepared: &'a Prepared,
    pub(crate) template: &'a Checked<'a>,
    pub(crate) range: Range,
    pub(crate) cover: Cover,
    pub(crate) kernel: Kernel,
}

impl Job<'_> {
    /// The template's part of the error that no source sample enters: the sum over unmasked samples of
    /// [`own`](Self::own); 0 where the number of compared samples varies and `cover` adds it position by position.
    pub(crate) fn constant(&self, bias: i64) -> i64 {
        if self.varies() {
            return 0;
        }
        (0..self.template.len()).filter(|&i| self.template.counts(i)).map(|i| self.own(i, bias)).sum()
    }

    /// True if the number of compared samples differs between positions.
    pub(crate) fn varies(&self) -> bool {
        matches!(self.cover, Cover::AtLeast(_)) && !self.prepared.is_full
    }

    /// `sum over c of W_c * (t'^2 + bias * t')` of a template sample with `t' = t - 128`.
    pub(crate) fn own(&self, index: usize, bias: i64) -> i64 {
        let len = self.template.len();
        let value = |c: usize| i64::from(self.template.features[c * len + index]) - 128;
        self.weights.iter().enumerate().map(|(c, &w)| i64::from(w) * value(c) * (value(c) + bias)).sum()
    }

    /// Calls `f(frame, first row, positions)` for each `rows` rows of a map (fewer at the end of a frame): beside each
    /// other, if `nanoseconds` for all of it are worth waking a thread.
    pub(crate) fn each_part<T: Send>(
        &self,
        map: &mut [T],
        rows: usize,
        nanoseconds: f64,
        f: impl Fn(usize, usize, &mut [T]) + Sync + Send,
    ) {
        let [_, height, width] = self.range.count;
        if nanoseconds < ALONE {
            for (t, frame) in map.chunks_mut(height * width).enumerate() {
                frame.chunks_mut(rows * width).enumerate().for_each(|(i, part)| f(t, i * rows, part));
            }
        } else {
            par::for_rows(map, height * width, |t, frame| {
                par::for_rows(frame, rows * width, |i, part| f(t, i * rows, part));
            });
        }
    }
}
