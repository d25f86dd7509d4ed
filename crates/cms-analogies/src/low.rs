//! Constraints of low resolution: what exemplars look like from as far away. `[CMS V-B]`

use selvedge_core::{Domain, Error as CoreError, Exemplars, Grid, Guide, Plane, Source, reserve, try_vec};

use crate::constraint::Constraint;
use crate::error::Error;
use crate::kernel::Kernel;

/// A constraint from a picture `ratio` times as coarse as the output, in the features of `maps`, one an exemplar.
///
/// `Q` stays at full resolution and is averaged around every sample as the picture was reduced, by `kernel`: what a
/// sample of the low-resolution picture sees, at every phase of its grid, but for what masks hide. The target is
/// interpolated between the middles of its samples. Around periodic axes of the output both go on.
///
/// # Errors
/// [`Range`](selvedge_core::Error::Range) for a ratio of 0 or over 256, and those of [`Guide::new`].
pub fn low_resolution(
    exemplars: &Exemplars<2>,
    maps: &[Grid<u8, 2>],
    low: &Grid<u8, 2>,
    ratio: u32,
    kernel: Kernel,
) -> Result<Constraint, Error> {
    if !(1..=256).contains(&ratio) {
        return Err(CoreError::range("ratio", ratio, "1 to 256").into());
    }
    let guide = Guide::new(exemplars, maps, enlarged(low, ratio)?)?;
    let guide = guide.over_sources(|source| averaged(source, &kernel.weights(ratio)))?;
    Ok(Constraint { guide, ratio, weight: 1.0 })
}

/// Means around each sample, by weights at distances 0, 1, ... along both axes. Beyond open borders and under masks
/// nothing counts, and 0 is the mean of nothing.
fn averaged(source: &Source<2>, weights: &[i64]) -> Result<Grid<u8, 2>, Error> {
    let (map, domain) = (&source.features, source.domain());
    let valid = source.valid.as_deref().map(|valid| valid.samples());
    let mut out = Grid::try_filled(domain, map.channels(), 0)?;
    let reach = weights.len() as i32 - 1;
    let reached = |at: [u32; 2], axis: usize| {
        (-reach..=reach).filter_map(move |by| {
            let mut step = [0; 2];
            step[axis] = by;
            Some((domain.step(at, step)?, weights[by.unsigned_abs() as usize]))
        })
    };
    let mut columns: Vec<(i64, i64)> = Vec::new();
    reserve(&mut columns, domain.len())?;
    for c in 0..map.channels() {
        columns.clear();
        let shown = |&(p, _): &([u32; 2], i64)| valid.is_none_or(|valid| valid[domain.index(p)]);
        let add = |(sum, n), (p, w): ([u32; 2], i64)| (sum + w * i64::from(map.get(c, p)), n + w);
        columns.extend(domain.positions().map(|at| reached(at, 0).filter(shown).fold((0, 0), add)));
        for (to, at) in out.plane_mut(c).iter_mut().zip(domain.positions()) {
            let add = |(sum, n), (p, w): ([u32; 2], i64)| {
                let column = columns[domain.index(p)];
                (sum + w * column.0, n + w * column.1)
            };
            let (sum, n) = reached(at, 1).fold((0, 0), add);
            *to = if n <= 0 { 0 } else { ((2 * sum + n) / (2 * n)).clamp(0, 255) as u8 };
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

/// Adds to a picture what it still lacks, reduced by the kernel, of one of low resolution: light and
/// colours of large parts are those of `low` then, details are the picture's own. What is lacking is added smoothly,
/// again and again, so that no square is seen; where samples are at the end of their range some of it stays lacking.
/// A grey `low` holds for all colours. Alpha and depth stay.
///
/// # Errors
/// [`Error::Low`] if the picture is not `ratio` times as large, and no memory.
///
/// # Complexity
/// `O(samples)` a channel, 12 times.
pub fn match_low(picture: &mut Plane<2>, low: &Plane<2>, ratio: u32, kernel: Kernel) -> Result<(), Error> {
    let (fine, coarse) = (picture.domain(), low.domain());
    let expected = coarse.shape.map(|side| side.saturating_mul(ratio));
    if fine.shape != expected || fine.is_empty() {
        return Err(Error::Low { expected: expected.to_vec(), found: fine.shape.to_vec() });
    }
    // What wraps for the output wraps for what it is compared with.
    let coarse = Domain { periodic: fine.periodic, ..coarse };
    let (full, of) = (picture.samples.depth().full(), low.samples.depth().full());
    let (mut values, mut lacking) = (try_vec(fine.len(), 0.0)?, try_vec(coarse.len(), 0.0)?);
    let (shares, between) = (kernel.shares(ratio), Domain::open([coarse.shape[0], fine.shape[1]]));
    let mut rows = try_vec(between.len(), 0.0)?;
    for c in 0..picture.color_channels() {
        let wanted = |i: usize| low.samples.value(c.min(low.color_channels() - 1), i) / of * full;
        values.iter_mut().enumerate().for_each(|(i, v)| *v = picture.samples.value(c, i));
        for _ in 0..ROUNDS {
            reduced(&values, fine, (&mut rows, &mut lacking), (coarse, ratio, &shares));
            lacking.iter_mut().enumerate().for_each(|(i, l)| *l = wanted(i) - *l);
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

/// A picture's samples as those of low resolution see them: along columns into `rows`, then along these.
fn reduced(
    values: &[f64],
    fine: Domain<2>,
    (rows, to): (&mut [f64], &mut [f64]),
    (coarse, ratio, shares): (Domain<2>, u32, &[(i64, f64)]),
) {
    let width = fine.shape[1] as usize;
    for (y, row) in (0_i64..).zip(rows.chunks_mut(width)) {
        row.fill(0.0);
        for (by, share) in shares {
            let from = fine.nearest(0, y * i64::from(ratio) + by) as usize * width;
            row.iter_mut().zip(&values[from..from + width]).for_each(|(to, v)| *to += share * v);
        }
    }
    for (to, [y, x]) in to.iter_mut().zip(coarse.positions()) {
        let row = &rows[y as usize * width..];
        let seen = |(by, share): &(i64, f64)| share * row[fine.nearest(1, i64::from(x * ratio) + by) as usize];
        *to = shares.iter().map(seen).sum();
    }
}

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
        super::averaged(
            &Source { features: map.clone(), valid: valid.map(Into::into), origin },
            &Kernel::Box.weights(side),
        )
        .unwrap()
    }

    #[test]
    fn what_masks_hide_is_no_part_of_a_mean() {
        let map = grid([1, 6], &[10, 30, 255, 90, 0, 0]);
        let valid = Grid::from_vec(map.domain(), 1, vec![true, true, false, true, false, false]).unwrap();
        assert_eq!(averaged(&map, 3, Some(valid.clone())).samples(), [20, 20, 60, 90, 90, 0]);
        let exemplars = Exemplars::from_sources(
            vec![Source {
                features: map.clone(),
                valid: Some(valid.into()),
                origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
            }],
            vec![1],
        );
        let low = grid([1, 2], &[1, 2]);
        let constraint = low_resolution(&exemplars.unwrap(), &[map], &low, 3, Kernel::Box).unwrap();
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
            match_low(&mut matched, &low, ratio, Kernel::Box).unwrap();
            let value = |plane: &Plane<2>, at: [u32; 2]| plane.samples.value(0, domain.index(at));
            for (i, at) in low.domain().positions().enumerate() {
                let square = Domain::open([ratio; 2]).positions().map(|p| [0, 1].map(|a| at[a] * ratio + p[a]));
                let mean = square.map(|p| value(&matched, p)).sum::<f64>() / 16.0;
                assert!((mean / 257.0 - f64::from(wanted[i])).abs() < 1.0, "{mean} for {}", wanted[i]);
            }
            let step = |plane: &Plane<2>| value(plane, [5, 8]) - value(plane, [5, 9]);
            // What is added is smooth: of a step from sample to sample three fourths are left at least.
            assert!((step(&matched) / step(&picture) - 1.0).abs() < 0.25, "{} {}", step(&matched), step(&picture));
            assert!(matches!(match_low(&mut matched, &low, 3, Kernel::Box), Err(Error::Low { .. })));
        }
    }

    /// Whatever was reduced, its own reduction lacks nothing, and what lies flat stays flat.
    #[test]
    fn pictures_are_reduced_as_the_kernel_says() {
        use selvedge_core::{Role, Samples, Seed};
        let (ratio, mut rng) = (4, Seed(5).rng());
        for kernel in [Kernel::Box, Kernel::Gauss, Kernel::Lanczos] {
            let fine = Domain { shape: [16, 24], periodic: [false, true] };
            let noise: Vec<f64> = (0..fine.len()).map(|_| f64::from(60 + rng.below(140))).collect();
            let coarse = Domain { shape: [4, 6], ..fine };
            let (mut rows, mut low) = (vec![0.0; 4 * 24], vec![0.0; coarse.len()]);
            let shares = kernel.shares(ratio);
            reduced(&noise, fine, (&mut rows, &mut low), (coarse, ratio, &shares));
            for (at, &found) in coarse.positions().zip(&low) {
                let seen = |axis: usize, by: i64| fine.nearest(axis, i64::from(at[axis] * ratio) + by);
                let along = |y: u32| shares.iter().map(move |(x, w)| (y, *x, *w));
                let all = shares.iter().flat_map(|(y, v)| along(seen(0, *y)).map(move |(y, x, w)| (y, x, v * w)));
                let expected: f64 = all.map(|(y, x, w)| w * noise[fine.index([y, seen(1, x)])]).sum();
                assert!((found - expected).abs() < 1e-9, "{kernel:?} {at:?}: {found} for {expected}");
            }
            // Rounded to whole numbers, what is lacking is half a level and a little of the last rounds.
            let of = |values: &[f64]| Samples::F32(Grid::from_vec(fine, 1, to_f32(values)).unwrap());
            let low = Plane::new(Role::Scalar, Samples::F32(Grid::from_vec(coarse, 1, to_f32(&low)).unwrap()));
            let mut flat = Plane::new(Role::Scalar, of(&vec![130.0; fine.len()]));
            let far = |plane: &Plane<2>| {
                let values: Vec<f64> = (0..fine.len()).map(|i| plane.samples.value(0, i)).collect();
                let (mut rows, mut seen) = (vec![0.0; 4 * 24], vec![0.0; coarse.len()]);
                reduced(&values, fine, (&mut rows, &mut seen), (coarse, ratio, &shares));
                seen.iter().enumerate().map(|(i, s)| (s - low.samples.value(0, i)).abs()).fold(0.0, f64::max)
            };
            let before = far(&flat);
            match_low(&mut flat, &low, ratio, kernel).unwrap();
            assert!(far(&flat) < 0.4 * before, "{kernel:?}: {} of {before}", far(&flat));
            let map = Grid::try_filled(Domain::open([9, 11]), 1, 77).unwrap();
            let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
            let same = super::averaged(&Source { features: map.clone(), valid: None, origin }, &kernel.weights(3));
            assert_eq!(same.unwrap(), map, "{kernel:?}");
        }
    }

    fn to_f32(values: &[f64]) -> Vec<f32> {
        values.iter().map(|&v| v as f32).collect()
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
