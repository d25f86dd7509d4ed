//! The same by conjugate gradients, where some samples are held.

use selvedge_core::{Error, par, try_vec};

use crate::fourier::Ends;
use crate::poisson::Poisson;

/// Values that sums are taken of before these are added, in order: the same sum on any number of threads, and enough of
/// them that starting a task costs nothing beside it.
const BLOCK: usize = 1 << 14;

/// Rounds after which what is reached must do. Some tens are usual: the whole box's solution is near.
const MOST_ROUNDS: u32 = 1000;

/// A box, some of whose places are held at 0.
pub(crate) struct Held<'a, const D: usize> {
    pub(crate) free: &'a [bool],
    pub(crate) poisson: &'a Poisson<D>,
}

impl<const D: usize> Held<'_, D> {
    /// Solves `sum over neighbors q of (w[p] - w[q]) = f[p]` where places are free, from `f` to `w`, about as near as
    /// `tolerance`: the solution over the whole box says how far away it is, and where to go (a preconditioner).
    pub(crate) fn solve(&self, values: &mut [f64], tolerance: f64) -> Result<(), Error> {
        let n = values.len();
        let (mut rest, mut near) = (try_vec(n, 0.0)?, try_vec(n, 0.0)?);
        let (mut way, mut pull) = (try_vec(n, 0.0)?, try_vec(n, 0.0)?);
        rest.copy_from_slice(values);
        self.hold(&mut rest);
        values.fill(0.0);
        let mut before = 0.0;
        for round in 0..MOST_ROUNDS {
            near.copy_from_slice(&rest);
            self.poisson.solve(&mut near);
            self.hold(&mut near);
            if near.iter().all(|v| v.abs() <= tolerance / 10.0) {
                break;
            }
            let now = dot(&rest, &near);
            let kept = if round == 0 { 0.0 } else { now / before };
            way.iter_mut().zip(&near).for_each(|(way, near)| *way = near + kept * *way);
            self.pull(&way, &mut pull);
            self.hold(&mut pull);
            let length = now / dot(&way, &pull);
            values.iter_mut().zip(&way).for_each(|(w, way)| *w += length * way);
            rest.iter_mut().zip(&pull).for_each(|(rest, pull)| *rest -= length * pull);
            before = now;
        }
        Ok(())
    }

    fn hold(&self, values: &mut [f64]) {
        values.iter_mut().zip(self.free).for_each(|(v, free)| *v = if *free { *v } else { 0.0 });
    }

    /// What the differences from neighbors sum up to.
    fn pull(&self, w: &[f64], to: &mut [f64]) {
        let (domain, ends, last) = (self.poisson.domain, self.poisson.ends, D - 1);
        let width = domain.shape[last] as usize;
        let mut rows = domain;
        (rows.shape[last], rows.periodic[last]) = (1, false);
        par::for_rows(to, width, |row, to| {
            let here = &w[row * width..][..width];
            to.fill(0.0);
            for (axis, ends) in ends.iter().enumerate().take(last) {
                for by in [-1, 1] {
                    let by = std::array::from_fn(|a| if a == axis { by } else { 0 });
                    if let Some(there) = rows.step(rows.position(row), by) {
                        let there = &w[rows.index(there) * width..][..width];
                        to.iter_mut().zip(here.iter().zip(there)).for_each(|(to, (p, q))| *to += p - q);
                    } else if *ends == Ends::Tied {
                        to.iter_mut().zip(here).for_each(|(to, p)| *to += p);
                    }
                }
            }
            for x in 1..width {
                let d = here[x] - here[x - 1];
                to[x] += d;
                to[x - 1] -= d;
            }
            match ends[last] {
                Ends::Free => {}
                Ends::Around => {
                    let d = here[0] - here[width - 1];
                    to[0] += d;
                    to[width - 1] -= d;
                }
                Ends::Tied => {
                    to[0] += here[0];
                    to[width - 1] += here[width - 1];
                }
            }
        });
    }
}

/// A sum of products, in one order on any number of threads.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let part = |range: std::ops::Range<usize>| a[range.clone()].iter().zip(&b[range]).map(|(a, b)| a * b).sum::<f64>();
    par::fold_blocks(a.len(), BLOCK, part, |a, b| a + b).unwrap_or(0.0)
}
