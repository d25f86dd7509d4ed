//! Whole patches moved by a sample where their seams become cheaper.

use std::collections::BTreeMap;

use selvedge_core::{Domain, Exemplars, Grid, Patch, SampleId, SeamCosts, SourceMap, reserve, try_vec};
use selvedge_maxflow::MaxflowError;

use crate::error::Error;

/// Moves whole patches of a map by one sample along any of the axes that are `free` where the price of all seams falls,
/// one after the other in the order in which they come; answers with how much it fell. Patches with a `fixed` sample,
/// or one that would leave what is valid of its source, stay.
///
/// A map that was solved at half the size has its offsets in steps of two samples. Along a line that goes on from one
/// patch into the next, the odd ones fit as often.
///
/// # Errors
/// [`Error::Core`] if memory is short; [`Error::Cut`] if `cancelled`: the map is whole then.
///
/// # Complexity
/// Time `O(3^D seams + output)`, and once more over the rows of each patch that moves, of a clip over its frames.
/// Space 4 bytes a sample of the output, and 32 a seam.
pub fn shift<const D: usize>(
    exemplars: &Exemplars<D>,
    map: &mut SourceMap<D>,
    costs: &SeamCosts<D>,
    (free, fixed): ([bool; D], Option<&Grid<bool, D>>),
    cancelled: &dyn Fn() -> bool,
) -> Result<i64, Error> {
    let asked = || if cancelled() { Err(Error::Cut(MaxflowError::Cancelled)) } else { Ok(()) };
    let labels = Labels::of(exemplars, map, costs, fixed)?;
    asked()?;
    let mut seams = labels.seams(map, costs)?;
    seams.sort_unstable();
    let mut gain = 0;
    for of in seams.chunk_by(|a, b| a.label == b.label) {
        asked()?;
        let label = of[0].label;
        if labels.stays[label as usize] {
            continue;
        }
        let ids = map.ids.plane(0);
        let price = |by: [i32; D]| labels.price(exemplars, costs, ids, of, by);
        let Some(before) = price([0; D]) else { continue };
        let mut moves: Vec<(i64, [i32; D])> = ways(free).filter_map(|by| Some((price(by)?, by))).collect();
        moves.retain(|(after, _)| *after < before);
        moves.sort_unstable();
        let whole = moves.into_iter().find_map(|(after, by)| Some((after, labels.moved(exemplars, ids, label, by)?)));
        let Some((after, moved)) = whole else { continue };
        gain += before - after;
        let ids = map.ids.plane_mut(0);
        moved.into_iter().for_each(|(place, id)| ids[place as usize] = id);
    }
    Ok(gain)
}

/// One sample along any free axes, in a fixed order.
fn ways<const D: usize>(free: [bool; D]) -> impl Iterator<Item = [i32; D]> {
    let all = Domain::open([3; D]).positions().map(|p| p.map(|p| p as i32 - 1)).filter(|by| *by != [0; D]);
    all.filter(move |by| (0..D).all(|a| free[a] || by[a] == 0))
}

/// The sample `by` away, if it is valid.
fn step<const D: usize>(exemplars: &Exemplars<D>, id: SampleId, by: [i32; D]) -> Option<SampleId> {
    let (source, at) = exemplars.locate(id)?;
    let source_of = &exemplars.sources()[source];
    let to = source_of.domain().step(at, by)?;
    let is_valid = source_of.valid.as_deref().is_none_or(|v| v.get(0, to));
    is_valid.then(|| exemplars.table().id(source, to))
}

/// Two neighbours along an axis that do not go on from each other, or are of two patches, seen from the patch of one of
/// them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Seam {
    label: u32,
    axis: u32,
    here: u32,
    there: u32,
}

/// The patches of a map.
struct Labels {
    /// By place; `HOLE` where nothing is assigned.
    of: Vec<u32>,
    /// The first place of each patch, and one past the last.
    range: Vec<[u32; 2]>,
    /// Those that hold a fixed sample.
    stays: Vec<bool>,
}

const HOLE: u32 = u32::MAX;

impl Labels {
    fn of<const D: usize>(
        exemplars: &Exemplars<D>,
        map: &SourceMap<D>,
        costs: &SeamCosts<D>,
        fixed: Option<&Grid<bool, D>>,
    ) -> Result<Self, Error> {
        let (output, ids) = (map.domain(), map.ids.plane(0));
        let mut labels = Self { of: try_vec(ids.len(), HOLE)?, range: Vec::new(), stays: Vec::new() };
        let mut numbers: BTreeMap<Patch<D>, u32> = BTreeMap::new();
        let row = output.shape[D - 1] as usize;
        for (place, &id) in ids.iter().enumerate() {
            let before = (!place.is_multiple_of(row)).then(|| ids[place - 1]).filter(|before| before.is_assigned());
            let label = if before.is_some_and(|before| costs.continued(before, 2 * (D - 1)) == Some(id)) {
                labels.of[place - 1]
            } else {
                let Some((source, from)) = exemplars.locate(id) else { continue };
                let at = output.position(place);
                let patch = Patch { source, offset: std::array::from_fn(|a| at[a] as i32 - from[a] as i32) };
                let next = numbers.len() as u32;
                *numbers.entry(patch.wrapped(exemplars.sources()[source].domain(), output)).or_insert(next)
            };
            labels.note(label, place, fixed.is_some_and(|f| f.samples()[place]));
        }
        Ok(labels)
    }

    fn note(&mut self, label: u32, place: usize, is_fixed: bool) {
        if self.range.len() == label as usize {
            self.range.push([place as u32; 2]);
            self.stays.push(false);
        }
        self.of[place] = label;
        self.range[label as usize][1] = place as u32 + 1;
        self.stays[label as usize] |= is_fixed;
    }

    /// All seams, once for each patch that they part.
    fn seams<const D: usize>(&self, map: &SourceMap<D>, costs: &SeamCosts<D>) -> Result<Vec<Seam>, Error> {
        let (output, ids) = (map.domain(), map.ids.plane(0));
        let mut seams = Vec::new();
        for axis in 0..D {
            let (stride, side) = (output.strides()[axis], output.shape[axis] as usize);
            for here in (0..ids.len()).filter(|&here| ids[here].is_assigned()) {
                let there = match (here / stride % side + 1 == side, output.periodic[axis]) {
                    (false, _) => here + stride,
                    (true, true) => here + stride - side * stride,
                    (true, false) => continue,
                };
                let [a, b] = [self.of[here], self.of[there]];
                // Around an output whose side is no multiple of a periodic source's, two patches may go on in each
                // other: one that moves tears them apart.
                let goes_on = a == b && costs.continued(ids[here], 2 * axis) == Some(ids[there]);
                if !ids[there].is_assigned() || goes_on {
                    continue;
                }
                let seam = |label| Seam { label, axis: axis as u32, here: here as u32, there: there as u32 };
                reserve(&mut seams, 2)?;
                seams.push(seam(a));
                seams.extend((a != b).then(|| seam(b)));
            }
        }
        Ok(seams)
    }

    /// The price of a patch's seams if it moves; `None` if a sample beside one cannot.
    fn price<const D: usize>(
        &self,
        exemplars: &Exemplars<D>,
        costs: &SeamCosts<D>,
        ids: &[SampleId],
        seams: &[Seam],
        by: [i32; D],
    ) -> Option<i64> {
        let mut sum = 0;
        for seam in seams {
            let shown = |place: u32| {
                let id = ids[place as usize];
                if self.of[place as usize] == seam.label { step(exemplars, id, by) } else { Some(id) }
            };
            sum += i64::from(costs.between(seam.axis as usize, shown(seam.here)?, shown(seam.there)?));
        }
        Some(sum)
    }

    /// All samples of a patch as they are once it moved; `None` if one of them cannot.
    fn moved<const D: usize>(
        &self,
        exemplars: &Exemplars<D>,
        ids: &[SampleId],
        label: u32,
        by: [i32; D],
    ) -> Option<Vec<(u32, SampleId)>> {
        let [first, end] = self.range[label as usize];
        let places = (first..end).filter(|&place| self.of[place as usize] == label);
        places.map(|place| Some((place, step(exemplars, ids[place as usize], by)?))).collect()
    }
}

#[cfg(test)]
mod tests;
