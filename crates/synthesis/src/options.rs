//! How much work is done.

use crate::error::Error;

/// Options of [`synthesize`](crate::synthesize()).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// How much work is done: 1 makes one candidate and scores nothing, 3 three drafts of which the best is finished, 9
    /// forty of which twelve are. Default: 3, two seconds for 512^2 from 192^2 on two cores, five with
    /// [mended](Self::mend) seams.
    pub effort: u8,
    /// Whether one more candidate is what stands best with its seams mended, by
    /// [texture optimization](selvedge_texture_optimization::Options::mending), where any are compared and exemplars
    /// times output are at most 2^34 samples (256^2 to 512^2): it takes the longer the larger both are. Default: yes.
    pub mend: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { effort: 3, mend: true }
    }
}

impl Options {
    /// Drafts that are made, and how many of them are finished, which takes six times as long. Chosen by time; no other
    /// numbers were ranked.
    const STEPS: [[usize; 2]; 9] = [[0, 1], [2, 1], [3, 1], [4, 1], [6, 1], [8, 2], [14, 4], [24, 7], [40, 12]];

    pub(crate) fn steps(self) -> Result<[usize; 2], Error> {
        let steps = usize::from(self.effort).checked_sub(1).and_then(|i| Self::STEPS.get(i));
        steps.copied().ok_or(selvedge_core::Error::amount("an effort", self.effort, "1 to 9").into())
    }
}
