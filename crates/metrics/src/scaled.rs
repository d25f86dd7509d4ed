//! Pictures at half their size.

use crate::Error;
use selvedge_core::{Domain, Exemplars, Grid, Source};

/// Means of squares of four samples, rounded; an odd last row or column is left out, and an axis of odd length does not
/// wrap.
pub(crate) fn halved(grid: &Grid<u8, 2>) -> Result<Grid<u8, 2>, Error> {
    let mean = |four: [u8; 4]| (four.iter().map(|&v| u32::from(v)).sum::<u32>().div_ceil(2) / 2) as u8;
    by_fours(grid, 0, mean)
}

/// Exemplars at half their size; what is not valid throughout is not valid. Sources that vanish are left out.
pub(crate) fn halved_exemplars(exemplars: &Exemplars<2>) -> Result<Exemplars<2>, Error> {
    let mut sources = Vec::new();
    for source in exemplars.sources().iter().filter(|s| s.domain().shape.iter().all(|&n| 2 <= n)) {
        let valid = source.valid.as_deref().map(|v| by_fours(v, false, |four| four == [true; 4])).transpose()?;
        sources.push(Source {
            features: halved(&source.features)?,
            valid: valid.map(Into::into),
            origin: source.origin,
        });
    }
    Ok(Exemplars::from_sources(sources, exemplars.weights().to_vec())?)
}

fn by_fours<T: Copy>(grid: &Grid<T, 2>, fill: T, of: impl Fn([T; 4]) -> T) -> Result<Grid<T, 2>, Error> {
    let from = grid.domain();
    let whole = |axis: usize| from.periodic[axis] && from.shape[axis].is_multiple_of(2);
    let to = Domain { shape: from.shape.map(|n| n / 2), periodic: [whole(0), whole(1)] };
    let mut half = Grid::try_filled(to, grid.channels(), fill)?;
    let (w, width) = (to.shape[1] as usize, from.shape[1] as usize);
    for c in 0..grid.channels() {
        let plane = grid.plane(c);
        for (i, v) in half.plane_mut(c).iter_mut().enumerate() {
            let at = i / w.max(1) * 2 * width + i % w.max(1) * 2;
            *v = of([plane[at], plane[at + 1], plane[at + width], plane[at + width + 1]]);
        }
    }
    Ok(half)
}
