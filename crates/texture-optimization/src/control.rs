//! What an output has to follow besides looking like the exemplars. `[Kwatra05 4]`

use selvedge_core::{Bytes, Domain, Error as CoreError, Exemplars, Grid, Guidance, Guide, SourceMap};

use crate::error::Error;
use crate::picture;

/// Most that a wish counts for where samples are halved together with some that are fixed: these hold only where all of
/// a coarse sample is fixed, but pull the others.
const MOST: f64 = 16.0;

/// The largest weight: the texture counts a millionth, and sums of weighted colours stay numbers.
const LARGEST: f64 = 1e6;

/// Constraints, each in the output's shape.
#[derive(Clone, Debug, Default)]
pub struct Control {
    /// Colours that are wanted at some places.
    pub wanted: Option<Wanted>,
    /// Where this is true, what a run starts from stays to the sample; it has to start from a map.
    pub fixed: Option<Grid<bool, 2>>,
    /// What the output follows besides: channels that are searched, but not shown. `[Kwatra05 6]`
    ///
    /// Where the guide is not [asked](Guide::asked) for they are not known, and found together with the texture: there
    /// the guide costs nothing by itself, but what is found has to go on from what is asked for beside it. Searches
    /// have the weight in whole numbers: less than a 255th of the exemplars' heaviest channel cannot be said, and less
    /// than a 60th not with neighborhoods of 32 samples.
    pub guidance: Option<Guidance<2>>,
}

/// A soft constraint. `[Kwatra05 eq. 2]`
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Features as the exemplars have them.
    pub features: Grid<u8, 2>,
    /// `lambda`: how much each sample's wish counts, where all neighborhoods over it together count about 1; 0 for no
    /// wish, up to a million.
    pub weight: Grid<f32, 2>,
}

impl Wanted {
    /// Refuses a weight that is less than nothing, more than a million, or no number.
    ///
    /// # Errors
    /// Of the core [`Amount`](CoreError::Amount).
    pub fn check_lambda(lambda: f64) -> Result<(), Error> {
        let range = "0 (no wish) to 1000000 (nothing else)";
        let is_weight = (0.0..=LARGEST).contains(&lambda);
        if is_weight { Ok(()) } else { Err(CoreError::amount("a lambda", lambda, range).into()) }
    }
}

/// Wishes at one resolution: `x_c`, and `lambda`, which is infinite where a sample is fixed, or a guide known.
#[derive(Clone, Debug)]
pub(crate) struct Wishes {
    pub(crate) colors: Grid<f64, 2>,
    /// Of as many channels.
    pub(crate) weights: Grid<f64, 2>,
    /// Channels of the texture; those after them are a guide's.
    pub(crate) texture: usize,
}

impl Control {
    /// A guide that counts anything.
    pub(crate) fn followed(&self) -> Option<&Guidance<2>> {
        self.guidance.as_ref().filter(|guidance| guidance.weight != 0.0)
    }

    /// What a run holds of this beside its [`estimate`](crate::estimate()), which counts the channels of a guide among
    /// the exemplars': wishes at all resolutions, what is fixed of the start, and the exemplars with the guide beside
    /// them.
    pub fn bytes(&self, exemplars: &Exemplars<2>, output: Domain<2>) -> Bytes {
        let guide = self.followed().map_or(0, |guidance| guidance.guide.weights().len());
        let channels = (exemplars.channels() + guide) as u64;
        let joined = if guide == 0 { 0 } else { channels + 1 };
        let features = exemplars.sources().iter().map(|source| Bytes::of_samples(source.domain(), joined)).sum();
        let wishes = if self.wanted.is_none() && self.fixed.is_none() && guide == 0 { 0 } else { 22 * channels };
        let shown = if self.fixed.is_some() { 8 * channels } else { 0 };
        Bytes::of_samples(output, wishes + shown) + features
    }

    /// As wishes at full resolution, with the map that fixed samples are taken from; `None` without any. The exemplars'
    /// last channels are the guide's.
    pub(crate) fn wishes(
        &self,
        exemplars: &Exemplars<2>,
        output: Domain<2>,
        start: Option<&SourceMap<2>>,
    ) -> Result<Option<Wishes>, Error> {
        let guide = self.followed().map(|guidance| &guidance.guide);
        if self.wanted.is_none() && self.fixed.is_none() && guide.is_none() {
            return Ok(None);
        }
        let channels = exemplars.channels();
        let texture = channels - guide.map_or(0, |guide| guide.weights().len());
        let none = || Grid::try_filled(output, channels, 0.0);
        let mut all = Wishes { colors: none()?, weights: none()?, texture };
        if let Some(wanted) = &self.wanted {
            all.want(wanted)?;
        }
        if let Some(guide) = guide {
            all.follow(guide)?;
        }
        if let Some(fixed) = &self.fixed {
            check("mask of fixed samples", fixed, output, 1)?;
            let shown = picture::shown(exemplars, start.ok_or(Error::NothingFixed)?)?;
            for c in 0..channels {
                all.fix(c, shown.plane(c), |i| fixed.samples()[i]);
            }
        }
        Ok(Some(all))
    }
}

/// Refuses what does not lie over the output.
pub(crate) fn check<T>(what: &'static str, grid: &Grid<T, 2>, output: Domain<2>, channels: usize) -> Result<(), Error> {
    let (found, expected) = (grid.domain().shape, output.shape);
    if found != expected || grid.channels() != channels {
        let [found, expected] =
            [(found, grid.channels()), (expected, channels)].map(|([h, w], c)| vec![h, w, c as u32]);
        return Err(Error::Control { what, expected, found });
    }
    Ok(())
}

impl Wishes {
    /// Wishes for the texture's channels.
    fn want(&mut self, Wanted { features, weight }: &Wanted) -> Result<(), Error> {
        let (output, channels) = (self.colors.domain(), self.texture);
        check("picture that is wanted", features, output, channels)?;
        check("weights of what is wanted", weight, output, 1)?;
        weight.samples().iter().try_for_each(|&lambda| Wanted::check_lambda(lambda.into()))?;
        for c in 0..channels {
            self.colors.plane_mut(c).iter_mut().zip(features.plane(c)).for_each(|(v, &color)| *v = color.into());
            self.weights.plane_mut(c).iter_mut().zip(weight.samples()).for_each(|(v, &lambda)| *v = lambda.into());
        }
        Ok(())
    }

    /// What is known of the guide's channels.
    fn follow(&mut self, guide: &Guide<2>) -> Result<(), Error> {
        let first = self.texture;
        check("picture that is followed", guide.target(), self.colors.domain(), self.colors.channels() - first)?;
        for c in 0..guide.weights().len() {
            let target: Vec<f64> = guide.target().plane(c).iter().map(|&v| f64::from(v)).collect();
            self.fix(first + c, &target, |i| guide.asked().is_none_or(|asked| asked.samples()[i]));
        }
        Ok(())
    }

    fn fix(&mut self, c: usize, colors: &[f64], is_fixed: impl Fn(usize) -> bool) {
        let own = self.colors.plane_mut(c).iter_mut().zip(self.weights.plane_mut(c)).zip(colors).enumerate();
        for (_, ((v, weight), color)) in own.filter(|(i, _)| is_fixed(*i)) {
            (*v, *weight) = (*color, f64::INFINITY);
        }
    }

    /// At half the size: colours by their weights, weights as means.
    pub(crate) fn coarser(&self) -> Result<Self, Error> {
        let (fine, coarse) = (self.weights.domain(), self.weights.domain().coarser());
        let channels = self.colors.channels();
        let none = || Grid::try_filled(coarse, channels, 0.0);
        let mut out = Self { colors: none()?, weights: none()?, texture: self.texture };
        for (i, at) in coarse.positions().enumerate() {
            let corners = [[0, 0], [0, 1], [1, 0], [1, 1]];
            let block: Vec<usize> =
                corners.into_iter().filter_map(|by| fine.step(at.map(|p| 2 * p), by).map(|p| fine.index(p))).collect();
            for c in 0..channels {
                let (colors, weights) = (self.colors.plane(c), self.weights.plane(c));
                let of = |j: usize| if weights[j] == f64::INFINITY { MOST } else { weights[j] };
                let sum: f64 = block.iter().map(|&j| of(j)).sum();
                let is_fixed = block.iter().all(|&j| weights[j] == f64::INFINITY);
                out.weights.plane_mut(c)[i] = if is_fixed { f64::INFINITY } else { sum / block.len() as f64 };
                if 0.0 < sum {
                    let color: f64 = block.iter().map(|&j| of(j) * colors[j]).sum();
                    out.colors.plane_mut(c)[i] = color / sum;
                }
            }
        }
        Ok(out)
    }

    /// The E-step's other part: averages and wishes, weighed. `votes` are the weights of averages, about 1.
    /// `[Kwatra05 4]`
    pub(crate) fn weigh(&self, x: &mut Grid<f64, 2>, votes: Option<&Grid<f64, 2>>) {
        for c in 0..x.channels() {
            let wishes = self.colors.plane(c).iter().zip(self.weights.plane(c));
            for (i, (v, (&color, &weight))) in x.plane_mut(c).iter_mut().zip(wishes).enumerate() {
                let votes = votes.map_or(1.0, |votes| votes.plane(0)[i]);
                *v = if weight == f64::INFINITY { color } else { (votes * *v + weight * color) / (votes + weight) };
            }
        }
    }

    /// Shows what is known at a position.
    pub(crate) fn show(&self, x: &mut Grid<f64, 2>, at: [u32; 2]) {
        let i = self.colors.domain().index(at);
        for c in (0..x.channels()).filter(|&c| self.weights.plane(c)[i] == f64::INFINITY) {
            x.plane_mut(c)[i] = self.colors.plane(c)[i];
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
        let wishes =
            Wishes { colors: line(&[100.0, 50.0, 7.0]), weights: line(&[3.0, 0.0, f64::INFINITY]), texture: 1 };
        let mut x = line(&[20.0, 30.0, 40.0]);
        wishes.weigh(&mut x, Some(&line(&[2.0, 1.0, 1.0])));
        // 2 (x - 20)^2 + 3 (x - 100)^2 is least at 68.
        assert_eq!(x.samples(), [68.0, 30.0, 7.0]);
    }

    #[test]
    fn a_wish_means_the_same_at_every_resolution() {
        let inf = f64::INFINITY;
        let (colors, weights) = (line(&[10.0, 30.0, 5.0, 99.0, 8.0, 4.0]), line(&[1.0, 3.0, 2.0, 0.0, inf, inf]));
        let wishes = Wishes { colors, weights, texture: 1 };
        let coarse = wishes.coarser().unwrap();
        assert_eq!(coarse.colors.samples(), [25.0, 5.0, 6.0]);
        assert_eq!(coarse.weights.samples(), [2.0, 1.0, inf]);
    }
}
