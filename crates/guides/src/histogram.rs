//! A target with the exemplars' range.

use selvedge_core::{Grid, Guide};

use crate::Error;

/// The guide with each channel of its target changed so that its histogram is that of the channel under the exemplars'
/// valid samples: the target's darkest, middle and brightest parts ask for the exemplars' own. What of the target is
/// not asked for does not count.
///
/// A level becomes the exemplar level of the same rank, the rank of its middle sample.
///
/// # Errors
/// [`Error::Core`] if memory is short.
pub fn match_histogram<const D: usize>(guide: Guide<D>) -> Result<Guide<D>, Error> {
    let (mut target, asked) = (guide.target().map(|v| v)?, guide.asked().map(|asked| asked.map(|v| v)).transpose()?);
    for c in 0..target.channels() {
        let from = histogram(masked(target.plane(c), asked.as_ref().map(Grid::samples)));
        let maps = guide.exemplars().sources().iter();
        let to = histogram(maps.flat_map(|map| masked(map.features.plane(c), map.valid.as_deref().map(Grid::samples))));
        let table = by_rank(&from, &to);
        target.plane_mut(c).iter_mut().for_each(|v| *v = table[usize::from(*v)]);
    }
    let guide = guide.with_target(target)?;
    Ok(match asked {
        Some(asked) => guide.asking(asked)?,
        None => guide,
    })
}

/// The values that a mask lets through.
fn masked<'a>(values: &'a [u8], mask: Option<&'a [bool]>) -> impl Iterator<Item = u8> + 'a {
    values.iter().enumerate().filter(move |&(i, _)| mask.is_none_or(|mask| mask[i])).map(|(_, &v)| v)
}

type Histogram = [u64; 256];

fn histogram(values: impl Iterator<Item = u8>) -> Histogram {
    let mut counts = [0; 256];
    values.for_each(|v| counts[usize::from(v)] += 1);
    counts
}

/// For each level of `from` the level of `to` that holds the same rank.
fn by_rank(from: &Histogram, to: &Histogram) -> [u8; 256] {
    let (n_from, n_to) = (from.iter().sum::<u64>(), to.iter().sum::<u64>());
    let mut table = [0; 256];
    let (mut below, mut level, mut reached) = (0, 0, to[0]);
    for (value, &count) in from.iter().enumerate() {
        // Ranks in halves of a sample: (2 below + count) / (2 n_from) must lie under reached / n_to.
        let rank = u128::from(2 * below + count) * u128::from(n_to);
        while u128::from(2 * reached) * u128::from(n_from) < rank && level < 255 {
            level += 1;
            reached += to[level];
        }
        table[value] = level as u8;
        below += count;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Encoder, Exemplar, Exemplars, Plane, Role, Samples};

    fn matched(exemplar: &[u8], target: &[u8]) -> Vec<u8> {
        let row = |v: &[u8]| Grid::from_vec(Domain::open([1, v.len() as u32]), 1, v.to_vec()).unwrap();
        let plane = Plane::new(Role::Color, Samples::U8(row(exemplar)));
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let guide = Guide::new(&exemplars, &[row(exemplar)], row(target)).unwrap();
        match_histogram(guide).unwrap().target().samples().to_vec()
    }

    #[test]
    fn targets_take_the_exemplars_levels_by_rank() {
        assert_eq!(matched(&[100, 110, 120, 130], &[0, 255, 1, 2]), [100, 130, 110, 120]);
        assert_eq!(matched(&[50, 60], &[9, 3, 7, 1]), [60, 50, 60, 50]);
        assert_eq!(matched(&[50, 60, 90], &[9, 9]), [60, 60], "a constant asks for the middle");
        assert_eq!(matched(&[42], &[0, 255]), [42, 42]);
    }

    #[test]
    fn masked_samples_ask_for_nothing() {
        let row = |v: &[u8]| Grid::from_vec(Domain::open([1, v.len() as u32]), 1, v.to_vec()).unwrap();
        let exemplar = row(&[0, 100, 255, 120, 1]);
        let plane = [Plane::new(Role::Color, Samples::U8(exemplar.clone()))];
        let mask = exemplar.map(|v| (100..=120).contains(&v)).unwrap();
        let encoder = Encoder::fit(&[&plane[..]]).unwrap();
        let exemplars = Exemplars::new(&encoder, &[Exemplar::new(&plane).masked(Some(&mask))]).unwrap();
        let guide = Guide::new(&exemplars, &[exemplar], row(&[9, 200, 3, 255])).unwrap();
        assert_eq!(match_histogram(guide).unwrap().target().samples(), [100, 120, 100, 120]);
    }

    #[test]
    fn what_is_not_asked_for_asks_for_nothing() {
        let row = |v: &[u8]| Grid::from_vec(Domain::open([1, v.len() as u32]), 1, v.to_vec()).unwrap();
        let plane = Plane::new(Role::Color, Samples::U8(row(&[100, 110, 120, 130])));
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let guide = Guide::new(&exemplars, &[row(&[100, 110, 120, 130])], row(&[7, 0, 8, 9, 10, 0, 0])).unwrap();
        let asked = guide.target().map(|v| v != 0).unwrap();
        let matched = match_histogram(guide.asking(asked.clone()).unwrap()).unwrap();
        let levels = matched.target().samples();
        assert_eq!([levels[0], levels[2], levels[3], levels[4]], [100, 110, 120, 130]);
        assert_eq!(matched.asked(), Some(&asked));
    }

    #[test]
    fn equal_histograms_change_nothing() {
        let values: Vec<u8> = (0..255).map(|i| (i * 7 % 253) as u8).collect();
        assert_eq!(matched(&values, &values), values);
    }
}
