//! What a run in windows has come to, so that another goes on from there to the same map.

use selvedge_core::{SampleId, SourceMap};

use crate::error::Error;
use crate::stats::Stats;
use crate::words::{Words, put_ids, put_prices, put_word};

/// Bytes begin so: what is kept, and in which form.
const MAGIC: &[u8] = b"selvedge windows 1\n";

/// What a run in windows has come to between two of them: its map, its counts, and how many were woven. Each draws by
/// its own seed, and knows of those before what they laid, so that nothing else is needed to go on to the same map
/// ([`woven_in_windows_on`](super::woven_in_windows_on)).
#[derive(Clone, Debug, PartialEq)]
pub struct WindowsCheckpoint {
    ids: Vec<SampleId>,
    at_once: u32,
    windows: u64,
    /// Of patches, refinements, improvements, cuts and their nodes.
    counts: [u64; 5],
    energy: Vec<i64>,
    settled: Vec<i64>,
}

impl WindowsCheckpoint {
    /// After so many windows of so many frames.
    pub(super) fn of(map: &SourceMap<3>, stats: &Stats<3>, (at_once, windows): (u32, usize)) -> Self {
        Self {
            ids: map.ids.plane(0).to_vec(),
            at_once,
            windows: windows as u64,
            counts: stats.counts(),
            energy: stats.energy.clone(),
            settled: stats.settled.clone(),
        }
    }

    /// A run that was just begun becomes this one; answers with the windows that it has woven.
    pub(super) fn resume(
        &self,
        map: &mut SourceMap<3>,
        stats: &mut Stats<3>,
        (at_once, windows): (u32, usize),
    ) -> Result<usize, Error> {
        let samples = map.table.len();
        let begun = usize::try_from(self.windows).ok().filter(|&begun| begun < windows);
        let differs = [
            ("number of frames at once", self.at_once != at_once),
            ("output", self.ids.len() != map.ids.plane(0).len()),
            ("exemplars", self.ids.iter().any(|id| id.is_assigned() && samples <= id.get())),
            ("number of windows", begun.is_none()),
        ];
        if let Some((what, _)) = differs.into_iter().find(|(_, differs)| *differs) {
            return Err(Error::Checkpoint { what });
        }
        map.ids.plane_mut(0).copy_from_slice(&self.ids);
        stats.set_counts(self.counts);
        stats.energy.clone_from(&self.energy);
        stats.settled.clone_from(&self.settled);
        Ok(begun.unwrap_or_default())
    }

    /// Windows that were woven.
    pub fn windows(&self) -> u64 {
        self.windows
    }

    /// The same in bytes, for a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        let numbers = [self.at_once.into(), self.windows].into_iter().chain(self.counts);
        numbers.chain([self.ids.len() as u64]).for_each(|word| put_word(&mut bytes, word));
        put_prices(&mut bytes, &self.energy);
        put_prices(&mut bytes, &self.settled);
        put_ids(&mut bytes, &self.ids);
        bytes
    }

    /// What [`to_bytes`](Self::to_bytes) made.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] for anything else.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, Error> {
        read(bytes).ok_or(Error::Checkpoint { what: "form" })
    }
}

fn read(bytes: &[u8]) -> Option<WindowsCheckpoint> {
    let mut words = Words(bytes.strip_prefix(MAGIC)?);
    let (at_once, windows) = (u32::try_from(words.word()?).ok()?, words.word()?);
    let (counts, samples) = (words.array()?, words.word()?);
    let (energy, settled) = (words.prices()?, words.prices()?);
    Some(WindowsCheckpoint { ids: words.ids(samples)?, at_once, windows, counts, energy, settled })
}
