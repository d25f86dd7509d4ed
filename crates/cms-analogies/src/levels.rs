//! Coarse to fine: solved at a fraction of the size first, carried up, and settled before anything is searched.
//!
//! Neighborhoods are as many samples wide at every level, so that the coarse ones see larger structures, for a fraction
//! of the samples. A map that was carried up has its labels in steps of two samples, and seams to within as many: what
//! is left to do is a sample of each offset, the course of seams, and detail.

use selvedge_core::{Domain, Exemplars, SourceMap, Window};

use crate::constraint::Constraint;
use crate::error::Error;
use crate::options::Options;

/// Levels where nobody says how many: the coarsest has a sixteenth of the samples, and what is larger than its
/// neighborhoods is larger than the exemplars that were looked at hold.
pub(crate) const AUTO: u32 = 3;

/// How far from the place that a label was searched for it may be taken at a finer level. At a coarser one all of its
/// source was tried, and what it could have brought farther away is there. Expansions of whole sources take most of a
/// run's time otherwise. With 96 samples brick, grass and sky, an arch, rice and a blur end at 866, 366, 58.4 and 638
/// for 879, 369, 64.5 and 661e6, in 1.9, 1.4, 5.6 and 2.8 times the time.
const REACH: u32 = 32;

/// The samples that it is tried for.
pub(crate) const AROUND: usize = (2 * REACH as usize + 1).pow(2);

/// How often all pieces are offered their label a sample further, the one of eight ways that promises most. All eight
/// take half as long again or twice as long, and find less: of the rock's arch, of brick, grass and sky, of bricks
/// enlarged eightfold and of rice two rounds end at 378, 876, 64.9 and 63.0e6 in 2.7, 1.8, 4.8 and 3.0 s, all eight
/// once at 410, 1017, 65.8 and 69.3e6 in 4.4, 2.9, 10.6 and 4.0 s. Further rounds lower the energy on, by cutting
/// textures into crumbs.
pub(crate) const MOVES: u32 = 2;

/// How often labels are settled at a coarse level, where all pieces together cost a fourth, and what became right is
/// right at all finer ones.
pub(crate) const ROUNDS: u32 = 2;

/// Exemplars and constraints at a fraction of the size.
pub(crate) struct Level {
    pub(crate) exemplars: Exemplars<2>,
    pub(crate) constraints: Vec<Constraint>,
}

/// The levels below the finest, each half as large as the one before: as many as are wanted and hold neighborhoods
/// twice over. Taps are as far apart as is nearest to what they are at the finest one: a level need not divide a ratio,
/// since what it decides is settled at the next. Bricks enlarged fivefold end at 2471e6 by way of taps 3 and 1 samples
/// apart, 2583e6 by 2 and 1, 2417e6 without levels in four times as long; a cloth of scale 3 takes a tenth of the time.
pub(crate) fn below(
    exemplars: &Exemplars<2>,
    constraints: &[Constraint],
    options: &Options,
) -> Result<Vec<Level>, Error> {
    let mut levels: Vec<Level> = Vec::new();
    for level in 1..options.levels.unwrap_or(AUTO) {
        let factor = 1_u32 << level;
        let (finer, over) = levels.last().map_or((exemplars, constraints), |l| (&l.exemplars, &l.constraints[..]));
        let exemplars = match finer.coarser() {
            // A mask leaves no whole block.
            Err(selvedge_core::Error::NothingValid) => break,
            coarse => coarse?,
        };
        let coarse = over.iter().zip(constraints).map(|(over, finest)| {
            let ratio = ((finest.ratio + factor / 2) / factor).max(1);
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

/// A map of a level at full size, by way of all levels between: what it will look like, before it is there.
pub(crate) fn whole(
    map: &SourceMap<2>,
    between: &[Level],
    exemplars: &Exemplars<2>,
    output: Domain<2>,
) -> Result<SourceMap<2>, Error> {
    let mut finer: Option<SourceMap<2>> = None;
    for level in between.iter().rev() {
        let output = level.constraints[0].guide.target().domain();
        finer = Some(finer.as_ref().unwrap_or(map).finer(&level.exemplars, output)?);
    }
    Ok(finer.as_ref().unwrap_or(map).finer(exemplars, output)?)
}

/// Where a label may be taken that was searched for a place of a finer level.
pub(crate) fn around(at: [u32; 2]) -> Window<2> {
    Window { start: at.map(|p| p as i32 - REACH as i32), shape: [2 * REACH + 1; 2] }
}

/// A sample further along any axes.
pub(crate) fn ways() -> impl Iterator<Item = [i32; 2]> {
    (-1..=1).flat_map(|y| (-1..=1).map(move |x| [y, x])).filter(|by| *by != [0; 2])
}
