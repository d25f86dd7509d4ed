//! What an output has to follow besides looking like the exemplars. `[Kwatra05 4]`

use selvedge_core::{Domain, Exemplars, Grid, SourceMap};

use crate::error::Error;
use crate::picture;

/// Most that a wish counts for where samples are halved together with some that are fixed: these hold only where all of
/// a coarse sample is fixed, but pull the others.
const MOST: f64 = 16.0;

/// Constraints, each in the output's shape.
#[derive(Clone, Debug, Default)]
pub struct Control {
    /// Colours that are wanted at some places.
    pub wanted: Option<Wanted>,
    /// Where this is true, what a run starts from stays to the sample; it has to start from a map.
    pub fixed: Option<Grid<bool, 2>>,
}

/// A soft constraint. `[Kwatra05 eq. 2]`
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Features as the exemplars have them.
    pub features: Grid<u8, 2>,
    /// `lambda`: how much each sample's wish counts, where all neighborhoods over it together count about 1; 0 for no
    /// wish.
    pub weight: Grid<f32, 2>,
}

/// Wishes at one resolution: `x_c`, and `lambda`, which is infinite where a sample is fixed.
#[derive(Clone, Debug)]
pub(crate) struct Wishes {
    pub(crate) colors: Grid<f64, 2>,
    pub(crate) weights: Grid<f64, 2>,
}

impl Control {
    /// As wishes at full resolution, with the map that fixed samples are taken from; `None` without any.
    pub(crate) fn wishes(
        &self,
        exemplars: &Exemplars<2>,
        output: Domain<2>,
        start: Option<&SourceMap<2>>,
    ) -> Result<Option<Wishes>, Error> {
        if self.wanted.is_none() && self.fixed.is_none() {
            return Ok(None);
        }
        let mut all = Wishes {
            colors: Grid::try_filled(output, exemplars.channels(), 0.0)?,
            weights: Grid::try_filled(output, 1, 0.0)?,
        };
        if let Some(Wanted { features, weight }) = &self.wanted {
            check("picture that is wanted", features, output, exemplars.channels())?;
            check("weights of what is wanted", weight, output, 1)?;
            if let Some(&lambda) = weight.samples().iter().find(|v| !(v.is_finite() && 0.0 <= **v)) {
                return Err(Error::Lambda { lambda });
            }
            all.colors = features.map(f64::from)?.with_periodic(output.periodic);
            all.weights = weight.map(f64::from)?.with_periodic(output.periodic);
        }
        if let Some(fixed) = &self.fixed {
            check("mask of fixed samples", fixed, output, 1)?;
            let shown = picture::shown(exemplars, start.ok_or(Error::NothingFixed)?)?;
            for i in (0..output.len()).filter(|&i| fixed.samples()[i]) {
                all.weights.plane_mut(0)[i] = f64::INFINITY;
                (0..exemplars.channels()).for_each(|c| all.colors.plane_mut(c)[i] = shown.plane(c)[i]);
            }
        }
        Ok(Some(all))
    }
}

fn check<T>(what: &'static str, grid: &Grid<T, 2>, output: Domain<2>, channels: usize) -> Result<(), Error> {
    let (found, expected) = (grid.domain().shape, output.shape);
    if found != expected || grid.channels() != channels {
        let [found, expected] =
            [(found, grid.channels()), (expected, channels)].map(|([h, w], c)| vec![h, w, c as u32]);
        return Err(Error::Control { what, expected, found });
    }
    Ok(())
}

impl Wishes {
    /// At half the size: colours by their weights, weights as means.
    pub(crate) fn coarser(&self) -> Result<Self, Error> {
        let (fine, coarse) = (self.weights.domain(), self.weights.domain().coarser());
        let mut out = Self {
            colors: Grid::try_filled(coarse, self.colors.channels(), 0.0)?,
            weights: Grid::try_filled(coarse, 1, 0.0)?,
        };
        for (i, at) in coarse.positions().enumerate() {
            let corners = [[0, 0], [0, 1], [1, 0], [1, 1]];
            let block: Vec<usize> =
                corners.into_iter().filter_map(|by| fine.step(at.map(|p| 2 * p), by).map(|p| fine.index(p))).collect();
            let finite = |weight: f64| if weight == f64::INFINITY { MOST } else { weight };
            let of = |j: usize| finite(self.weights.plane(0)[j]);
            let sum: f64 = block.iter().map(|&j| of(j)).sum();
            let is_fixed = block.iter().all(|&j| self.weights.plane(0)[j] == f64::INFINITY);
            out.weights.plane_mut(0)[i] = if is_fixed { f64::INFINITY } else { sum / block.len() as f64 };
            for c in (0..self.colors.channels()).filter(|_| 0.0 < sum) {
                let color: f64 = block.iter().map(|&j| of(j) * self.colors.plane(c)[j]).sum();
                out.colors.plane_mut(c)[i] = color / sum;
            }
        }
        Ok(out)
    }

    /// The E-step's other part: averages and wishes, weighed. `votes` are the weights of averages, about 1.
    /// `[Kwatra05 4]`
    pub(crate) fn weigh(&self, x: &mut Grid<f64, 2>, votes: Option<&Grid<f64, 2>>) {
        for c in 0..x.channels() {
            let wishes = self.colors.plane(c).iter().zip(self.weights.plane(0));
            for (i, (v, (&color, &weight))) in x.plane_mut(c).iter_mut().zip(wishes).enumerate() {
                let votes = votes.map_or(1.0, |votes| votes.plane(0)[i]);
                *v = if weight == f64::INFINITY { color } else { (votes * *v + weight * color) / (votes + weight) };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(values: &[f64]) -> Grid<f64, 2> {
        Grid::from_vec(Domain::open([1, values.len() as u32]), 1, values.to_vec()).unwrap()
    }

    #[test]
    fn wishes_are_least_squares_and_fixed_samples_are_exact() {
        let wishes = Wishes { colors: line(&[100.0, 50.0, 7.0]), weights: line(&[3.0, 0.0, f64::INFINITY]) };
        let mut x = line(&[20.0, 30.0, 40.0]);
        wishes.weigh(&mut x, Some(&line(&[2.0, 1.0, 1.0])));
        // 2 (x - 20)^2 + 3 (x - 100)^2 is least at 68.
        assert_eq!(x.samples(), [68.0, 30.0, 7.0]);
    }

    #[test]
    fn a_wish_means_the_same_at_every_resolution() {
        let inf = f64::INFINITY;
        let wishes =
            Wishes { colors: line(&[10.0, 30.0, 5.0, 99.0, 8.0, 4.0]), weights: line(&[1.0, 3.0, 2.0, 0.0, inf, inf]) };
        let coarse = wishes.coarser().unwrap();
        assert_eq!(coarse.colors.samples(), [25.0, 5.0, 6.0]);
        assert_eq!(coarse.weights.samples(), [2.0, 1.0, inf]);
    }
}
