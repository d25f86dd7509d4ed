//! Dominant offsets: the translations under which a picture resembles itself around its holes. `[He12 3.1]`
//!
//! `[He12]`: K. He, J. Sun, *Statistics of Patch Offsets for Image Completion*, ECCV 2012.

use selvedge_core::{Domain, Error as CoreError, Exemplars, Grid, SourceMap, par, try_vec};

use crate::error::Error;
use crate::labels::label::Label;
use crate::labels::patches::{Patches, boxes};

/// How offsets are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OffsetOptions {
    /// Offsets at most.
    pub count: usize,
    /// Patches that look for their nearest neighbours, at most: half of them nearest to the holes, the others evenly
    /// from the rest.
    pub patches: usize,
    /// Sides of these patches.
    pub side: u32,
    /// How far away a neighbour must be; `None` for a fifteenth of the output's longest side. Nearer ones say that a
    /// picture is smooth, not what it repeats.
    pub apart: Option<u32>,
}

impl Default for OffsetOptions {
    /// As in the paper: 60 offsets, patches of 8, a fifteenth. Of twelve textures with a quarter of their sides hidden,
    /// seams of fills cost as much from 1000 patches as from 2000, within a half of a thousandth in the mean, and fills
    /// take three quarters of the time; two readers preferred them on 9 and 6 of the twelve. From 600 patches seams
    /// cost three thousandths more.
    fn default() -> Self {
        Self { count: 60, patches: 1000, side: 8, apart: None }
    }
}

impl OffsetOptions {
    /// Offsets are found, and labels decided first, where the longest side is at most so long: there structures are
    /// seen whole, and the search is exact at no great cost. `[He12 3.1]` takes 800x600.
    pub const COARSE: u32 = 400;

    /// Refuses patches without samples.
    ///
    /// # Errors
    /// [`Range`](CoreError::Range).
    pub(super) fn validate(&self) -> Result<(), CoreError> {
        CoreError::within("side", self.side, 1.0..=f64::from(u32::MAX), "at least 1")
    }
}

/// Patches near holes start this many samples apart: votes of neighbours are alike.
const STEP: u32 = 2;

/// The labels by which patches of an output find themselves again in the exemplars, the most frequent first.
///
/// Patches of what stands look for their exact nearest neighbours among all valid patches of all sources; of equal ones
/// the least far counts. Offsets are counted, the counts smoothed (1 4 6 4 1 along each axis), and their highest peaks
/// taken.
///
/// Meant for small pictures: time `O(patches * samples)` of the exemplars at worst, though all but a few are ruled out
/// by the sums of their parts, most of them together. Space: about 20 bytes a channel and
/// sample of the exemplars, twice as many of small ones.
///
/// # Errors
/// [`Error::Core`] for patches without samples, and if memory is short.
pub fn dominant_offsets<const D: usize>(
    exemplars: &Exemplars<D>,
    standing: &SourceMap<D>,
    options: &OffsetOptions,
) -> Result<Vec<Label<D>>, Error> {
    repeating(exemplars, standing, options, &|| false)
}

/// [`dominant_offsets`], of the patches that have looked before it is `cancelled`.
pub(super) fn repeating<const D: usize>(
    exemplars: &Exemplars<D>,
    standing: &SourceMap<D>,
    options: &OffsetOptions,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Label<D>>, Error> {
    options.validate()?;
    let output = standing.domain();
    let shape = output.shape.map(|n| n.min(options.side));
    let longest = output.shape.into_iter().max().unwrap_or(0);
    let apart = options.apart.unwrap_or(longest / 15).max(1);
    let chosen = chosen(standing, shape, options.patches)?;
    let patches = Patches::new(exemplars, shape)?;
    let nearest = |i: usize| patches.nearest(standing, output.position(chosen[i]), apart);
    let found = par::map_indexed(chosen.len(), |i| if cancelled() { None } else { nearest(i) });
    let mut votes = Vec::new();
    for source in exemplars.sources() {
        let shape: [u32; D] = std::array::from_fn(|a| output.shape[a] + source.domain().shape[a] + 2 * MARGIN);
        votes.push(Grid::try_filled(Domain::open(shape), 1, 0_u32)?);
    }
    for (&start, found) in chosen.iter().zip(&found) {
        let Some((source, from)) = *found else { continue };
        let (side, at) = (exemplars.sources()[source].domain().shape, output.position(start));
        let place: [u32; D] = std::array::from_fn(|a| at[a] + side[a] + MARGIN - from[a]);
        let before = votes[source].get(0, place);
        votes[source].set(0, place, before + 1);
    }
    let mut peaks = Vec::new();
    for (source, votes) in votes.into_iter().enumerate() {
        let side = exemplars.sources()[source].domain().shape;
        for (count, place) in highest(votes)? {
            let offset = std::array::from_fn(|a| place[a] as i32 - (side[a] + MARGIN) as i32);
            peaks.push((count, Label { source, offset }));
        }
    }
    let far = |label: &Label<D>| label.offset.iter().map(|&o| i64::from(o).pow(2)).sum::<i64>();
    peaks.sort_unstable_by_key(|(count, label)| (std::cmp::Reverse(*count), far(label), *label));
    peaks.truncate(options.count);
    Ok(peaks.into_iter().map(|(_, label)| label).collect())
}

/// About so many boxes look along the borders of holes at most: each of them searches everything.
const BOXES: usize = 64;

/// The labels that go on from what stands around holes: for boxes on the border of holes, evenly about half a side
/// apart, the label of the valid patch most like what stands in them, and at least `apart` away.
///
/// Where a texture does not repeat itself, frequent offsets fit nowhere in particular, and the border of a hole shows:
/// these fit there, and expansions choose how far into the hole.
///
/// # Errors
/// [`Error::Core`] if memory is short.
pub(super) fn continuing<const D: usize>(
    exemplars: &Exemplars<D>,
    standing: &SourceMap<D>,
    side: u32,
    apart: u32,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Label<D>>, Error> {
    let output = standing.domain();
    let shape = output.shape.map(|n| n.min(side));
    let ids = standing.ids.plane(0);
    let at_border = |at: [u32; D]| {
        (0..D).flat_map(|axis| [(axis, 1), (axis, -1)]).any(|(axis, by)| {
            let mut step = [0; D];
            step[axis] = by;
            output.step(at, step).is_some_and(|next| ids[output.index(next)].is_assigned())
        })
    };
    let mut border = Vec::new();
    for (_, at) in output.positions().enumerate().filter(|(i, at)| !ids[*i].is_assigned() && at_border(*at)) {
        selvedge_core::reserve(&mut border, 1)?;
        border.push(at);
    }
    let between = shape.map(|n| n.div_ceil(2).max(border.len().div_ceil(BOXES) as u32));
    let mut centres: Vec<[u32; D]> = Vec::new();
    for at in border {
        if !centres.iter().any(|other| (0..D).all(|a| at[a].abs_diff(other[a]) < between[a])) {
            selvedge_core::reserve(&mut centres, 1)?;
            centres.push(at);
        }
    }
    let patches = Patches::new(exemplars, shape)?;
    let start = |at: [u32; D]| -> [u32; D] {
        std::array::from_fn(|a| at[a].saturating_sub(shape[a] / 2).min(output.shape[a] - shape[a]))
    };
    let found = par::map_indexed(centres.len(), |i| {
        let at = start(centres[i]);
        let (source, from) = if cancelled() { None } else { patches.nearest(standing, at, apart) }?;
        Some(Label { source, offset: std::array::from_fn(|a| at[a] as i32 - from[a] as i32) })
    });
    let mut labels: Vec<Label<D>> = found.into_iter().flatten().collect();
    labels.sort_unstable();
    labels.dedup();
    Ok(labels)
}

/// Room around all offsets: smoothing reaches two further, and a peak has neighbours.
const MARGIN: u32 = 3;

/// Where patches start that stand whole: half of them near holes, the others from the rest.
fn chosen<const D: usize>(standing: &SourceMap<D>, shape: [u32; D], count: usize) -> Result<Vec<usize>, Error> {
    let domain = standing.domain();
    let mut known = try_vec(domain.len(), false)?;
    known.iter_mut().zip(standing.ids.plane(0)).for_each(|(known, id)| *known = id.is_assigned());
    let distances = distances(domain, &known)?;
    let whole = boxes(domain, &known, shape)?;
    let mut near: Vec<usize> = (0..domain.len()).filter(|&i| whole[i]).collect();
    near.sort_by_key(|&i| distances[i]);
    let on_step = |i: &usize| domain.position(*i).iter().all(|p| p.is_multiple_of(STEP));
    let close: Vec<usize> = near.iter().copied().filter(on_step).take(count / 2).collect();
    let last = close.last().map_or(0, |&i| distances[i]);
    let rest: Vec<usize> = near.into_iter().filter(|&i| last < distances[i]).collect();
    let thin = rest.len().div_ceil((count - count / 2).max(1)).max(1);
    Ok(close.into_iter().chain(rest.into_iter().step_by(thin)).collect())
}

/// Steps along axes from each position to the next hole; the most there is without one.
fn distances<const D: usize>(domain: Domain<D>, known: &[bool]) -> Result<Vec<u32>, Error> {
    let mut distances = try_vec(known.len(), u32::MAX)?;
    let mut near = Vec::new();
    selvedge_core::reserve(&mut near, known.len())?;
    for (i, _) in known.iter().enumerate().filter(|(_, known)| !**known) {
        distances[i] = 0;
        near.push(i);
    }
    let mut done = 0;
    while let Some(&i) = near.get(done) {
        done += 1;
        for (axis, by) in (0..D).flat_map(|axis| [(axis, 1), (axis, -1)]) {
            let mut step = [0; D];
            step[axis] = by;
            let Some(next) = domain.step(domain.position(i), step).map(|next| domain.index(next)) else { continue };
            if distances[next] == u32::MAX {
                distances[next] = distances[i] + 1;
                near.push(next);
            }
        }
    }
    Ok(distances)
}

/// Peaks of smoothed counts and where they are, in row-major order; of equal neighbours the first.
fn highest<const D: usize>(mut votes: Grid<u32, D>) -> Result<Vec<(u32, [u32; D])>, Error> {
    let (domain, strides) = (votes.domain(), votes.domain().strides());
    for stride in strides {
        let from = votes.map(|v| v)?;
        let from = from.plane(0);
        let at = |i: usize, by: isize| i.checked_add_signed(by * stride as isize).and_then(|i| from.get(i)).copied();
        // Beyond the ends of rows there is a margin without votes.
        for (i, to) in votes.plane_mut(0).iter_mut().enumerate() {
            let pair = |by: isize| at(i, by).unwrap_or(0) + at(i, -by).unwrap_or(0);
            *to = 6 * from[i] + 4 * pair(1) + pair(2);
        }
    }
    let counts = votes.plane(0);
    let mut found = Vec::new();
    for (i, &count) in counts.iter().enumerate().filter(|(_, count)| 0 < **count) {
        let at = domain.position(i);
        let is_peak = Domain::<D>::open([3; D]).positions().all(|step| {
            let by: [i32; D] = step.map(|s| s as i32 - 1);
            let Some(j) = domain.step(at, by).map(|next| domain.index(next)) else { return true };
            i == j || counts[j] < count || (counts[j] == count && i < j)
        });
        if is_peak {
            selvedge_core::reserve(&mut found, 1)?;
            found.push((count, at));
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Origin, Source, Transform};

    #[test]
    fn of_peaks_as_high_as_each_other_the_first_is_one() {
        let mut votes = Grid::try_filled(Domain::open([9, 12]), 1, 0_u32).unwrap();
        [[4, 3], [4, 4], [4, 9]].into_iter().for_each(|at| votes.set(0, at, 5));
        let peaks = highest(votes).unwrap();
        assert_eq!(peaks.iter().map(|(_, at)| *at).collect::<Vec<_>>(), [[4, 3], [4, 9]]);
        assert!(peaks[1].0 < peaks[0].0, "the second vote of the first peak counts: {peaks:?}");
    }

    #[test]
    fn votes_count_for_offsets_two_samples_away() {
        let mut votes = Grid::try_filled(Domain::open([9, 12]), 1, 0_u32).unwrap();
        votes.set(0, [4, 3], 5);
        votes.set(0, [4, 5], 1);
        // 1, 4, 6, 4, 1 along both axes.
        assert_eq!(highest(votes).unwrap(), [((5 * 6 + 1) * 6, [4, 3])]);
    }

    #[test]
    fn a_patch_is_asked_once() {
        let domain = Domain::open([40, 44]);
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let source = Source { features: Grid::try_filled(domain, 1, 0).unwrap(), valid: None, origin };
        let exemplars = Exemplars::from_sources(vec![source], vec![1]).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, domain).unwrap();
        map.lay_under(&exemplars, 0).unwrap();
        for at in Domain::open([9, 7]).positions() {
            map.ids.set(0, [at[0] + 12, at[1] + 20], selvedge_core::SampleId::UNASSIGNED);
        }
        for count in [1, 20, 150, 5000] {
            let mut found = chosen(&map, [4, 4], count).unwrap();
            assert!(!found.is_empty() && (found.len() <= count || 150 < count), "{} of {count}", found.len());
            found.sort_unstable();
            assert!(found.is_sorted_by(|a, b| a < b), "{count}: none twice");
        }
    }
}
