//! Constraints of low resolution: what exemplars look like from as far away. `[CMS V-B]`

use selvedge_core::{Domain, Error as CoreError, Exemplars, Grid, Guide, Plane, Source, reserve, try_vec};

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
    let span = 2 * u64::from(ratio);
    let columns: Vec<_> = (0..domain.shape[1]).map(|x| between(from, ratio, x, 1)).collect();
    for c in 0..low.channels() {
        for y in 0..domain.shape[0] {
            let (ys, v) = between(from, ratio, y, 0);
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

/// The coarse samples before and after a place along an axis, and how far it is from the one to the other, in units of
/// half a sample of the output.
fn between(from: Domain<2>, ratio: u32, p: u32, axis: usize) -> ([u32; 2], u64) {
    let twice = i64::from(2 * p + 1) - i64::from(ratio);
    let span = 2 * i64::from(ratio);
    let first = twice.div_euclid(span);
    ([first, first + 1].map(|place| from.nearest(axis, place)), twice.rem_euclid(span) as u64)
}

/// Adds to a picture what its means over squares of the ratio's side still lack of one of low resolution: light and
/// colours of large parts are those of `low` then, details are the picture's own. What is lacking is added smoothly,
/// again and again, so that no square is seen; where samples are at the end of their range some of it stays lacking.
/// A grey `low` holds for all colours. Alpha and depth stay.
///
/// # Errors
/// [`Error::Low`] if the picture is not `ratio` times as large, and no memory.
///
/// # Complexity
/// `O(samples)` a channel, 12 times.
pub fn match_low(picture: &mut Plane<2>, low: &Plane<2>, ratio: u32) -> Result<(), Error> {
    let (fine, coarse) = (picture.domain(), low.domain());
    let expected = coarse.shape.map(|side| side.saturating_mul(ratio));
    if fine.shape != expected || fine.is_empty() {
        return Err(Error::Low { expected: expected.to_vec(), found: fine.shape.to_vec() });
    }
    // What wraps for the output wraps for what it is compared with.
    let coarse = Domain { periodic: fine.periodic, ..coarse };
    let (full, of) = (picture.samples.depth().full(), low.samples.depth().full());
    let (mut values, mut lacking) = (try_vec(fine.len(), 0.0)?, try_vec(coarse.len(), 0.0)?);
    for c in 0..picture.color_channels() {
        let wanted = |i: usize| low.samples.value(c.min(low.color_channels() - 1), i) / of * full;
        values.iter_mut().enumerate().for_each(|(i, v)| *v = picture.samples.value(c, i));
        for _ in 0..ROUNDS {
            lacking.iter_mut().enumerate().for_each(|(i, l)| *l = wanted(i));
            let share = 1.0 / (f64::from(ratio) * f64::from(ratio));
            for (v, at) in values.iter().zip(fine.positions()) {
                lacking[coarse.index(at.map(|p| p / ratio))] -= v * share;
            }
            add_enlarged(&mut values, fine, &lacking, coarse, ratio);
            if 1.0 < full {
                values.iter_mut().for_each(|v| *v = v.clamp(0.0, full));
            }
        }
        values.iter().enumerate().for_each(|(i, &v)| picture.samples.set_value(c, i, v));
    }
    Ok(())
}

/// How often what is lacking is added: of noise against noise a hundredth of it is left.
const ROUNDS: usize = 12;

fn add_enlarged(values: &mut [f64], fine: Domain<2>, low: &[f64], coarse: Domain<2>, ratio: u32) {
    let span = f64::from(2 * ratio);
    for (v, at) in values.iter_mut().zip(fine.positions()) {
        let [(ys, dy), (xs, dx)] = [0, 1].map(|a| between(coarse, ratio, at[a], a));
        let [dy, dx] = [dy, dx].map(|d| d as f64 / span);
        let row = |y: u32| low[coarse.index([y, xs[0]])] * (1.0 - dx) + low[coarse.index([y, xs[1]])] * dx;
        *v += row(ys[0]) * (1.0 - dy) + row(ys[1]) * dy;
    }
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
    fn a_matched_picture_has_the_means_of_the_coarse_one_and_keeps_its_detail() {
        use selvedge_core::{Role, Samples, Seed};
        let (ratio, mut rng) = (4, Seed(3).rng());
        for periodic in [[false; 2], [true, false]] {
            let domain = Domain { shape: [16, 24], periodic };
            let noise = (0..domain.len() as u32).map(|i| (60 + 100 * (i % 2) + rng.below(30)) as u16 * 200).collect();
            let picture = Plane::new(Role::Color, Samples::U16(Grid::from_vec(domain, 1, noise).unwrap()));
            let wanted: Vec<u8> = (0..24).map(|_| 90 + rng.below(40) as u8).collect();
            let low = Plane::new(Role::Color, Samples::U8(grid([4, 6], &wanted)));
            let mut matched = picture.clone();
            match_low(&mut matched, &low, ratio).unwrap();
            let value = |plane: &Plane<2>, at: [u32; 2]| plane.samples.value(0, domain.index(at));
            for (i, at) in low.domain().positions().enumerate() {
                let square = Domain::open([ratio; 2]).positions().map(|p| [0, 1].map(|a| at[a] * ratio + p[a]));
                let mean = square.map(|p| value(&matched, p)).sum::<f64>() / 16.0;
                assert!((mean / 257.0 - f64::from(wanted[i])).abs() < 1.0, "{mean} for {}", wanted[i]);
            }
            let step = |plane: &Plane<2>| value(plane, [5, 8]) - value(plane, [5, 9]);
            // What is added is smooth: of a step from sample to sample three fourths are left at least.
            assert!((step(&matched) / step(&picture) - 1.0).abs() < 0.25, "{} {}", step(&matched), step(&picture));
            assert!(matches!(match_low(&mut matched, &low, 3), Err(Error::Low { .. })));
        }
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
