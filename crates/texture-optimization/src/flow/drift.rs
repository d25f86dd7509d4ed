//! What a frame is worth beside the exemplars, so that a texture that washes out is noticed.

use selvedge_core::{Exemplars, SourceMap, try_vec};

use crate::error::Error;

/// Exemplars are counted in squares of so many samples a side: smaller ones would count the order of a patch's samples,
/// larger ones would hide that most of one is never shown.
const CELL: u32 = 8;

/// What a frame shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// How much neighbours differ in the mean, where they do in the exemplars by 1: below it the frame is blurred or
    /// flat, above it it is torn.
    pub sharpness: f64,
    /// The share of the exemplars' squares of 8 by 8 samples that show in it: what it is complete of.
    pub completeness: f64,
}

/// Exemplars that frames are held beside.
#[derive(Clone, Copy, Debug)]
pub struct Beside<'e> {
    exemplars: &'e Exemplars<2>,
    own: Contrast,
}

impl<'e> Beside<'e> {
    /// Time `O(exemplars)`.
    pub fn new(exemplars: &'e Exemplars<2>) -> Self {
        Self { exemplars, own: Contrast::of_exemplars(exemplars) }
    }

    /// What a whole map of these exemplars shows. Constant exemplars are as sharp as anything that shows them.
    ///
    /// # Errors
    /// No memory.
    ///
    /// # Complexity
    /// Time `O(output)`, space `O(exemplars / 64)`.
    pub fn shown(&self, map: &SourceMap<2>) -> Result<Shown, Error> {
        let made = Contrast::of_map(self.exemplars, map);
        let sharpness = if self.own.sum == 0.0 { 1.0 } else { made.mean() / self.own.mean() };
        Ok(Shown { sharpness, completeness: completeness(self.exemplars, map)? })
    }
}

/// Weighted differences between neighbours.
#[derive(Clone, Copy, Debug, Default)]
struct Contrast {
    sum: f64,
    pairs: u64,
}

impl Contrast {
    fn of_exemplars(exemplars: &Exemplars<2>) -> Self {
        let mut all = Self::default();
        for (s, source) in exemplars.sources().iter().enumerate() {
            let is_valid = |at| source.valid.as_deref().is_none_or(|valid| valid.get(0, at));
            for at in source.domain().positions().filter(|&at| is_valid(at)) {
                let next = (0..2).filter_map(|axis| source.domain().next(at, axis)).filter(|&next| is_valid(next));
                next.for_each(|next| all.add(exemplars, (s, at), (s, next)));
            }
        }
        all
    }

    fn of_map(exemplars: &Exemplars<2>, map: &SourceMap<2>) -> Self {
        let mut all = Self::default();
        for at in map.domain().positions() {
            for next in (0..2).filter_map(|axis| map.domain().next(at, axis)) {
                if let (Some(here), Some(there)) = (map.locate(at), map.locate(next)) {
                    all.add(exemplars, here, there);
                }
            }
        }
        all
    }

    fn add(&mut self, exemplars: &Exemplars<2>, here: (usize, [u32; 2]), there: (usize, [u32; 2])) {
        let value = |(source, at): (usize, [u32; 2]), c: usize| exemplars.sources()[source].features.get(c, at);
        let of = |(c, &weight): (usize, &u8)| f64::from(weight) * f64::from(value(here, c).abs_diff(value(there, c)));
        self.sum += exemplars.weights().iter().enumerate().map(of).sum::<f64>();
        self.pairs += 1;
    }

    fn mean(self) -> f64 {
        self.sum / self.pairs.max(1) as f64
    }
}

fn completeness(exemplars: &Exemplars<2>, map: &SourceMap<2>) -> Result<f64, Error> {
    let cells = |shape: [u32; 2]| shape.map(|n| n.div_ceil(CELL) as usize);
    let of = |shape: [u32; 2]| cells(shape).iter().product::<usize>();
    let mut firsts = vec![0];
    for source in exemplars.sources() {
        firsts.push(firsts[firsts.len() - 1] + of(source.domain().shape));
    }
    let mut shows = try_vec(firsts[firsts.len() - 1], false)?;
    for (source, at) in map.domain().positions().filter_map(|at| map.locate(at)) {
        let [_, wide] = cells(exemplars.sources()[source].domain().shape);
        shows[firsts[source] + (at[0] / CELL) as usize * wide + (at[1] / CELL) as usize] = true;
    }
    Ok(shows.iter().filter(|&&shows| shows).count() as f64 / shows.len().max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, SampleId};
    use selvedge_testkit::simple;

    #[test]
    fn a_copy_is_worth_its_exemplar_and_a_flat_part_is_not() {
        let plane = simple::spots(40, 32, 7, 1);
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, Domain::open([32, 40])).unwrap();
        map.ids.plane_mut(0).iter_mut().zip(0..).for_each(|(id, i)| *id = SampleId::new(i));
        let beside = Beside::new(&exemplars);
        let copy = beside.shown(&map).unwrap();
        assert_eq!(copy, Shown { sharpness: 1.0, completeness: 1.0 });
        // One sample all over, and the upper left square alone.
        map.ids.plane_mut(0).fill(SampleId::new(0));
        let flat = beside.shown(&map).unwrap();
        assert_eq!(flat, Shown { sharpness: 0.0, completeness: 1.0 / 20.0 });
        // Every second row from elsewhere: torn.
        for at in map.domain().positions() {
            map.ids.set(0, at, SampleId::new(if at[0] % 2 == 0 { at[1] } else { 16 * 40 + (at[1] + 20) % 40 }));
        }
        let torn = beside.shown(&map).unwrap();
        assert!(1.0 < torn.sharpness && torn.completeness == 10.0 / 20.0, "{torn:?}");
    }
}
