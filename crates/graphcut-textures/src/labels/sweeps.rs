//! Sweeps of expansions over boxes of positions that may change.

use selvedge_core::{Event, Exemplars, Grid, Run, SampleId, SeamCosts, SourceMap, Start, Window, Woven, try_vec};
use selvedge_expansion::{Choice, Frame, Holes, Pin, Scratch, expand};

use crate::error::Error;
use crate::labels::first::{First, first};
use crate::labels::label::Label;
use crate::labels::options::{LabelOptions, LabelStats};
use crate::labels::prices::{LabelPrices, NONE, price_of};
use crate::labels::sets::Sets;
use crate::labels::windows::windows;

/// A labelling in the making.
pub(super) struct Sweeps<'a, const D: usize> {
    sets: Sets<'a, D>,
    options: &'a LabelOptions<D>,
    run: &'a Run<'a, D>,
    costs: &'a SeamCosts<D>,
    map: SourceMap<D>,
    /// By place, the label that shows.
    standing: Vec<u8>,
    /// Positions that stay as they are.
    fixed: Option<Grid<bool, D>>,
    parts: Vec<Part<D>>,
    scratch: Scratch<D>,
    energy: i64,
    stats: LabelStats,
}

/// A box of positions that may change, apart from all others.
struct Part<const D: usize> {
    window: Window<D>,
    /// How often it has changed.
    changes: u64,
    /// By label, the change after which it brought nothing.
    failed: Vec<Option<u64>>,
}

impl<'a, const D: usize> Sweeps<'a, D> {
    /// `known` are the labels of what stands; without them it is nobody's.
    ///
    /// # Errors
    /// Those of [`expand`](crate::labels::expand) that are known before the first cut.
    pub(super) fn new(
        exemplars: &'a Exemplars<D>,
        costs: &'a SeamCosts<D>,
        known: Option<&[u8]>,
        mut start: Start<D>,
        labels: &'a [Label<D>],
        options: &'a LabelOptions<D>,
        run: &'a Run<'a, D>,
    ) -> Result<Self, Error> {
        let sets = Sets::new(exemplars, labels, options, &mut start);
        let (mut map, fixed) = (start.map, start.fixed);
        let stood = known.map(|known| (known, map.ids.map(SampleId::is_assigned)));
        let First { mut standing, may, holes } = first(&sets, options, &mut map)?;
        if let Some((known, stood)) = stood {
            let known = known.iter().zip(stood?.plane(0).to_vec());
            standing.iter_mut().zip(known).filter(|(_, (_, stood))| *stood).for_each(|(to, (label, _))| *to = *label);
        }
        let domain = map.domain();
        let mut free = try_vec(domain.len(), false)?;
        for (place, free) in free.iter_mut().enumerate() {
            // What was a hole and can show one label alone shows it.
            let decided = may[place].is_power_of_two() || fixed.as_ref().is_some_and(|f| f.samples()[place]);
            *free = !decided && map.ids.plane(0)[place].is_assigned();
        }
        let part = |window| Part { window, changes: 0, failed: vec![None; labels.len()] };
        let parts = windows(domain, &free)?.into_iter().map(part).collect();
        let energy = price_of(costs, options.own.as_ref(), &map, &standing);
        let stats = LabelStats { holes, energy: vec![energy], ..LabelStats::default() };
        Ok(Self { sets, options, run, costs, map, standing, fixed, parts, scratch: Scratch::default(), energy, stats })
    }

    /// Sweeps until nothing changes; false if the run was cancelled before.
    ///
    /// # Errors
    /// [`Error::Cut`].
    pub(super) fn run_to_end(&mut self) -> Result<bool, Error> {
        match self.run() {
            Ok(()) => Ok(true),
            Err(error) if error.is_cancelled() => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Sweeps until nothing changes.
    ///
    /// # Errors
    /// [`Error::Cut`], also if the run was cancelled.
    fn run(&mut self) -> Result<(), Error> {
        for _ in 0..self.options.sweeps {
            self.stats.sweeps += 1;
            let mut changed = false;
            for label in 0..self.sets.labels.len() {
                for part in 0..self.parts.len() {
                    changed |= self.try_label(label, part)?;
                }
            }
            self.stats.energy.push(self.energy);
            if !changed {
                break;
            }
        }
        Ok(())
    }

    /// One expansion; says whether it changed something.
    fn try_label(&mut self, label: usize, part: usize) -> Result<bool, Error> {
        let Part { window, changes, ref failed } = self.parts[part];
        if failed[label] == Some(changes) {
            self.stats.skipped += 1;
            return Ok(false);
        }
        self.parts[part].failed[label] = Some(changes);
        let Some(window) = self.sets.reach(label, &window) else { return Ok(false) };
        let mut frame = Frame::new(&self.map, &window, self.sets.offered(label, &window)?.into_iter())?;
        if 0 < self.stats.holes {
            // Holes that stay are no places to fill.
            let ids = self.map.ids.plane(0);
            frame.allow(|place| ids[place].is_assigned());
        }
        let choices = frame.choices(Holes::Fill, |place| self.pin(label, place))?;
        if !choices.iter().zip(frame.old.iter().zip(&frame.new)).any(|(c, (old, new))| *c == Choice::Free && old != new)
        {
            return Ok(false);
        }
        let prices = LabelPrices {
            costs: self.costs,
            own: self.options.own.as_ref(),
            ids: self.map.ids.plane(0),
            standing: &self.standing,
            offered: label,
        };
        let cancelled = || self.run.observer.cancelled();
        let proposal = expand(&frame, &choices, &prices, &mut self.scratch, &cancelled)?;
        self.stats.expansions += 1;
        self.stats.truncated += proposal.truncated as u64;
        if proposal.gain <= 0 {
            return Ok(false);
        }
        proposal.lay(&frame, &mut self.map);
        // Where the offer is what shows, the cut knew the price of the label that has it, and that label stays.
        let other = frame.old.iter().zip(&frame.new).map(|(old, new)| old != new);
        let taken = frame.places.iter().zip(proposal.taken.iter().zip(other));
        let taken = taken.filter(|(_, (taken, other))| **taken && *other);
        taken.for_each(|(&place, _)| self.standing[place as usize] = label as u8);
        self.energy -= proposal.gain;
        self.stats.improvements += 1;
        self.parts[part].changes += 1;
        if proposal.truncated == 0 {
            // The best that there is was just done.
            self.parts[part].failed[label] = Some(self.parts[part].changes);
        }
        let (done, energy) = (self.stats.improvements, Some(self.energy));
        self.run.observer.event(&Event { energy, so_far: Some(&self.map), ..Event::step("labels", done, 0) });
        Ok(true)
    }

    /// What is decided about a place before the cut.
    fn pin(&self, label: usize, place: usize) -> Option<Pin> {
        let stays = self.fixed.as_ref().is_some_and(|f| f.samples()[place]);
        if stays || !self.sets.lets(label, place) { Some(Pin::Old) } else { None }
    }

    /// The labels that show, by place.
    pub(super) fn standing(&self) -> &[u8] {
        &self.standing
    }

    pub(super) fn answer(mut self, complete: bool) -> Woven<SourceMap<D>, LabelStats> {
        self.stats.shown = shown(&self.standing, self.sets.labels.len());
        Woven { result: self.map, stats: self.stats, complete }
    }
}

/// How often each label shows.
pub(super) fn shown(standing: &[u8], labels: usize) -> Vec<u64> {
    let mut shown = vec![0; labels];
    standing.iter().filter(|label| **label != NONE).for_each(|label| shown[usize::from(*label)] += 1);
    shown
}
