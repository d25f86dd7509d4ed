//! How far what moved is still a texture, so far as it is wished for.
//!
//! Where a flow tears a texture apart, or stretches it, the wish for what moved is the wish for what no exemplar has:
//! it would hold the tear open, frame after frame. So a wish counts by how well what moved fits at the places that it
//! came from; where it does not, the texture closes by itself.

use selvedge_core::{Error, Exemplars, par};

use super::carry::Carried;
use crate::control::Wishes;
use crate::gradient::seen;
use crate::neighborhoods::Neighborhoods;
use crate::search::Listed;

/// Lowers the weights of wishes that do not fit; `usual` is how far neighborhoods were in the mean of the first frame
/// that moved, which is answered where it is not known yet. `size` is that of neighborhoods that fit: the smallest tell
/// a tear from what is beside it.
pub(super) fn trusted(
    exemplars: &Exemplars<2>,
    (carried, size): (&Carried, u32),
    wishes: &mut Wishes,
    usual: Option<f64>,
) -> Result<f64, Error> {
    let domain = wishes.colors.domain();
    let all = Neighborhoods::new(domain, size);
    let (seen, listed) = (seen(&wishes.colors, None)?, Listed::new(exemplars, exemplars.weights().to_vec(), &all)?);
    let weights: u64 = exemplars.weights().iter().map(|&w| u64::from(w)).sum();
    let compared = (u64::from(size * size) * weights).max(1) as f64;
    let distances = par::map_indexed(all.len(), |number| {
        let mut candidates = carried.offered(exemplars, all.first(number), size);
        candidates.retain(|place| listed.holds(*place));
        let best = listed.best(&seen, number, &candidates, |_, error| error as f64);
        best.map_or(f64::INFINITY, |best| best.error as f64 / compared)
    });
    let known: Vec<f64> = distances.iter().copied().filter(|d| d.is_finite()).collect();
    let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
    let usual = usual.unwrap_or(mean);
    let fit = |distance: &f64| {
        let fit = ((usual + 1.0) / (distance + 1.0)).min(1.0);
        fit * fit
    };
    let fits: Vec<f64> = distances.iter().map(fit).collect();
    let columns = all.shape()[1];
    let trust = par::map_indexed(domain.len(), |i| {
        let [y, x] = domain.position(i);
        let (mut sum, mut n) = (0.0, 0.0);
        for (j, _) in all.holding(0, y) {
            for (i, _) in all.holding(1, x) {
                (sum, n) = (sum + fits[j * columns + i], n + 1.0);
            }
        }
        sum / n
    });
    for c in 0..wishes.weights.channels() {
        wishes.weights.plane_mut(c).iter_mut().zip(&trust).for_each(|(weight, trust)| *weight *= trust);
    }
    Ok(mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::exemplars;
    use selvedge_core::{Direction, Domain, Flow, Grid, Seed, SourceMap};

    #[test]
    fn a_tear_is_not_wished_for() {
        let exemplars = exemplars(&mut Seed(3).rng(), [40, 44], false);
        let output = Domain::open([24, 40]);
        let mut map = SourceMap::unassigned(&exemplars, output).unwrap();
        // The right half goes on from elsewhere.
        let id = |[y, x]: [u32; 2]| exemplars.table().id(0, if x < 20 { [y, x] } else { [y + 9, x] });
        output.positions().for_each(|at| map.ids.set(0, at, id(at)));
        let still = Flow { by: Grid::try_filled(output, 2, 0.0).unwrap(), known: None };
        let origins = still.came_from(Direction::Forward).unwrap();
        let carried = Carried::of(&map).unwrap().moved(&origins).unwrap();
        let none = Grid::try_filled(output, 2, 0.0).unwrap();
        let (mut wishes, _) = carried.wishes(&exemplars, (&origins, 0.5), &none).unwrap();
        let mean = trusted(&exemplars, (&carried, 8), &mut wishes, Some(0.0)).unwrap();
        assert!(1.0 < mean, "{mean}");
        for at in output.positions() {
            let weight = wishes.weights.get(0, at);
            match at[1].abs_diff(20).min(at[1].abs_diff(19)) {
                // All but a fourth of what lies over it.
                0 => assert!(weight < 0.25, "{at:?}: {weight}"),
                // No neighborhood over it reaches the tear.
                6.. => assert_eq!(weight, 0.5, "{at:?}"),
                _ => assert!(weight < 0.5, "{at:?}: {weight}"),
            }
        }
    }
}
