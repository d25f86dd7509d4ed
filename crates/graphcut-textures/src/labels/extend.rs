//! Pictures made larger: what is around them is filled in steps, from the inside out.

use selvedge_core::{Domain, Exemplars, Run, SourceMap, Start, Woven};

use crate::error::Error;
use crate::labels::fill::{FillOptions, FillStats, fill};
use crate::labels::offsets::OffsetOptions;

/// A step adds at most one in so many samples of what there is along an axis: farther out a border has little to say,
/// and what repeats itself would be decided all at once.
const STEP: u32 = 3;

/// What goes on comes from at least so far away, in parts of the longest side of what there is: from beside the border
/// the same strip would come again and again, step after step.
const APART: u32 = 4;

/// Extends what stands in a map to an output that it lies in, its first sample `at` a position there: by
/// [`fill`], in steps of at most a third of what there is along each axis. What stands stays; holes in it are filled as
/// well. Around periodic axes it closes with the last step.
///
/// # Errors
/// [`Range`](selvedge_core::Error::Range) where it does not lie in the output, and those of [`fill`].
///
/// # Complexity
/// That of [`fill`] for each step.
///
/// # Events, Determinism
/// As those of [`fill`].
pub fn extend<const D: usize>(
    exemplars: &Exemplars<D>,
    mut map: SourceMap<D>,
    at: [u32; D],
    output: Domain<D>,
    options: &FillOptions,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, FillStats>, Error> {
    let fits = |a: usize| u64::from(at[a]) + u64::from(map.domain().shape[a]) <= output.shape[a].into();
    if let Some(axis) = (0..D).find(|&a| !fits(a)) {
        return Err(selvedge_core::Error::range("place", at[axis], "one at which the map lies in the output").into());
    }
    let (mut low, mut stats) = (at, FillStats::default());
    loop {
        let (domain, before) = step(map.domain().shape, low, output);
        low = std::array::from_fn(|a| low[a] - before[a]);
        let start = Start { map: moved(exemplars, &map, before, domain)?, fixed: None, sources: None };
        let longest = map.domain().shape.into_iter().max().unwrap_or(0);
        let apart = options.offsets.apart.unwrap_or((longest / APART).max(1));
        let offsets = OffsetOptions { apart: Some(apart), ..options.offsets };
        let woven = fill(exemplars, start, &FillOptions { offsets, ..options.clone() }, run)?;
        add(&mut stats, woven.stats);
        map = woven.result;
        if !woven.complete {
            return Ok(Woven { result: moved(exemplars, &map, low, output)?, stats, complete: false });
        }
        if map.domain() == output {
            return Ok(Woven { result: map, stats, complete: true });
        }
    }
}

/// The domain of the next step, and how many samples it has before what there is.
fn step<const D: usize>(shape: [u32; D], low: [u32; D], output: Domain<D>) -> (Domain<D>, [u32; D]) {
    let (mut grown, mut before) = (shape, [0; D]);
    for a in 0..D {
        let missing = output.shape[a] - shape[a];
        let more = missing.min((shape[a] / STEP).max(1));
        // On both sides in proportion to what is missing there, so that both are reached at once.
        before[a] = (u64::from(more) * u64::from(low[a])).checked_div(missing.into()).unwrap_or(0) as u32;
        grown[a] = shape[a] + more;
    }
    let last = grown == output.shape;
    (Domain { shape: grown, periodic: if last { output.periodic } else { [false; D] } }, before)
}

/// A map laid into a larger domain, all else of which is a hole.
fn moved<const D: usize>(
    exemplars: &Exemplars<D>,
    map: &SourceMap<D>,
    to: [u32; D],
    domain: Domain<D>,
) -> Result<SourceMap<D>, Error> {
    let mut moved = SourceMap::unassigned(exemplars, domain)?;
    for (at, id) in map.domain().positions().zip(map.ids.plane(0)) {
        moved.ids.set(0, std::array::from_fn(|a| at[a] + to[a]), *id);
    }
    Ok(moved)
}

/// Counts of another step.
fn add(all: &mut FillStats, step: FillStats) {
    all.filled += step.filled;
    all.grown += step.grown;
    all.levels = all.levels.max(step.levels);
    all.offsets += step.offsets;
    all.used = all.used.max(step.used);
    all.expansions += step.expansions;
    all.refined += step.refined;
    all.energy.extend(step.energy);
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Error as CoreError, Grid, Origin, Seed, Source, Transform};

    /// Noise that repeats itself.
    fn periodic(shape: [u32; 2], period: [u32; 2]) -> (Exemplars<2>, Vec<u8>) {
        let mut rng = Seed(5).rng();
        let cell: Vec<u8> = (0..period[0] * period[1]).map(|_| rng.below(256) as u8).collect();
        let domain = Domain::open(shape);
        let value = |[y, x]: [u32; 2]| cell[(y % period[0] * period[1] + x % period[1]) as usize];
        let features = Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        (Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap(), cell)
    }

    #[test]
    fn steps_reach_the_output_and_no_more() {
        for case in 0..300 {
            let mut rng = Seed(case).rng();
            let shape: [u32; 2] = [1 + rng.below(50), 1 + rng.below(50)];
            let output = Domain { shape: shape.map(|n| n + rng.below(90)), periodic: [case % 2 == 0, false] };
            let mut low: [u32; 2] = std::array::from_fn(|a| rng.below(output.shape[a] - shape[a] + 1));
            let mut now = shape;
            loop {
                let (domain, before) = step(now, low, output);
                for a in 0..2 {
                    let more = domain.shape[a] - now[a];
                    assert!(more <= (now[a] / 3).max(1) && before[a] <= more.min(low[a]));
                    assert!(low[a] - before[a] + domain.shape[a] <= output.shape[a]);
                    low[a] -= before[a];
                }
                if domain.shape == now {
                    assert_eq!((domain, low), (output, [0, 0]));
                    break;
                }
                assert_eq!(domain.periodic, if domain.shape == output.shape { output.periodic } else { [false; 2] });
                now = domain.shape;
            }
        }
    }

    #[test]
    fn what_repeats_itself_goes_on() {
        let (e, cell) = periodic([40, 44], [7, 9]);
        let mut map = SourceMap::unassigned(&e, Domain::open([40, 44])).unwrap();
        map.lay_under(&e, 0).unwrap();
        let (at, output) = ([5, 20], Domain::open([70, 75]));
        let woven = extend(&e, map, at, output, &FillOptions::default(), &Run::seeded(0)).unwrap();
        assert!(woven.complete && woven.result.domain() == output);
        let features = &e.sources()[0].features;
        for [y, x] in output.positions() {
            let (_, from) = woven.result.locate([y, x]).unwrap();
            let kept = (5..45).contains(&y) && (20..64).contains(&x);
            assert!(!kept || from == [y - 5, x - 20]);
            let truth = cell[((y + 7 - 5) % 7 * 9 + (x + 27 - 20) % 9) as usize];
            assert_eq!(features.get(0, from), truth, "{x},{y}");
        }
        assert_eq!(woven.stats.filled, 70 * 75 - 40 * 44);
    }

    #[test]
    fn what_does_not_lie_in_the_output_is_refused() {
        let (e, _) = periodic([10, 10], [3, 3]);
        let map = SourceMap::unassigned(&e, Domain::open([10, 10])).unwrap();
        let error = extend(&e, map, [1, 0], Domain::open([10, 12]), &FillOptions::default(), &Run::seeded(0));
        assert!(matches!(error, Err(Error::Core(CoreError::Range { .. }))));
    }
}
