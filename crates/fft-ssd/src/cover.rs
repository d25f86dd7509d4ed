//! Where samples are missing: what is no candidate, how many samples count, and what the template adds by itself.

use crate::axes::Shape;
use crate::job::Job;
use crate::sums::{Corners, Table};
use crate::word::Word;
use crate::{Cover, Error};
use selvedge_core::{collected, par, try_vec};

/// Working memory of this step.
#[derive(Debug, Default)]
pub(crate) struct CoverScratch {
    corners: Corners,
}

/// Marks positions that are no candidates; where the number of compared samples varies, adds the template's own part
/// (see [`Job::own`]) and writes the counts, unless the engine has (`summed`, where validity is no box).
pub(crate) fn apply<W: Word>(
    job: &Job<'_>,
    bias: i64,
    summed: bool,
    scratch: &mut CoverScratch,
    map: &mut [W],
    counts: &mut [u32],
) -> Result<(), Error> {
    match job.cover {
        Cover::AtLeast(least) if job.prepared.is_full => {
            counts.fill(job.template.samples as u32);
            if job.template.samples < least.max(1) {
                map.fill(W::NONE);
            }
            Ok(())
        }
        _ if job.prepared.is_full => Ok(()),
        Cover::AtLeast(least) => {
            if job.prepared.is_box || !summed {
                partial(job, bias, scratch, map, counts)?;
            }
            for (cost, _) in map.iter_mut().zip(counts).filter(|(_, count)| u64::from(**count) < least.max(1)) {
                *cost = W::NONE;
            }
            Ok(())
        }
        Cover::Box | Cover::Mask => whole(job, scratch, map),
    }
}

/// Excludes positions at which a needed sample is missing.
fn whole<W: Word>(job: &Job<'_>, scratch: &mut CoverScratch, map: &mut [W]) -> Result<(), Error> {
    let table = job.prepared.valid(job.source)?;
    let needed = if job.cover == Cover::Box {
        scratch.corners.of_box(job.template, table.shape)?;
        job.template.len() as u64
    } else {
        scratch.corners.of_masks(&[*job.template], table.shape)?;
        job.template.samples
    };
    let (corners, width) = (&scratch.corners, job.range.count[2]);
    let needed = u32::try_from(needed).unwrap_or(u32::MAX);
    let nanoseconds = (map.len() * corners.len()) as f64 / LANES;
    job.each_part(map, 8, nanoseconds, |t, y, part| {
        for (row, costs) in part.chunks_mut(width).enumerate() {
            let first = (t * table.shape[1] + y + row) * table.shape[2];
            for (number, costs) in costs.chunks_mut(TOGETHER).enumerate() {
                let mut counts = [0; TOGETHER];
                let counts = &mut counts[..costs.len()];
                count(&table.sums[first + number * TOGETHER..], corners, counts);
                for (cost, _) in costs.iter_mut().zip(counts).filter(|(_, count)| **count < needed) {
                    *cost = W::NONE;
                }
            }
        }
    });
    Ok(())
}

/// Excludes positions at which a part of the template, by its start and shape, does not stand on valid samples alone.
pub(crate) fn require<W: Word>(valid: &Table<u32>, count: Shape, start: Shape, part: Shape, map: &mut [W]) {
    let all: usize = part.iter().product();
    for (i, cost) in map.iter_mut().enumerate() {
        let at = crate::axes::position(count, i);
        let under = [0, 1, 2].map(|a: usize| at[a] + start[a]..at[a] + start[a] + part[a]);
        if (valid.over(&under) as usize) < all {
            *cost = W::NONE;
        }
    }
}

/// Positions that are counted together: their counts stay in registers and the nearest cache, corner after corner.
const TOGETHER: usize = 256;
/// Positions that an instruction counts, on most machines.
const LANES: f64 = 8.0;

/// Valid samples under the corners' mask at positions of a row, from a table's entries there on.
fn count(sums: &[u32], corners: &Corners, counts: &mut [u32]) {
    counts.fill(0);
    for &corner in &corners.plus {
        counts.iter_mut().zip(&sums[corner..]).for_each(|(count, &sum)| *count = count.wrapping_add(sum));
    }
    for &corner in &corners.minus {
        counts.iter_mut().zip(&sums[corner..]).for_each(|(count, &sum)| *count = count.wrapping_sub(sum));
    }
}

/// Counts the samples that are there, and adds what the template's share of them adds.
fn partial<W: Word>(
    job: &Job<'_>,
    bias: i64,
    scratch: &mut CoverScratch,
    map: &mut [W],
    counts: &mut [u32],
) -> Result<(), Error> {
    if job.prepared.is_box {
        let own = Table::new(job.template.shape, |row, values| {
            template_row(job, row, values, |i| W::wrapping(job.own(i, bias)))
        })?;
        let mask = Table::<u32>::new(job.template.shape, |row, values| template_row(job, row, values, |_| 1))?;
        let inside = job.prepared.extension.inside();
        let overlap = |axis: usize, at: usize| {
            let clip = |end: usize| end.saturating_sub(at).min(job.template.shape[axis]);
            clip(inside[axis].start)..clip(inside[axis].end)
        };
        each_row(job, map, counts, |t, y, costs, counts| {
            let mut over = [overlap(0, t), overlap(1, y), overlap(2, 0)];
            let mut sums = (own.over(&over), mask.over(&over));
            for (x, (cost, count)) in costs.iter_mut().zip(counts).enumerate() {
                let along = overlap(2, x);
                // As much of the template as at the position before, but for those near the source's ends.
                if along != over[2] {
                    over[2] = along;
                    sums = (own.over(&over), mask.over(&over));
                }
                *cost = cost.plus(sums.0);
                *count = sums.1;
            }
        })
    } else {
        let table = job.prepared.valid(job.source)?;
        scratch.corners.of_masks(&[*job.template], table.shape)?;
        let valid = valid_samples(job)?;
        let corners = &scratch.corners;
        each_row(job, map, counts, |t, y, costs, counts| {
            add_own_where_valid(job, bias, &valid, t, y, costs);
            count(&table.sums[(t * table.shape[1] + y) * table.shape[2]..], corners, counts);
        })
    }
}

/// Values of the unmasked samples of one row of a template.
fn template_row<T>(job: &Job<'_>, row: usize, values: &mut [T], value: impl Fn(usize) -> T) {
    let start = row * job.template.shape[2];
    for (x, to) in values.iter_mut().enumerate().filter(|(x, _)| job.template.counts(start + x)) {
        *to = value(start + x);
    }
}

/// Calls `f(t, y, costs, counts)` for each row of positions, in any order.
fn each_row<W: Word>(
    job: &Job<'_>,
    map: &mut [W],
    counts: &mut [u32],
    f: impl Fn(usize, usize, &mut [W], &mut [u32]) + Sync + Send,
) -> Result<(), Error> {
    let [_, height, width] = job.range.count;
    let mut rows = collected(map.chunks_mut(width).zip(counts.chunks_mut(width)))?;
    par::for_rows(&mut rows, 1, |row, part| {
        let (costs, counts) = &mut part[0];
        f(row / height, row % height, costs, counts);
    });
    Ok(())
}

/// Validity of each sample of the extension.
fn valid_samples(job: &Job<'_>) -> Result<Vec<bool>, Error> {
    let extension = &job.prepared.extension;
    let mut valid = try_vec(extension.len(), false)?;
    let (first, columns) = extension.columns();
    for (row, from) in extension.rows(job.source) {
        let to = &mut valid[row * extension.shape[2] + first..];
        for (valid, &x) in to.iter_mut().zip(columns) {
            *valid = job.source.is_valid(from + x as usize);
        }
    }
    Ok(valid)
}

/// The template's own part where validity has any shape: sample by sample.
fn add_own_where_valid<W: Word>(job: &Job<'_>, bias: i64, valid: &[bool], t: usize, y: usize, costs: &mut [W]) {
    let shape = job.prepared.extension.shape;
    for i in (0..job.template.len()).filter(|&i| job.template.counts(i)) {
        let x = crate::axes::position(job.template.shape, i);
        let own = W::wrapping(job.own(i, bias));
        let from = ((t + x[0]) * shape[1] + y + x[1]) * shape[2] + x[2];
        for (cost, &valid) in costs.iter_mut().zip(&valid[from..]) {
            *cost = cost.plus(if valid { own } else { W::ZERO });
        }
    }
}
