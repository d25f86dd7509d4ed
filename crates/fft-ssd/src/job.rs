//! One template over one source.

use crate::Cover;
use crate::kernel::Kernel;
use crate::placement::Range;
use crate::prepared::{Cache, Prepared};
use crate::source::SourceView;
use crate::template::Checked;

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
    pub(crate) cache: &'a Cache,
    /// Bytes that what is kept may take.
    pub(crate) budget: u64,
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

    /// True if spectra of so many bytes are kept: they and the tables of the same source fit the budget.
    pub(crate) fn keeps(&self, spectra: u64) -> bool {
        spectra.saturating_add(self.prepared.bytes()) <= self.budget
    }

    /// `sum over c of W_c * (t'^2 + bias * t')` of a template sample with `t' = t - 128`.
    pub(crate) fn own(&self, index: usize, bias: i64) -> i64 {
        let len = self.template.len();
        let value = |c: usize| i64::from(self.template.features[c * len + index]) - 128;
        self.weights.iter().enumerate().map(|(c, &w)| i64::from(w) * value(c) * (value(c) + bias)).sum()
    }

    /// Positions of a map that one task computes: rows of one frame, a multiple of four where possible.
    pub(crate) fn task(&self, rows: usize) -> usize {
        let [frames, height, width] = self.range.count;
        if frames == 1 { rows * width } else { height * width }
    }

    /// Frame, row and positions of each row of a task's part of a map.
    pub(crate) fn rows<'m, T>(
        &self,
        task: usize,
        number: usize,
        part: &'m mut [T],
    ) -> impl Iterator<Item = (usize, usize, &'m mut [T])> {
        let [_, height, width] = self.range.count;
        let first = task * number / width;
        part.chunks_mut(width).enumerate().map(move |(i, row)| ((first + i) / height, (first + i) % height, row))
    }
}
