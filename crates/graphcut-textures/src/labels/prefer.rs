//! Which of several labels is preferred at a place, as far as seams allow it.

use selvedge_core::{Domain, Exemplars, Grid, SeamCosts};

use crate::error::Error;
use crate::labels::label::Label;

/// What of several labels is wanted at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Prefer {
    /// What most have: those who pass by are left out.
    Median,
    /// The one in focus: the largest differences to neighbours, over 5 samples along both axes of space. Differences in
    /// time are none: what flickers is not in focus.
    Sharpest,
    /// The lightest.
    Brightest,
    /// The darkest.
    Darkest,
}

/// A grey level less than the best of all costs what it would as a difference on one side of a seam. With a fourth of
/// it, a person in one of five photographs stayed.
const A_LEVEL: i32 = SeamCosts::<2>::SCALE as i32;

/// Pictures that differ by so many levels show something else, however much they differ. By their distance from the
/// median alone, five photographs of a busy square kept six people: two coats of one colour are a median.
const FAR: i32 = 30;

/// Prices of labels by themselves ([`LabelOptions::own`](crate::labels::LabelOptions::own)): nothing where a label is
/// the best of all that are defined there, else by how much it is worse.
///
/// # Errors
/// [`Error::Core`] if memory is short.
///
/// # Complexity
/// Time `O(samples * labels)`, for [`Prefer::Median`] `O(samples * labels^2)`.
pub fn preferred<const D: usize>(
    exemplars: &Exemplars<D>,
    labels: &[Label<D>],
    output: Domain<D>,
    prefer: Prefer,
) -> Result<Grid<i32, D>, Error> {
    let mut prices = Grid::try_filled(output, labels.len(), 0_i32)?;
    let (mut here, mut worths) = (Here::default(), Vec::new());
    for (place, at) in output.positions().enumerate() {
        here.look(exemplars, labels, at, prefer);
        worths.clear();
        worths.extend((0..here.numbers.len()).map(|i| here.worth(i, prefer)));
        let best = worths.iter().copied().max().unwrap_or(0);
        for (number, worth) in here.numbers.iter().zip(&worths) {
            prices.plane_mut(*number)[place] = best - worth;
        }
    }
    Ok(prices)
}

/// The labels that are defined at a place.
#[derive(Default)]
struct Here {
    numbers: Vec<usize>,
    /// What they have there, label by label.
    values: Vec<i32>,
    channels: usize,
    /// The median of each channel.
    middle: Vec<i32>,
    sorted: Vec<i32>,
}

impl Here {
    fn look<const D: usize>(&mut self, exemplars: &Exemplars<D>, labels: &[Label<D>], at: [u32; D], prefer: Prefer) {
        self.channels = if prefer == Prefer::Sharpest { 1 } else { exemplars.channels() };
        self.numbers.clear();
        self.values.clear();
        for (number, label) in labels.iter().enumerate() {
            let source = &exemplars.sources()[label.source];
            let from = source.domain().step([0; D], std::array::from_fn(|a| at[a] as i32 - label.offset[a]));
            let Some(from) = from.filter(|&from| source.valid.as_deref().is_none_or(|v| v.get(0, from))) else {
                continue;
            };
            self.numbers.push(number);
            match prefer {
                Prefer::Sharpest => self.values.push(sharpness(&source.features, from)),
                _ => self.values.extend((0..self.channels).map(|c| i32::from(source.features.get(c, from)))),
            }
        }
        if prefer == Prefer::Median {
            self.find_middle();
        }
    }

    fn find_middle(&mut self) {
        self.middle.clear();
        for c in 0..self.channels {
            self.sorted.clear();
            self.sorted.extend(self.values.iter().skip(c).step_by(self.channels));
            self.sorted.sort_unstable();
            self.middle.extend(self.sorted.get(self.sorted.len().saturating_sub(1) / 2));
        }
    }

    fn worth(&self, i: usize, prefer: Prefer) -> i32 {
        let own = &self.values[i * self.channels..(i + 1) * self.channels];
        let mean = own.iter().sum::<i32>() / self.channels.max(1) as i32;
        match prefer {
            Prefer::Median => {
                let unlike = self.values.chunks(self.channels.max(1)).map(|other| distance(own, other).min(FAR));
                // Of those that are as like the others the one nearest to the median.
                -A_LEVEL * unlike.sum::<i32>() - distance(own, &self.middle)
            }
            Prefer::Sharpest | Prefer::Brightest => A_LEVEL * mean,
            Prefer::Darkest => -A_LEVEL * mean,
        }
    }
}

/// The mean absolute difference of channels.
fn distance(a: &[i32], b: &[i32]) -> i32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<i32>() / a.len().max(1) as i32
}

/// Mean absolute differences of neighbours around a position, in space: the last two axes.
fn sharpness<const D: usize>(features: &Grid<u8, D>, at: [u32; D]) -> i32 {
    let (domain, mut sum, mut count) = (features.domain(), 0, 0);
    let in_space = D.saturating_sub(2)..D;
    let around = std::array::from_fn(|axis| if in_space.contains(&axis) { 5 } else { 1 });
    for step in Domain::<D>::open(around).positions() {
        let from = |axis: usize| step[axis] as i32 - around[axis] as i32 / 2;
        let Some(here) = domain.step(at, std::array::from_fn(from)) else { continue };
        for axis in in_space.clone() {
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
    use selvedge_core::{Origin, Source, Transform};

    fn prices(pictures: Vec<Grid<u8, 2>>, prefer: Prefer) -> Grid<i32, 2> {
        let domain = pictures[0].domain();
        let labels: Vec<Label<2>> = (0..pictures.len()).map(|source| Label { source, offset: [0, 0] }).collect();
        let source = |(exemplar, features): (usize, Grid<u8, 2>)| Source {
            features,
            valid: None,
            origin: Origin { exemplar: exemplar as u16, transform: Transform::IDENTITY },
        };
        let sources = pictures.into_iter().enumerate().map(source).collect();
        preferred(&Exemplars::from_sources(sources, vec![1]).unwrap(), &labels, domain, prefer).unwrap()
    }

    fn flat(v: u8) -> Grid<u8, 2> {
        Grid::try_filled(Domain::open([3, 3]), 1, v).unwrap()
    }

    #[test]
    fn what_is_wanted_costs_nothing() {
        let free = |prefer: Prefer| -> Vec<usize> {
            let mut stripes = flat(90);
            (0..9).step_by(2).for_each(|i| stripes.plane_mut(0)[i] = 110);
            let prices = prices(vec![flat(10), flat(100), stripes, flat(200)], prefer);
            (0..4).filter(|&l| prices.get(l, [1, 0]) == 0).collect()
        };
        assert_eq!(free(Prefer::Darkest), [0]);
        assert_eq!(free(Prefer::Brightest), [3]);
        assert_eq!(free(Prefer::Sharpest), [2]);
        assert_eq!(free(Prefer::Median), [2], "90 of 10, 90, 100, 200");
    }

    #[test]
    fn what_flickers_is_not_in_focus() {
        let domain = Domain::open([5, 5, 5]);
        let frames =
            |value: fn([u32; 3]) -> u8| Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap();
        let clips = [frames(|[t, ..]| 100 + 40 * (t % 2) as u8), frames(|[_, _, x]| 100 + 9 * (x % 2) as u8)];
        let source = |(exemplar, features): (usize, Grid<u8, 3>)| Source {
            features,
            valid: None,
            origin: Origin { exemplar: exemplar as u16, transform: Transform::IDENTITY },
        };
        let clips = Exemplars::from_sources(clips.into_iter().enumerate().map(source).collect(), vec![1]).unwrap();
        let labels = [0, 1].map(|source| Label { source, offset: [0; 3] });
        let prices = preferred(&clips, &labels, domain, Prefer::Sharpest).unwrap();
        assert!(prices.plane(1).iter().all(|price| *price == 0) && prices.plane(0).iter().all(|price| 0 < *price));
    }

    #[test]
    fn those_that_agree_are_the_most_also_where_they_are_not_in_the_middle() {
        // Two of a wall, and three who pass by, each in another coat, two of them darker.
        let pictures = [120, 123, 10, 60, 119].map(flat).to_vec();
        let median = |pictures: Vec<Grid<u8, 2>>| {
            let prices = prices(pictures, Prefer::Median);
            (0..prices.channels()).map(|l| prices.get(l, [0, 0])).collect::<Vec<_>>()
        };
        assert_eq!(median(pictures)[0], 0);
        let darker = median([200, 202, 10, 60, 110].map(flat).to_vec());
        assert_eq!(darker.iter().position(|price| *price == 0), Some(0), "the median is 110");
        assert!(darker[4] > 10 * darker[1] && darker[1] < A_LEVEL, "{darker:?}");
    }
}
