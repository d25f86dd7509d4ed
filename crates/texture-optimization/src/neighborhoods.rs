//! Which neighborhoods there are: a grid a fourth of their size apart. `[Kwatra05 3]`

use selvedge_core::{Domain, Error, Grid, Source};

use crate::falloff::Falloff;

/// Cells along a neighborhood: the grid's step is a fourth of the size. `[Kwatra05 3]`
pub(crate) const CELLS: u32 = 4;

/// The neighborhoods of an output: squares whose first samples stand on a grid, the last row and column flush with open
/// edges, those of periodic axes closing around them.
#[derive(Clone, Debug)]
pub(crate) struct Neighborhoods {
    /// The output.
    pub(crate) domain: Domain<2>,
    pub(crate) size: u32,
    /// First samples along each axis.
    pub(crate) firsts: [Vec<u32>; 2],
}

impl Neighborhoods {
    /// Those of a size that the domain holds.
    pub(crate) fn new(domain: Domain<2>, size: u32) -> Self {
        let step = size / CELLS;
        let along = |axis: usize| -> Vec<u32> {
            let n = domain.shape[axis];
            let last = if domain.periodic[axis] { n - 1 } else { n - size };
            let mut firsts: Vec<u32> = (0..=last).step_by(step as usize).collect();
            if !domain.periodic[axis] && firsts.last() != Some(&last) {
                firsts.push(last);
            }
            firsts
        };
        Self { domain, size, firsts: [along(0), along(1)] }
    }

    /// Rows and columns of neighborhoods.
    pub(crate) fn shape(&self) -> [usize; 2] {
        [self.firsts[0].len(), self.firsts[1].len()]
    }

    /// A value of each as they lie.
    pub(crate) fn laid(&self, values: &[f64]) -> Result<Grid<f32, 2>, Error> {
        Grid::from_vec(Domain::open(self.shape().map(|n| n as u32)), 1, values.iter().map(|&v| v as f32).collect())
    }

    pub(crate) fn len(&self) -> usize {
        self.firsts[0].len() * self.firsts[1].len()
    }

    pub(crate) fn step(&self) -> u32 {
        self.size / CELLS
    }

    /// The first sample of a neighborhood.
    pub(crate) fn first(&self, number: usize) -> [u32; 2] {
        let columns = self.firsts[1].len();
        [self.firsts[0][number / columns], self.firsts[1][number % columns]]
    }

    /// The neighborhoods around one on the grid: eight, or fewer at open edges.
    pub(crate) fn around(&self, number: usize) -> impl Iterator<Item = usize> + '_ {
        let grid = Domain { shape: self.shape().map(|n| n as u32), periodic: self.domain.periodic };
        let at = grid.position(number);
        let all = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [dy, dx])).filter(|by| *by != [0, 0]);
        all.filter_map(move |by| grid.step(at, by)).map(move |at| grid.index(at)).filter(move |other| *other != number)
    }

    /// Samples from the first one of a neighborhood to that of another, around a periodic axis the shorter way.
    pub(crate) fn way(&self, from: usize, to: usize) -> [i32; 2] {
        let (from, to) = (self.first(from), self.first(to));
        [0, 1].map(|axis| {
            let (by, n) = (i64::from(to[axis]) - i64::from(from[axis]), i64::from(self.domain.shape[axis]));
            (if self.domain.periodic[axis] && n < 2 * by.abs() { by - n * by.signum() } else { by }) as i32
        })
    }

    /// Rows (axis 0) or columns of neighborhoods that hold a sample, and how far from their first one it is.
    ///
    /// Time `O(log rows)`, and one for each of at most a few: finishes and votes ask for every sample of an output.
    pub(crate) fn holding(&self, axis: usize, p: u32) -> impl Iterator<Item = (usize, u32)> + '_ {
        let (firsts, n, size) = (&self.firsts[axis], self.domain.shape[axis], self.size);
        let reaching = move |p: u32| firsts.partition_point(|&first| first + size <= p);
        let own = reaching(p)..firsts.partition_point(|&first| first <= p);
        let around = if self.domain.periodic[axis] { reaching(p + n)..firsts.len() } else { 0..0 };
        own.map(move |i| (i, p - firsts[i])).chain(around.map(move |i| (i, p + n - firsts[i])))
    }

    /// Those that hold a square as a whole, and how far its first sample is from theirs.
    pub(crate) fn holding_all(&self, first: [u32; 2], side: u32) -> impl Iterator<Item = (usize, [u32; 2])> + '_ {
        let along = move |axis: usize| self.holding(axis, first[axis]).filter(move |(_, by)| by + side <= self.size);
        along(0).flat_map(move |(j, dy)| along(1).map(move |(i, dx)| (j * self.firsts[1].len() + i, [dy, dx])))
    }

    /// For each sample along an axis, how much neighborhoods weigh there together: less at open edges, which few of
    /// them hold.
    pub(crate) fn weighed(&self, axis: usize, falloff: &Falloff) -> Vec<f64> {
        let at = |p: u32| self.holding(axis, p).map(|(_, by)| falloff.along()[by as usize]).sum();
        (0..self.domain.shape[axis]).map(at).collect()
    }
}

/// First samples of all neighborhoods of a source that are valid throughout, in the order of their numbers.
///
/// Time `O(samples)`.
pub(crate) fn places(source: &Source<2>, size: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
    let domain = source.domain();
    let over = selvedge_fft_ssd::Windows { side: size, step: 1 }.over(domain);
    let hidden = source.valid.as_deref().filter(|_| !over.is_empty()).map(|valid| Hidden::new(valid, over, size));
    over.positions().filter(move |&at| hidden.as_ref().is_none_or(|h| h.inside(at, size) == 0))
}

/// How many samples of a source are not valid above and left of each corner, as far as windows reach around it.
struct Hidden {
    width: usize,
    sums: Vec<u32>,
}

impl Hidden {
    fn new(valid: &Grid<bool, 2>, over: Domain<2>, size: u32) -> Self {
        let [h, w] = over.shape.map(|n| (n + size - 1) as usize);
        let [rows, columns] = valid.domain().shape.map(|n| n as usize);
        let (width, mut sums) = (w + 1, vec![0; (h + 1) * (w + 1)]);
        for (y, x) in (0..h).flat_map(|y| (0..w).map(move |x| (y, x))) {
            let at = (y + 1) * width + x + 1;
            let is_hidden = !valid.plane(0)[y % rows * columns + x % columns];
            sums[at] = sums[at - width] + sums[at - 1] - sums[at - width - 1] + u32::from(is_hidden);
        }
        Self { width, sums }
    }

    fn inside(&self, at: [u32; 2], size: u32) -> u32 {
        let corner = |y: u32, x: u32| self.sums[y as usize * self.width + x as usize];
        let [y, x] = at;
        corner(y + size, x + size) + corner(y, x) - corner(y + size, x) - corner(y, x + size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_reaches_open_edges_and_closes_around_periodic_ones() {
        let domain = Domain { shape: [21, 21], periodic: [false, true] };
        let all = Neighborhoods::new(domain, 8);
        assert_eq!(all.firsts[0], [0, 2, 4, 6, 8, 10, 12, 13]);
        assert_eq!(all.firsts[1], [0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20]);
        assert_eq!((all.shape(), all.len(), all.first(12)), ([8, 11], 88, [2, 2]));
        for axis in 0..2 {
            for p in 0..21 {
                let found: Vec<_> = all.holding(axis, p).collect();
                let expected: Vec<_> = (0..all.firsts[axis].len())
                    .flat_map(|i| (0..8).map(move |by| (i, by)))
                    .filter(|&(i, by)| {
                        let at = all.firsts[axis][i] + by;
                        at == p || (axis == 1 && at == p + 21)
                    })
                    .collect();
                assert_eq!(found, expected);
                assert!(!found.is_empty());
            }
        }
    }

    #[test]
    fn a_square_is_held_as_a_whole_by_some_and_by_all_that_are_told() {
        let domain = Domain { shape: [37, 40], periodic: [false, true] };
        let (all, smaller) = (Neighborhoods::new(domain, 16), Neighborhoods::new(domain, 8));
        for number in 0..smaller.len() {
            let first = smaller.first(number);
            let mut found: Vec<_> = all.holding_all(first, 8).collect();
            let holds = |other: usize| {
                let by = [0, 1].map(|a| (first[a] + domain.shape[a] - all.first(other)[a]) % domain.shape[a]);
                by.iter().all(|by| by + 8 <= 16).then_some((other, by))
            };
            found.sort_unstable();
            assert_eq!(found, (0..all.len()).filter_map(holds).collect::<Vec<_>>(), "{number}");
            assert!(!found.is_empty());
        }
    }

    #[test]
    fn places_are_those_without_any_hidden_sample() {
        let mut rng = selvedge_core::Seed(2).rng();
        for case in 0..100 {
            let shape = [1 + rng.below(12), 1 + rng.below(12)];
            let domain = Domain { shape, periodic: [rng.below(2) == 0, rng.below(2) == 0] };
            let valid = (0..domain.len()).map(|_| rng.below(12) != 0).collect();
            let source = Source {
                features: Grid::try_filled(domain, 1, 0).unwrap(),
                valid: (case % 4 != 0).then(|| Grid::from_vec(domain, 1, valid).unwrap()).map(Into::into),
                origin: selvedge_core::Origin { exemplar: 0, transform: selvedge_core::Transform::IDENTITY },
            };
            let inside = |at: [u32; 2], by: [u32; 2]| domain.step(at, by.map(|b| b as i32));
            let is_whole = |at: &[u32; 2]| {
                let fits = shape.iter().all(|&n| 4 <= n);
                let mut all = Domain::open([4, 4]).positions().map(|by| inside(*at, by));
                fits && all.all(|p| p.is_some_and(|p| source.valid.as_deref().is_none_or(|v| v.get(0, p))))
            };
            let expected: Vec<_> = domain.positions().filter(is_whole).collect();
            assert_eq!(places(&source, 4).collect::<Vec<_>>(), expected);
        }
    }
}
