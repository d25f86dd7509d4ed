//! Constraints of low resolution: what exemplars look like from as far away. `[CMS V-B]`

use selvedge_core::{Domain, Error as CoreError, Exemplars, Grid, Guide, Source, reserve};

use crate::constraint::Constraint;
use crate::error::Error;

/// A constraint from a picture `ratio` times as coarse as the output, in the features of `maps`, one an exemplar.
///
/// `Q` stays at full resolution and is averaged over squares of the ratio's side around every sample: what a sample of
/// the low-resolution picture sees, at every phase of its grid, but for what masks hide. The target is interpolated
/// between the middles of its samples. Around periodic axes of the output both go on.
///
/// # Errors
/// [`Range`](selvedge_core::Error::Range) for a ratio of 0 or over 256, and those of [`Guide::new`].
pub fn low_resolution(
    exemplars: &Exemplars<2>,
    maps: &[Grid<u8, 2>],
    low: &Grid<u8, 2>,
    ratio: u32,
) -> Result<Constraint, Error> {
    if !(1..=256).contains(&ratio) {
        return Err(CoreError::range("ratio", ratio, "1 to 256").into());
    }
    let guide = Guide::new(exemplars, maps, enlarged(low, ratio)?)?;
    let guide = guide.over_sources(|source| averaged(source, ratio))?;
    Ok(Constraint { guide, ratio, weight: 1.0 })
}

/// Means over squares of so many samples a side around each sample; of an even side the outermost count half. Beyond
/// open borders and under masks nothing counts, and 0 is the mean of nothing.
fn averaged(source: &Source<2>, side: u32) -> Result<Grid<u8, 2>, Error> {
    let (map, domain) = (&source.features, source.domain());
    let valid = source.valid.as_ref().map(|valid| valid.samples());
    let mut out = Grid::try_filled(domain, map.channels(), 0)?;
    let reach = (side / 2) as i32;
    // Twice the weight, so that halves are whole.
    let weight = |by: i32| if side.is_multiple_of(2) && by.abs() == reach { 1_u64 } else { 2 };
    let reached = |at: [u32; 2], axis: usize| {
        (-reach..=reach).filter_map(move |by| {
            let mut step = [0; 2];
            step[axis] = by;
            Some((domain.step(at, step)?, weight(by)))
        })
    };
    let mut columns: Vec<(u64, u64)> = Vec::new();
    reserve(&mut columns, domain.len())?;
    for c in 0..map.channels() {
        columns.clear();
        let shown = |&(p, _): &([u32; 2], u64)| valid.is_none_or(|valid| valid[domain.index(p)]);
        let add = |(sum, n), (p, w): ([u32; 2], u64)| (sum + w * u64::from(map.get(c, p)), n + w);
        columns.extend(domain.positions().map(|at| reached(at, 0).filter(shown).fold((0, 0), add)));
        for (to, at) in out.plane_mut(c).iter_mut().zip(domain.positions()) {
            let add = |(sum, n), (p, w): ([u32; 2], u64)| {
                let column = columns[domain.index(p)];
                (sum + w * column.0, n + w * column.1)
            };
            let (sum, n) = reached(at, 1).fold((0, 0), add);
            *to = if n == 0 { 0 } else { ((2 * sum + n) / (2 * n)) as u8 };
        }
    }
    Ok(out)
}

/// Between the middles of samples on a line along each axis; before the first and after the last one as these.
fn enlarged(low: &Grid<u8, 2>, ratio: u32) -> Result<Grid<u8, 2>, Error> {
    let from = low.domain();
    let side = |a: usize| from.shape[a].checked_mul(ratio).ok_or(CoreError::range("ratio", ratio, "less"));
    let domain = Domain { shape: [side(0)?, side(1)?], ..from };
    let mut out = Grid::try_filled(domain, low.channels(), 0)?;
    // In units of half a sample of the output: the sample before, the one after, and how far it is between them.
    let along = |p: u32, axis: usize| {
        let twice = i64::from(2 * p + 1) - i64::from(ratio);
        let (span, side) = (2 * i64::from(ratio), i64::from(from.shape[axis]));
        let place = |i: i64| if from.periodic[axis] { i.rem_euclid(side) } else { i.clamp(0, side - 1) } as u32;
        let first = twice.div_euclid(span);
        ([place(first), place(first + 1)], twice.rem_euclid(span) as u64)
    };
    let span = 2 * u64::from(ratio);
    let columns: Vec<_> = (0..domain.shape[1]).map(|x| along(x, 1)).collect();
    for c in 0..low.channels() {
        for y in 0..domain.shape[0] {
            let (ys, v) = along(y, 0);
            for (x, (xs, u)) in columns.iter().enumerate() {
                let row =
                    |y: u32| u64::from(low.get(c, [y, xs[0]])) * (span - u) + u64::from(low.get(c, [y, xs[1]])) * u;
                let sum = row(ys[0]) * (span - v) + row(ys[1]) * v;
                out.set(c, [y, x as u32], ((2 * sum + span * span) / (2 * span * span)) as u8);
            }
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Origin, Transform};

    fn grid(shape: [u32; 2], samples: &[u8]) -> Grid<u8, 2> {
        Grid::from_vec(Domain::open(shape), 1, samples.to_vec()).unwrap()
    }

    /// Means over what a mask shows.
    fn averaged(map: &Grid<u8, 2>, side: u32, valid: Option<Grid<bool, 2>>) -> Grid<u8, 2> {
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        super::averaged(&Source { features: map.clone(), valid, origin }, side).unwrap()
    }

    #[test]
    fn what_masks_hide_is_no_part_of_a_mean() {
        let map = grid([1, 6], &[10, 30, 255, 90, 0, 0]);
        let valid = Grid::from_vec(map.domain(), 1, vec![true, true, false, true, false, false]).unwrap();
        assert_eq!(averaged(&map, 3, Some(valid.clone())).samples(), [20, 20, 60, 90, 90, 0]);
        let exemplars = Exemplars::from_sources(
            vec![Source {
                features: map.clone(),
                valid: Some(valid),
                origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
            }],
            vec![1],
        );
        let low = grid([1, 2], &[1, 2]);
        let constraint = low_resolution(&exemplars.unwrap(), &[map], &low, 3).unwrap();
        assert_eq!(constraint.guide.exemplars().sources()[0].features.samples()[..2], [20, 20]);
    }

    #[test]
    fn means_see_what_a_coarse_sample_sees() {
        let map = grid([1, 6], &[0, 30, 60, 90, 120, 250]);
        assert_eq!(averaged(&map, 3, None).samples(), [15, 30, 60, 90, 153, 185]);
        // (30 / 2 + 60 + 90 / 2) / 2 in the middle.
        assert_eq!(averaged(&map, 2, None).samples()[2], 60);
        // (90 / 2 + 120 + 250 / 2) / 2.
        assert_eq!(averaged(&map, 2, None).samples()[4], 145);
        assert_eq!(averaged(&map, 1, None), map);
        let around = averaged(&map.with_periodic([false, true]), 3, None);
        assert_eq!(around.samples()[0], 93);
    }

    #[test]
    fn enlarged_samples_keep_their_middles() {
        let low = grid([1, 3], &[0, 90, 60]);
        assert_eq!(enlarged(&low, 3).unwrap().plane(0)[..9], [0, 0, 30, 60, 90, 80, 70, 60, 60]);
        assert_eq!(enlarged(&low, 2).unwrap().domain().shape, [2, 6]);
        assert_eq!(enlarged(&low, 2).unwrap().plane(0)[..6], [0, 23, 68, 83, 68, 60]);
        assert_eq!(enlarged(&low, 1).unwrap(), low);
        let around = enlarged(&low.with_periodic([false, true]), 3).unwrap();
        assert_eq!(around.plane(0)[..2], [20, 0]);
    }
}
