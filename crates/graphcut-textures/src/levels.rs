//! Levels: a map is solved at a fraction of the size, carried up, and decided again near its seams. `[Lombaert05]`
//!
//! Searches and cuts pay for samples, and most of what they decide can be seen at half the size: which part of an
//! exemplar lies where, and about where it ends. So the smallest level is a run of the method by itself. Of each finer
//! one, all samples are exact copies again ([`SourceMap::finer`]); what is left to it is a sample of each patch's
//! offset ([`shift`]) and the course of the seams, in a band ([`settle`]). Of clips frames are halved, and stay as
//! many.

use selvedge_core::{Domain, Event, Exemplars, Grid, Run, SeamCosts, SourceMap, Start, Within, Woven};
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

/// A size.
struct Level<const D: usize> {
    exemplars: Exemplars<D>,
    output: Domain<D>,
    /// What stands there, if anything does.
    start: Option<Start<D>>,
}

impl<const D: usize> Level<D> {
    fn coarser(&self) -> Result<Self, Error> {
        let exemplars = self.exemplars.coarser()?;
        let start = self.start.as_ref().map(|start| coarser(start, &exemplars)).transpose()?;
        Ok(Self { exemplars, output: self.output.coarser(), start })
    }

    /// What a coarser level came to at this one. What it left as it stood is as it stands here.
    fn carried(&self, map: &SourceMap<D>, stood: Option<&Start<D>>) -> Result<SourceMap<D>, Error> {
        let mut fine = map.finer(&self.exemplars, self.output)?;
        let Some((start, stood)) = self.start.as_ref().zip(stood) else { return Ok(fine) };
        let (small, fixed) = (map.domain(), start.fixed.as_ref().map(Grid::samples));
        let is_left = |at| {
            let above = small.index(Domain::halved(at, 1));
            map.ids.plane(0)[above] == stood.map.ids.plane(0)[above]
        };
        let all = fine.ids.plane_mut(0).iter_mut().zip(start.map.ids.plane(0)).zip(self.output.positions());
        for (place, ((id, stands), at)) in all.enumerate().filter(|(_, ((_, stands), _))| stands.is_assigned()) {
            if fixed.is_some_and(|fixed| fixed[place]) || is_left(at) {
                *id = *stands;
            }
        }
        Ok(fine)
    }
}

/// What stands at half the size: the first sample of each block, and whether it stays.
fn coarser<const D: usize>(start: &Start<D>, exemplars: &Exemplars<D>) -> Result<Start<D>, Error> {
    let map = start.map.coarser(exemplars)?;
    let of = |fixed: &Grid<bool, D>| {
        let kept = map.domain().positions().map(|at| fixed.get(0, Domain::below(at))).collect();
        Grid::from_vec(map.domain(), 1, kept)
    };
    let fixed = start.fixed.as_ref().map(of).transpose()?;
    Ok(Start { map, fixed, sources: None })
}

/// Solves the smallest level and carries it up.
///
/// # Errors
/// Those of [`graphcut`](crate::graphcut()).
pub(crate) fn weave<const D: usize>(
    exemplars: &Exemplars<D>,
    start: Start<D>,
    settings: &Settings<D>,
    options: &Options<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
    let output = start.map.domain();
    let start = (start.map.holes() < output.len()).then_some(start);
    let mut levels = vec![Level { exemplars: exemplars.clone(), output, start }];
    for finest in 1..settings.levels as usize {
        levels.push(levels[finest - 1].coarser()?);
    }
    let Some(coarsest) = levels.pop() else { unreachable!("there is one level at least") };
    let coarse_settings = settings.coarser(&coarsest.exemplars, options);
    let larger = levels.iter().map(|level| level.output.len() as u64).sum();
    let work = Work::of(&coarse_settings, coarsest.output, larger, options);
    let run = &Run { observer: &Weighed { observer: run.observer, work }, ..*run };
    // What it has so far is no map of these exemplars.
    let within = Run { observer: &Within(run.observer), ..*run };
    let begin = coarsest.start.clone().map_or_else(|| Start::empty(&coarsest.exemplars, coarsest.output), Ok)?;
    let mut woven = weave_at(&coarsest.exemplars, begin, &coarse_settings, options, &within)?;
    let (mut done, mut stood) = (0, coarsest.start);
    let sizes = levels.len() as u64;
    for (number, level) in levels.into_iter().rev().enumerate() {
        woven.result = level.carried(&woven.result, stood.as_ref())?;
        let len = level.output.len() as u64;
        if woven.complete {
            let told = |tiles: u64, of: u64| {
                let step = Event::step("settle", number as u64, sizes);
                run.observer.event(&Event { work: Some(work.settled(done + len * tiles / of.max(1))), ..step });
            };
            let energy;
            (energy, woven.complete) = level.near_seams(&mut woven.result, options, run, &told)?;
            woven.stats.settled.push(energy);
            done += len;
            let so_far = (level.exemplars.table() == exemplars.table()).then_some(&woven.result as _);
            let work = Some(work.settled(done));
            let step = Event::step("settle", number as u64 + 1, sizes);
            run.observer.event(&Event { work, energy: Some(energy), so_far, ..step });
        }
        stood = level.start;
    }
    woven.stats.settings = *settings;
    Ok(woven)
}

impl<const D: usize> Level<D> {
    /// Decides a map again near its seams; answers with their price, and whether it came to an end.
    fn near_seams(
        &self,
        map: &mut SourceMap<D>,
        options: &Options<D>,
        run: &Run<'_, D>,
        told: &dyn Fn(u64, u64),
    ) -> Result<(i64, bool), Error> {
        let exemplars = &self.exemplars;
        let costs = SeamCosts::new(exemplars, options.seam)?;
        let cancelled = || run.observer.cancelled();
        let fixed = self.start.as_ref().and_then(|start| start.fixed.as_ref());
        let pins = Pins { fixed, sources: None };
        let decided = shift(exemplars, map, &costs, (options.free, fixed), &cancelled)
            .and_then(|_| settle(exemplars, map, &costs, pins, WIDTH, &cancelled, told));
        let complete = match decided {
            Err(error) if error.is_cancelled() => false,
            other => other.map(|_| true)?,
        };
        Ok((costs.total(map), complete))
    }
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
        let level = Level { exemplars, output: map.domain(), start: None };
        assert_eq!(level.near_seams(&mut map, &options, &run, &|_, _| {}).unwrap(), (0, true));
    }
}
