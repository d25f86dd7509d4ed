//! Where the output is worst: match errors, of which the largest of every row is known. `[CMS IV-C step 1]`

use selvedge_core::{Domain, Grid, Window, try_vec};

use crate::error::Error;

/// The match error of a hole: worse than anything else. `[CMS IV-C step 0]`
pub(crate) const OF_HOLE: i64 = i64::MAX;

/// Match errors by place.
pub(crate) struct Worst {
    domain: Domain<2>,
    errors: Vec<i64>,
    /// The largest of each row, of places that are not covered.
    rows: Vec<i64>,
    /// Places that nobody may improve.
    fixed: Vec<bool>,
    /// How often each place is [covered](Self::cover).
    covered: Vec<u16>,
}

impl Worst {
    pub(crate) fn new(domain: Domain<2>, fixed: Option<&Grid<bool, 2>>) -> Result<Self, Error> {
        let mut of_place = Vec::new();
        if let Some(fixed) = fixed {
            of_place = try_vec(domain.len(), false)?;
            of_place.copy_from_slice(fixed.samples());
        }
        let (errors, rows) = (try_vec(domain.len(), 0)?, try_vec(domain.shape[0] as usize, 0)?);
        Ok(Self { domain, errors, rows, fixed: of_place, covered: try_vec(domain.len(), 0)? })
    }

    /// An error of a place; [`renew`](Self::renew) makes it count.
    pub(crate) fn set(&mut self, place: usize, error: i64) {
        let fixed = self.fixed.get(place).is_some_and(|&fixed| fixed);
        // What is fixed stays as it is, but a hole is filled.
        self.errors[place] = if fixed && error != OF_HOLE { 0 } else { error };
    }

    /// After errors of a window have changed.
    pub(crate) fn renew(&mut self, window: &Window<2>, output: Domain<2>) {
        let wide = self.domain.shape[1] as usize;
        for start in window.along(output, 0).flatten() {
            let row = start as usize..start as usize + wide;
            let errors = self.errors[row.clone()].iter().zip(&self.covered[row]);
            self.rows[start as usize / wide] =
                errors.filter(|(_, covered)| **covered == 0).map(|(e, _)| *e).max().unwrap_or(0);
        }
    }

    /// Leaves out what is less than `apart` from a place along both axes, until that is [uncovered](Self::uncover). So
    /// the worst of what is left is found as fast, however much is left out.
    pub(crate) fn cover(&mut self, at: [u32; 2], apart: u32) {
        self.count(at, apart, |covered| covered.saturating_add(1));
    }

    pub(crate) fn uncover(&mut self, at: [u32; 2], apart: u32) {
        self.count(at, apart, |covered| covered.saturating_sub(1));
    }

    fn count(&mut self, at: [u32; 2], apart: u32, next: impl Fn(u16) -> u16) {
        let domain = self.domain;
        let Some(reach) = apart.checked_sub(1) else { return };
        // Once around at most: a place is covered once by each.
        let along = |a: usize| match domain.periodic[a] && domain.shape[a] < 2 * reach + 1 {
            true => (0, domain.shape[a]),
            false => (at[a] as i32 - reach as i32, 2 * reach + 1),
        };
        let [(y, height), (x, width)] = [along(0), along(1)];
        let window = Window { start: [y, x], shape: [height, width] };
        window.places(domain).flatten().for_each(|place| self.covered[place] = next(self.covered[place]));
        self.renew(&window, domain);
    }

    /// The worst place, then the worst that is at least `apart` from it along some axis, and so on: places above 0 that
    /// are not covered, the first of equal ones.
    pub(crate) fn places(&self, count: usize, apart: u32) -> Vec<usize> {
        self.found(count, |found| self.next(found, apart, |y| self.rows[y], |_| 0))
    }

    /// The same with something added to the error of every place, which nobody has noted: all of them are looked at.
    pub(crate) fn places_with(&self, count: usize, apart: u32, added: impl Fn(usize) -> i64) -> Vec<usize> {
        let wide = self.domain.shape[1] as usize;
        let most = |y: usize| (y * wide..(y + 1) * wide).map(|place| self.errors[place].saturating_add(added(place)));
        let rows: Vec<i64> = (0..self.rows.len()).map(|y| most(y).max().unwrap_or(0)).collect();
        self.found(count, |found| self.next(found, apart, |y| rows[y], &added))
    }

    fn found(&self, count: usize, next: impl Fn(&[[u32; 2]]) -> Option<usize>) -> Vec<usize> {
        let mut found = Vec::new();
        while found.len() < count
            && let Some(place) = next(&found)
        {
            found.push(self.domain.position(place));
        }
        found.iter().map(|&at| self.domain.index(at)).collect()
    }

    /// `most` bounds what can be found in a row.
    fn next(
        &self,
        found: &[[u32; 2]],
        apart: u32,
        most: impl Fn(usize) -> i64,
        added: impl Fn(usize) -> i64,
    ) -> Option<usize> {
        let wide = self.domain.shape[1] as usize;
        let (mut worst, mut best) = (0, None);
        for y in 0..self.rows.len() {
            if most(y) <= worst {
                continue;
            }
            let near: Vec<u32> =
                found.iter().filter(|f| self.domain.apart(0, f[0], y as u32) < apart).map(|f| f[1]).collect();
            for x in 0..wide {
                let place = y * wide + x;
                let is_fixed = self.errors[place] == 0 && self.fixed.get(place) == Some(&true);
                if self.covered[place] != 0 || is_fixed {
                    continue;
                }
                let error = self.errors[place].saturating_add(added(place));
                if worst < error && near.iter().all(|&f| apart <= self.domain.apart(1, f, x as u32)) {
                    (worst, best) = (error, Some(place));
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Seed;

    #[test]
    fn places_are_the_worst_and_apart() {
        for case in 0..100 {
            let mut rng = Seed(case).rng();
            let shape = [1 + rng.below(20), 1 + rng.below(20)];
            let domain = Domain { shape, periodic: [case % 2 == 0, case % 3 == 0] };
            let mut worst = Worst::new(domain, None).unwrap();
            let errors: Vec<i64> = (0..domain.len()).map(|_| i64::from(rng.below(30))).collect();
            errors.iter().enumerate().for_each(|(place, &e)| worst.set(place, e));
            worst.renew(&Window::all(domain), domain);
            let apart = 1 + rng.below(6);
            let far = |p: usize, q: usize, apart: u32| {
                let [p, q] = [p, q].map(|p| domain.position(p));
                (0..2).any(|a| {
                    let d = p[a].abs_diff(q[a]);
                    apart <= if domain.periodic[a] { d.min(shape[a] - d) } else { d }
                })
            };
            let near = 1 + rng.below(6);
            let covered: Vec<usize> = (0..rng.below(4)).map(|_| rng.below(domain.len() as u32) as usize).collect();
            covered.iter().for_each(|&place| worst.cover(domain.position(place), near));
            // Some are left out no more, one of them was left out twice.
            let kept = covered.len() / 2;
            covered[kept..].iter().for_each(|&place| worst.uncover(domain.position(place), near));
            let mut expected: Vec<usize> = Vec::new();
            for _ in 0..5 {
                let is_free = |p: usize| covered[..kept].iter().all(|&q| far(p, q, near));
                let free = (0..errors.len())
                    .filter(|&p| 0 < errors[p] && is_free(p) && expected.iter().all(|&q| far(p, q, apart)));
                expected.extend(free.max_by_key(|&p| (errors[p], usize::MAX - p)));
            }
            assert_eq!(worst.places(5, apart), expected, "{domain:?} {apart}");
            // Something added to each is a larger error of each.
            let added: Vec<i64> = (0..errors.len()).map(|_| i64::from(rng.below(30))).collect();
            let with = worst.places_with(5, apart, |place| added[place]);
            errors.iter().zip(&added).enumerate().for_each(|(place, (&e, &a))| worst.set(place, e + a));
            worst.renew(&Window::all(domain), domain);
            assert_eq!(with, worst.places(5, apart), "{domain:?} {apart}");
        }
    }
}
