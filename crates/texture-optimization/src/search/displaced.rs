//! All places of the exemplars at once, by displacement.

use std::ops::Range;

use selvedge_core::{Domain, Exemplars, Grid, SimdLevel};
use selvedge_fft_ssd::{Coverage, Field, Neighbor, Windows, nearest};

use crate::Error;
use crate::neighborhoods::Neighborhoods;

/// What is asked: which neighborhoods, of what, and how channels count.
#[derive(Debug)]
pub(super) struct Displaced<'a> {
    pub(super) exemplars: &'a Exemplars<2>,
    pub(super) weights: Vec<u8>,
    pub(super) all: &'a Neighborhoods,
    pub(super) simd: SimdLevel,
}

impl Displaced<'_> {
    /// Samples that some neighborhoods of an axis hold.
    pub(super) fn covered(&self, axis: usize, part: &Range<usize>) -> Range<u32> {
        let firsts = &self.all.firsts[axis];
        firsts[part.start]..firsts[part.end - 1] + self.all.size
    }

    /// The nearest of the neighborhoods in some rows and columns: all that are evenly spaced at once, those that are
    /// flush with an edge by themselves.
    pub(super) fn part(&self, seen: &Grid<u8, 2>, part: [Range<usize>; 2]) -> Result<Vec<Option<Neighbor>>, Error> {
        let (sources, weights) = (Field::all(self.exemplars), &self.weights);
        self.by_runs(seen, part, |field, windows| Ok(nearest(field, &sources, weights, windows, self.simd)?))
    }

    /// How near all neighborhoods come to the places of the exemplars.
    pub(super) fn coverage(&self, seen: &Grid<u8, 2>, whole: &[Range<usize>; 2]) -> Result<Coverage, Error> {
        let (sources, weights) = (Field::all(self.exemplars), &self.weights);
        let mut all: Option<Coverage> = None;
        for run in self.runs(whole) {
            let cut = self.covering(seen, &run)?;
            let field = Field::new(cut.as_ref().unwrap_or(seen));
            let here = Coverage::of(field, &sources, weights, self.windows(), self.simd)?;
            all = Some(all.map_or(here.clone(), |all| all.and(&here)));
        }
        Ok(all.expect("there are neighborhoods"))
    }

    /// The nearest by their scores, for which all must be known.
    pub(super) fn complete(
        &self,
        seen: &Grid<u8, 2>,
        whole: [Range<usize>; 2],
        (all, alpha): (&Coverage, f64),
    ) -> Result<Vec<Option<Neighbor>>, Error> {
        let (sources, weights, simd) = (Field::all(self.exemplars), &self.weights, self.simd);
        self.by_runs(seen, whole, |field, windows| Ok(all.nearest(field, &sources, weights, windows, alpha, simd)?))
    }

    fn by_runs(
        &self,
        seen: &Grid<u8, 2>,
        part: [Range<usize>; 2],
        search: impl Fn(Field<'_>, Windows) -> Result<Grid<Option<Neighbor>, 2>, Error>,
    ) -> Result<Vec<Option<Neighbor>>, Error> {
        let width = part[1].len();
        let mut all = vec![None; part[0].len() * width];
        for run in self.runs(&part) {
            let cut = self.covering(seen, &run)?;
            let found = search(Field::new(cut.as_ref().unwrap_or(seen)), self.windows())?.into_vec();
            for (row, found) in run[0].clone().zip(found.chunks(run[1].len())) {
                let to = (row - part[0].start) * width + run[1].start - part[1].start;
                all[to..to + run[1].len()].copy_from_slice(found);
            }
        }
        Ok(all)
    }

    fn windows(&self) -> Windows {
        Windows { side: self.all.size, step: self.all.step() }
    }

    /// Rows and columns that are evenly spaced.
    fn runs(&self, part: &[Range<usize>; 2]) -> Vec<[Range<usize>; 2]> {
        let [rows, columns] = [0, 1].map(|a| self.even(a, part[a].clone()));
        rows.iter().flat_map(|y| columns.iter().map(move |x| [y.clone(), x.clone()])).collect()
    }

    /// Neighborhoods of an axis in runs that are evenly spaced.
    fn even(&self, axis: usize, part: Range<usize>) -> Vec<Range<usize>> {
        let (firsts, last) = (&self.all.firsts[axis], part.end - 1);
        if part.start < last && firsts[last] - firsts[last - 1] != self.all.step() {
            vec![part.start..last, last..last + 1]
        } else {
            vec![part]
        }
    }

    /// What neighborhoods that are evenly spaced cover of a picture; `None` if these are all of it.
    fn covering(&self, seen: &Grid<u8, 2>, run: &[Range<usize>; 2]) -> Result<Option<Grid<u8, 2>>, Error> {
        if (0..2).all(|a| run[a].len() == self.all.firsts[a].len()) {
            return Ok(None);
        }
        let covered = [0, 1].map(|a| self.covered(a, &run[a]));
        cropped(seen, covered, self.all.domain).map(Some)
    }
}

/// A part of a picture, around its periodic axes.
fn cropped(seen: &Grid<u8, 2>, [rows, columns]: [Range<u32>; 2], domain: Domain<2>) -> Result<Grid<u8, 2>, Error> {
    let part = Domain::open([rows.len() as u32, columns.len() as u32]);
    let mut out = Grid::try_filled(part, seen.channels(), 0)?;
    for c in 0..seen.channels() {
        for (to, at) in out.plane_mut(c).iter_mut().zip(part.positions()) {
            let [y, x] = [(rows.start + at[0]) % domain.shape[0], (columns.start + at[1]) % domain.shape[1]];
            *to = seen.get(c, [y, x]);
        }
    }
    Ok(out)
}
