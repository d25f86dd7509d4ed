//! What stands best, with its seams mended by texture optimization.

use selvedge_core::{Bytes, Domain, Exemplars, Grid, Run, SourceMap, Woven};
use selvedge_metrics::{Columns, preference};
use selvedge_texture_optimization as optimization;
use selvedge_texture_optimization::{Control, Optimized, optimize_from};

use crate::candidate::Settings;
use crate::error::Error;

/// The method's command.
pub(crate) const METHOD: &str = "optimize";

/// Bytes that it takes beside exemplars and maps, with what was there before.
pub(crate) fn memory(exemplars: &Exemplars<2>, output: Domain<2>) -> Bytes {
    let (channels, options) = (exemplars.channels(), optimization::Options::mending());
    let before = Bytes::of_samples(output, channels as u64 + 4);
    optimization::estimate(&exemplars.domains(), channels, output, &options) + before
}

/// More products of samples of exemplars and output are not mended: all of the former are searched for all of the
/// latter, which grows sixteenfold with each doubling of both. 256^2 to 512^2 is as much, and takes 10 s of one core;
/// 512^2 to 1024^2 would take 154, where all else takes 6.
const MOST: u64 = 1 << 34;

/// Whether mending takes seconds, not minutes.
pub(crate) fn is_affordable(exemplars: &Exemplars<2>, output: Domain<2>) -> bool {
    u64::from(exemplars.table().len()).saturating_mul(output.len() as u64) <= MOST
}

/// A map with its seams mended.
pub(crate) fn mended(
    exemplars: &Exemplars<2>,
    map: &SourceMap<2>,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Settings>, Error> {
    let options = optimization::Options::mending();
    let levels = options.schedule.iter().map(|level| format!("{}:{}", level.scale, level.size));
    let stats = vec![("schedule", levels.collect::<Vec<_>>().join(",")), ("complete", "none".to_owned())];
    let woven = optimize_from(exemplars, map, &Control::default(), &options, run)?;
    let Optimized::Map(result) = woven.result else { unreachable!("a coherent finish is a map") };
    Ok(Woven { result, stats, complete: woven.complete })
}

/// True if what a mended one shows is preferred to what it was.
///
/// Not by what its seams cost: preference has that from maps of quilts and cuts, whose seams are where they show. A
/// mended one has twice as many, most of which are not seen: it is preferred on four of 14 by its map, on 13 by its
/// picture.
pub(crate) fn is_preferred(mended: &Columns, before: &Columns) -> bool {
    let shown = |columns: &Columns| preference(&Columns { seams: None, ..*columns });
    shown(before) < shown(mended)
}

/// Side of the blocks whose contrast is compared, and how many of their samples have to have changed.
const SIDE: u32 = 8;
const CHANGED: usize = 8;

/// The part of its contrast that what was mended has to keep. Stones that a cut has set side by side fade into each
/// other, for nothing in the exemplar is like the two: chickpeas, gravel, pebbles and pumpkin seeds keep .78 to .88 of
/// their variance, for which readers prefer them as they were, and olives .83, which they would prefer all the same; 15
/// others keep .94 or more.
const LEAST: f64 = 0.91;

/// True if things that touch have faded into each other.
pub(crate) fn is_melted(before: &Grid<u8, 2>, after: &Grid<u8, 2>) -> bool {
    let domain = before.domain();
    let mut sums = [0.0; 2];
    for block in Domain::open(domain.shape.map(|n| n / SIDE)).positions() {
        let all = Domain::open([SIDE; 2]).positions();
        let all: Vec<usize> = all.map(|by| domain.index([0, 1].map(|a| block[a] * SIDE + by[a]))).collect();
        let channels = 0..before.channels();
        let is_changed = |&&i: &&usize| channels.clone().any(|c| before.plane(c)[i] != after.plane(c)[i]);
        if CHANGED <= all.iter().filter(is_changed).count() {
            for (sum, of) in sums.iter_mut().zip([before, after]) {
                *sum += channels.clone().map(|c| variance(all.iter().map(|&i| of.plane(c)[i]))).sum::<f64>();
            }
        }
    }
    sums[1] < LEAST * sums[0]
}

fn variance(values: impl Iterator<Item = u8> + Clone) -> f64 {
    let (n, sum) = values.clone().fold((0.0, 0.0), |(n, sum), v| (n + 1.0, sum + f64::from(v)));
    let apart = |v: u8| f64::from(v) - sum / n;
    values.map(|v| apart(v) * apart(v)).sum::<f64>() / n
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stones_that_fade_into_each_other_melt_and_others_do_not() {
        let domain = Domain::open([32, 40]);
        let stones = |edge: [u8; 2]| {
            let mut all = Grid::try_filled(domain, 1, 90).unwrap();
            // Two that touch, from column 8 to 32.
            domain.positions().filter(|at| (8..32).contains(&at[1])).for_each(|at| {
                let value = match at[1] {
                    8..18 => 60,
                    18..20 => edge[0],
                    20..22 => edge[1],
                    _ => 160,
                };
                all.set(0, at, value);
            });
            all
        };
        assert!(!is_melted(&stones([60, 160]), &stones([60, 160])));
        assert!(!is_melted(&stones([60, 160]), &stones([40, 180])), "what has more contrast");
        assert!(is_melted(&stones([40, 200]), &stones([90, 130])));
    }
}
