//! A larger texture without knobs: several settings and seeds make drafts of it, each is scored, the best are finished,
//! and the best of these is kept.
//!
//! The work follows from [`Options::effort`], never from a clock, so the same seed and effort give the same map on any
//! machine and any number of threads. A [`Candidate`] is a trait: what else makes a texture may join. What is kept can
//! be made again by its method alone, with the options and the seed that [`Stats`] tell; where its seams are mended,
//! from the map of the one that [`Trial::mends`] tells.
//!
//! # Features
//! `rayon` (default): candidates are made beside each other in the caller's pool; the result is the same without it.
#![forbid(unsafe_code)]

mod candidate;
mod error;
mod estimate;
mod mend;
mod options;
mod sizes;

pub use candidate::{Candidate, Draft, Graphcut, Rest, Settings};
pub use error::Error;
pub use estimate::estimate;
pub use options::Options;

use selvedge_core::{
    Bytes, Domain, Error as CoreError, ErrorKind, Event, Exemplars, Grid, Observer, Run, SampleId, Seed, SourceMap,
    Woven, par, try_vec,
};
use selvedge_metrics::{Columns, Judge, preference};

use candidate::of_kind;
use sizes::Sizes;

/// One candidate that was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The method's command.
    pub method: &'static str,
    /// Its options as used.
    pub used: Settings,
    /// Its seed.
    pub seed: Seed,
    /// True if it only told what its candidate would be worth.
    pub draft: bool,
    /// Which of those before it has its seams mended in this one.
    pub mends: Option<usize>,
    /// Its columns and preference; `None` where nothing was compared.
    pub scored: Option<(Columns, f64)>,
    /// What it shows, in features, reduced to at most [`SEEN`] a side; `None` where nothing was compared.
    pub picture: Option<Grid<u8, 2>>,
}

/// Samples a side of [`Trial::picture`] at most: what is told apart beside others on a sheet.
pub const SEEN: u32 = 192;

/// What was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Stats {
    /// In the order of trying.
    pub tried: Vec<Trial>,
    /// Which of them was kept.
    pub kept: usize,
}

/// Makes a texture of several candidates and keeps the best.
///
/// Candidates are taken in turns, each time with the next seed. Exemplars and outputs that are too small to be compared
/// have one. One whose method refuses the exemplars is left out.
///
/// What then stands best is made once more with its [seams mended](Options::mend). That is kept where it is preferred
/// by what it shows, and where nothing melts: stones that a cut has set side by side fade into each other, and lose a
/// tenth of the contrast that was there.
///
/// From 384 samples a side on, drafts are made and compared at a fraction of the size, which leaves 192 of exemplars,
/// and what was finished is compared there as well: which one is better shows there, for a fraction of the work.
///
/// # Errors
/// Of the core [`Amount`](selvedge_core::Error::Amount); the first candidate's if all fail; [`Error::Core`],
/// [`Error::Graphcut`], [`Error::Optimization`] and [`Error::Metrics`] if memory is short.
///
/// # Events
/// `"synthesize"` after each round, with how many drafts and candidates are done.
///
/// # Determinism
/// The map follows from exemplars, domain, options and seed alone. Draft `i` of `n` candidates has the seed `seed + i /
/// n`.
pub fn synthesize(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, Stats>, Error> {
    let [drafts, finished] = options.steps()?;
    run.limits.admit(output, Bytes(0))?;
    let is_compared = 0 < drafts && output.shape.iter().all(|&n| selvedge_metrics::LEAST <= n);
    let sizes = if is_compared { Sizes::new(exemplars, output)? } else { Sizes::default() };
    let judge = match is_compared.then(|| Judge::new(sizes.small(exemplars), run.simd)).transpose() {
        // Masks that leave no whole block at a half of the size, such as noise, leave nothing to compare.
        Err(selvedge_metrics::Error::TooSmall { .. } | selvedge_metrics::Error::Core(CoreError::NothingValid)) => None,
        judge => judge?,
    };
    let mends = options.mend && mend::is_affordable(exemplars, output);
    let of = (drafts + finished) as u64 + u64::from(mends);
    let mut bench = Bench { exemplars, sizes, output, run, judge, done: 0, of };
    let mut best = Best::default();
    if bench.judge.is_none() {
        // Nothing to choose by: the likeliest, which is first of any kind.
        bench.of = 1;
        let (all, _) = of_kind(exemplars, output, None, &run.limits)?;
        let only = Chosen { turn: Turn::new(0, all.len(), run.seed), preference: 0.0, rest: None };
        bench.finish(&all, vec![only], &mut best)?;
        return best.answer();
    }
    let (all, orderly) = of_kind(exemplars, output, None, &run.limits)?;
    let turns: Vec<Turn> = (0..drafts).map(|i| Turn::new(i, all.len(), run.seed)).collect();
    let small = if bench.sizes.are_several() {
        Some(of_kind(bench.sizes.small(exemplars), bench.sizes.output(output), Some(orderly), &run.limits)?.0)
    } else {
        None
    };
    let chosen = bench.draft(small.as_ref().unwrap_or(&all), &turns, finished, &mut best)?;
    bench.finish(&all, chosen, &mut best)?;
    if mends {
        bench.mend(&mut best)?;
    }
    let mut woven = best.answer()?;
    // What was left out might have been better.
    woven.complete &= !run.observer.cancelled();
    if bench.sizes.are_several() && woven.stats.tried[woven.stats.kept].draft {
        // Nothing was finished.
        woven.result = bench.sizes.raised(woven.result, exemplars, output)?;
    }
    Ok(woven)
}

/// A candidate's number and the seed that it is made with.
#[derive(Clone, Copy, Debug)]
struct Turn {
    which: usize,
    seed: Seed,
}

impl Turn {
    fn new(number: usize, candidates: usize, seed: Seed) -> Self {
        Self { which: number % candidates, seed: Seed(seed.0.wrapping_add((number / candidates) as u64)) }
    }
}

/// A draft that is to be finished.
struct Chosen {
    turn: Turn,
    preference: f64,
    /// Where it goes on; `None` if it begins again.
    rest: Option<Box<dyn Rest>>,
}

/// What is made at once, beside others.
enum Job<'a> {
    Draft(&'a dyn Candidate),
    Whole(&'a dyn Candidate),
    Rest(Box<dyn Rest>),
    /// A map, and which of what was tried it is of.
    Mend {
        of: usize,
        map: &'a SourceMap<2>,
    },
}

/// Where candidates are made and scored.
struct Bench<'a> {
    exemplars: &'a Exemplars<2>,
    /// Where drafts are made, and everything is compared.
    sizes: Sizes,
    output: Domain<2>,
    run: &'a Run<'a, 2>,
    judge: Option<Judge>,
    done: u64,
    of: u64,
}

impl Bench<'_> {
    /// Makes and scores drafts; answers with the most preferred, but for those that were refused or cancelled.
    fn draft(
        &mut self,
        all: &[Box<dyn Candidate>],
        turns: &[Turn],
        most: usize,
        best: &mut Best,
    ) -> Result<Vec<Chosen>, Error> {
        let mut chosen = Vec::new();
        for some in turns.chunks(par::threads().max(1)) {
            let jobs = some.iter().map(|turn| (Job::Draft(all[turn.which].as_ref()), turn.seed)).collect();
            for (made, &turn) in self.round(jobs).into_iter().zip(some) {
                let Some((preference, rest)) = best.take(made)? else { continue };
                // What was made small begins again.
                let rest = rest.filter(|_| !self.sizes.are_several());
                chosen.extend(preference.map(|preference| Chosen { turn, preference, rest }));
            }
            chosen.sort_by(|a, b| b.preference.total_cmp(&a.preference));
            chosen.truncate(most);
            if best.is_cancelled(self.run) {
                break;
            }
        }
        Ok(chosen)
    }

    /// Makes and scores whole candidates.
    fn finish(&mut self, all: &[Box<dyn Candidate>], mut chosen: Vec<Chosen>, best: &mut Best) -> Result<(), Error> {
        while !chosen.is_empty() && !best.is_cancelled(self.run) {
            let some = chosen.drain(..chosen.len().min(par::threads().max(1)));
            let job = |c: Chosen| (c.rest.map_or(Job::Whole(all[c.turn.which].as_ref()), Job::Rest), c.turn.seed);
            let jobs = some.map(job).collect();
            self.round(jobs).into_iter().try_for_each(|made| best.take(made).map(|_| ()))?;
        }
        Ok(())
    }

    /// Makes one more of what stands best, with its seams mended, unless that is a small draft. It is kept instead
    /// where it is preferred, but for what melted.
    fn mend(&mut self, best: &mut Best) -> Result<(), Error> {
        let Some((kept, map, true)) = &best.kept else { return Ok(()) };
        let of = &best.tried[*kept];
        if of.draft || best.is_cancelled(self.run) {
            return Ok(());
        }
        let before = shown(self.exemplars, map)?;
        for made in self.round(vec![(Job::Mend { of: *kept, map }, of.seed)]) {
            match made {
                Ok(made) if mend::is_melted(&before, &shown(self.exemplars, &made.map)?) => best.tried.push(made.trial),
                made => _ = best.take(made)?,
            }
        }
        Ok(())
    }

    /// Some at once, each on a thread; small if they are drafts.
    fn round(&mut self, jobs: Vec<(Job<'_>, Seed)>) -> Vec<Result<Attempt, Error>> {
        let mut done: Vec<_> = jobs.into_iter().map(|(job, seed)| (Some(job), seed, None)).collect();
        par::for_rows(&mut done, 1, |_, row| {
            if let [(job, seed, made)] = row {
                *made = job.take().map(|job| self.make(job, *seed));
            }
        });
        self.done += done.len() as u64;
        self.run.observer.event(&Event::step("synthesize", self.done, self.of));
        done.into_iter().filter_map(|(_, _, made)| made).collect()
    }

    fn make(&self, job: Job<'_>, seed: Seed) -> Result<Attempt, Error> {
        let run = Run { seed, observer: &Quiet(self.run.observer), ..*self.run };
        let (is_draft, method, mends) = match &job {
            Job::Draft(c) => (true, c.method(), None),
            Job::Whole(c) => (false, c.method(), None),
            Job::Rest(rest) => (false, rest.method(), None),
            Job::Mend { of, .. } => (false, mend::METHOD, Some(*of)),
        };
        let Draft { woven, rest } = match job {
            Job::Draft(candidate) => {
                candidate.draft(self.sizes.small(self.exemplars), self.sizes.output(self.output), &run)?
            }
            Job::Whole(candidate) => Draft { woven: candidate.weave(self.exemplars, self.output, &run)?, rest: None },
            Job::Rest(rest) => Draft { woven: rest.finish(self.exemplars, &run)?, rest: None },
            Job::Mend { map, .. } => Draft { woven: mend::mended(self.exemplars, map, &run)?, rest: None },
        };
        let scored = match &self.judge {
            Some(judge) if woven.complete => Some(self.scored(judge, &woven.result, is_draft)?),
            _ => None,
        };
        let (scored, picture) = scored.unzip();
        let draft = is_draft && (self.sizes.are_several() || rest.is_some());
        let trial = Trial { method, used: woven.stats, seed, draft, mends, scored, picture };
        Ok(Attempt { trial, map: woven.result, complete: woven.complete, rest })
    }

    /// What a map is worth, at the size of drafts, and what it shows.
    fn scored(&self, judge: &Judge, map: &SourceMap<2>, is_small: bool) -> Result<(Scored, Grid<u8, 2>), Error> {
        let reduced = if is_small { None } else { self.sizes.reduced(map)? };
        let map = reduced.as_ref().unwrap_or(map);
        let shown = shown(self.sizes.small(self.exemplars), map)?;
        let columns = judge.columns(&shown, Some(map))?;
        Ok(((columns, preference(&columns)), shown.reduced(SEEN)?))
    }
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

/// Columns, and the preference that follows from them.
type Scored = (Columns, f64);

/// What one candidate came to.
struct Attempt {
    trial: Trial,
    map: SourceMap<2>,
    complete: bool,
    rest: Option<Box<dyn Rest>>,
}

/// The preference of what was made, where it was compared, and what is left to do of it.
type Taken = (Option<f64>, Option<Box<dyn Rest>>);

/// The best so far.
#[derive(Default)]
struct Best {
    tried: Vec<Trial>,
    kept: Option<(usize, SourceMap<2>, bool)>,
    refused: Option<Error>,
}

impl Best {
    /// Keeps one that is preferred, or finished, or more complete; of equals the first. `None` if it was refused.
    fn take(&mut self, made: Result<Attempt, Error>) -> Result<Option<Taken>, Error> {
        let made = match made {
            Ok(made) => made,
            Err(e) if matches!(e.kind(), ErrorKind::Option | ErrorKind::Input) => {
                self.refused.get_or_insert(e);
                return Ok(None);
            }
            Err(e) => return Err(e),
        };
        let preference = |trial: &Trial| trial.scored.map(|(_, preference)| preference);
        let is_better = self.kept.as_ref().is_none_or(|(kept, _, whole)| {
            let (kept, trial) = (&self.tried[*kept], &made.trial);
            match trial.mends {
                Some(_) => {
                    let columns = trial.scored.zip(kept.scored);
                    made.complete && columns.is_some_and(|(own, other)| mend::is_preferred(&own.0, &other.0))
                }
                None => (*whole, !kept.draft, preference(kept)) < (made.complete, !trial.draft, preference(trial)),
            }
        });
        let Attempt { trial, map, complete, rest } = made;
        if is_better {
            self.kept = Some((self.tried.len(), map, complete));
        }
        let taken = preference(&trial);
        self.tried.push(trial);
        Ok(Some((taken, rest)))
    }

    /// True if the run was cancelled and something was made.
    fn is_cancelled(&self, run: &Run<'_, 2>) -> bool {
        self.kept.is_some() && run.observer.cancelled()
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
