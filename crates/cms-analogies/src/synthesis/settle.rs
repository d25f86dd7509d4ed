//! What was carried up from a coarser level: each label around every piece that shows it.

use selvedge_core::{Patch, par};

use super::Weaver;
use crate::error::Error;
use crate::expansion::{Desk, Expansions, Trial, first_of};
use crate::labelling::Labelling;
use crate::levels;
use crate::pieces::{self, LEAST_MOVED, Piece};

impl Weaver<'_, '_> {
    /// Offers each label around every piece that shows it, as it is and then, so many times, moved by a sample.
    pub(super) fn settle(&mut self) -> Result<bool, Error> {
        self.labelling.wait(true)?;
        let output = self.labelling.map.domain();
        for round in 0..=levels::MOVES {
            let pieces = pieces::of(&self.labelling.map)?;
            let groups = if self.labelling.holes == 0 && self.labelling.uses.is_off() {
                pieces::groups(&pieces, output, self.expansions.room(output))?
            } else {
                // What one changes counts for all.
                (0..pieces.len()).map(|number| vec![number]).collect()
            };
            for group in groups {
                if self.run.observer.cancelled() {
                    return Ok(false);
                }
                for trial in self.settled(round, &pieces, &group) {
                    if let Some(trial) = trial? {
                        self.lay(trial)?;
                    }
                }
            }
        }
        self.labelling.wait(false)?;
        Ok(true)
    }

    /// Tries the labels of some pieces beside each other.
    pub(super) fn settled(
        &mut self,
        round: u32,
        pieces: &[Piece],
        group: &[usize],
    ) -> Vec<Result<Option<Trial>, Error>> {
        let (labelling, expansions, observer) = (&self.labelling, self.expansions, self.run.observer);
        par::map_with(&mut self.desks, group.len(), |desk, i| {
            let Piece { patch, window, .. } = &pieces[group[i]];
            let label = if round == 0 { Some(*patch) } else { moved(labelling, expansions, &pieces[group[i]], desk)? };
            let Some(label) = label else { return Ok(None) };
            let at = first_of(window, labelling.map.domain());
            expansions.try_label(labelling, &label, at, Some(window), desk, &|| observer.cancelled()).map(Some)
        })
    }
}

/// A piece's label moved by that sample which promises most; `None` where no move promises anything.
fn moved(
    labelling: &Labelling<'_>,
    expansions: Expansions<'_>,
    piece: &Piece,
    desk: &mut Desk,
) -> Result<Option<Patch<2>>, Error> {
    let (mut most, mut best) = (0, None);
    for by in levels::ways().filter(|_| LEAST_MOVED <= piece.samples) {
        let offset = [0, 1].map(|a| piece.patch.offset[a] + by[a]);
        let label = Patch { offset, ..piece.patch };
        let promise = expansions.promise(labelling, &label, &piece.window, desk)?;
        if most < promise {
            (most, best) = (promise, Some(label));
        }
    }
    Ok(best)
}
