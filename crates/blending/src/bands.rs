//! A patch taken apart into bands of detail, as far as they are mixed in.

use selvedge_core::Window;

use crate::region::{grown, rows};

/// Samples on each side of a position that its low pass after so many levels depends on.
pub(crate) fn reach(levels: u32) -> u32 {
    2 * ((1 << levels) - 1)
}

/// A patch over a region, coarser from level to level.
pub(crate) struct Bands {
    /// Its samples, a list a channel.
    pub(crate) values: Vec<Vec<f64>>,
    /// Where it shows.
    pub(crate) mask: Vec<f64>,
    coarse: Vec<f64>,
    half_done: Vec<f64>,
}

impl Bands {
    pub(crate) fn new(channels: usize) -> Self {
        Self { values: vec![Vec::new(); channels], mask: Vec::new(), coarse: Vec::new(), half_done: Vec::new() }
    }

    /// Adds the bands to `sums` over a window, in the target that the window and the region share, each weighed by the
    /// mask as coarse as the band. The region is the target and what that depends on.
    pub(crate) fn add<const D: usize>(
        &mut self,
        [region, target, window]: [&Window<D>; 3],
        levels: u32,
        sums: &mut [Vec<f64>],
    ) {
        let Self { values, mask, coarse, half_done } = self;
        let both = || rows(region, target).zip(rows(window, target));
        // What the last low pass depends on after some levels: what lies around is not made.
        let needed = |level: u32| grown(target, reach(levels) - reach(level), region).unwrap_or(*target);
        for level in 0..levels {
            let mut blur = |fine: &[f64], coarse: &mut Vec<f64>| {
                blur(fine, (coarse, half_done), region, [&needed(level), &needed(level + 1)], 1 << level);
            };
            for (fine, sum) in values.iter_mut().zip(sums.iter_mut()) {
                blur(fine, coarse);
                for (from, to) in both() {
                    let (mask, fine, coarse) = (&mask[from.clone()], &fine[from.clone()], &coarse[from]);
                    let band = mask.iter().zip(fine).zip(coarse).map(|((mask, fine), coarse)| mask * (fine - coarse));
                    sum[to].iter_mut().zip(band).for_each(|(sum, v)| *sum += v);
                }
                std::mem::swap(fine, coarse);
            }
            blur(mask, coarse);
            std::mem::swap(mask, coarse);
        }
        for (fine, sum) in values.iter().zip(sums.iter_mut()) {
            for (from, to) in both() {
                let last = mask[from.clone()].iter().zip(&fine[from]).map(|(mask, fine)| mask * fine);
                sum[to].iter_mut().zip(last).for_each(|(sum, v)| *sum += v);
            }
        }
    }
}

/// Burt and Adelson's kernel, 1 4 6 4 1 sixteenths, with gaps, along each axis; the last sample goes on beyond the
/// region. Values are known in the first window and made in the second.
fn blur<const D: usize>(
    fine: &[f64],
    (coarse, half_done): (&mut Vec<f64>, &mut Vec<f64>),
    region: &Window<D>,
    [known, wanted]: [&Window<D>; 2],
    gap: usize,
) {
    let mut now = *known;
    for axis in 0..D {
        let first = rows(region, &now).next().map_or(0, |row| row.start);
        half_done.resize(fine.len(), 0.0);
        let from: &[f64] = if axis == 0 { fine } else { coarse };
        let side = now.shape[axis] as usize;
        let stride: usize = region.shape[axis + 1..].iter().map(|&n| n as usize).product();
        let line_of = |place: usize| place / stride % region.shape[axis] as usize;
        (now.start[axis], now.shape[axis]) = (wanted.start[axis], wanted.shape[axis]);
        let skipped = (wanted.start[axis] - known.start[axis]) as usize;
        for to in rows(region, &now) {
            if axis == D - 1 {
                let known = to.start - skipped..to.start - skipped + side;
                blur_line(&mut half_done[to], skipped, &from[known], gap);
            } else {
                // Which of the known lines it is, and where the first of them would be.
                let line = line_of(to.start) - line_of(first);
                let begin = to.start - line * stride;
                let at = |line: usize| &from[begin + line.min(side - 1) * stride..][..to.len()];
                let back = |by: usize| at(line.saturating_sub(by));
                let lines = [back(2 * gap), back(gap), at(line), at(line + gap), at(line + 2 * gap)];
                blur_across(&mut half_done[to.clone()], lines);
            }
        }
        std::mem::swap(coarse, half_done);
    }
}

fn kernel([a, b, c, d, e]: [f64; 5]) -> f64 {
    (6.0 * c + 4.0 * (b + d) + (a + e)) / 16.0
}

/// Along one line, of which `to` begins after some of the samples in `from`.
fn blur_line(to: &mut [f64], skipped: usize, from: &[f64], gap: usize) {
    let last = from.len() - 1;
    let at = |p: usize, back: usize, ahead: usize| from[(p + ahead).saturating_sub(back).min(last)];
    let border = |p| kernel([at(p, 2 * gap, 0), at(p, gap, 0), from[p], at(p, 0, gap), at(p, 0, 2 * gap)]);
    // Samples of `to` with all their taps inside.
    let begin = (2 * gap).saturating_sub(skipped).min(to.len());
    let end = from.len().saturating_sub(2 * gap + skipped).min(to.len()).max(begin);
    for p in (0..begin).chain(end..to.len()) {
        to[p] = border(p + skipped);
    }
    let n = end - begin;
    if n == 0 {
        return;
    }
    let taps = [0, 1, 2, 3, 4].map(|i| &from[begin + skipped + i * gap - 2 * gap..][..n]);
    blur_across(&mut to[begin..end], taps);
}

/// Across five lines.
fn blur_across(to: &mut [f64], lines: [&[f64]; 5]) {
    let [a, b, c, d, e] = lines.map(|line| &line[..to.len()]);
    for (i, to) in to.iter_mut().enumerate() {
        *to = kernel([a[i], b[i], c[i], d[i], e[i]]);
    }
}
