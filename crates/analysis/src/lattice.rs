//! Two translations that a texture is made of.

use selvedge_core::{Domain, collected, par};
use selvedge_fft_ssd::Error;

use crate::near::Near;
use crate::periods::Strengths;
use crate::picture::Picture;
use crate::reach::Reach;

/// From this share of a picture on an overlap counts in full; resemblance over less of it may be chance.
const FULL: u64 = 300;
/// Least likeness of a translation, in thousandths: what is as unlike as this is no repetition, as
/// [`feature_size_of`](crate::feature_size_of) has it.
const LIKE: i64 = 200;
/// A translation of so many thousandths of the strongest may be chosen for its shortness: twice a period is as like as
/// the period, up to noise. Chosen on the textures by which [kinds](crate::Kind) are told apart.
const SHORT: u64 = 750;
/// How far a straight way may be from an axis: one sample in so many of its length.
const STRAIGHT: u32 = 30;
/// By how many thousandths likeness rises again on a straight way: lines along it are alike at any length.
const RISE: i64 = 250;
/// What is longer than half of the picture, and so is seen once and by little of it, is at least so alike: cobbles in
/// no order have a peak of 390 there.
const FAR: i64 = 600;
/// A straight way is one and not half of one if twice as far is hardly more alike: at least so many thousandths of
/// that. The courses of a running bond are alike at each, and more so at each second.
const HALF: i64 = 900;

/// Two translations under which a texture comes again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// Down and across, in samples; the first component that is not 0 is positive. The shorter comes first.
    pub vectors: [[i32; 2]; 2],
    /// Along each axis (0 down, 1 across) the shortest way after which it comes again: so many samples, and how often
    /// it comes again on them, for that way need not be whole. Where that is not seen within four fifths of the
    /// picture, nor one of more than half of it is a vector, or the sum or difference of both, none.
    pub along: [Option<(u32, u32)>; 2],
    /// How clearly it comes again, in thousandths, up to 2000: by how much the likeness under the weaker translation
    /// rises above the least on the straight way there. Unrelated textures stay below 350.
    pub strength: u32,
}

/// A translation in cells, and how clear it is.
#[derive(Clone, Copy)]
struct Peak {
    vector: [i32; 2],
    score: u64,
}

impl Lattice {
    /// Of a picture without its shade: also where it holds little more than one period, for translations of up to four
    /// fifths of its sides are looked at, as long as a seventh of it overlaps.
    pub(crate) fn of(strengths: &Strengths<2>, picture: &Picture) -> Result<Option<Self>, Error> {
        let shape = picture.shape();
        let peaks = strengths.costs.iter().filter_map(|c| peak(strengths, shape, c.position));
        let mut peaks = collected(peaks)?;
        peaks.sort_unstable_by_key(|p| (std::cmp::Reverse(p.score), length(p.vector), p.vector));
        let Some((first, second)) = pair(&peaks) else { return Ok(None) };
        let enough = second.score.min(first.score) * SHORT / 1000;
        peaks.retain(|p| enough <= p.score);
        peaks.sort_unstable_by_key(|p| (length(p.vector), p.vector));
        let Some((a, b)) = pair(&peaks) else { return Ok(None) };
        let scaled = |p: Peak| p.vector.map(|v| v * picture.side as i32);
        let vectors = [scaled(a), scaled(b)];
        let mut along = [None; 2];
        for (axis, to) in along.iter_mut().enumerate() {
            let way = Straight::of(strengths, axis, shape[axis] * 4 / 5)?.way(shape[axis]);
            // What is seen twice has a peak; of what is longer too little overlaps.
            let longer = || combined([a.vector, b.vector], axis).filter(|(cells, _)| shape[axis] < 2 * cells);
            *to = way.or_else(longer).map(|(cells, times)| (cells * picture.side, times));
        }
        Ok(Some(Self { vectors, along, strength: second.score as u32 }))
    }

    /// The same by samples, after it was found by cells.
    pub(crate) fn refined<const D: usize>(self, texture: &Near<'_, D>, side: u32) -> Self {
        let best = |vector: [i32; 2], off: [i32; 2]| {
            let [down, across] = off.map(|n| 2 * n as usize + 1);
            let place = |i: usize| [vector[0] - off[0] + (i / across) as i32, vector[1] - off[1] + (i % across) as i32];
            let found = par::map_indexed(down * across, |i| texture.at(place(i)));
            let far = |v: [i32; 2]| std::cmp::Reverse(length([v[0] - vector[0], v[1] - vector[1]]));
            found.into_iter().enumerate().filter_map(|(i, at)| Some((at?, far(place(i)), place(i)))).max()
        };
        let vectors = self.vectors.map(|v| best(v, [side as i32; 2]).map_or(v, |(_, _, v)| v));
        let often = |axis: usize| {
            let (samples, times) = self.along[axis]?;
            // The farther, the more exact.
            let far = (1..=times).rev().find_map(|n| {
                let (mut vector, mut off) = ([0; 2], [0; 2]);
                vector[axis] = (samples * n / times) as i32;
                off[axis] = side as i32;
                off[1 - axis] = vector[axis] / STRAIGHT as i32;
                best(vector, off).filter(|&(s, ..)| LIKE <= s).map(|(_, _, v)| (v[axis] as u32, n))
            });
            far.or(self.along[axis])
        };
        Self { vectors, along: [0, 1].map(often), ..self }
    }

    /// The length along an axis next to `length` after which the lattice closes; itself where it never does.
    pub fn closing(&self, axis: usize, length: u32) -> u32 {
        let Some((samples, times)) = self.along[axis] else { return length };
        let (samples, times) = (u64::from(samples), u64::from(times));
        let often = ((2 * u64::from(length) * times + samples) / (2 * samples)).max(1);
        ((2 * often * samples + times) / (2 * times)) as u32
    }

    /// The same, but no longer than `length` where the lattice goes into it at all.
    pub fn closing_within(&self, axis: usize, length: u32) -> u32 {
        let Some((samples, times)) = self.along[axis] else { return length };
        let next = self.closing(axis, length);
        if next <= length {
            return next;
        }
        let shorter = self.closing(axis, next - samples / times);
        if shorter <= length { shorter } else { length }
    }

    /// How far translations reach that [`of`](Self::of) looks at.
    pub(crate) fn reach(cells: Domain<2>) -> Reach<2> {
        Reach { most: cells.shape.map(|n| n * 4 / 5), one_in: 7 }
    }
}

/// The shortest way along an axis that is a vector, or two: more of them add up what each is off by.
fn combined([a, b]: [[i32; 2]; 2], axis: usize) -> Option<(u32, u32)> {
    let ways = [a, b, [a[0] + b[0], a[1] + b[1]], [a[0] - b[0], a[1] - b[1]]];
    let ways = ways.into_iter().map(|v| if v[axis] < 0 { v.map(|n| -n) } else { v });
    let straight = |v: &[i32; 2]| 0 < v[axis] && v[1 - axis].abs() * STRAIGHT as i32 <= v[axis];
    ways.filter(straight).map(|v| (v[axis] as u32, 1)).min()
}

/// How alike a texture is to itself along an axis, by length: the best of what is straight enough.
struct Straight(Vec<i64>);

impl Straight {
    fn of(strengths: &Strengths<2>, axis: usize, most: u32) -> Result<Self, Error> {
        let best = |length: u32| {
            let aside = (length / STRAIGHT).max(1) as i32;
            let at = |by: i32| {
                let mut vector = [by; 2];
                vector[axis] = length as i32;
                strengths.at(vector)
            };
            (-aside..=aside).filter_map(at).max().unwrap_or(0)
        };
        Ok(Self(collected((0..=most).map(best))?))
    }

    fn at(&self, length: u32) -> i64 {
        self.0.get(length as usize).copied().unwrap_or(0)
    }

    /// The likest length within one of `length`, if it is alike at all and likelier than those beside it.
    fn near(&self, length: u32) -> Option<u32> {
        let best = (length.saturating_sub(1)..=length + 1).max_by_key(|&n| (self.at(n), std::cmp::Reverse(n)))?;
        let is_inside = (best as usize) + 1 < self.0.len();
        (is_inside && LIKE <= self.at(best) && self.at(best - 1) < self.at(best) && self.at(best + 1) <= self.at(best))
            .then_some(best)
    }

    /// The shortest length after which it comes again, and how often it does on the farthest multiple that is seen.
    fn way(&self, side: u32) -> Option<(u32, u32)> {
        let lengths = 4..self.0.len() as u32;
        let rises = |&n: &u32| {
            let by = self.at(n) - self.0[..n as usize].iter().min().copied().unwrap_or(0);
            RISE <= by && (2 * n <= side || FAR <= self.at(n))
        };
        let peaks = || lengths.clone().filter(|&n| self.near(n) == Some(n)).filter(rises);
        let most = peaks().map(|n| self.at(n)).max()?;
        let is_whole = |&n: &u32| {
            let twice = (2 * n - 1..=2 * n + 1).map(|n| self.at(n)).max().unwrap_or(0);
            most * SHORT as i64 <= self.at(n) * 1000 && twice * HALF <= self.at(n) * 1000
        };
        let once = peaks().find(is_whole)?;
        let mut far = (once, 1);
        for times in 2..=lengths.end / once {
            let (samples, so_far) = far;
            far = self.near((2 * samples * times + so_far) / (2 * so_far)).map_or(far, |n| (n, times));
        }
        Some(far)
    }
}

/// The first peak, and the first that goes another way.
fn pair(peaks: &[Peak]) -> Option<(Peak, Peak)> {
    let &first = peaks.first()?;
    let another = |p: &&Peak| {
        let ([ay, ax], [by, bx]) = (first.vector.map(i64::from), p.vector.map(i64::from));
        // The sine of the angle between them is over a quarter.
        length(first.vector) * length(p.vector) < 16 * (ax * by - ay * bx).pow(2)
    };
    Some((first, *peaks.iter().find(another)?))
}

/// The squared length.
fn length(vector: [i32; 2]) -> i64 {
    vector.iter().map(|&v| i64::from(v).pow(2)).sum()
}

/// What speaks for a translation, if it is likelier than all around it.
fn peak(strengths: &Strengths<2>, shape: [u32; 2], vector: [i32; 2]) -> Option<Peak> {
    let here = strengths.at(vector).filter(|&s| LIKE <= s)?;
    let steps = vector.iter().map(|v| v.abs()).max().filter(|&n| 4 <= n)?;
    strengths.peak(vector)?;
    let on_the_way = |s: i32| vector.map(|v| (v * s + steps / 2 * v.signum()) / steps);
    let lowest = (1..=steps).filter_map(|s| strengths.at(on_the_way(s))).min()?;
    let left = |a: usize| u64::from(shape[a] - vector[a].unsigned_abs()) * 1000 / u64::from(shape[a]);
    let overlap = left(0) * left(1) / 1000;
    Some(Peak { vector, score: (here - lowest) as u64 * overlap.min(FULL) / FULL })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_along_an_axis_is_straight_to_a_thirtieth() {
        assert_eq!(combined([[30, 1], [0, 77]], 0), Some((30, 1)));
        assert_eq!(combined([[29, 1], [0, 77]], 0), None, "it leans");
        assert_eq!([0, 1].map(|axis| combined([[12, 0], [0, 9]], axis)), [Some((12, 1)), Some((9, 1))]);
        let rows = [[50, -35], [50, 35]];
        assert_eq!([0, 1].map(|axis| combined(rows, axis)), [Some((100, 1)), Some((70, 1))]);
    }
}
