//! Draws of blocks where nothing is compared: the places are numbered, not listed.
//!
//! The first block of an output, and all blocks without overlap, fit anywhere equally well. A list of all places for
//! each of them would take more time and memory than all the rest.

use selvedge_core::{Error, Exemplars, Rng, try_vec};

use crate::search::Candidate;

/// All places at which a valid block of one shape may begin, by source, row and column.
pub(crate) struct FreePlaces<'e> {
    exemplars: &'e Exemplars<2>,
    /// Of each masked source, how many samples above and left of a corner are masked: `(h + 1) * (w + 1)` values.
    masked: Vec<Option<Vec<u32>>>,
    shape: [u32; 2],
    /// Of each source, the places in all sources and rows before each row, and at last those up to its end.
    before: Vec<Vec<u32>>,
}

impl<'e> FreePlaces<'e> {
    pub(crate) fn new(exemplars: &'e Exemplars<2>) -> Self {
        Self { exemplars, masked: Vec::new(), shape: [0; 2], before: Vec::new() }
    }

    /// One of the places for a block of this shape but those to avoid, as a uniform draw, and how many there were; one
    /// of all if all are to be avoided. `None` if there is none at all.
    pub(crate) fn draw(
        &mut self,
        shape: [u32; 2],
        avoid: impl Iterator<Item = (usize, [i64; 2])>,
        rng: &mut Rng,
    ) -> Result<Option<(Candidate, u32)>, Error> {
        self.count(shape)?;
        let all = self.before.last().and_then(|rows| rows.last()).copied().unwrap_or(0);
        let mut avoided: Vec<u32> = avoid.filter_map(|(source, at)| self.number(source, at)).collect();
        avoided.sort_unstable();
        avoided.dedup();
        if avoided.len() as u32 == all {
            avoided.clear();
        }
        let n = all - avoided.len() as u32;
        if n == 0 {
            return Ok(None);
        }
        let drawn = rng.below(n);
        // Each one avoided before it moves it on.
        let number = avoided.into_iter().fold(drawn, |number, avoided| number + u32::from(avoided <= number));
        Ok(Some((self.place(number), n)))
    }

    /// Counts the places for a shape, row by row.
    fn count(&mut self, shape: [u32; 2]) -> Result<(), Error> {
        if self.shape == shape {
            return Ok(());
        }
        if self.masked.is_empty() {
            self.masked = (0..self.exemplars.sources().len()).map(|s| self.sums(s)).collect::<Result<_, _>>()?;
        }
        self.shape = shape;
        let (mut before, mut total) = (Vec::new(), 0);
        for source in 0..self.masked.len() {
            let [rows, columns] = self.range(source);
            let mut of_rows = try_vec(rows as usize + 1, 0)?;
            for y in 0..rows {
                of_rows[y as usize] = total;
                total += if self.masked[source].is_none() {
                    columns
                } else {
                    (0..columns).filter(|&x| self.is_free(source, [y, x])).count() as u32
                };
            }
            of_rows[rows as usize] = total;
            before.push(of_rows);
        }
        self.before = before;
        Ok(())
    }

    /// Rows and columns at which a block lies within a source.
    fn range(&self, source: usize) -> [u32; 2] {
        let source = self.exemplars.sources()[source].domain().shape;
        let [rows, columns] = [0, 1].map(|axis| (source[axis] + 1).saturating_sub(self.shape[axis]));
        if rows == 0 || columns == 0 { [0, 0] } else { [rows, columns] }
    }

    fn sums(&self, source: usize) -> Result<Option<Vec<u32>>, Error> {
        let Some(valid) = &self.exemplars.sources()[source].valid else { return Ok(None) };
        let [h, w] = valid.domain().shape.map(|side| side as usize);
        let mut sums = try_vec((h + 1) * (w + 1), 0_u32)?;
        for y in 0..h {
            let mut row = 0;
            for x in 0..w {
                row += u32::from(!valid.plane(0)[y * w + x]);
                sums[(y + 1) * (w + 1) + x + 1] = sums[y * (w + 1) + x + 1] + row;
            }
        }
        Ok(Some(sums))
    }

    /// True if no sample of the block is masked.
    fn is_free(&self, source: usize, [y, x]: [u32; 2]) -> bool {
        let Some(sums) = &self.masked[source] else { return true };
        let wide = self.exemplars.sources()[source].domain().shape[1] as usize + 1;
        let sum = |y: u32, x: u32| sums[y as usize * wide + x as usize];
        let (bottom, right) = (y + self.shape[0], x + self.shape[1]);
        sum(bottom, right) + sum(y, x) == sum(y, right) + sum(bottom, x)
    }

    /// The number of a place; `None` if it is none.
    fn number(&self, source: usize, at: [i64; 2]) -> Option<u32> {
        let [y, x] = [u32::try_from(at[0]).ok()?, u32::try_from(at[1]).ok()?];
        let [rows, columns] = self.range(source);
        if rows <= y || columns <= x || !self.is_free(source, [y, x]) {
            return None;
        }
        let in_row = match self.masked[source] {
            None => x,
            Some(_) => (0..x).filter(|&x| self.is_free(source, [y, x])).count() as u32,
        };
        Some(self.before[source][y as usize] + in_row)
    }

    /// The place of a number below that of all.
    fn place(&self, number: u32) -> Candidate {
        let source = self.before.partition_point(|rows| rows.last().is_some_and(|&end| end <= number));
        let y = self.before[source].partition_point(|&before| before <= number) - 1;
        let in_row = number - self.before[source][y];
        let y = y as u32;
        let free = |&x: &u32| self.is_free(source, [y, x]);
        let x = match self.masked[source] {
            None => in_row,
            Some(_) => (0..).filter(free).nth(in_row as usize).expect("counted before"),
        };
        Candidate { error: 0, source, at: [y, x] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Origin, Seed, Source, Transform};

    /// Three sources: one masked here and there, one too narrow for most blocks, one whole.
    fn exemplars() -> Exemplars<2> {
        let source = |exemplar, shape: [u32; 2], masked: bool| Source {
            features: Grid::try_filled(Domain::open(shape), 1, 0).unwrap(),
            valid: masked
                .then(|| {
                    let valid = Domain::open(shape).positions().map(|[y, x]| (y * 7 + x * 3) % 17 != 0).collect();
                    Grid::from_vec(Domain::open(shape), 1, valid).unwrap()
                })
                .map(Into::into),
            origin: Origin { exemplar, transform: Transform::IDENTITY },
        };
        let sources = vec![source(0, [9, 12], true), source(1, [20, 2], false), source(2, [6, 5], false)];
        Exemplars::from_sources(sources, vec![1]).unwrap()
    }

    /// Every place, one after the other.
    fn listed(exemplars: &Exemplars<2>, shape: [u32; 2]) -> Vec<(usize, [u32; 2])> {
        let mut all = Vec::new();
        for (number, source) in exemplars.sources().iter().enumerate() {
            let is_free = |at: [u32; 2]| {
                Domain::open(shape).positions().all(|p| {
                    let from = source.domain().step(at, p.map(|p| p as i32));
                    from.is_some_and(|from| source.valid.as_deref().is_none_or(|v| v.get(0, from)))
                })
            };
            all.extend(source.domain().positions().filter(|&at| is_free(at)).map(|at| (number, at)));
        }
        all
    }

    #[test]
    fn numbered_places_are_those_of_the_list_without_the_avoided_ones() {
        let exemplars = exemplars();
        let mut free = FreePlaces::new(&exemplars);
        for shape in [[1, 1], [3, 2], [3, 4], [5, 5], [1, 12], [10, 1]] {
            let all = listed(&exemplars, shape);
            let avoid = [(0, [3, 4]), (0, [3, 4]), (2, [0, 1]), (1, [-1, 0]), (2, [900, 0]), (0, [0, 0])];
            let is_avoided = |&&(s, at): &&(usize, [u32; 2])| avoid.contains(&(s, at.map(i64::from)));
            let left: Vec<_> = all.iter().filter(|place| !is_avoided(place)).collect();
            for seed in 0..200 {
                let drawn = free.draw(shape, avoid.into_iter(), &mut Seed(seed).rng()).unwrap();
                let (chosen, n) = drawn.unwrap();
                let expected = left[Seed(seed).rng().below(left.len() as u32) as usize];
                assert_eq!((n as usize, (chosen.source, chosen.at)), (left.len(), *expected), "{shape:?} {seed}");
            }
            // Where all are to be avoided, none is.
            let every = all.iter().map(|&(s, at)| (s, at.map(i64::from)));
            assert_eq!(free.draw(shape, every, &mut Seed(1).rng()).unwrap().unwrap().1 as usize, all.len());
        }
        assert_eq!(free.draw([10, 3], std::iter::empty(), &mut Seed(1).rng()), Ok(None));
    }
}
