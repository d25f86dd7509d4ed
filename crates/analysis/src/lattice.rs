//! Two translations that a texture is made of.

use selvedge_fft_ssd::Error;

use crate::memory::collected;
use crate::periods::{Reach, Strengths};
use crate::picture::Picture;

/// From this share of a picture on an overlap counts in full; resemblance over less of it may be chance.
const FULL: u64 = 300;
/// Least likeness of a translation, in thousandths: what is as unlike as this is no repetition, as
/// [`feature_size_of`](crate::feature_size_of) has it.
const LIKE: i64 = 200;
/// A translation of so many thousandths of the strongest may be chosen for its shortness: twice a period is as like as
/// the period, up to noise. Chosen on the textures by which [kinds](crate::Kind) are told apart.
const SHORT: u64 = 750;

/// Two translations under which a texture comes again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// Down and across, in samples; the first component that is not 0 is positive. The shorter comes first.
    pub vectors: [[i32; 2]; 2],
    /// Along each axis (0 down, 1 across) the shortest way after which it comes again: so many samples, and how often
    /// it comes again on them, for that way need not be whole. Where none is shorter than eight of the longer vector,
    /// none.
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
        let along = [0, 1].map(|axis| along(vectors, axis).map(|n| (n, 1)));
        Ok(Some(Self { vectors, along, strength: second.score as u32 }))
    }

    /// The same by samples, after it was found by cells.
    pub(crate) fn refined<const D: usize>(self, strengths: &Strengths<D>, side: u32) -> Self {
        let at = |[y, x]: [i32; 2]| {
            let mut vector = [0; D];
            vector[D - 1] = x;
            if D < 2 {
                return (y == 0).then(|| strengths.at(vector)).flatten();
            }
            vector[D - 2] = y;
            strengths.at(vector)
        };
        let best = |vector: [i32; 2], off: [i32; 2]| {
            let near = (-off[0]..=off[0]).flat_map(|y| (-off[1]..=off[1]).map(move |x| [vector[0] + y, vector[1] + x]));
            near.filter_map(|v| Some((at(v)?, std::cmp::Reverse(length([v[0] - vector[0], v[1] - vector[1]])), v)))
                .max()
        };
        let near = if side == 1 { 0 } else { side as i32 };
        let vectors = self.vectors.map(|v| best(v, [near; 2]).map_or(v, |(_, _, v)| v));
        let often = |axis: usize| {
            let once = along(vectors, axis)?;
            // The farther, the more exact; each time may add half a sample.
            let far = (1..=8).rev().find_map(|times: u32| {
                let mut vector = [0; 2];
                vector[axis] = (once * times) as i32;
                let mut off = [2; 2];
                off[axis] = times as i32 / 2;
                best(vector, off).filter(|&(s, ..)| LIKE <= s).map(|(_, _, v)| (v[axis] as u32, times))
            });
            far.or(Some((once, 1)))
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
    pub(crate) fn reach(picture: &Picture) -> Reach<2> {
        Reach { most: picture.shape().map(|n| n * 4 / 5), one_in: 7 }
    }
}

/// The shortest way along an axis after which a lattice comes again, exactly or by less than a thirtieth of that way.
fn along([a, b]: [[i32; 2]; 2], axis: usize) -> Option<u32> {
    let steps = || -8..=8;
    let ways = steps().flat_map(|i| steps().map(move |j| [0, 1].map(|axis| i * a[axis] + j * b[axis])));
    let straight = |v: &[i32; 2]| 0 < v[axis] && v[1 - axis].abs() * 30 <= v[axis];
    ways.filter(straight).map(|v| v[axis] as u32).min()
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
        assert_eq!(along([[30, 1], [0, 77]], 0), Some(30));
        assert_eq!(along([[29, 1], [0, 77]], 0), None, "all multiples lean as much");
        assert_eq!(along([[29, 1], [0, 2]], 0), Some(58), "the second leads back");
        assert_eq!([0, 1].map(|axis| along([[12, 0], [0, 9]], axis)), [Some(12), Some(9)]);
    }
}
