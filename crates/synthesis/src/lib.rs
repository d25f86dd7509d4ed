//! A larger texture without knobs: several methods with several settings make it, each is scored, and the best is kept.
//!
//! The work is bounded by [`Options::effort`], never by a clock, so the same seed and effort give the same map on any
//! machine and any number of threads. A [`Candidate`] is a trait: what else makes a texture may join. What is kept can be made
//! again by its method alone, with the options and the seed that [`Stats`] tell.
//!
//! # Features
//! `rayon` (default): candidates are made beside each other in the caller's pool; the result is the same without it.
#![forbid(unsafe_code)]

mod candidate;
mod error;

pub use candidate::{Candidate, Graphcut, Quilt, Used, candidates};
pub use error::Error;

use selvedge_core::{
    Domain, ErrorKind, Event, Exemplars, Grid, Observer, Run, SampleId, Seed, SourceMap, Woven, par, try_vec,
};
use selvedge_metrics::{Columns, Judge, preference};

/// Options of [`synthesize`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// How much work may be done: 1 makes one candidate and scores nothing, 5 takes about a second for 512^2 from 192^2 on
    /// two cores, each step beyond twice as much; 9 tens of candidates. Default: 5.
    pub effort: u8,
}

impl Default for Options {
    fn default() -> Self {
        Self { effort: 5 }
    }
}

/// One candidate that was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// The method's command.
    pub method: &'static str,
    /// Its options as used.
    pub used: Used,
    /// Its seed.
    pub seed: Seed,
    /// Its columns and preference; `None` where nothing was compared.
    pub scored: Option<(Columns, f64)>,
}

/// What was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Stats {
    /// In the order of trying.
    pub tried: Vec<Tried>,
    /// Which of them was kept.
    pub kept: usize,
}

/// Scoring takes about so many steps of a nanosecond an output sample, for exemplars of 192^2.
const SCORING: u64 = 1000;
/// Steps an output sample at the default effort: some 2.5 s on one thread for 512^2 from 192^2.
const STEPS: u64 = 12_000;
/// The default effort, from which the budget doubles and halves.
const MIDDLE: u8 = 5;
/// No more candidates than this, whatever they cost.
const MOST: usize = 60;

/// Makes a texture of several candidates and keeps the best.
///
/// Candidates are taken in order, and again with the next seed, as long as their work and their scoring fit what the effort
/// leaves; at least one. Exemplars and outputs that are too small to be compared have one candidate. One whose method
/// refuses the exemplars is left out.
///
/// # Errors
/// [`Error::Effort`]; the first candidate's if all fail; [`Error::Core`] and [`Error::Metrics`] if memory is short.
///
/// # Events
/// `"synthesize"` after each round of candidates, with how many are done.
///
/// # Determinism
/// The map follows from exemplars, domain, options and seed alone. Candidate `i` of a list of `n` has the seed `seed + i / n`.
pub fn synthesize(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Stats>, Error> {
    if !(1..=9).contains(&options.effort) {
        return Err(Error::Effort { effort: options.effort });
    }
    let judge = match Judge::new(exemplars, run.simd) {
        Ok(judge) if options.effort != 1 && output.shape.iter().all(|&n| selvedge_metrics::LEAST <= n) => Some(judge),
        Err(e) if !matches!(e, selvedge_metrics::Error::TooSmall { .. }) => return Err(e.into()),
        _ => None,
    };
    let all = candidates(exemplars);
    let plan = plan(&all, exemplars, output, if judge.is_some() { options.effort } else { 1 });
    let quiet = Quiet(run.observer);
    let mut best = Best { tried: Vec::new(), kept: None, refused: None };
    for (round, some) in plan.chunks(par::threads().max(1)).enumerate() {
        let made = par::map_indexed(some.len(), |i| {
            let (which, seed) = (some[i] % all.len(), Seed(run.seed.0.wrapping_add((some[i] / all.len()) as u64)));
            let woven = all[which].weave(exemplars, output, &Run { seed, observer: &quiet, ..*run })?;
            let scored = match &judge {
                Some(judge) if woven.complete => {
                    let columns = judge.columns(&shown(exemplars, &woven.result)?, Some(&woven.result))?;
                    Some((columns, preference(&columns)))
                }
                _ => None,
            };
            Ok((all[which].method(), seed, woven, scored))
        });
        made.into_iter().try_for_each(|one| best.take(one))?;
        let done = (round * par::threads().max(1) + some.len()) as u64;
        run.observer.event(&Event::step("synthesize", done, plan.len() as u64));
        if run.observer.cancelled() && best.kept.is_some() {
            break;
        }
    }
    best.answer()
}

/// Bytes that [`synthesize`] needs at most, on `threads` threads: what their candidates and comparisons hold at once, and the best map.
pub fn estimate(exemplars: &[Domain<2>], channels: usize, output: Domain<2>, threads: usize) -> u64 {
    let len = |d: &Domain<2>| d.shape.iter().fold(1_u64, |n, &side| n.saturating_mul(u64::from(side)));
    let quilt = Quilt(selvedge_quilting::Options::default()).memory(exemplars, channels, output);
    let graphcut = Graphcut(selvedge_graphcut_textures::Options::default()).memory(exemplars, channels, output);
    let sources = exemplars.iter().map(len).fold(0, u64::saturating_add);
    // Features, half and quarter sizes, words, running answers: what the measures hold.
    let scoring = len(&output).saturating_mul(12 + 4 * channels as u64) + sources.saturating_mul(40);
    let each = quilt.max(graphcut).saturating_add(scoring).saturating_add(len(&output).saturating_mul(8));
    each.saturating_mul(threads.max(1) as u64)
}

/// Which candidates are made: numbers that count through the list again and again.
fn plan(all: &[Box<dyn Candidate>], exemplars: &Exemplars<2>, output: Domain<2>, effort: u8) -> Vec<usize> {
    if effort == 1 {
        return vec![0];
    }
    let area: u64 = output.shape.iter().map(|&n| u64::from(n)).product();
    let scoring = area * SCORING * u64::from(exemplars.table().len()) / (192 * 192);
    let steps = area * STEPS * u64::from(exemplars.table().len()) / (192 * 192);
    let mut left = if effort < MIDDLE { steps >> (MIDDLE - effort) } else { steps << (effort - MIDDLE) };
    let mut plan = Vec::new();
    for number in 0..all.len() * MOST {
        let work = all[number % all.len()].work(exemplars, output).saturating_add(scoring);
        if number == 0 || work <= left {
            left = left.saturating_sub(work);
            plan.push(number);
        }
        if plan.len() == MOST {
            break;
        }
    }
    plan
}

/// The features that a map shows.
fn shown(exemplars: &Exemplars<2>, map: &SourceMap<2>) -> Result<Grid<u8, 2>, Error> {
    let channels = exemplars.channels();
    let mut samples = try_vec(map.domain().len() * channels, 0_u8)?;
    for (c, plane) in samples.chunks_mut(map.domain().len().max(1)).enumerate() {
        let mut of = Vec::new();
        for source in exemplars.sources() {
            of.extend_from_slice(source.features.plane(c));
        }
        let value = |id: &SampleId| of.get(id.get() as usize).copied().unwrap_or(0);
        plane.iter_mut().zip(map.ids.plane(0)).for_each(|(to, id)| *to = value(id));
    }
    Ok(Grid::from_vec(map.domain(), channels, samples)?)
}

/// What one candidate came to.
type Made = Result<(&'static str, Seed, Woven<SourceMap<2>, Used>, Option<(Columns, f64)>), Error>;

/// The best so far.
struct Best {
    tried: Vec<Tried>,
    kept: Option<(usize, SourceMap<2>, bool)>,
    refused: Option<Error>,
}

impl Best {
    /// Keeps one that is preferred, or more complete; of equals the first.
    fn take(&mut self, made: Made) -> Result<(), Error> {
        let (method, seed, woven, scored) = match made {
            Ok(made) => made,
            Err(e) if matches!(e.kind(), ErrorKind::Option | ErrorKind::Input) => {
                self.refused.get_or_insert(e);
                return Ok(());
            }
            Err(e) => return Err(e),
        };
        let value = |complete: bool, scored: &Option<(Columns, f64)>| (complete, scored.map(|(_, p)| p));
        let is_better = self.kept.as_ref().is_none_or(|(kept, _, complete)| {
            value(*complete, &self.tried[*kept].scored) < value(woven.complete, &scored)
        });
        if is_better {
            self.kept = Some((self.tried.len(), woven.result, woven.complete));
        }
        self.tried.push(Tried { method, used: woven.stats, seed, scored });
        Ok(())
    }

    fn answer(self) -> Result<Woven<SourceMap<2>, Stats>, Error> {
        match (self.kept, self.refused) {
            (Some((kept, result, complete)), _) => {
                Ok(Woven { result, stats: Stats { tried: self.tried, kept }, complete })
            }
            (None, Some(refused)) => Err(refused),
            (None, None) => Err(selvedge_core::Error::NothingValid.into()),
        }
    }
}

/// Candidates are made beside each other: what each says of its steps would be a babel.
struct Quiet<'a>(&'a dyn Observer<2>);

impl Observer<2> for Quiet<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}
