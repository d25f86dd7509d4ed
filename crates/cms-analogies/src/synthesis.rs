//! Steps 0 to 4: from nothing, or from a map, to an output that no label improves. `[CMS IV-C]`

use selvedge_core::{Event, Exemplars, Grid, Patch, Run, SampleId, SourceMap, Window};

use crate::agreement::Term;
use crate::error::Error;
use crate::expansion::Expansions;
use crate::labelling::Labelling;
use crate::options::Options;
use crate::ranking::Ranking;
use crate::start::Start;
use crate::stats::Stats;

/// Labels that were searched for a place and did not help; they are the answer until something near the place changes.
struct Tried {
    at: [u32; 2],
    /// Each with whether something has changed where it could show since it was tried.
    labels: Vec<(Patch<2>, bool)>,
}

/// A run over one resolution.
pub(crate) struct Weaver<'a, 'r> {
    exemplars: &'a Exemplars<2>,
    options: &'a Options,
    run: &'r Run<'r, 2>,
    labelling: Labelling<'a>,
    expansions: Expansions<'a>,
    tried: Vec<Tried>,
    pub(crate) stats: Stats,
}

impl<'a, 'r> Weaver<'a, 'r> {
    pub(crate) fn new(
        exemplars: &'a Exemplars<2>,
        terms: Vec<Term<'a>>,
        start: (&SourceMap<2>, Option<&'a Grid<bool, 2>>),
        options: &'a Options,
        run: &'r Run<'r, 2>,
        pruning: bool,
    ) -> Result<Self, Error> {
        let (map, fixed) = start;
        let samples = map.domain().len();
        let mut map_copy = SourceMap::unassigned(exemplars, map.domain())?;
        map_copy.ids.samples_mut().copy_from_slice(map.ids.samples());
        Ok(Self {
            exemplars,
            options,
            run,
            labelling: Labelling::new(exemplars, terms, map_copy, fixed, options)?,
            expansions: Expansions::new(exemplars, fixed, samples, pruning)?,
            tried: Vec::new(),
            stats: Stats::default(),
        })
    }

    /// Works until nothing improves the output; false if it was cancelled before.
    pub(crate) fn weave(&mut self) -> Result<bool, Error> {
        let done = match self.options.random_labels {
            Some(labels) => self.draw(labels),
            None => self.search(),
        };
        match done {
            Err(error) if error.is_cancelled() => Ok(false),
            done => done.map(|()| true),
        }
    }

    /// The map, and the counts.
    pub(crate) fn finish(mut self) -> Result<(SourceMap<2>, Stats), Error> {
        self.stats.model = self.labelling.energy();
        self.stats.truth = self.labelling.truth()?;
        Ok((self.labelling.map, self.stats))
    }

    /// `[CMS IV-C]`
    fn search(&mut self) -> Result<(), Error> {
        let mut ranking = Ranking::new(self.exemplars, &self.labelling, self.options, self.run.simd)?;
        let (apart, least) = (2 * self.options.neighborhood + 1, self.options.least_gain());
        loop {
            let mut improved = false;
            let history = if self.labelling.holes == 0 { self.options.history as usize } else { 1 };
            for place in self.labelling.worst.places(history, apart, &self.idle()) {
                let before = (self.labelling.holes, self.labelling.energy().sum());
                let at = self.labelling.map.domain().position(place);
                self.improve(&mut ranking, at)?;
                let gain = before.1 - self.labelling.energy().sum();
                improved = self.labelling.holes < before.0 || least < gain;
                if improved {
                    break;
                }
            }
            if !improved {
                return self.check_filled();
            }
        }
    }

    /// Refuses to end with places where nothing shows.
    fn check_filled(&self) -> Result<(), Error> {
        let hole = self.labelling.own.iter().position(|&own| own == crate::constraint::DUMMY);
        let Some(place) = hole else { return Ok(()) };
        Err(selvedge_core::Error::NoSource { at: self.labelling.map.domain().position(place).to_vec() }.into())
    }

    /// Places that were tried in vain, and near which nothing has changed since: they would be in vain again.
    ///
    /// Where a constraint asks for what no exemplar holds, at borders of labels above all, errors stay the largest of the
    /// output. Were those places tried again and again, as the paper has it, they alone would fill the history, and the run
    /// would end with errors elsewhere that one expansion mends.
    fn idle(&self) -> Vec<[u32; 2]> {
        let waits = |t: &&Tried| t.labels.iter().all(|(_, again)| !again);
        self.tried.iter().filter(waits).map(|t| t.at).collect()
    }

    /// Tries the best labels for a place. `[CMS IV-C step 2]`
    fn improve(&mut self, ranking: &mut Ranking<'a>, at: [u32; 2]) -> Result<(), Error> {
        let mut labels = match self.tried.iter().position(|t| t.at == at) {
            Some(known) => self.tried.swap_remove(known).labels,
            None => {
                self.stats.searches += 1;
                ranking.labels(&self.labelling, at)?.into_iter().map(|label| (label, true)).collect()
            }
        };
        self.tried.push(Tried { at, labels: Vec::new() });
        for i in 0..labels.len() {
            if std::mem::take(&mut labels[i].1) {
                let patch = labels[i].0;
                let changed = self.expand(&patch, at)?;
                if let Some(changed) = changed {
                    // Only what others have changed makes it worth another try.
                    let others = labels.iter_mut().enumerate().filter(|(other, _)| *other != i);
                    others.for_each(|(_, label)| label.1 |= self.shows_in(&label.0, &changed));
                    self.forget(&changed);
                }
            }
        }
        if let Some(tried) = self.tried.iter_mut().find(|t| t.at == at) {
            tried.labels = labels;
        }
        Ok(())
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
        let sees = |at: [u32; 2]| Window { start: at.map(|p| p as i32), shape: [1; 2] }.meets(&seen, output);
        self.tried.retain(|t| !sees(t.at));
        let mut tried = std::mem::take(&mut self.tried);
        for label in tried.iter_mut().flat_map(|t| &mut t.labels) {
            label.1 |= self.shows_in(&label.0, changed);
        }
        self.tried = tried;
    }

    /// One expansion, told to whoever watches.
    fn expand(&mut self, patch: &Patch<2>, at: [u32; 2]) -> Result<Option<Window<2>>, Error> {
        let cancelled = || self.run.observer.cancelled();
        let changed = self.expansions.expand(&mut self.labelling, patch, at, &mut self.stats, &cancelled)?;
        if changed.is_some() && self.labelling.holes == 0 {
            let energy = self.labelling.energy().sum();
            selvedge_core::reserve(&mut self.stats.energy, 1)?;
            self.stats.energy.push(energy);
            let event = Event::step("cms/expand", self.stats.expansions, 0);
            self.run.observer.event(&Event { energy: Some(energy), so_far: Some(&self.labelling.map), ..event });
        }
        Ok(changed)
    }

    /// Schödl's baseline: labels at random instead of step 1 and 2. `[CMS IV-D]`
    fn draw(&mut self, labels: u32) -> Result<(), Error> {
        let output = self.labelling.map.domain();
        let valid = self.exemplars.validity();
        let (mut drawn, mut number) = (0, 0);
        while drawn < labels || self.labelling.holes != 0 {
            let mut rng = self.run.seed.derive("cms/random-label", number).rng();
            number += 1;
            let hole = (self.labelling.holes != 0).then(|| self.labelling.worst.places(1, 1, &[]));
            let hole = hole.and_then(|places| places.first().copied());
            let at = output.position(hole.unwrap_or_else(|| rng.below(output.len() as u32) as usize));
            let id = SampleId::new(rng.below(self.exemplars.table().len()));
            let Some((source, from)) = self.exemplars.locate(id) else { continue };
            if valid[source].is_some_and(|v| !v.get(0, from)) {
                continue;
            }
            drawn += 1;
            self.stats.searches += 1;
            self.expand(&Patch { source, offset: [0, 1].map(|a| at[a] as i32 - from[a] as i32) }, at)?;
        }
        Ok(())
    }
}

/// A run: the loop, and what it came to.
pub(crate) fn weave(
    exemplars: &Exemplars<2>,
    terms: &[Term<'_>],
    start: &Start,
    options: &Options,
    run: &Run<'_, 2>,
    pruning: bool,
) -> Result<(SourceMap<2>, Stats, bool), Error> {
    let begin = (&start.map, start.fixed.as_ref());
    let mut weaver = Weaver::new(exemplars, terms.to_vec(), begin, options, run, pruning)?;
    let complete = weaver.weave()?;
    let (map, stats) = weaver.finish()?;
    Ok((map, stats, complete))
}
