//! Linear systems of samples tied to their neighbours, by conjugate gradients.

use selvedge_core::{Domain, Error, par, try_vec};

/// Steps at most: systems of textures need a few dozen, since each sample is held by its own colour as well.
const STEPS: u32 = 1000;

/// The minimum of `sum of a_k x_k^2 - 2 b_k x_k`, and of ties between samples that lie beside each other.
pub(crate) struct System {
    domain: Domain<2>,
    /// `a`, without ties.
    own: Vec<f64>,
    /// `b`, with them.
    right: Vec<f64>,
    /// By axis, how much each sample is tied to the next one.
    ties: [Vec<f64>; 2],
    /// Samples that stay.
    fixed: Vec<Option<f64>>,
}

impl System {
    /// One without ties.
    pub(crate) fn new(domain: Domain<2>, own: &[f64], right: &[f64]) -> Result<Self, Error> {
        let n = own.len();
        let ties = [try_vec(n, 0.0)?, try_vec(n, 0.0)?];
        Ok(Self { domain, own: copied(own)?, right: copied(right)?, ties, fixed: try_vec(n, None)? })
    }

    /// Adds `mu (W (x_next - x)^2 - 2 B (x_next - x))` of an axis.
    pub(crate) fn tie(&mut self, axis: usize, weights: &[f64], differences: &[f64], mu: f64) {
        for at in self.domain.positions() {
            let Some(next) = self.domain.step(at, if axis == 0 { [1, 0] } else { [0, 1] }) else { continue };
            let (i, next) = (self.domain.index(at), self.domain.index(next));
            self.ties[axis][i] = mu * weights[i];
            self.right[i] -= mu * differences[i];
            self.right[next] += mu * differences[i];
        }
    }

    /// Adds `weight (x_i - color)^2`; a weight without end fixes the sample.
    pub(crate) fn wish(&mut self, i: usize, weight: f64, color: f64) {
        if weight == f64::INFINITY {
            self.fixed[i] = Some(color);
        } else {
            self.own[i] += weight;
            self.right[i] += weight * color;
        }
    }

    /// Solves from `x` on, until samples are wrong by about `tolerance` in the mean, each preconditioned by its own
    /// weight. The energy falls with each step, so that it ends no higher than it was, but for samples that were fixed
    /// to others.
    ///
    /// Time `O(samples)` a step, in the caller's pool; sums are taken row by row.
    pub(crate) fn solve(&self, x: &mut [f64], tolerance: f64) -> Result<(), Error> {
        x.iter_mut().zip(&self.fixed).for_each(|(x, fixed)| *x = fixed.unwrap_or(*x));
        let scale = self.diagonal()?;
        let mut times = try_vec(x.len(), 0.0)?;
        self.multiply(x, &mut times);
        let mut residual = copied(&self.right)?;
        residual.iter_mut().zip(&times).for_each(|(r, ax)| *r -= ax);
        residual.iter_mut().zip(&self.fixed).filter(|(_, fixed)| fixed.is_some()).for_each(|(r, _)| *r = 0.0);
        let mut z = try_vec(x.len(), 0.0)?;
        let scaled = |residual: &[f64], z: &mut [f64]| {
            z.iter_mut().zip(residual).zip(&scale).for_each(|((z, r), d)| *z = r / d);
        };
        scaled(&residual, &mut z);
        let mut along = copied(&z)?;
        let mut length = self.dot(&residual, &z);
        let enough = tolerance * tolerance * scale.iter().sum::<f64>();
        for _ in 0..STEPS {
            if length <= enough {
                break;
            }
            self.multiply(&along, &mut times);
            times.iter_mut().zip(&self.fixed).filter(|(_, fixed)| fixed.is_some()).for_each(|(v, _)| *v = 0.0);
            let by = length / self.dot(&along, &times);
            x.iter_mut().zip(&along).for_each(|(x, a)| *x += by * a);
            residual.iter_mut().zip(&times).for_each(|(r, t)| *r -= by * t);
            scaled(&residual, &mut z);
            let next = self.dot(&residual, &z);
            let kept = next / length;
            along.iter_mut().zip(&z).for_each(|(a, z)| *a = z + kept * *a);
            length = next;
        }
        Ok(())
    }

    /// What stands on the diagonal.
    fn diagonal(&self) -> Result<Vec<f64>, Error> {
        let mut diagonal = copied(&self.own)?;
        for at in self.domain.positions() {
            for (axis, next) in [[1, 0], [0, 1]].into_iter().map(|by| self.domain.step(at, by)).enumerate() {
                let (i, Some(next)) = (self.domain.index(at), next.map(|p| self.domain.index(p))) else { continue };
                diagonal[i] += self.ties[axis][i];
                diagonal[next] += self.ties[axis][i];
            }
        }
        Ok(diagonal)
    }

    /// The left side of the equations.
    fn multiply(&self, x: &[f64], out: &mut [f64]) {
        let [height, width] = self.domain.shape.map(|n| n as usize);
        let periodic = self.domain.periodic;
        par::for_rows(out, width, |y, row| {
            let above = if y != 0 { Some(y - 1) } else { periodic[0].then_some(height - 1) };
            let below = if y + 1 != height { Some(y + 1) } else { periodic[0].then_some(0) };
            let (own, here) = (y * width, &x[y * width..][..width]);
            for (i, v) in row.iter_mut().enumerate() {
                *v = self.own[own + i] * here[i];
            }
            if let Some(above) = above.map(|y| y * width) {
                let ties = &self.ties[0][above..][..width];
                let pairs = row.iter_mut().zip(ties).zip(here).zip(&x[above..][..width]);
                pairs.for_each(|(((v, tie), x), other)| *v += tie * (x - other));
            }
            if let Some(below) = below.map(|y| y * width) {
                let ties = &self.ties[0][own..][..width];
                let pairs = row.iter_mut().zip(ties).zip(here).zip(&x[below..][..width]);
                pairs.for_each(|(((v, tie), x), other)| *v += tie * (x - other));
            }
            let ties = &self.ties[1][own..][..width];
            for i in 1..width {
                let by = ties[i - 1] * (here[i] - here[i - 1]);
                row[i] += by;
                row[i - 1] -= by;
            }
            if periodic[1] {
                let by = ties[width - 1] * (here[0] - here[width - 1]);
                row[0] += by;
                row[width - 1] -= by;
            }
        });
    }

    fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        let width = self.domain.shape[1] as usize;
        let row = |y: usize| -> f64 {
            let row = y * width..(y + 1) * width;
            a[row.clone()].iter().zip(&b[row]).map(|(a, b)| a * b).sum()
        };
        par::map_indexed(self.domain.shape[0] as usize, row).into_iter().sum()
    }
}

fn copied(from: &[f64]) -> Result<Vec<f64>, Error> {
    let mut to = try_vec(from.len(), 0.0)?;
    to.copy_from_slice(from);
    Ok(to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Seed;

    /// Cholesky's factors of a dense matrix, and both substitutions.
    fn solved(mut m: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
        let n = b.len();
        for i in 0..n {
            for j in 0..=i {
                let sum: f64 = (0..j).map(|k| m[i][k] * m[j][k]).sum();
                m[i][j] = if i == j { (m[i][i] - sum).sqrt() } else { (m[i][j] - sum) / m[j][j] };
            }
        }
        for i in 0..n {
            b[i] = (b[i] - (0..i).map(|k| m[i][k] * b[k]).sum::<f64>()) / m[i][i];
        }
        for i in (0..n).rev() {
            b[i] = (b[i] - (i + 1..n).map(|k| m[k][i] * b[k]).sum::<f64>()) / m[i][i];
        }
        b
    }

    #[test]
    fn conjugate_gradients_find_what_cholesky_finds() {
        for case in 0..60 {
            let mut rng = Seed(case).rng();
            let shape = [1 + rng.below(9), 1 + rng.below(9)];
            let domain = Domain { shape, periodic: [case % 2 == 0, case / 2 % 2 == 0] };
            let n = domain.len();
            let mut some = |most: u32| (0..n).map(|_| f64::from(1 + rng.below(most)) / 8.0).collect::<Vec<f64>>();
            let (own, right) = (some(40), some(9000));
            let mut system = System::new(domain, &own, &right).unwrap();
            let mut matrix = vec![vec![0.0; n]; n];
            let mut b = right;
            (0..n).for_each(|i| matrix[i][i] = own[i]);
            for axis in 0..2 {
                let (weights, differences) = (some(30), some(2000));
                system.tie(axis, &weights, &differences, 10.0);
                for at in domain.positions() {
                    let Some(next) = domain.step(at, if axis == 0 { [1, 0] } else { [0, 1] }) else { continue };
                    let (i, j) = (domain.index(at), domain.index(next));
                    let w = 10.0 * weights[i];
                    // Around an axis of one sample it is tied to itself.
                    (matrix[i][i], matrix[j][j]) =
                        if i == j { (matrix[i][i], matrix[j][j]) } else { (matrix[i][i] + w, matrix[j][j] + w) };
                    if i != j {
                        matrix[i][j] -= w;
                        matrix[j][i] -= w;
                    }
                    b[i] -= 10.0 * differences[i];
                    b[j] += 10.0 * differences[i];
                }
            }
            // A wish, and a sample that is fixed: an equation of its own.
            system.wish(0, 3.0, 77.0);
            matrix[0][0] += 3.0;
            b[0] += 3.0 * 77.0;
            system.wish(n - 1, f64::INFINITY, 200.0);
            for i in 0..n {
                b[i] -= if i == n - 1 { 0.0 } else { matrix[i][n - 1] * 200.0 };
                (matrix[i][n - 1], matrix[n - 1][i]) = (0.0, 0.0);
            }
            (matrix[n - 1][n - 1], b[n - 1]) = (1.0, 200.0);
            let mut x = vec![128.0; n];
            system.solve(&mut x, 1e-10).unwrap();
            for (x, y) in x.iter().zip(solved(matrix, b)) {
                assert!((x - y).abs() < 1e-6, "{case}: {x}, and by factors {y}");
            }
        }
    }
}
