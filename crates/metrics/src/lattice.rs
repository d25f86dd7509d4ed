//! Whether the exemplar's periods are kept.

use crate::error::Error;
use selvedge_analysis::periods;
use selvedge_core::{Exemplars, Grid};

/// A period counts from this strength on, of 1000: weaker ones are chance resemblances of a few
/// large features, as [`feature_size`](selvedge_analysis::feature_size) has it.
const CLEAR: u32 = 300;

/// A period of the exemplar, and how strongly it is there.
pub(crate) struct Kept {
    vector: [i32; 2],
    strength: f64,
}

/// The strongest clear period of the first exemplar, and the strongest that goes another way.
pub(crate) fn lattice(exemplars: &Exemplars<2>) -> Result<Vec<Kept>, Error> {
    let Some(source) = exemplars.firsts().next() else { return Ok(Vec::new()) };
    let found = periods(&source.features, source.valid.as_deref(), exemplars.weights())?;
    let clear: Vec<_> = found.into_iter().filter(|p| CLEAR <= p.strength).collect();
    let Some(&first) = clear.first() else { return Ok(Vec::new()) };
    let other_way = |p: [i32; 2]| {
        let ([ay, ax], [by, bx]) = (first.vector.map(f64::from), p.map(f64::from));
        0.25 * (ax * ax + ay * ay).sqrt() * (bx * bx + by * by).sqrt() < (ax * by - ay * bx).abs()
    };
    let second = clear.iter().find(|p| other_way(p.vector)).copied();
    let both = std::iter::once(first).chain(second);
    Ok(both.map(|p| Kept { vector: p.vector, strength: f64::from(p.strength) / 1000.0 }).collect())
}

/// By how much the periods are weaker in an output, the largest loss; 0 without periods.
pub(crate) fn lost(lattice: &[Kept], output: &Grid<u8, 2>, weights: &[u8]) -> f64 {
    let loss = |kept: &Kept| strength(output, weights, kept.vector).map_or(0.0, |s| kept.strength - s);
    lattice.iter().map(loss).fold(0.0, f64::max)
}

/// 1 less the mean squared difference at a translation over twice the variance; `None` if flat or too small.
fn strength(output: &Grid<u8, 2>, weights: &[u8], by: [i32; 2]) -> Option<f64> {
    let domain = output.domain();
    let (mut squares, mut variance, mut n) = (0.0, 0.0, 0_u64);
    for (c, &w) in weights.iter().enumerate() {
        let plane = output.plane(c);
        let (mut sum, mut own, mut apart) = (0_u64, 0_u64, 0_u64);
        n = 0;
        for (i, at) in domain.positions().enumerate() {
            let v = u64::from(plane[i]);
            (sum, own) = (sum + v, own + v * v);
            if let Some(to) = domain.step(at, by) {
                n += 1;
                apart += u64::from(plane[i].abs_diff(plane[domain.index(to)])).pow(2);
            }
        }
        let all = domain.len() as f64;
        squares += f64::from(w) * apart as f64;
        variance += f64::from(w) * (own as f64 / all - (sum as f64 / all) * (sum as f64 / all));
    }
    (0.0 < variance && n != 0).then(|| 1.0 - squares / n as f64 / (2.0 * variance))
}
