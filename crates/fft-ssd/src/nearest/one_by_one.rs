//! Window by window through the search at every position: for windows that cells do not tile, and errors beyond 32
//! bits.

use super::comparison::Comparison;
use super::scale::{Best as Scaled, factor};
use super::{Best, joined};
use crate::{Costs, Error, Options, Placement, Scratch, SsdSearcher, Template};
use selvedge_core::{Grid, SimdLevel, par, try_vec};
use std::sync::atomic::{AtomicU64, Ordering};

/// See [`super::walk::nearest`].
pub(super) fn nearest(comparison: Comparison<'_>, simd: SimdLevel) -> Result<Vec<Best>, Error> {
    // A search wraps a template even around what is smaller than it; a window stands nowhere there.
    let stands = !comparison.offered().is_empty();
    each(comparison, simd, |_, costs| costs.best().filter(|_| stands).map(|c| (c.error, c.position.map(|p| p as u32))))
}

/// See [`super::walk::least`].
pub(super) fn least(comparison: Comparison<'_>, simd: SimdLevel) -> Result<Vec<u64>, Error> {
    let over = comparison.offered();
    let least: Vec<AtomicU64> = (0..over.len()).map(|_| AtomicU64::new(u64::MAX)).collect();
    if !over.is_empty() {
        each(comparison, simd, |_, costs| {
            for c in costs.iter() {
                // The least of all is the same in any order.
                least[over.index(c.position.map(|p| p as u32))].fetch_min(c.error, Ordering::Relaxed);
            }
        })?;
    }
    Ok(least.into_iter().map(AtomicU64::into_inner).collect())
}

/// See [`super::walk::scaled`].
pub(super) fn scaled(
    comparison: Comparison<'_>,
    (least, added): (&[u64], f64),
    simd: SimdLevel,
) -> Result<Vec<Scaled>, Error> {
    let over = comparison.offered();
    if over.is_empty() {
        return Ok(vec![None; comparison.asked().len()]);
    }
    each(comparison, simd, |_, costs| {
        let all = costs.iter().map(|c| {
            let at = c.position.map(|p| p as u32);
            (c.error as f32 * factor(least[over.index(at)], added), at)
        });
        all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    })
}

/// See [`super::walk::alike`].
pub(super) fn alike(comparison: Comparison<'_>, error: u64, apart: u32, simd: SimdLevel) -> Result<Vec<u32>, Error> {
    let domain = comparison.picture.features.domain();
    each(comparison, simd, |at, costs| {
        let away = |axis: usize, to: i32| domain.apart(axis, at[axis], to as u32);
        let is_far = |p: [i32; 2]| apart <= away(0, p[0]).max(away(1, p[1]));
        costs.iter().filter(|c| c.error <= error && is_far(c.position)).count() as u32
    })
}

/// What `ask` makes of the costs of each window, told where it lies.
fn each<T: Send>(
    comparison: Comparison<'_>,
    simd: SimdLevel,
    ask: impl Fn([u32; 2], &Costs<2>) -> T + Sync + Send,
) -> Result<Vec<T>, Error> {
    let Comparison { picture, source, weights, windows } = comparison;
    let over = comparison.asked();
    let options = Options { simd, ..Options::default() };
    let searcher = SsdSearcher::of_grid(source.features, source.valid, weights, options)?;
    let row = |y: usize| {
        let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
        let side = windows.side as usize;
        let mut features = try_vec(side * side * weights.len(), 0)?;
        let mut mask = try_vec(side * side, true)?;
        let one = |x: usize| {
            let at = [y as u32, x as u32].map(|p| p * windows.step);
            cut(picture.features, at, side, &mut features);
            let template = Template::new([windows.side; 2], &features);
            let template = match picture.valid {
                None => template,
                Some(valid) => {
                    cut(valid, at, side, &mut mask);
                    template.masked(&mask)
                }
            };
            searcher.search(&template, Placement::INSIDE, &mut scratch, &mut costs)?;
            Ok(ask(at, &costs))
        };
        (0..over.shape[1] as usize).map(one).collect()
    };
    joined(par::map_indexed(over.shape[0] as usize, row), over.len())
}

/// A window of a grid, around periodic axes.
fn cut<T: Copy>(from: &Grid<T, 2>, at: [u32; 2], side: usize, to: &mut [T]) {
    let domain = from.domain();
    for (c, to) in to.chunks_mut(side * side).enumerate() {
        for (i, to) in to.iter_mut().enumerate() {
            let [y, x] = [0, 1].map(|a| (at[a] as usize + [i / side, i % side][a]) as u32 % domain.shape[a]);
            *to = from.get(c, [y, x]);
        }
    }
}
