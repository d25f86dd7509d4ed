//! Where pictures lie over each other.

use selvedge_core::{Bytes, Domain, Exemplars, SimdLevel};
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

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Grid, Origin, Seed, Source, Transform};

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
}
