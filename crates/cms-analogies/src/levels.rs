//! Coarse to fine: solved at a fraction of the size first, carried up, and settled before anything is searched.
//!
//! Neighborhoods are as many samples wide at every level, so that the coarse ones see larger structures, for a fraction
//! of the samples. A map that was carried up has its labels in steps of two samples, and seams to within as many: what
//! is left to do is a sample of each offset, the course of seams, and detail.

use std::collections::BTreeMap;

use selvedge_core::{Exemplars, Patch, SourceMap, Window};

use crate::constraint::Constraint;
use crate::error::Error;
use crate::options::Options;

/// Levels where nobody says how many: the coarsest has a sixteenth of the samples, and what is larger than its
/// neighborhoods is larger than the exemplars that were looked at hold.
pub(crate) const AUTO: u32 = 3;

/// How far from what a label shows it may be taken when it is moved: twice what a sample of the coarser level is here.
const WIDTH: u32 = 4;

/// How far from the place that a label was searched for it may be taken at a finer level. At a coarser one all of its
/// source was tried, and what it could have brought farther away is there. Expansions of whole sources take most of a
/// run's time otherwise.
const REACH: u32 = 32;

/// Labels of fewer samples are not moved: eight expansions each, of windows that are mostly what is around them, took
/// more time than all that was searched afterwards.
pub(crate) const LEAST_MOVED: usize = 64;

/// Exemplars and constraints at a fraction of the size.
pub(crate) struct Level {
    pub(crate) exemplars: Exemplars<2>,
    pub(crate) constraints: Vec<Constraint>,
}

/// The levels below the finest, each half as large as the one before: as many as are wanted, divide every ratio or are
/// divided by it, and hold neighborhoods twice over.
pub(crate) fn below(
    exemplars: &Exemplars<2>,
    constraints: &[Constraint],
    options: &Options,
) -> Result<Vec<Level>, Error> {
    let mut levels: Vec<Level> = Vec::new();
    for level in 1..options.levels.unwrap_or(AUTO) {
        let factor = 1_u32 << level;
        if !constraints.iter().all(|c| c.ratio.is_multiple_of(factor) || factor.is_multiple_of(c.ratio)) {
            break;
        }
        let (finer, over) = levels.last().map_or((exemplars, constraints), |l| (&l.exemplars, &l.constraints[..]));
        let exemplars = match finer.coarser() {
            // A mask leaves no whole block.
            Err(selvedge_core::Error::NothingValid) => break,
            coarse => coarse?,
        };
        let coarse = over.iter().zip(constraints).map(|(over, finest)| {
            let ratio = (finest.ratio / factor).max(1);
            Ok(Constraint { guide: over.guide.coarser()?, ratio, weight: finest.weight })
        });
        let constraints = match coarse.collect::<Result<Vec<_>, selvedge_core::Error>>() {
            Err(selvedge_core::Error::NothingValid) => break,
            coarse => coarse?,
        };
        if !constraints.iter().all(|c| c.fits_twice(&exemplars, options)) {
            break;
        }
        levels.push(Level { exemplars, constraints });
    }
    Ok(levels)
}

/// A label of a map.
pub(crate) struct Label {
    pub(crate) patch: Patch<2>,
    /// The box around all that shows it.
    pub(crate) window: Window<2>,
    /// How many samples do.
    pub(crate) samples: usize,
}

/// Each label of a map with the box around all that shows it and a little more; the whole output where that goes
/// around.
pub(crate) fn labels(map: &SourceMap<2>) -> Vec<Label> {
    let output = map.domain();
    let mut boxes: BTreeMap<Patch<2>, ([u32; 2], [u32; 2], usize)> = BTreeMap::new();
    for at in output.positions() {
        let Some((source, from)) = map.locate(at) else { continue };
        let patch = Patch { source, offset: [0, 1].map(|a| at[a] as i32 - from[a] as i32) };
        let patch = patch.wrapped(map.table.sources()[source].1, output);
        let (low, high, samples) = boxes.entry(patch).or_insert((at, at, 0));
        *samples += 1;
        *low = [0, 1].map(|a| low[a].min(at[a]));
        *high = [0, 1].map(|a| high[a].max(at[a]));
    }
    let grown = |low: [u32; 2], high: [u32; 2]| {
        let of = Window { start: low.map(|p| p as i32), shape: [0, 1].map(|a| high[a] - low[a] + 1) };
        if output.periodic == [false; 2] { of.grown(output, [WIDTH; 2], [WIDTH; 2]) } else { Window::all(output) }
    };
    let label = |(patch, (low, high, samples))| Label { patch, window: grown(low, high), samples };
    boxes.into_iter().map(label).collect()
}

/// Where a label may be taken that was searched for a place of a finer level.
pub(crate) fn around(at: [u32; 2]) -> Window<2> {
    Window { start: at.map(|p| p as i32 - REACH as i32), shape: [2 * REACH + 1; 2] }
}

/// As it is, and a sample further along any axes.
pub(crate) fn ways() -> impl Iterator<Item = [i32; 2]> {
    std::iter::once([0; 2]).chain((-1..=1).flat_map(|y| (-1..=1).map(move |x| [y, x])).filter(|by| *by != [0; 2]))
}
