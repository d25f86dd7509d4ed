//! The texture between levels: by a map, coarser, finer.

use selvedge_core::{Domain, Exemplars, Grid, SampleId, SourceMap};

use crate::Error;

/// What a map shows of the features.
pub(crate) fn shown(exemplars: &Exemplars<2>, map: &SourceMap<2>) -> Result<Grid<f64, 2>, Error> {
    let mut x = Grid::try_filled(map.domain(), exemplars.channels(), 0.0)?;
    for (at, &id) in map.domain().positions().zip(map.ids.plane(0)) {
        show(&mut x, exemplars, at, id);
    }
    Ok(x)
}

/// Shows a sample at a position; nothing changes where it is none.
pub(crate) fn show(x: &mut Grid<f64, 2>, exemplars: &Exemplars<2>, at: [u32; 2], id: SampleId) {
    let Some((source, from)) = exemplars.locate(id) else { return };
    let features = &exemplars.sources()[source].features;
    (0..exemplars.channels()).for_each(|c| x.set(c, at, f64::from(features.get(c, from))));
}

/// At half the size: means of what each coarse sample stands for.
pub(crate) fn coarser(x: &Grid<f64, 2>) -> Result<Grid<f64, 2>, Error> {
    let (fine, coarse) = (x.domain(), x.domain().coarser());
    let mut out = Grid::try_filled(coarse, x.channels(), 0.0)?;
    for c in 0..x.channels() {
        for (to, at) in out.plane_mut(c).iter_mut().zip(coarse.positions()) {
            let corners = [[0, 0], [0, 1], [1, 0], [1, 1]];
            let all = corners.into_iter().filter_map(|by| fine.step(at.map(|p| 2 * p), by));
            let (sum, n) = all.fold((0.0, 0.0), |(sum, n), at| (sum + x.get(c, at), n + 1.0));
            *to = sum / n;
        }
    }
    Ok(out)
}

/// At twice the size, for an output that [`Domain::coarser`] made this one of: interpolated linearly. `[Kwatra05 3.2]`
pub(crate) fn finer(x: &Grid<f64, 2>, output: Domain<2>) -> Result<Grid<f64, 2>, Error> {
    let coarse = x.domain();
    let mut out = Grid::try_filled(output, x.channels(), 0.0)?;
    // A fine sample lies a fourth of a coarse one from the middle of its own, towards a neighbour.
    let beside = |at: [u32; 2], axis: usize| {
        let by = if at[axis].is_multiple_of(2) { -1 } else { 1 };
        [at[axis] / 2, coarse.nearest(axis, i64::from(at[axis] / 2) + by)]
    };
    for c in 0..x.channels() {
        for (to, at) in out.plane_mut(c).iter_mut().zip(output.positions()) {
            let ([y, y2], [x1, x2]) = (beside(at, 0), beside(at, 1));
            let along = |y: u32| 0.75 * x.get(c, [y, x1]) + 0.25 * x.get(c, [y, x2]);
            *to = 0.75 * along(y) + 0.25 * along(y2);
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_stays_a_slope_between_levels() {
        let output = Domain::open([8, 11]);
        let values = output.positions().map(|[y, x]| f64::from(10 * y + 3 * x)).collect();
        let fine = Grid::from_vec(output, 1, values).unwrap();
        let coarse = coarser(&fine).unwrap();
        assert_eq!(coarse.domain(), output.coarser());
        assert_eq!(coarse.get(0, [1, 2]), 25.0 + 13.5);
        let again = finer(&coarse, output).unwrap();
        for at in [[2, 2], [5, 7], [3, 4]] {
            assert!((again.get(0, at) - fine.get(0, at)).abs() < 1e-12);
        }
    }

    #[test]
    fn periodic_axes_are_interpolated_around() {
        let coarse = Grid::from_vec(Domain::periodic([1, 4]), 1, vec![0.0, 8.0, 8.0, 16.0]).unwrap();
        let fine = finer(&coarse, Domain::periodic([1, 8])).unwrap();
        assert_eq!(fine.samples(), [4.0, 2.0, 6.0, 8.0, 8.0, 10.0, 14.0, 12.0]);
    }
}
