//! How often each part of the exemplars shows, and what that costs: an output spreads over all of them.
//!
//! Of samples that agree alike, those without seams are the flat ones: of a wall the middle of a brick, again and
//! again, and never a joint. So an energy of uses is added, `sum over parts of S n^2 / 2 m` for a part that shows in
//! `n` samples and would show in `m` if all showed alike. A sample then costs `S n / m` at the margin, which an
//! expansion is priced with; what it would change is counted before it is accepted, so that the sum of all three
//! energies never rises.

use std::collections::BTreeMap;

use selvedge_core::{Bytes, Domain, Exemplars, SampleId, reserve, try_vec};
use selvedge_expansion::Frame;

use crate::constraint::{self, FRACTION, LEVEL, unit};
use crate::error::Error;

/// Side of a part in samples of its exemplar. Smaller ones let a patch beside one that is used often count as rare;
/// larger ones do not tell a joint from the brick beside it.
const SIDE: u32 = 8;
/// What no valid sample has.
const NONE: u32 = u32::MAX;

/// Uses by part. Without weight nothing is counted, and nothing costs anything.
#[derive(Debug, Default)]
pub(crate) struct Uses {
    /// By sample number, its part; all orientations of an exemplar share theirs.
    parts: Vec<u32>,
    /// By part, what a sample costs for each that shows, in units of `2^-20`.
    factors: Vec<u64>,
    counts: Vec<u32>,
    /// Of the parts that an offer would change, by how much: scratch.
    changes: Vec<i64>,
    touched: Vec<u32>,
}

impl Uses {
    /// Of an output of so many samples that shows nothing yet. `spread` is in the unit of the paper's energy.
    pub(crate) fn new(exemplars: &Exemplars<2>, output: usize, spread: f64) -> Result<Self, Error> {
        if spread == 0.0 {
            return Ok(Self::default());
        }
        let mut parts = try_vec(exemplars.table().len() as usize, NONE)?;
        let mut numbers: BTreeMap<(u16, [u32; 2]), u32> = BTreeMap::new();
        let mut sizes: Vec<u32> = Vec::new();
        let mut whole = BTreeMap::new();
        for (number, source) in exemplars.sources().iter().enumerate() {
            let (domain, origin) = (source.domain(), source.origin);
            *whole.entry(origin.exemplar).or_insert(0_u32) += 1;
            let first = exemplars.table().first(number) as usize;
            let mut last = None;
            for (i, at) in domain.positions().enumerate() {
                if source.valid.as_deref().is_some_and(|valid| !valid.samples()[i]) {
                    continue;
                }
                let part = (origin.exemplar, origin.transform.origin(domain, at).map(|p| p / SIDE));
                let known = last.filter(|&(same, _)| same == part).map(|(_, number)| number);
                let number = match known {
                    Some(number) => number,
                    None => {
                        let next = sizes.len() as u32;
                        let number = *numbers.entry(part).or_insert(next);
                        if number == next {
                            reserve(&mut sizes, 1)?;
                            sizes.push(0);
                        }
                        number
                    }
                };
                last = Some((part, number));
                parts[first + i] = number;
                sizes[number as usize] += 1;
            }
        }
        let all: f64 = sizes.iter().map(|&n| f64::from(n)).sum();
        let orientations: Vec<f64> = {
            let mut of = try_vec(sizes.len(), 1.0)?;
            numbers.iter().for_each(|((exemplar, _), &number)| of[number as usize] = f64::from(whole[exemplar]));
            of
        };
        let price = spread * unit(exemplars) * 255.0 * LEVEL * f64::from(1_u32 << FRACTION);
        let mut factors = try_vec(sizes.len(), 0)?;
        for ((factor, &size), orientations) in factors.iter_mut().zip(&sizes).zip(orientations) {
            // To show a part once is never too often.
            let mean = (f64::from(size) / all * output as f64).max(f64::from(size) / orientations).max(1.0);
            *factor = (price / mean).round() as u64;
        }
        let (counts, changes) = (try_vec(sizes.len(), 0)?, try_vec(sizes.len(), 0)?);
        Ok(Self { parts, factors, counts, changes, touched: Vec::new() })
    }

    /// True where nothing is counted.
    pub(crate) fn is_off(&self) -> bool {
        self.parts.is_empty()
    }

    fn part(&self, id: SampleId) -> Option<usize> {
        self.parts.get(id.get() as usize).filter(|&&part| part != NONE).map(|&part| part as usize)
    }

    /// What a sample costs as often as its part shows; 0 for none.
    #[inline]
    pub(crate) fn price(&self, id: SampleId) -> i32 {
        constraint::price(self.scaled_of(id.get() as usize))
    }

    /// The same of the sample of a number, in units of `2^-20`.
    #[inline]
    pub(crate) fn scaled_of(&self, number: usize) -> u64 {
        self.part(SampleId::new(number as u32)).map_or(0, |part| self.scaled(part))
    }

    #[inline]
    fn scaled(&self, part: usize) -> u64 {
        self.factors[part].saturating_mul(u64::from(self.counts[part]))
    }

    /// One sample shows instead of another one.
    pub(crate) fn replace(&mut self, old: SampleId, new: SampleId) {
        if let Some(part) = self.part(old) {
            self.counts[part] -= 1;
        }
        if let Some(part) = self.part(new) {
            self.counts[part] += 1;
        }
    }

    /// How much the energy of uses would grow if a frame took these samples.
    pub(crate) fn growth(&mut self, frame: &Frame<2>, taken: &[bool]) -> Result<i64, Error> {
        if self.is_off() {
            return Ok(0);
        }
        self.touched.clear();
        for i in (0..taken.len()).filter(|&i| taken[i]) {
            for (id, by) in [(frame.old[i], -1), (frame.new[i], 1)] {
                let Some(part) = self.part(id) else { continue };
                if self.changes[part] == 0 {
                    reserve(&mut self.touched, 1)?;
                    self.touched.push(part as u32);
                }
                self.changes[part] += by;
            }
        }
        let mut growth = 0_i128;
        for &part in &self.touched {
            // A part that was changed there and back stands here twice, the second time without a change.
            let change = i128::from(std::mem::take(&mut self.changes[part as usize]));
            let (n, factor) = (i128::from(self.counts[part as usize]), i128::from(self.factors[part as usize]));
            growth += factor * ((n + change) * (n + change) - n * n);
        }
        Ok(saturated(growth))
    }

    /// The energy of all uses.
    pub(crate) fn energy(&self) -> i64 {
        let squares = self.counts.iter().zip(&self.factors).map(|(&n, &f)| i128::from(f) * i128::from(n).pow(2));
        saturated(squares.sum())
    }
}

/// An energy from twice its units of `2^-20`, rounded up.
fn saturated(twice: i128) -> i64 {
    let whole = (twice + (1 << (FRACTION + 1)) - 1) >> (FRACTION + 1);
    whole.clamp(i64::MIN.into(), i64::MAX.into()) as i64
}

/// What the counts take for sources of these domains.
pub(crate) fn bytes(sources: &[Domain<2>]) -> Bytes {
    let samples: Bytes = sources.iter().map(|d| Bytes::of_samples(*d, 4)).sum();
    // Its number in the tree with its node, its size and orientations, factor, count, change, and what an offer
    // touches.
    let each = 40 + 12 + 8 + 4 + 8 + 8;
    let parts = |d: &Domain<2>| Bytes::of_box(d.shape.map(|side| side.div_ceil(SIDE).into()), each);
    samples + sources.iter().map(parts).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Encoder, Exemplar, Grid, Plane, Role, Samples, Seed, SourceMap, Transform, Window};

    fn exemplars() -> Exemplars<2> {
        let grid = Grid::try_filled(Domain::open([20, 33]), 1, 7).unwrap();
        let plane = [Plane::new(Role::Scalar, Samples::U8(grid))];
        let turns = [0.0, 90.0, 180.0, 270.0].map(|turn| Transform::new(turn, 1.0, false));
        let exemplar = Exemplar::new(&plane).shown(&turns);
        Exemplars::new(&Encoder::fit(&[&plane]).unwrap(), &[exemplar]).unwrap()
    }

    #[test]
    fn parts_are_those_of_the_exemplar_whatever_way_it_is_turned() {
        let exemplars = exemplars();
        let uses = Uses::new(&exemplars, 5000, 1.0).unwrap();
        let mut of = BTreeMap::new();
        for number in 0..exemplars.table().len() {
            let (source, at) = exemplars.locate(SampleId::new(number)).unwrap();
            let source = &exemplars.sources()[source];
            let from = source.origin.transform.origin(source.domain(), at).map(|p| p / SIDE);
            assert_eq!(*of.entry(from).or_insert(uses.parts[number as usize]), uses.parts[number as usize]);
        }
        assert_eq!((of.len(), uses.factors.len()), (3 * 5, 3 * 5));
        // Of a part that shows as often as all do a sample costs the weight of the term.
        let mut even = uses;
        even.counts[0] = (256.0 * 5000.0 / 2640.0_f64).round() as u32;
        assert!((even.price(SampleId::new(0)) - (255.0 * 16.0 / 3.0_f64.sqrt()) as i32).abs() < 10);
    }

    #[test]
    fn what_an_offer_would_change_is_what_it_changes() {
        let exemplars = exemplars();
        let output = Domain::open([9, 12]);
        for seed in 0..40 {
            let mut rng = Seed(seed).rng();
            let mut map = SourceMap::unassigned(&exemplars, output).unwrap();
            let mut uses = Uses::new(&exemplars, output.len(), 0.3).unwrap();
            for id in map.ids.plane_mut(0) {
                *id = SampleId::new(rng.below(exemplars.table().len()));
                uses.replace(SampleId::UNASSIGNED, *id);
            }
            let offers: Vec<SampleId> = (0..108).map(|_| SampleId::new(rng.below(exemplars.table().len()))).collect();
            let frame = Frame::new(&map, &Window::all(output), offers.into_iter()).unwrap();
            let taken: Vec<bool> = frame.new.iter().map(|id| id.is_assigned() && rng.below(2) == 0).collect();
            let (growth, before) = (uses.growth(&frame, &taken).unwrap(), uses.energy());
            assert_eq!(growth, uses.growth(&frame, &taken).unwrap(), "asking changes nothing");
            (0..taken.len()).filter(|&i| taken[i]).for_each(|i| uses.replace(frame.old[i], frame.new[i]));
            assert!((uses.energy() - before - growth).abs() <= 1);
        }
        let mut off = Uses::new(&exemplars, 100, 0.0).unwrap();
        off.replace(SampleId::UNASSIGNED, SampleId::new(3));
        assert!(off.is_off() && off.price(SampleId::new(3)) == 0 && off.energy() == 0);
    }
}
