//! Levels: a map is solved at a fraction of the size, carried up, and decided again near its seams. `[Lombaert05]`
//!
//! Searches and cuts pay for samples, and most of what they decide can be seen at half the size: which part of an
//! exemplar lies where, and about where it ends. So the smallest level is a run of the method by itself. Of each finer
//! one, all samples are exact copies again ([`SourceMap::finer`]); what is left to it is a sample of each patch's
//! offset ([`shift`]) and the course of the seams, in a band ([`settle`]). Of clips frames are halved, and stay as
//! many.

use selvedge_core::{Domain, Event, Exemplars, Run, SeamCosts, SourceMap, Start, Within, Woven};
use selvedge_expansion::{Pins, settle, shift};

use crate::error::Error;
use crate::options::Options;
use crate::settings::Settings;
use crate::stats::Stats;
use crate::weaver::weave_at;
use crate::work::{Weighed, Work};

/// How far seams may move at a finer level, in its samples. Twice the sample of the coarser one that they were solved
/// for, and as much again for what the finer one shows.
const WIDTH: u32 = 4;

/// Solves the smallest level and carries it up.
///
/// # Errors
/// Those of [`graphcut`](crate::graphcut()).
pub(crate) fn weave<const D: usize>(
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    settings: &Settings<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
    let mut coarser: Vec<(Exemplars<D>, Domain<D>)> = Vec::new();
    for _ in 1..settings.levels {
        let (finest, whole) = coarser.last().map_or((exemplars, output), |(e, output)| (e, *output));
        let coarse = (finest.coarser()?, whole.coarser());
        coarser.push(coarse);
    }
    let Some((coarsest, small)) = coarser.last() else {
        return weave_at(exemplars, Start::empty(exemplars, output)?, settings, options, run);
    };
    let coarse_settings = settings.coarser(coarsest, options);
    let len = |output: &Domain<D>| output.len() as u64;
    let larger = len(&output) + coarser.iter().rev().skip(1).map(|(_, output)| len(output)).sum::<u64>();
    let work = Work::of(&coarse_settings, *small, larger, options);
    let run = &Run { observer: &Weighed { observer: run.observer, work }, ..*run };
    // What it has so far is no map of these exemplars.
    let within = Run { observer: &Within(run.observer), ..*run };
    let mut woven = weave_at(coarsest, Start::empty(coarsest, *small)?, &coarse_settings, options, &within)?;
    coarser.insert(0, (exemplars.clone(), output));
    coarser.pop();
    let mut done = 0;
    let levels = coarser.len() as u64;
    for (number, (finer, output)) in coarser.into_iter().rev().enumerate() {
        woven.result = woven.result.finer(&finer, output)?;
        if woven.complete {
            let told = |tiles: u64, of: u64| {
                let part = len(&output) * tiles / of.max(1);
                let step = Event::step("settle", number as u64, levels);
                run.observer.event(&Event { work: Some(work.settled(done + part)), ..step });
            };
            let energy;
            (energy, woven.complete) = near_seams(&finer, &mut woven.result, options, run, &told)?;
            woven.stats.settled.push(energy);
            done += len(&output);
            let so_far = (finer.table() == exemplars.table()).then_some(&woven.result as _);
            let work = Some(work.settled(done));
            let step = Event::step("settle", number as u64 + 1, levels);
            run.observer.event(&Event { work, energy: Some(energy), so_far, ..step });
        }
    }
    woven.stats.settings = *settings;
    Ok(woven)
}

/// Decides a map again near its seams; answers with their price, and whether it came to an end.
fn near_seams<const D: usize>(
    exemplars: &Exemplars<D>,
    map: &mut SourceMap<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
    told: &dyn Fn(u64, u64),
) -> Result<(i64, bool), Error> {
    let costs = SeamCosts::new(exemplars, options.seam)?;
    let cancelled = || run.observer.cancelled();
    let decided = shift(exemplars, map, &costs, (options.free, None), &cancelled)
        .and_then(|_| settle(exemplars, map, &costs, Pins::default(), WIDTH, &cancelled, told));
    let complete = match decided {
        Err(error) if error.is_cancelled() => false,
        other => other.map(|_| true)?,
    };
    Ok((costs.total(map), complete))
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_testkit::simple::noise;

    #[test]
    fn patches_are_moved_as_well_as_their_seams() {
        let plane = noise(96, 64, 3);
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        // The right half lies a sample beside of where it would go on: no seam can mend what an offset does.
        let mut map = SourceMap::unassigned(&exemplars, Domain::open([40, 80])).unwrap();
        for at @ [y, x] in map.domain().positions().collect::<Vec<_>>() {
            map.ids.set(0, at, exemplars.table().id(0, [y + 4, x + 4 + u32::from(40 <= x)]));
        }
        let (run, options) = (Run::seeded(1), Options::default());
        assert_eq!(near_seams(&exemplars, &mut map, &options, &run, &|_, _| {}).unwrap(), (0, true));
    }
}
