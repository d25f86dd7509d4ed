//! Options and counts of labellings.

use selvedge_core::{Domain, Grid, SeamMeasure};

use crate::error::Error;
use crate::labels::label::{Label, MOST_LABELS};

/// How labels are decided.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelOptions<const D: usize> {
    /// How seams are priced.
    pub seam: SeamMeasure,
    /// Sweeps over all labels at most. A sweep that brings nothing is the last.
    pub sweeps: u32,
    /// By position, bit `l` says whether label `l` may show there; `None` for all everywhere.
    pub only: Option<Grid<u64, D>>,
    /// What each label costs at each position, a channel a label, in the units of seams (within 2^28 of 0); `None` for
    /// nothing.
    pub own: Option<Grid<i32, D>>,
    /// Positions where no label may show stay holes; otherwise they are an error.
    pub leave_holes: bool,
}

impl<const D: usize> Default for LabelOptions<D> {
    /// Seams by gradient, until nothing changes.
    fn default() -> Self {
        // Sweeps end by themselves, after three or four as a rule: the limit is one against surprises.
        Self { seam: SeamMeasure::default(), sweeps: 64, only: None, own: None, leave_holes: false }
    }
}

impl<const D: usize> LabelOptions<D> {
    pub(super) fn validate(&self, labels: &[Label<D>], sources: usize, output: Domain<D>) -> Result<(), Error> {
        if labels.is_empty() || MOST_LABELS < labels.len() {
            return Err(Error::Labels { found: labels.len() });
        }
        if let Some(label) = labels.iter().find(|label| sources <= label.source) {
            return Err(Error::LabelSource { number: label.source, sources });
        }
        let shapes = [
            ("field of labels", self.only.as_ref().map(|g| (g.domain().shape, g.channels())), 1),
            ("prices of labels", self.own.as_ref().map(|g| (g.domain().shape, g.channels())), labels.len()),
        ];
        for (what, found, channels) in shapes {
            let Some((shape, found)) = found else { continue };
            if shape != output.shape {
                let (expected, found) = (output.shape.to_vec(), shape.to_vec());
                return Err(selvedge_core::Error::StartShape { what, expected, found }.into());
            }
            if found != channels {
                return Err(selvedge_core::Error::Channels { what, found }.into());
            }
        }
        Ok(())
    }
}

/// What became of labels.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LabelStats {
    /// Positions that show each label in the end.
    pub shown: Vec<u64>,
    /// Sweeps begun.
    pub sweeps: u32,
    /// Cuts that were solved.
    pub expansions: u64,
    /// Those of them that made the whole cheaper.
    pub improvements: u64,
    /// Expansions left out, because nothing had changed since they last failed.
    pub skipped: u64,
    /// Pairs whose price was lowered in the model, over all cuts: 0 for prices that are a metric.
    pub truncated: u64,
    /// Positions where no label may show.
    pub holes: usize,
    /// Price of all seams and labels at first, and after each sweep; where two labels are one cut, that of the cut.
    pub energy: Vec<i64>,
}
