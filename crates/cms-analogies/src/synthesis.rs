//! Steps 0 to 4: from nothing, or from a map, to an output that no label improves. `[CMS IV-C]`

use std::collections::BTreeMap;

use selvedge_core::{Event, Exemplars, Grid, Patch, Run, SampleId, SourceMap, Start, Window, Within, par};

use crate::agreement::Term;
use crate::constraint::{Constraint, unit};
use crate::error::Error;
use crate::expansion::{Desk, Expansions, Trial};
use crate::labelling::Labelling;
use crate::levels;
use crate::options::Options;
use crate::ranking::Ranking;
use crate::stats::Stats;

/// Labels that were searched for a place and did not help; they are the answer until something near the place changes.
/// (With a [spread](Options::spread) what shows elsewhere counts as well, a little: that is not asked again.)
struct Tried {
    /// Each with whether something has changed where it could show since it was tried.
    labels: Vec<(Patch<2>, bool)>,
    /// Whether nothing has: it would be in vain again.
    ///
    /// Where a constraint asks for what no exemplar holds, at borders of labels above all, errors stay the largest of
    /// the output. Were those places tried again and again, as the paper has it, they alone would fill the history, and
    /// the run would end with errors elsewhere that one expansion mends.
    is_idle: bool,
}

/// A run over one resolution.
pub(crate) struct Weaver<'a, 'r> {
    exemplars: &'a Exemplars<2>,
    options: &'a Options,
    run: &'r Run<'r, 2>,
    labelling: Labelling<'a>,
    expansions: Expansions<'a>,
    /// One for each thread.
    desks: Vec<Desk>,
    /// By place.
    tried: BTreeMap<usize, Tried>,
    /// By source, whether it may be used.
    allowed: &'a [bool],
    is_carried: bool,
    pub(crate) stats: Stats,
}

impl<'a, 'r> Weaver<'a, 'r> {
    pub(crate) fn new(
        (exemplars, terms): (&'a Exemplars<2>, Vec<Term<'a>>),
        (map, fixed): (SourceMap<2>, Option<&'a Grid<bool, 2>>),
        allowed: &'a [bool],
        options: &'a Options,
        run: &'r Run<'r, 2>,
        pruning: bool,
    ) -> Result<Self, Error> {
        Ok(Self {
            exemplars,
            options,
            run,
            labelling: Labelling::new(exemplars, terms, map, fixed, options)?,
            expansions: Expansions::new(exemplars, fixed, pruning),
            desks: std::iter::repeat_with(Desk::default).take(par::threads()).collect(),
            tried: BTreeMap::new(),
            allowed,
            is_carried: false,
            stats: Stats::default(),
        })
    }

    /// Works until nothing improves the output; false if it was cancelled before. What was carried up from a coarser
    /// level is settled first, so many times.
    pub(crate) fn weave(&mut self, settled: u32) -> Result<bool, Error> {
        self.is_carried = settled != 0;
        if self.labelling.holes == 0 {
            self.tell()?;
        }
        let done = match self.options.random_labels {
            Some(labels) => self.draw(labels),
            None => (0..settled)
                .try_fold(true, |done, _| Ok(done && self.settle()?))
                .and_then(|done| if done { self.search() } else { Ok(false) }),
        };
        match done {
            Err(error) if error.is_cancelled() => Ok(false),
            done => done,
        }
    }

    /// The map, and the counts.
    pub(crate) fn finish(mut self) -> Result<(SourceMap<2>, Stats), Error> {
        self.stats.model = self.labelling.energy();
        self.stats.truth = self.labelling.truth()?;
        Ok((self.labelling.map, self.stats))
    }

    /// `[CMS IV-C]`
    fn search(&mut self) -> Result<bool, Error> {
        let mut ranking = Ranking::new(self.exemplars, &self.labelling, self.options, self.run.simd)?;
        let least = self.options.least_gain(unit(self.exemplars));
        // Places share no tap.
        let reach = self.labelling.terms.iter().map(|term| term.taps.reach()).max().unwrap_or(0);
        let apart = 2 * reach.max(self.options.neighborhood) + 1;
        loop {
            let mut improved = false;
            let history = if self.labelling.holes == 0 { self.options.history as usize } else { 1 };
            for place in self.labelling.worst_places(history, apart) {
                if self.run.observer.cancelled() {
                    return Ok(false);
                }
                let before = (self.labelling.holes, self.labelling.energy().sum());
                self.improve(&mut ranking, place)?;
                let gain = before.1 - self.labelling.energy().sum();
                improved = self.labelling.holes < before.0 || least < gain;
                if improved {
                    break;
                }
            }
            if !improved {
                return self.check_filled().map(|()| true);
            }
        }
    }

    /// Refuses to end with places where nothing shows.
    fn check_filled(&self) -> Result<(), Error> {
        let hole = self.labelling.own.iter().position(|&own| own == crate::constraint::DUMMY);
        let Some(place) = hole else { return Ok(()) };
        Err(selvedge_core::Error::NoSource { at: self.labelling.map.domain().position(place).to_vec() }.into())
    }

    /// What lies nearer to a place that was tried in vain is like it: in a neighborhood of the output, however far
    /// apart taps of constraints are.
    fn near(&self) -> u32 {
        2 * self.options.neighborhood + 1
    }

    /// Tries the best labels for a place. `[CMS IV-C step 2]`
    fn improve(&mut self, ranking: &mut Ranking<'a>, place: usize) -> Result<(), Error> {
        let at = self.labelling.map.domain().position(place);
        let mut labels = match self.tried.remove(&place) {
            Some(known) => self.uncovered(place, known).labels,
            None => {
                self.stats.searches += 1;
                let labels = ranking.labels(&self.labelling, self.allowed, at)?;
                labels.into_iter().map(|label| (label, true)).collect()
            }
        };
        self.tried.insert(place, Tried { labels: Vec::new(), is_idle: false });
        let mut next = 0;
        loop {
            let some: Vec<usize> = (next..labels.len()).filter(|&i| labels[i].1).take(self.beside()).collect();
            let Some(last) = some.last() else { break };
            next = last + 1;
            let patches: Vec<Patch<2>> = some.iter().map(|&i| labels[i].0).collect();
            for (i, trial) in some.into_iter().zip(self.tried_beside(&patches, at)) {
                labels[i].1 = false;
                if let Some(changed) = self.lay(trial?)? {
                    // Only what others have changed makes it worth another try.
                    let others = labels.iter_mut().enumerate().filter(|(other, _)| *other != i);
                    others.for_each(|(_, label)| label.1 |= self.shows_in(&label.0, &changed));
                    self.forget(&changed);
                    // What was tried beside it has not seen that.
                    next = i + 1;
                    break;
                }
            }
        }
        // Gone if something that its search looked at has changed.
        if self.tried.remove(&place).is_some() {
            let is_idle = labels.iter().all(|(_, again)| !again);
            if is_idle {
                self.labelling.worst.cover(at, self.near());
            }
            self.tried.insert(place, Tried { labels, is_idle });
        }
        Ok(())
    }

    /// What was tried for a place, which is one to try again.
    fn uncovered(&mut self, place: usize, tried: Tried) -> Tried {
        if tried.is_idle {
            let at = self.labelling.map.domain().position(place);
            self.labelling.worst.uncover(at, self.near());
        }
        Tried { is_idle: false, ..tried }
    }

    /// True if a label could show beside what has changed.
    fn shows_in(&self, label: &Patch<2>, changed: &Window<2>) -> bool {
        let output = self.labelling.map.domain();
        let window = label.footprint(self.exemplars, &Window::all(output)).inside(output);
        window.meets(&changed.grown(output, [1; 2], [1; 2]), output)
    }

    /// Drops answers of searches that looked at what has changed, and marks labels that may now be taken.
    fn forget(&mut self, changed: &Window<2>) {
        let (output, half) = (self.labelling.map.domain(), self.options.neighborhood);
        let seen = changed.grown(output, [half; 2], [half; 2]);
        for (place, mut tried) in std::mem::take(&mut self.tried) {
            let at = output.position(place);
            if (Window { start: at.map(|p| p as i32), shape: [1; 2] }).meets(&seen, output) {
                self.uncovered(place, tried);
                continue;
            }
            for (label, again) in &mut tried.labels {
                *again |= self.shows_in(label, changed);
            }
            if tried.labels.iter().any(|(_, again)| *again) {
                tried = self.uncovered(place, tried);
            }
            self.tried.insert(place, tried);
        }
    }

    /// How many labels are tried for a place at once: each takes memory for its window, which is small where labels
    /// were carried up.
    fn beside(&self) -> usize {
        let room = self.expansions.room(self.labelling.map.domain());
        if self.is_carried { (room / 2 / levels::AROUND).clamp(1, self.desks.len()) } else { 1 }
    }

    /// Tries labels for a place, as if each was the only one.
    fn tried_beside(&mut self, labels: &[Patch<2>], at: [u32; 2]) -> Vec<Result<Trial, Error>> {
        let (labelling, expansions, observer) = (&self.labelling, self.expansions, self.run.observer);
        // What is large was placed at a coarser level.
        let around = self.is_carried.then(|| levels::around(at));
        par::map_with(&mut self.desks, labels.len(), |desk, i| {
            expansions.try_label(labelling, &labels[i], at, around.as_ref(), desk, &|| observer.cancelled())
        })
    }

    /// Lays what was tried, told to whoever watches.
    fn lay(&mut self, trial: Trial) -> Result<Option<Window<2>>, Error> {
        let changed = trial.lay(&mut self.labelling, &mut self.stats)?;
        if changed.is_some() && self.labelling.holes == 0 {
            self.tell()?;
        }
        Ok(changed)
    }

    /// Notes the energy, and tells it with what stands.
    fn tell(&mut self) -> Result<(), Error> {
        let energy = self.labelling.energy().sum();
        selvedge_core::reserve(&mut self.stats.energy, 1)?;
        self.stats.energy.push(energy);
        let event = Event::step("cms/expand", self.stats.expansions, 0);
        self.run.observer.event(&Event { energy: Some(energy), so_far: Some(&self.labelling.map), ..event });
        Ok(())
    }

    /// Schödl's baseline: labels at random instead of step 1 and 2. `[CMS IV-D]`
    fn draw(&mut self, labels: u32) -> Result<bool, Error> {
        let output = self.labelling.map.domain();
        let valid = self.exemplars.validity();
        let usable = |s: usize| self.allowed[s] && valid[s].is_none_or(|valid| valid.samples().contains(&true));
        if !(0..self.allowed.len()).any(usable) {
            // Nothing can be drawn.
            return self.check_filled().map(|()| true);
        }
        let (mut drawn, mut number) = (0, 0);
        while drawn < labels || self.labelling.holes != 0 {
            if self.run.observer.cancelled() {
                return Ok(false);
            }
            let mut rng = self.run.seed.derive("cms/random-label", number).rng();
            number += 1;
            let hole = (self.labelling.holes != 0).then(|| self.labelling.worst.places(1, 1));
            let hole = hole.and_then(|places| places.first().copied());
            let at = output.position(hole.unwrap_or_else(|| rng.below(output.len() as u32) as usize));
            let id = SampleId::new(rng.below(self.exemplars.table().len()));
            let Some((source, from)) = self.exemplars.locate(id) else { continue };
            if !self.allowed[source] || valid[source].is_some_and(|v| !v.get(0, from)) || !self.labelling.may_show(id) {
                continue;
            }
            drawn += 1;
            self.stats.searches += 1;
            let patch = Patch { source, offset: [0, 1].map(|a| at[a] as i32 - from[a] as i32) };
            for trial in self.tried_beside(&[patch], at) {
                self.lay(trial?)?;
            }
        }
        Ok(true)
    }
}

/// A run: the loop at each level, and what it came to. Energies are those of the finest one.
pub(crate) fn weave(
    exemplars: &Exemplars<2>,
    constraints: &[Constraint],
    start: &Start<2>,
    options: &Options,
    run: &Run<'_, 2>,
    pruning: bool,
) -> Result<(SourceMap<2>, Stats, bool), Error> {
    // What stands already was decided at full size; labels drawn at random are compared with the paper's loop.
    let begun = start.fixed.is_some() || start.map.ids.samples().iter().any(|id| id.is_assigned());
    let alone = begun || options.random_labels.is_some();
    let coarse = if alone { Vec::new() } else { levels::below(exemplars, constraints, options)? };
    let within = Run { observer: &Within(run.observer), ..*run };
    let allowed = allowed(exemplars, start);
    let (mut before, mut counts): (Option<SourceMap<2>>, Stats) = (None, Stats::default());
    let of = coarse.len() as u64 + 1;
    for (done, (number, level)) in (0..).zip(coarse.iter().enumerate().rev()) {
        let output = level.constraints[0].guide.target().domain();
        let map = match &before {
            Some(map) => map.finer(&level.exemplars, output)?,
            None => SourceMap::unassigned(&level.exemplars, output)?,
        };
        let shown = levels::whole(&map, &coarse[..number], exemplars, start.map.domain())?;
        run.observer.event(&Event { so_far: Some(&shown), ..Event::step("cms/level", done, of) });
        let terms = Term::list(&level.exemplars, &level.constraints, options);
        let mut weaver = Weaver::new((&level.exemplars, terms), (map, None), &allowed, options, &within, pruning)?;
        weaver.weave(if before.is_some() { levels::ROUNDS } else { 0 })?;
        let (map, stats) = weaver.finish()?;
        counts.add(&stats);
        before = Some(map);
    }
    let map = match &before {
        Some(map) => map.finer(exemplars, start.map.domain())?,
        None => copied(&start.map, exemplars)?,
    };
    if before.is_some() {
        run.observer.event(&Event { so_far: Some(&map), ..Event::step("cms/level", of - 1, of) });
    }
    let terms = Term::list(exemplars, constraints, options);
    let start = (map, start.fixed.as_ref());
    let mut weaver = Weaver::new((exemplars, terms), start, &allowed, options, run, pruning)?;
    let complete = weaver.weave(before.is_some().into())?;
    let (map, mut stats) = weaver.finish()?;
    stats.add(&counts);
    Ok((map, stats, complete))
}

fn copied(map: &SourceMap<2>, exemplars: &Exemplars<2>) -> Result<SourceMap<2>, Error> {
    let mut copy = SourceMap::unassigned(exemplars, map.domain())?;
    copy.ids.samples_mut().copy_from_slice(map.ids.samples());
    Ok(copy)
}

/// By source, whether it may be used. One that may not be used everywhere is used nowhere: labels are of whole sources.
pub(crate) fn allowed(exemplars: &Exemplars<2>, start: &Start<2>) -> Vec<bool> {
    let everywhere = start.sources.as_ref().map(|s| s.plane(0).iter().fold(u64::MAX, |all, bits| all & bits));
    (0..exemplars.sources().len()).map(|s| everywhere.is_none_or(|bits| bits >> s & 1 == 1)).collect()
}

mod settle;
#[cfg(test)]
mod tests;
