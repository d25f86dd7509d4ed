//! Resolutions and sizes: what is optimised after what. `[Kwatra05 3.2]`

use selvedge_core::{Domain, Exemplars};

use crate::error::Error;
use crate::level::Level;
use crate::neighborhoods::{CELLS, places};

/// The coarsest resolution: beyond, textures have no samples left.
const COARSEST: u32 = 64;
/// The largest neighborhood: a sum of its squares fits 32 bits in one channel. From 148 px on three channels do not,
/// and few windows are compared one by one.
const LARGEST: u32 = 256;

/// A level that pyramids and searches have.
pub(crate) fn check(level: Level) -> Result<(), Error> {
    if !level.scale.is_power_of_two() || COARSEST < level.scale {
        return Err(Error::Scale { scale: level.scale });
    }
    if level.size == 0 || LARGEST < level.size || !level.size.is_multiple_of(CELLS) {
        return Err(Error::Size { size: level.size });
    }
    Ok(())
}

/// The levels of figure 3: 8 at a fourth of the resolution; 16 and 8 at a half; 32, 16 and 8 at the full one.
pub(crate) fn paper_schedule() -> Vec<Level> {
    [(4, 8), (2, 16), (2, 8), (1, 32), (1, 16), (1, 8)].map(|(scale, size)| Level { scale, size }).to_vec()
}

/// The exemplars at all resolutions of a schedule, and the levels that fit.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    /// Exemplars halved once, twice, ...
    coarse: Vec<Exemplars<2>>,
    pub(crate) levels: Vec<Level>,
    pub(crate) left_out: Vec<Level>,
}

/// How far a run is, in steps of the coarsest iteration's work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Steps {
    /// Before a level begins.
    pub(crate) before: u64,
    /// Of an iteration there.
    pub(crate) each: u64,
    /// Of all levels, if none settles before its last iteration.
    pub(crate) of: u64,
}

impl Schedule {
    /// Of the levels those whose neighborhoods fit into exemplars and output. `[Kwatra05 3.2]`
    pub(crate) fn new(exemplars: &Exemplars<2>, output: Domain<2>, levels: &[Level]) -> Result<Self, Error> {
        let mut coarse: Vec<Exemplars<2>> = Vec::new();
        for _ in 0..levels.iter().map(|l| l.halvings()).max().unwrap_or(0) {
            match coarse.last().unwrap_or(exemplars).coarser() {
                Ok(exemplars) => coarse.push(exemplars),
                Err(selvedge_core::Error::NothingValid) => break,
                Err(error) => return Err(error.into()),
            }
        }
        let fits = |level: &&Level| {
            let here = halved(exemplars, &coarse, level.halvings());
            here.is_some_and(|e| holds(e, level.size)) && largest(at(output, level.halvings())) >= level.size
        };
        let (levels, left_out): (Vec<&Level>, Vec<&Level>) = levels.iter().partition(fits);
        let [levels, left_out] = [levels, left_out].map(|all| all.into_iter().copied().collect::<Vec<_>>());
        if levels.last().is_none_or(|level| level.scale != 1) {
            return Err(nothing_fits(exemplars, output, &left_out));
        }
        Ok(Self { coarse, levels, left_out })
    }

    /// Those of a level: at half the resolution an iteration is a sixteenth of the work, as output and exemplars have a
    /// fourth.
    pub(crate) fn steps(&self, number: usize, iterations: u32) -> Steps {
        let most = self.levels.iter().map(|l| l.halvings()).max().unwrap_or(0);
        let each = |level: &Level| 16_u64.pow((most - level.halvings()) as u32);
        let of = |levels: &[Level]| levels.iter().map(each).sum::<u64>().saturating_mul(u64::from(iterations));
        Steps { before: of(&self.levels[..number]), each: each(&self.levels[number]), of: of(&self.levels) }
    }

    /// Exemplars at a resolution of this schedule.
    pub(crate) fn exemplars<'a>(&'a self, full: &'a Exemplars<2>, halvings: usize) -> &'a Exemplars<2> {
        halved(full, &self.coarse, halvings).expect("levels without exemplars are left out")
    }
}

fn halved<'a>(full: &'a Exemplars<2>, coarse: &'a [Exemplars<2>], halvings: usize) -> Option<&'a Exemplars<2>> {
    if halvings == 0 { Some(full) } else { coarse.get(halvings - 1) }
}

/// An output halved so many times.
pub(crate) fn at(output: Domain<2>, halvings: usize) -> Domain<2> {
    (0..halvings).fold(output, |domain, _| domain.coarser())
}

fn holds(exemplars: &Exemplars<2>, size: u32) -> bool {
    exemplars.sources().iter().any(|source| places(source, size).next().is_some())
}

/// The largest neighborhood that fits.
fn largest(domain: Domain<2>) -> u32 {
    domain.shape.into_iter().min().unwrap_or(0)
}

fn nothing_fits(exemplars: &Exemplars<2>, output: Domain<2>, left_out: &[Level]) -> Error {
    let least = left_out.iter().filter(|l| l.scale == 1).map(|l| l.size).min().unwrap_or(0);
    let of_exemplars = exemplars.sources().iter().map(|s| s.domain().shape).max_by_key(|s| s[0].min(s[1]));
    // A larger output is of no use where exemplars are too small.
    let is_small = largest(output) < least && of_exemplars.is_none_or(|shape| shape.iter().all(|&n| least <= n));
    let [height, width] = if is_small { output.shape } else { of_exemplars.unwrap_or_default() };
    Error::NothingFits { least, width, height, output: is_small }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Grid, Plane, Role, Samples};

    fn exemplars(shape: [u32; 2]) -> Exemplars<2> {
        let plane = Plane::new(Role::Scalar, Samples::U8(Grid::try_filled(Domain::open(shape), 1, 0).unwrap()));
        Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap()
    }

    fn sizes(exemplar: [u32; 2], output: [u32; 2]) -> Result<Vec<(u32, u32)>, Error> {
        let schedule = Schedule::new(&exemplars(exemplar), Domain::open(output), &paper_schedule())?;
        assert_eq!(schedule.levels.len() + schedule.left_out.len(), 6);
        Ok(schedule.levels.iter().map(|l| (l.scale, l.size)).collect())
    }

    #[test]
    fn sizes_that_do_not_fit_are_left_out() {
        let all = [(4, 8), (2, 16), (2, 8), (1, 32), (1, 16), (1, 8)];
        assert_eq!(sizes([32, 40], [64, 64]).unwrap(), all);
        assert_eq!(sizes([32, 40], [32, 64]).unwrap(), all, "just as large");
        assert_eq!(sizes([31, 40], [64, 64]).unwrap(), [(2, 8), (1, 16), (1, 8)]);
        assert_eq!(sizes([64, 64], [20, 64]).unwrap(), [(2, 8), (1, 16), (1, 8)]);
        let small = Error::NothingFits { least: 8, width: 64, height: 7, output: false };
        assert_eq!(sizes([7, 64], [64, 64]), Err(small));
        assert!(matches!(sizes([64, 64], [64, 7]), Err(Error::NothingFits { output: true, .. })));
    }

    #[test]
    fn odd_levels_are_refused() {
        let level = |scale, size| check(Level { scale, size });
        assert!([(1, 4), (64, 256), (2, 12)].into_iter().all(|(scale, size)| level(scale, size).is_ok()));
        assert_eq!(level(3, 8), Err(Error::Scale { scale: 3 }));
        assert_eq!([0, 9, 260].map(|size| level(1, size)), [0, 9, 260].map(|size| Err(Error::Size { size })));
    }
}
