//! Sums over neighborhoods of every sample of a window, whatever their size. `[CMS IV-B2]`

use selvedge_core::{Window, try_vec};

use crate::error::Error;

/// A neighborhood: so many taps along each axis, from `first` on, `ratio` samples apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Taps {
    pub(crate) first: [i32; 2],
    pub(crate) count: [u32; 2],
    pub(crate) ratio: u32,
}

impl Taps {
    /// `(2 half + 1)^2` taps around a sample.
    pub(crate) fn around(half: u32, ratio: u32) -> Self {
        Self { first: [-((half * ratio) as i32); 2], count: [2 * half + 1; 2], ratio }
    }

    /// How far the taps around a sample reach.
    pub(crate) fn reach(self) -> u32 {
        self.first[0].unsigned_abs()
    }

    /// All positions at which a window's samples have taps, and between them.
    pub(crate) fn reached(self, window: &Window<2>) -> Window<2> {
        let start = [0, 1].map(|a| window.start[a] + self.first[a]);
        Window { start, shape: [0, 1].map(|a| window.shape[a] + (self.count[a].max(1) - 1) * self.ratio) }
    }
}

/// Working memory of sums.
#[derive(Debug, Default)]
pub(crate) struct Boxes {
    values: Vec<u64>,
    columns: Vec<u64>,
    sums: Vec<u64>,
}

impl Boxes {
    /// The sum over each sample's taps, row-major over the window; `fill` writes the values of all positions that taps
    /// [reach](Taps::reached), which are 0 before. `O(window)` additions a call, whatever the taps.
    pub(crate) fn of(
        &mut self,
        window: &Window<2>,
        taps: Taps,
        fill: impl FnOnce(&Window<2>, &mut [u64]),
    ) -> Result<&[u64], Error> {
        let reached = taps.reached(window);
        sized(&mut self.values, reached.len())?;
        sized(&mut self.columns, window.shape[0] as usize * reached.shape[1] as usize)?;
        sized(&mut self.sums, window.len())?;
        if taps.count.contains(&0) || window.is_empty() {
            return Ok(&self.sums);
        }
        fill(&reached, &mut self.values);
        let (ratio, [ny, nx]) = (taps.ratio as usize, taps.count.map(|n| n as usize));
        let wide = reached.shape[1] as usize;
        for y in 0..window.shape[0] as usize {
            let (done, rest) = self.columns.split_at_mut(y * wide);
            let row = &mut rest[..wide];
            let value = |y: usize| &self.values[y * wide..(y + 1) * wide];
            if y < ratio {
                (0..ny).for_each(|k| row.iter_mut().zip(value(y + k * ratio)).for_each(|(to, v)| *to += v));
            } else {
                let before = &done[(y - ratio) * wide..(y - ratio + 1) * wide];
                let (leaves, enters) = (value(y - ratio), value(y + (ny - 1) * ratio));
                for (((to, b), l), e) in row.iter_mut().zip(before).zip(leaves).zip(enters) {
                    *to = b + e - l;
                }
            }
        }
        let narrow = window.shape[1] as usize;
        for (to, from) in self.sums.chunks_mut(narrow).zip(self.columns.chunks(wide)) {
            for x in 0..narrow.min(ratio) {
                to[x] = (0..nx).map(|k| from[x + k * ratio]).sum();
            }
            for x in ratio..narrow {
                to[x] = to[x - ratio] + from[x + (nx - 1) * ratio] - from[x - ratio];
            }
        }
        Ok(&self.sums)
    }
}

/// So many zeros, in memory that is used again.
fn sized(to: &mut Vec<u64>, len: usize) -> Result<(), Error> {
    if to.capacity() < len {
        *to = Vec::new();
        *to = try_vec(len, 0)?;
    } else {
        to.clear();
        to.resize(len, 0);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Seed;

    #[test]
    fn sums_are_those_of_the_definition() {
        let mut boxes = Boxes::default();
        for case in 0..200 {
            let mut rng = Seed(case).rng();
            let window = Window { start: [-2, 5], shape: [1 + rng.below(9), 1 + rng.below(9)] };
            let mut taps = Taps::around(rng.below(3), 1 + rng.below(4));
            taps.count[case as usize % 2] -= u32::from(1 < taps.count[0]);
            let value = |y: i32, x: i32| (31 * y + 7 * x + y * x).rem_euclid(101) as u64;
            let fill = |reached: &Window<2>, values: &mut [u64]| {
                for (v, at) in values.iter_mut().zip(reached.local().positions()) {
                    *v = value(reached.start[0] + at[0] as i32, reached.start[1] + at[1] as i32);
                }
            };
            let sums = boxes.of(&window, taps, fill).unwrap();
            for (sum, at) in sums.iter().zip(window.local().positions()) {
                let tap = |a: usize, k: u32| window.start[a] + at[a] as i32 + taps.first[a] + (k * taps.ratio) as i32;
                let all = (0..taps.count[0]).flat_map(|i| (0..taps.count[1]).map(move |j| (i, j)));
                assert_eq!(*sum, all.map(|(i, j)| value(tap(0, i), tap(1, j))).sum::<u64>(), "{window:?} {taps:?}");
            }
        }
    }
}
