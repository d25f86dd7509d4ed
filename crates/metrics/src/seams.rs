//! Columns of the source map.

use crate::{Error, Seams};
use selvedge_core::{Exemplars, SampleId, SeamCosts, SeamMeasure, Seed, SourceMap, try_vec};

/// Chance meetings whose mean price is the unit of seams: by so many it is known to one or two percent.
const MEETINGS: u64 = 4096;

/// Exemplars prepared for the price of seams.
pub(crate) struct Prices {
    difference: SeamCosts<2>,
    gradient: SeamCosts<2>,
    /// Mean prices of chance meetings.
    chance: [f64; 2],
    /// Mean norm of the difference of samples two apart.
    step: f64,
    valid: u64,
}

impl Prices {
    pub(crate) fn new(exemplars: &Exemplars<2>) -> Result<Self, Error> {
        let difference = SeamCosts::new(exemplars, SeamMeasure::Difference)?;
        let gradient = SeamCosts::new(exemplars, SeamMeasure::Gradient)?;
        let table = exemplars.table();
        let is_valid = |id: SampleId| {
            let (source, at) = table.locate(id)?;
            exemplars.sources()[source].valid.as_deref().is_none_or(|v| v.get(0, at)).then_some(())
        };
        let valid: Vec<SampleId> = (0..table.len()).map(SampleId::new).filter(|&id| is_valid(id).is_some()).collect();
        let drawn = |i: u64| valid[Seed(0).derive("metrics/meeting", i).rng().below(valid.len() as u32) as usize];
        let mean = |costs: &SeamCosts<2>| {
            let one = |i: u64| f64::from(costs.between((i % 2) as usize, drawn(2 * i), drawn(2 * i + 1)));
            // One grey level at least: flat exemplars divide nothing by 0.
            ((0..MEETINGS).map(one).sum::<f64>() / MEETINGS as f64).max(f64::from(SeamCosts::<2>::SCALE))
        };
        let chance = [mean(&difference), mean(&gradient)];
        let one =
            |i: u64| slope(&difference, drawn(i), (i % 2) as usize).map(|[a, b]| f64::from(difference.norm(a, b)));
        let steps: Vec<f64> = (0..MEETINGS).filter_map(one).collect();
        let step = crate::windows::mean(&steps).max(f64::from(SeamCosts::<2>::SCALE));
        Ok(Self { difference, gradient, chance, step, valid: valid.len() as u64 })
    }

    pub(crate) fn of(&self, map: &SourceMap<2>) -> Result<Seams, Error> {
        let mut used = try_vec(map.table.len() as usize, false)?;
        let (mut seams, mut colour, mut gradient, mut torn) = (0_u64, 0_u64, 0_u64, 0_u64);
        let domain = map.domain();
        for at in domain.positions() {
            let here = map.ids.get(0, at);
            if !here.is_assigned() {
                continue;
            }
            used[here.get() as usize] = true;
            for axis in 0..2 {
                let Some(there) = domain.next(at, axis).map(|n| map.ids.get(0, n)) else { continue };
                if !there.is_assigned() || self.difference.continued(here, 2 * axis) == Some(there) {
                    continue;
                }
                seams += 1;
                colour += self.difference.between(axis, here, there) as u64;
                gradient += self.gradient.between(axis, here, there) as u64;
                torn += self.torn(axis, here, there);
            }
        }
        let (n, each) = (domain.len().max(1) as f64, seams.max(1) as f64);
        Ok(Seams {
            colour: colour as f64 / each / self.chance[0],
            gradient: gradient as f64 / each / self.chance[1],
            energy: 100.0 * colour as f64 / n / self.chance[0],
            torn: torn as f64 / n / self.step,
            density: seams as f64 / n,
            used: used.iter().filter(|&&u| u).count() as f64 / self.valid.max(1) as f64,
        })
    }

    /// How much the slopes along a seam differ between the patch that ends here and the one that begins there: at the
    /// sample beyond the seam. Slopes of different sign are an edge that ends and another that begins.
    fn torn(&self, axis: usize, here: SampleId, there: SampleId) -> u64 {
        let Some(beyond) = self.difference.continued(here, 2 * axis) else { return 0 };
        let (Some(a), Some(b)) = (slope(&self.difference, beyond, 1 - axis), slope(&self.difference, there, 1 - axis))
        else {
            return 0;
        };
        // |a - b| of vectors, from norms alone: at least the difference of their lengths, and of crossed ends.
        let n = |x: SampleId, y: SampleId| u64::from(self.difference.norm(x, y));
        let (straight, crossed) = (n(a[0], b[0]) + n(a[1], b[1]), n(a[0], b[1]) + n(a[1], b[0]));
        n(a[0], a[1]).abs_diff(n(b[0], b[1])).max(straight.saturating_sub(crossed) / 2)
    }
}

/// The samples before and after one along an axis.
fn slope(costs: &SeamCosts<2>, id: SampleId, axis: usize) -> Option<[SampleId; 2]> {
    Some([costs.continued(id, 2 * axis + 1)?, costs.continued(id, 2 * axis)?])
}
