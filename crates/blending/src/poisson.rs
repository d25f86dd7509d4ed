//! Values whose differences from neighbors are as asked for, by least squares, over a whole domain: exactly and at
//! once.

use selvedge_core::{Domain, Error, par, try_vec};

use crate::fourier::{Ends, Scratch, Waves};

/// Columns that one task solves: a line of memory's worth of them, some times over.
const COLUMNS: usize = 64;

/// Solves `sum over neighbors q of (w[p] - w[q]) = f[p]`, where each axis has free ends, goes around, or has a `w` of 0
/// beyond its ends. If none is tied, the mean is 0. (The mean of `f` has no solution then and is left out.)
///
/// All axes but the first become sums of waves; along the first, each of these is a chain of springs, which one sweep
/// down and one up solve: half of the transforms of a solution by waves alone, and nothing to be transposed.
pub(crate) struct Poisson<const D: usize> {
    pub(crate) domain: Domain<D>,
    pub(crate) ends: [Ends; D],
    /// By axis but the first.
    waves: Vec<Waves>,
    /// By wave, those of all axes but the first row-major: what its differences along them sum up to.
    stiffness: Vec<f64>,
}

impl<const D: usize> Poisson<D> {
    /// Axes that are `tied` are not periodic.
    pub(crate) fn new(domain: Domain<D>, tied: [bool; D]) -> Result<Self, Error> {
        let ends = std::array::from_fn(|a| match (tied[a], domain.periodic[a]) {
            (true, _) => Ends::Tied,
            (false, true) => Ends::Around,
            (false, false) => Ends::Free,
        });
        let waves: Vec<Waves> = (1..D).map(|a| Waves::new(domain.shape[a], ends[a])).collect();
        let mut stiffness = vec![0.0];
        for waves in &waves {
            let along = waves.eigenvalues();
            let mut wider = try_vec(0, 0.0)?;
            wider.extend(stiffness.iter().flat_map(|s| along.iter().map(move |a| s + a)));
            stiffness = wider;
        }
        Ok(Self { domain, ends, waves, stiffness })
    }

    /// From `f` to `w`.
    pub(crate) fn solve(&self, values: &mut [f64]) {
        let is_tied = self.ends.contains(&Ends::Tied);
        if !is_tied {
            less_mean(values);
        }
        for axis in (1..D).rev() {
            self.transform(values, axis, true);
        }
        self.sweep(values);
        for axis in 1..D {
            self.transform(values, axis, false);
        }
        if !is_tied {
            less_mean(values);
        }
    }

    /// All lines along an axis, two at a time.
    fn transform(&self, values: &mut [f64], axis: usize, forward: bool) {
        let waves = &self.waves[axis - 1];
        let side = self.domain.shape[axis] as usize;
        let stride = self.domain.strides()[axis];
        let both = |pair: [&mut [f64]; 2], scratch: &mut Scratch| {
            if forward { waves.forward(pair, scratch) } else { waves.backward(pair, scratch) }
        };
        if stride == 1 {
            par::for_rows(values, 2 * side, |_, rows| {
                let (a, b) = rows.split_at_mut(side);
                let mut none = vec![0.0; if b.is_empty() { side } else { 0 }];
                both([a, if b.is_empty() { &mut none } else { b }], &mut Scratch::default());
            });
            return;
        }
        par::for_rows(values, side * stride, |_, slab| {
            let (mut a, mut b, mut scratch) = (vec![0.0; side], vec![0.0; side], Scratch::default());
            for first in (0..stride).step_by(2) {
                let second = (first + 1).min(stride - 1);
                for i in 0..side {
                    (a[i], b[i]) = (slab[i * stride + first], slab[i * stride + second]);
                }
                both([&mut a, &mut b], &mut scratch);
                for i in 0..side {
                    (slab[i * stride + first], slab[i * stride + second]) = (a[i], b[i]);
                }
            }
        });
    }

    /// Along the first axis, for each wave of the others.
    fn sweep(&self, values: &mut [f64]) {
        let (columns, lines) = (self.stiffness.len(), self.domain.shape[0] as usize);
        let blocks: Vec<Vec<f64>> = {
            let values = &*values;
            par::map_indexed(columns.div_ceil(COLUMNS), |block| {
                let range = block * COLUMNS..((block + 1) * COLUMNS).min(columns);
                let stiffness = &self.stiffness[range.clone()];
                let mut part: Vec<f64> = Vec::with_capacity(lines * range.len());
                (0..lines).for_each(|y| part.extend(&values[y * columns..][range.clone()]));
                match self.ends[0] {
                    Ends::Around => around(&mut part, stiffness),
                    Ends::Free => chain(&mut part, stiffness, 1.0),
                    Ends::Tied => chain(&mut part, stiffness, 0.0),
                }
                part
            })
        };
        for (block, part) in blocks.iter().enumerate() {
            let width = part.len() / lines;
            for (y, part) in part.chunks_exact(width).enumerate() {
                values[y * columns + block * COLUMNS..][..width].copy_from_slice(part);
            }
        }
    }
}

/// Takes the mean off.
fn less_mean(values: &mut [f64]) {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter_mut().for_each(|v| *v -= mean);
}

/// Chains of springs side by side, `f` to `w`: `(2 + s) w[i] - w[i - 1] - w[i + 1] = f[i]`, with `free` less in the
/// middle term at both ends: 1 for ends that are free, 0 for ends that are tied to a 0 beyond them.
fn chain(values: &mut [f64], stiffness: &[f64], free: f64) {
    let (width, lines) = (stiffness.len(), values.len() / stiffness.len());
    // What is left of the upper neighbor's share after the sweep down.
    let mut shares = vec![0.0; values.len()];
    for i in 0..lines {
        let ends = f64::from(u8::from(i == 0) + u8::from(i + 1 == lines)) * free;
        let (above, here) = values.split_at_mut(i * width);
        let (shares_above, shares_here) = shares.split_at_mut(i * width);
        for k in 0..width {
            let (above, share) =
                if i == 0 { (0.0, 0.0) } else { (above[(i - 1) * width + k], shares_above[(i - 1) * width + k]) };
            // A chain that nothing holds is held at its beginning: any height would do, and the mean is taken off
            // later.
            let held = if i == 0 && stiffness[k] == 0.0 && free == 1.0 { 1.0 } else { 0.0 };
            let scale = 1.0 / (2.0 + stiffness[k] - ends + held - share);
            shares_here[k] = scale;
            here[k] = (here[k] + above) * scale;
        }
    }
    for i in (0..lines.saturating_sub(1)).rev() {
        let (above, below) = values.split_at_mut((i + 1) * width);
        let (above, shares) = (&mut above[i * width..], &shares[i * width..][..width]);
        above.iter_mut().zip(below).zip(shares).for_each(|((above, below), share)| *above += *below * share);
    }
}

/// The same around a periodic axis: the last line is found first, then the others hang between it and itself.
fn around(values: &mut [f64], stiffness: &[f64]) {
    let width = stiffness.len();
    let m = values.len() / width - 1;
    let (others, last) = values.split_at_mut(m * width);
    if m == 0 {
        last.iter_mut().zip(stiffness).for_each(|(v, s)| *v = if *s == 0.0 { 0.0 } else { *v / s });
        return;
    }
    let mut hung = others.to_vec();
    chain(&mut hung, stiffness, 0.0);
    for (k, last) in last.iter_mut().enumerate() {
        let s = stiffness[k];
        // Chains of m springs tied to 1 at both ends end at (r + r^m) / (1 + r^(m + 1)), 2 + s = r + 1 / r.
        let r = (2.0 + s - (s * (4.0 + s)).sqrt()) / 2.0;
        let end = (r + libm::pow(r, m as f64)) / (1.0 + libm::pow(r, m as f64 + 1.0));
        let pulled = *last + hung[k] + hung[(m - 1) * width + k];
        *last = if s == 0.0 { 0.0 } else { pulled / (2.0 + s - 2.0 * end) };
    }
    for (k, last) in last.iter().enumerate() {
        others[k] += last;
        others[(m - 1) * width + k] += last;
    }
    chain(others, stiffness, 0.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Seed;

    /// What the differences from neighbors sum up to.
    fn summed<const D: usize>(domain: Domain<D>, tied: [bool; D], w: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; w.len()];
        for at in domain.positions() {
            for axis in 0..D {
                let ends = u8::from(at[axis] == 0) + u8::from(at[axis] + 1 == domain.shape[axis]);
                if tied[axis] {
                    sums[domain.index(at)] += f64::from(ends) * w[domain.index(at)];
                }
                let Some(next) = domain.next(at, axis) else { continue };
                let (p, q) = (domain.index(at), domain.index(next));
                sums[p] += w[p] - w[q];
                sums[q] += w[q] - w[p];
            }
        }
        sums
    }

    fn check<const D: usize>(shape: [u32; D], periodic: [bool; D], tied: [bool; D]) {
        let domain = Domain { shape, periodic: std::array::from_fn(|a| periodic[a] && !tied[a]) };
        let mut rng = Seed(domain.len() as u64).rng();
        let mut w: Vec<f64> = (0..domain.len()).map(|_| f64::from(rng.below(1000))).collect();
        let mut solved = summed(domain, tied, &w);
        if !tied.contains(&true) {
            // A mean that no differences have is left out.
            solved.iter_mut().for_each(|v| *v += 3.0);
            less_mean(&mut w);
        }
        Poisson::new(domain, tied).unwrap().solve(&mut solved);
        let off = w.iter().zip(&solved).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{domain:?}: {off}");
    }

    #[test]
    fn differences_give_back_what_they_were_taken_of() {
        let mut rng = Seed(3).rng();
        for round in 0..200 {
            let periodic = [round & 1 == 0, round & 2 == 0, round & 4 == 0];
            let tied = [0, 1, 2].map(|_| rng.below(3) == 0);
            let mut side = || 1 + rng.below(9);
            check([side()], [periodic[0]], [tied[0]]);
            check([side(), side()], [periodic[0], periodic[1]], [tied[0], tied[1]]);
            check([side(), side(), side()], periodic, tied);
        }
        check([130, 67], [false, true], [false; 2]);
        check([200, 301], [true, false], [false; 2]);
        check([130, 166], [false; 2], [true; 2]);
    }
}
