//! Where pictures lie over each other, and which of them is preferred.

use selvedge_core::{Bytes, Domain, Exemplars, Grid, SeamCosts, SimdLevel};
use selvedge_fft_ssd::{Costs, Options, Placement, Scratch, Sizes, SsdSearcher, Template};

use crate::error::Error;
use crate::labels::label::Label;

/// Overlaps of less than one in so many samples agree by chance: the least mean difference of all would be that of a
/// few flat samples in a corner. A guess.
const ONE_IN: u64 = 8;

/// The label by which a source agrees best with another that lies at 0: the translation of the least mean squared
/// difference over their overlap, of those that overlap by an eighth of the smaller one. `[Kwatra03 eq. 2]`
///
/// `None` where no translation does.
///
/// # Errors
/// [`Error::Search`].
pub fn aligned<const D: usize>(
    exemplars: &Exemplars<D>,
    under: usize,
    over: usize,
    simd: SimdLevel,
) -> Result<Option<Label<D>>, Error> {
    let [below, above] = [under, over].map(|s| &exemplars.sources()[s]);
    let options = Options { simd, ..Options::default() };
    let searcher = SsdSearcher::of_grid(&below.features, below.valid.as_deref(), exemplars.weights(), options)?;
    let template = Template::of(&above.features);
    let template = above.valid.as_deref().map_or(template, |valid| template.masked(valid.samples()));
    let (low, high) = (below.domain().shape, above.domain().shape);
    let first = high.map(|n| 1 - n as i32);
    let count = std::array::from_fn(|a| low[a] + high[a] - 1);
    let least = (below.domain().len().min(above.domain().len()) as u64).div_ceil(ONE_IN);
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    searcher.search_box(&template, first, count, least, &mut scratch, &mut costs)?;
    Ok(costs.best().map(|best| Label { source: over, offset: best.position }))
}

/// An upper bound of the bytes that [`aligned`] holds besides the exemplars themselves.
pub fn estimate_aligned<const D: usize>(under: Domain<D>, over: Domain<D>, channels: usize) -> Bytes {
    let (template, weights) = (over.shape, vec![u8::MAX; channels]);
    let sizes = Sizes {
        sources: &[under],
        weights: &weights,
        holes: true,
        template,
        samples: over.len() as u64,
        noisy_masks: true,
    };
    let overlapping = Placement::overlapping((under.len().min(over.len()) as u64).div_ceil(ONE_IN));
    selvedge_fft_ssd::estimate(&sizes, overlapping, &Options::default()).unwrap_or(Bytes::MOST)
}

/// What of several labels is wanted at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Prefer {
    /// What most have: those who pass by are left out.
    Median,
    /// The one in focus: the largest differences to neighbours, over 5 samples along each axis.
    Sharpest,
    /// The lightest.
    Brightest,
    /// The darkest.
    Darkest,
}

/// A grey level less than the best of all costs what it would as a difference on one side of a seam. With a fourth of
/// it, a person in one of five photographs stayed.
const A_LEVEL: i32 = SeamCosts::<2>::SCALE as i32;

/// Prices of labels by themselves ([`LabelOptions::own`](crate::labels::LabelOptions::own)): nothing where a label is
/// the best of all that are defined there, else by how much it is worse.
///
/// # Errors
/// [`Error::Core`] if memory is short.
pub fn preferred<const D: usize>(
    exemplars: &Exemplars<D>,
    labels: &[Label<D>],
    output: Domain<D>,
    prefer: Prefer,
) -> Result<Grid<i32, D>, Error> {
    let mut prices = Grid::try_filled(output, labels.len(), 0_i32)?;
    let channels = exemplars.channels();
    let mut here: Vec<(usize, Vec<i32>)> = Vec::new();
    for (place, at) in output.positions().enumerate() {
        here.clear();
        for (number, label) in labels.iter().enumerate() {
            let source = &exemplars.sources()[label.source];
            let from = source.domain().step([0; D], std::array::from_fn(|a| at[a] as i32 - label.offset[a]));
            let Some(from) = from.filter(|&from| source.valid.as_deref().is_none_or(|v| v.get(0, from))) else {
                continue;
            };
            let values = match prefer {
                Prefer::Sharpest => vec![sharpness(&source.features, from)],
                _ => (0..channels).map(|c| i32::from(source.features.get(c, from))).collect(),
            };
            here.push((number, values));
        }
        let worth = |values: &Vec<i32>| match prefer {
            Prefer::Median => {
                let middle = |c: usize| {
                    let mut all: Vec<i32> = here.iter().map(|(_, v)| v[c]).collect();
                    all.sort_unstable();
                    all[(all.len() - 1) / 2]
                };
                -values.iter().enumerate().map(|(c, v)| (v - middle(c)).abs()).sum::<i32>() / channels as i32
            }
            Prefer::Sharpest => values[0],
            Prefer::Brightest => values.iter().sum::<i32>() / channels as i32,
            Prefer::Darkest => -values.iter().sum::<i32>() / channels as i32,
        };
        let worths: Vec<(usize, i32)> = here.iter().map(|(number, values)| (*number, worth(values))).collect();
        let best = worths.iter().map(|w| w.1).max().unwrap_or(0);
        for (number, worth) in worths {
            prices.plane_mut(number)[place] = A_LEVEL * (best - worth);
        }
    }
    Ok(prices)
}

/// Mean absolute differences of neighbours around a position.
fn sharpness<const D: usize>(features: &Grid<u8, D>, at: [u32; D]) -> i32 {
    let (domain, mut sum, mut count) = (features.domain(), 0, 0);
    for step in Domain::<D>::open([5; D]).positions() {
        let Some(here) = domain.step(at, step.map(|s| s as i32 - 2)) else { continue };
        for axis in 0..D {
            let Some(next) = domain.next(here, axis) else { continue };
            for c in 0..features.channels() {
                sum += i32::from(features.get(c, here).abs_diff(features.get(c, next)));
                count += 1;
            }
        }
    }
    sum / count.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Origin, Seed, Source, Transform};

    fn exemplars(pictures: Vec<Grid<u8, 2>>) -> Exemplars<2> {
        let source = |(exemplar, features): (usize, Grid<u8, 2>)| Source {
            features,
            valid: None,
            origin: Origin { exemplar: exemplar as u16, transform: Transform::IDENTITY },
        };
        Exemplars::from_sources(pictures.into_iter().enumerate().map(source).collect(), vec![1]).unwrap()
    }

    #[test]
    fn pictures_are_laid_where_they_agree() {
        let mut rng = Seed(1).rng();
        let world: Vec<u8> = (0..40 * 50).map(|_| rng.below(256) as u8).collect();
        let part = |y: u32, x: u32, shape: [u32; 2]| {
            let domain = Domain::open(shape);
            let value = |[v, u]: [u32; 2]| world[((y + v) * 50 + x + u) as usize];
            Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap()
        };
        let e = exemplars(vec![part(5, 4, [30, 24]), part(0, 16, [28, 30])]);
        let found = aligned(&e, 0, 1, SimdLevel::Auto).unwrap();
        assert_eq!(found, Some(Label { source: 1, offset: [-5, 12] }));
    }

    #[test]
    fn what_is_wanted_costs_nothing() {
        let flat = |v: u8| Grid::try_filled(Domain::open([3, 3]), 1, v).unwrap();
        let mut stripes = flat(90);
        (0..9).step_by(2).for_each(|i| stripes.plane_mut(0)[i] = 110);
        let e = exemplars(vec![flat(10), flat(100), stripes, flat(200)]);
        let labels: Vec<Label<2>> = (0..4).map(|source| Label { source, offset: [0, 0] }).collect();
        let free = |prefer: Prefer| -> Vec<usize> {
            let prices = preferred(&e, &labels, Domain::open([3, 3]), prefer).unwrap();
            (0..4).filter(|&l| prices.get(l, [1, 0]) == 0).collect()
        };
        assert_eq!(free(Prefer::Darkest), [0]);
        assert_eq!(free(Prefer::Brightest), [3]);
        assert_eq!(free(Prefer::Sharpest), [2]);
        assert_eq!(free(Prefer::Median), [2], "90 of 10, 90, 100, 200");
    }
}
