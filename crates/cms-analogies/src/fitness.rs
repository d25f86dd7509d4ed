//! Whether what lies under the exemplars covers what an output has to look like. `[CMS V-H]`
//!
//! "Good source data is needed": where no neighborhood of `Q` is like one of `C`, no label agrees there, and the result
//! is bad whatever `K` and `N`. How unlike is too unlike, `Q` itself tells: almost all of its own neighborhoods are
//! nearer to another one of it than that.

use selvedge_core::{Domain, Exemplars, Grid, Guide, SimdLevel, Source, Start, reserve};
use selvedge_fft_ssd::{Field, Windows, nearest};

use crate::constraint::Constraint;
use crate::error::Error;
use crate::options::Options;
use crate::synthesis::allowed;

/// Pictures are halved until none has more samples: all neighborhoods of both are compared, in about a tenth of a
/// second. Whether a colour or an edge is there at all is seen at that size as well.
const SAMPLES: usize = 12_000;

/// More products of samples are not compared: where neighborhoods are too large for a picture to be halved, what
/// would be compared grows with the square of its samples. About two seconds.
const MOST: u64 = 1 << 32;

/// Differences of so many grey levels are those of compression and rounding, however flat what lies under exemplars is:
/// flat labels asked for by a file that was compressed with losses would all be like nothing.
const LEAST_LIMIT: f64 = 4.0;
/// Of this share of its own neighborhoods the nearest other one is no farther than the limit.
const SHARE: f64 = 0.99;

/// How well a constraint's exemplars cover its target.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitness {
    /// What of the target is like nothing under the exemplars: the share of its neighborhoods that differ from the most
    /// similar one by more than `limit`, 0 to 1; `None` where nothing tells: exemplars that hold no second
    /// neighborhood, or more samples than are compared.
    pub uncovered: Option<f64>,
    /// Up to which root mean square difference, in 8-bit steps, `Q`'s own neighborhoods have a like elsewhere in it.
    pub limit: f64,
    /// By neighborhood of the target, how much it differs from the most similar one, in the same unit. They stand side
    /// by side, each [`side`](Self::side) samples of the output wide; 0 where nothing is asked for.
    pub differences: Grid<f64, 2>,
    /// Side of a neighborhood in samples of the output.
    pub side: u32,
}

impl Fitness {
    /// Whether nothing under the exemplars is like the neighborhood around a place of the output. What is left over
    /// at far borders belongs to the last one.
    pub fn is_uncovered(&self, at: [u32; 2]) -> bool {
        let over = self.differences.domain();
        let tile = [0, 1].map(|a| (at[a] / self.side).min(over.shape[a].saturating_sub(1)));
        !over.is_empty() && self.limit < self.differences.get(0, tile)
    }
}

/// How well exemplars cover the target of each constraint, in order, without synthesis.
///
/// # Errors
/// What [`Plan::new`](crate::Plan::new) refuses of options and constraints; no memory.
///
/// # Complexity
/// At most 12,000 samples of each exemplar are compared with as many of the target, and with those of all exemplars,
/// where neighborhoods leave room to halve them; else at most 2^32 pairs of samples.
pub fn fitness(exemplars: &Exemplars<2>, constraints: &[Constraint], options: &Options) -> Result<Vec<Fitness>, Error> {
    fitness_of(exemplars, constraints, &vec![true; exemplars.sources().len()], options)
}

/// The same of a run that goes on from what is there: what only stays where it is covers nothing.
///
/// # Errors
/// Those of [`fitness`].
pub fn fitness_from(
    exemplars: &Exemplars<2>,
    constraints: &[Constraint],
    start: &Start<2>,
    options: &Options,
) -> Result<Vec<Fitness>, Error> {
    fitness_of(exemplars, constraints, &allowed(exemplars, start), options)
}

fn fitness_of(
    exemplars: &Exemplars<2>,
    constraints: &[Constraint],
    allowed: &[bool],
    options: &Options,
) -> Result<Vec<Fitness>, Error> {
    options.validate()?;
    let first = constraints.first().ok_or(Error::NoConstraint)?;
    constraints.iter().try_for_each(|constraint| constraint.check(exemplars, first, options))?;
    constraints.iter().map(|constraint| of(constraint, allowed, options)).collect()
}

/// At the size at which it is asked.
fn of(constraint: &Constraint, allowed: &[bool], options: &Options) -> Result<Fitness, Error> {
    let side = |ratio: u32| 2 * options.neighborhood * ratio + 1;
    let (mut ratio, mut factor, mut coarser) = (constraint.ratio, 1, None::<Guide<2>>);
    loop {
        let guide = coarser.as_ref().unwrap_or(&constraint.guide);
        let domains = || guide.exemplars().table().sources().iter().map(|s| s.1).chain([guide.target().domain()]);
        let next = (ratio / 2).max(1);
        let holds = domains().all(|d| d.shape.iter().all(|&n| 4 * side(next) <= n));
        // A constraint of low resolution tells no more than at its own.
        if !holds || ratio == 1 && domains().all(|d| d.len() <= SAMPLES) {
            return compared(guide, allowed, side(ratio), factor);
        }
        coarser = match guide.coarser() {
            // A mask leaves no whole block.
            Err(selvedge_core::Error::NothingValid) => return compared(guide, allowed, side(ratio), factor),
            guide => Some(guide?),
        };
        (ratio, factor) = (next, factor * 2);
    }
}

fn compared(guide: &Guide<2>, allowed: &[bool], side: u32, factor: u32) -> Result<Fitness, Error> {
    let sources: Vec<&Source<2>> =
        guide.exemplars().sources().iter().zip(allowed).filter(|(_, used)| **used).map(|(s, _)| &**s).collect();
    // Of each exemplar the first orientation that may be used: the others show the same samples.
    let mut firsts: Vec<&Source<2>> = Vec::new();
    for source in &sources {
        if firsts.last().is_none_or(|last| last.origin.exemplar != source.origin.exemplar) {
            firsts.push(source);
        }
    }
    let samples = |source: &Source<2>| source.domain().len() as u64;
    let own: u64 = firsts.iter().map(|source| samples(source)).sum();
    let all: u64 = sources.iter().map(|source| samples(source)).sum();
    let pairs = own.saturating_mul(own).saturating_add(all.saturating_mul(guide.target().domain().len() as u64));
    if MOST < pairs {
        let differences = Grid::try_filled(Domain::open([0; 2]), 1, 0.0)?;
        return Ok(Fitness { uncovered: None, limit: f64::INFINITY, differences, side: side * factor });
    }
    let (windows, weights) = (Windows { side, step: side }, guide.weights());
    let taps = f64::from(side) * f64::from(side) * weights.iter().map(|&w| f64::from(w)).sum::<f64>().max(1.0);
    let root = |error: u64| (error as f64 / taps).sqrt();
    let known = limit(&firsts, weights, windows)?.map(|error| root(error).max(LEAST_LIMIT));
    let limit = known.unwrap_or(f64::INFINITY);
    let target = Field { features: guide.target(), valid: guide.asked() };
    let fields: Vec<Field<'_>> = sources.iter().map(|source| Field::of(source)).collect();
    let found = nearest(target, &fields, weights, windows, SimdLevel::default())?;
    let mut differences = Grid::try_filled(found.domain(), 1, 0.0)?;
    let roots = found.plane(0).iter().map(|n| n.map_or(f64::INFINITY, |n| root(n.error)));
    differences.plane_mut(0).iter_mut().zip(roots).for_each(|(to, root)| *to = root);
    let far = differences.plane(0).iter().filter(|&&d| limit < d).count();
    let uncovered = known.map(|_| far as f64 / differences.domain().len().max(1) as f64);
    Ok(Fitness { uncovered, limit, differences, side: side * factor })
}

/// The error up to which windows of the exemplars have a like that shares no row with them; `None` without any.
fn limit(firsts: &[&Source<2>], weights: &[u8], windows: Windows) -> Result<Option<u64>, Error> {
    let mut errors = Vec::new();
    for (own, source) in firsts.iter().enumerate() {
        for first in (0..source.domain().shape[0] / windows.side).map(|band| band * windows.side) {
            let rows = first..first + windows.side;
            let (band, elsewhere) = (band(source, &rows)?, without(source, &rows)?);
            let mut fields: Vec<Field<'_>> = firsts.iter().map(|source| Field::of(source)).collect();
            fields[own].valid = Some(&elsewhere);
            let found = nearest(Field::new(&band), &fields, weights, windows, SimdLevel::default())?;
            let wide = source.domain().shape[1];
            let is_whole = |window: usize| {
                let columns = (0..windows.side).map(|x| (window as u32 * windows.side + x) % wide);
                let whole = |x: u32| rows.clone().all(|y| source.valid.as_deref().is_none_or(|v| v.get(0, [y, x])));
                columns.into_iter().all(whole)
            };
            reserve(&mut errors, found.domain().len())?;
            let whole = found.plane(0).iter().enumerate().filter(|(window, _)| is_whole(*window));
            errors.extend(whole.filter_map(|(_, n)| n.map(|n| n.error)));
        }
    }
    errors.sort_unstable();
    let last = errors.len().saturating_sub(1);
    Ok(errors.get((last as f64 * SHARE) as usize).copied())
}

/// Some rows of a source.
fn band(source: &Source<2>, rows: &std::ops::Range<u32>) -> Result<Grid<u8, 2>, Error> {
    let (features, wide) = (&source.features, source.domain().shape[1] as usize);
    let periodic = [false, source.domain().periodic[1]];
    let domain = Domain { shape: [rows.end - rows.start, wide as u32], periodic };
    let mut samples = Vec::new();
    reserve(&mut samples, domain.len() * features.channels())?;
    for c in 0..features.channels() {
        samples.extend_from_slice(&features.plane(c)[rows.start as usize * wide..rows.end as usize * wide]);
    }
    Ok(Grid::from_vec(domain, features.channels(), samples)?)
}

/// What of a source is valid, but for some rows.
fn without(source: &Source<2>, rows: &std::ops::Range<u32>) -> Result<Grid<bool, 2>, Error> {
    let domain = source.domain();
    let mut valid = Grid::try_filled(domain, 1, true)?;
    for (to, at) in valid.plane_mut(0).iter_mut().zip(domain.positions()) {
        *to = !rows.contains(&at[0]) && source.valid.as_deref().is_none_or(|valid| valid.get(0, at));
    }
    Ok(valid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Origin, Seed, Transform};

    fn noise(domain: Domain<2>, seed: u64, most: u32) -> Grid<u8, 2> {
        let mut rng = Seed(seed).rng();
        Grid::from_vec(domain, 1, (0..domain.len()).map(|_| rng.below(most) as u8).collect()).unwrap()
    }

    fn exemplars(map: &Grid<u8, 2>, valid: Option<Grid<bool, 2>>) -> Exemplars<2> {
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        Exemplars::from_sources(
            vec![Source { features: map.map(|v| v).unwrap(), valid: valid.map(Into::into), origin }],
            vec![1],
        )
        .unwrap()
    }

    fn fit(exemplars: &Exemplars<2>, map: &Grid<u8, 2>, target: Grid<u8, 2>, half: u32) -> Fitness {
        let guide = Guide::new(exemplars, &[map.map(|v| v).unwrap()], target).unwrap();
        let options = Options { neighborhood: half, ..Options::paper() };
        fitness(exemplars, &[Constraint::new(guide)], &options).unwrap().remove(0)
    }

    #[test]
    fn what_is_there_is_covered_and_what_is_not_is_told() {
        let map = noise(Domain::open([48, 60]), 1, 100);
        let exemplars = exemplars(&map, None);
        let part = Domain::open([20, 40]);
        let shown = |at: [u32; 2]| map.get(0, [at[0] + 9, at[1] + 13]);
        let of = |f: &dyn Fn([u32; 2]) -> u8| Grid::from_vec(part, 1, part.positions().map(f).collect()).unwrap();
        let same = fit(&exemplars, &map, of(&shown), 2);
        assert_eq!((same.uncovered, same.side), (Some(0.0), 5));
        assert!(same.differences.plane(0).iter().all(|&d| d == 0.0) && 0.0 < same.limit);
        // The right half is brighter than anything that is there.
        let half = fit(&exemplars, &map, of(&|at| if at[1] < 20 { shown(at) } else { 255 }), 2);
        assert_eq!(half.uncovered, Some(0.5));
        assert!(!half.is_uncovered([19, 19]) && half.is_uncovered([0, 20]) && half.is_uncovered([19, 39]));
        // Where nothing is asked for, nothing is missing.
        let guide = Guide::new(&exemplars, &[map.map(|v| v).unwrap()], of(&|_| 255)).unwrap();
        let asked = Grid::from_vec(part, 1, part.positions().map(|at| at[0] < 10).collect()).unwrap();
        let constraint = Constraint::new(guide.asking(asked).unwrap());
        let options = Options { neighborhood: 2, ..Options::paper() };
        assert_eq!(fitness(&exemplars, &[constraint], &options).unwrap()[0].uncovered, Some(0.5));
    }

    #[test]
    fn the_limit_is_what_almost_all_neighborhoods_have_a_like_within() {
        for case in 0..12 {
            let mut rng = Seed(case).rng();
            let domain = Domain { shape: [8 + rng.below(9), 8 + rng.below(9)], periodic: [false, case % 3 == 0] };
            let map = noise(domain, case, 40);
            let valid = (case % 2 == 0)
                .then(|| Grid::from_vec(domain, 1, (0..domain.len()).map(|_| rng.below(25) != 0).collect()).unwrap());
            let exemplars = exemplars(&map, valid.as_ref().map(|v| v.map(|v| v).unwrap()));
            let found = fit(&exemplars, &map, noise(Domain::open([9, 9]), 7, 40), 1).limit;
            let window = |at: [u32; 2]| -> Option<Vec<u8>> {
                let taps = (0..3).flat_map(|y| (0..3).map(move |x| [y, x]));
                let sample = |by: [i32; 2]| {
                    let p = domain.step(at, by)?;
                    valid.as_ref().is_none_or(|v| v.get(0, p)).then(|| map.get(0, p))
                };
                taps.map(sample).collect()
            };
            let squares =
                |a: &[u8], b: &[u8]| -> u64 { a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum() };
            let over = Windows { side: 3, step: 3 }.over(Domain { periodic: [false, domain.periodic[1]], ..domain });
            let mut errors: Vec<u64> = over
                .positions()
                .filter_map(|at| window(at.map(|p| 3 * p)).map(|own| (3 * at[0], own)))
                .filter_map(|(y, own)| {
                    let others = domain.positions().filter(|other| 3 <= other[0].abs_diff(y));
                    others.filter_map(window).map(|other| squares(&own, &other)).min()
                })
                .collect();
            errors.sort_unstable();
            let expected = errors[((errors.len() - 1) as f64 * 0.99) as usize];
            assert!((found - (expected as f64 / 9.0).sqrt()).abs() < 1e-9, "{case}: {found}");
        }
    }

    #[test]
    fn what_compression_adds_to_flat_labels_is_not_unlike_them() {
        let flat = |level| Grid::try_filled(Domain::open([40, 40]), 1, level).unwrap();
        let exemplars = exemplars(&flat(100), None);
        let uncovered = |level| fit(&exemplars, &flat(100), flat(level), 1).uncovered;
        assert_eq!([100, 97, 104, 105, 90].map(uncovered), [0.0, 0.0, 0.0, 1.0, 1.0].map(Some));
    }

    #[test]
    fn large_pictures_are_asked_at_a_fraction_of_their_size() {
        let map = noise(Domain::open([160, 240]), 3, 200);
        let exemplars = exemplars(&map, None);
        let found = fit(&exemplars, &map, noise(Domain::open([100, 100]), 4, 200), 2);
        assert_eq!((found.side, found.differences.domain().shape), (10, [10, 10]));
    }
}
