//! One alpha-expansion: who of a label's window takes it. `[CMS IV-C step 3]`

use selvedge_core::{Domain, Exemplars, Grid, Patch, SampleId, SeamCosts, Window, reserve, try_vec};
use selvedge_expansion::{Frame, Holes, Pin, Prices, Proposal, Quad, Scratch, expand};

use crate::agreement::of_label;
use crate::boxes::Boxes;
use crate::constraint::{DUMMY, MOST_AGREEMENT};
use crate::error::Error;
use crate::labelling::Labelling;
use crate::stats::Stats;
use crate::uses::Uses;

/// What is offered nowhere: more than anything costs.
const NEVER: i32 = i32::MAX;

/// Tries labels: what one would change is found first, that of several beside each other, and laid then.
#[derive(Clone, Copy)]
pub(crate) struct Expansions<'a> {
    exemplars: &'a Exemplars<2>,
    fixed: Option<&'a Grid<bool, 2>>,
    /// No sample's pairwise prices can fall by more.
    most_saved: i64,
    pruning: bool,
}

/// Memory of a trial, used again.
#[derive(Default)]
pub(crate) struct Desk {
    /// The place that offers begin with, that of the window's first row, and how many there are.
    first: usize,
    all: usize,
    /// `A'` of the label, by place; means something in its window.
    offer: Vec<i32>,
    /// By place: true where the label could ever be taken.
    possible: Vec<bool>,
    boxes: Boxes,
    scaled: Vec<u64>,
    costs: Vec<i32>,
    scratch: Scratch<2>,
}

/// A label that was tried.
#[derive(Default)]
pub(crate) struct Trial {
    change: Option<Change>,
    saturated: u64,
    pruned: u64,
}

/// What it would change.
struct Change {
    frame: Frame<2>,
    proposal: Proposal,
    /// `A'` of the samples that take it, in order.
    costs: Vec<i32>,
}

/// `A'` and `B`. `[CMS eq. 6]`
struct Both<'a> {
    seams: &'a SeamCosts<2>,
    uses: &'a Uses,
    standing: &'a [SampleId],
    own: &'a [i32],
    desk: &'a Desk,
}

impl Prices<2> for Both<'_> {
    #[inline]
    fn pair(&self, axis: usize, here: SampleId, there: SampleId) -> i32 {
        self.seams.pair(axis, here, there)
    }

    #[inline]
    fn unary(&self, place: usize, sample: SampleId) -> i32 {
        if !sample.is_assigned() {
            return DUMMY;
        }
        let own = if self.standing[place] == sample { self.own[place] } else { self.desk.offer[self.desk.at(place)] };
        own + self.uses.price(sample)
    }

    #[inline]
    fn difference(&self, old: SampleId, new: SampleId) -> u32 {
        self.seams.difference(old, new)
    }

    #[inline]
    fn quad(&self, axis: usize, old: [SampleId; 2], new: [SampleId; 2], differences: [u32; 2]) -> Quad {
        self.seams.quad(axis, old, new, differences)
    }
}

impl Desk {
    /// Lays what a window was priced with at its places, in room for the rows that it lies in.
    fn lay_out(&mut self, window: &Window<2>, output: Domain<2>) -> Result<(), Error> {
        let [rows, wide] = [window.shape[0], output.shape[1]].map(|n| n as usize);
        self.first = window.start[0].rem_euclid(output.shape[0].max(1) as i32) as usize * wide;
        self.all = output.len();
        let len = rows * wide;
        if self.offer.len() < len {
            self.offer = Vec::new();
            self.possible = Vec::new();
            self.offer = try_vec(len, 0)?;
            self.possible = try_vec(len, false)?;
        }
        for (place, &cost) in window.places(output).zip(&self.costs) {
            if let Some(place) = place {
                let there = self.at(place);
                self.offer[there] = cost;
            }
        }
        Ok(())
    }

    /// Where the offer to a place of the window's rows stands: rows that go around follow the last one.
    #[inline]
    fn at(&self, place: usize) -> usize {
        if place < self.first { place + self.all - self.first } else { place - self.first }
    }
}

impl<'a> Expansions<'a> {
    pub(crate) fn new(exemplars: &'a Exemplars<2>, fixed: Option<&'a Grid<bool, 2>>, pruning: bool) -> Self {
        let weight: u32 = exemplars.weights().iter().map(|&w| u32::from(w)).sum();
        let norm = (f64::from(weight).sqrt() * 255.0 * f64::from(SeamCosts::<2>::SCALE)).ceil() as i64;
        // Four neighbours, and a seam is two norms.
        Self { exemplars, fixed, most_saved: 4 * 2 * norm, pruning }
    }

    /// The most samples that a label may have.
    pub(crate) fn room(&self, output: Domain<2>) -> usize {
        let sources = self.exemplars.sources().iter().map(|source| source.domain().shape);
        let shared = |shape: [u32; 2]| shape[0].min(output.shape[0]) as usize * shape[1].min(output.shape[1]) as usize;
        sources.map(shared).max().unwrap_or(0)
    }

    /// What a label would change. It may show at `at`, also where it is longer than an output that goes around; in the
    /// label's own turn, no more is tried than `within`.
    pub(crate) fn try_label(
        &self,
        labelling: &Labelling<'_>,
        patch: &Patch<2>,
        at: [u32; 2],
        within: Option<&Window<2>>,
        desk: &mut Desk,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Trial, Error> {
        let mut trial = Trial::default();
        let Some(window) = self.priced(labelling, patch, at, within, desk)? else { return Ok(trial) };
        desk.lay_out(&window, labelling.map.domain())?;
        let Some(window) = self.considered(labelling, patch, &window, desk, &mut trial)? else {
            return Ok(trial);
        };
        let mut frame = Frame::of_patch(self.exemplars, &labelling.map, patch, &window)?;
        if labelling.is_masked {
            // On the ring nothing is offered.
            frame.allow(|place| desk.offer.get(desk.at(place)).is_none_or(|&cost| cost != NEVER));
        }
        let pin = |place: usize| {
            let fixed = self.fixed.is_some_and(|f| f.samples()[place] && labelling.own[place] != DUMMY);
            (fixed || !desk.possible[desk.at(place)]).then_some(Pin::Old)
        };
        let choices = frame.choices(Holes::Fill, pin)?;
        let mut scratch = std::mem::take(&mut desk.scratch);
        let prices = Both {
            seams: &labelling.seams,
            uses: &labelling.uses,
            standing: labelling.map.ids.plane(0),
            own: &labelling.own,
            desk,
        };
        let proposal = expand(&frame, &choices, &prices, &mut scratch, cancelled);
        desk.scratch = scratch;
        let proposal = proposal?;
        let taken = (0..proposal.taken.len()).filter(|&i| proposal.taken[i]);
        let mut costs = Vec::new();
        reserve(&mut costs, taken.clone().count())?;
        costs.extend(taken.map(|i| desk.offer[desk.at(frame.places[i] as usize)]));
        trial.change = Some(Change { frame, proposal, costs });
        Ok(trial)
    }

    /// Prices a label wherever it could show, in a window or everywhere; where that is.
    fn priced(
        &self,
        labelling: &Labelling<'_>,
        patch: &Patch<2>,
        at: [u32; 2],
        within: Option<&Window<2>>,
        desk: &mut Desk,
    ) -> Result<Option<Window<2>>, Error> {
        let output = labelling.map.domain();
        let around = within.copied().unwrap_or_else(|| Window::all(output));
        let footprint = patch.footprint(self.exemplars, &around);
        let shared = within.map(|within| footprint.shared(within));
        let Some(mut window) = shared.unwrap_or(Some(footprint)) else { return Ok(None) };
        let wide = window;
        for a in (0..2).filter(|&a| output.periodic[a] && output.shape[a] < wide.shape[a]) {
            // Once around, with the place that it was chosen for as near to the middle as it goes.
            let last = window.end(a) - output.shape[a] as i32;
            window.start[a] = (at[a] as i32 - output.shape[a] as i32 / 2).clamp(window.start[a], last);
            window.shape[a] = output.shape[a];
        }
        let window = window.inside(output);
        if window.is_empty() {
            return Ok(None);
        }
        let Desk { boxes, scaled, costs, .. } = desk;
        of_label(&labelling.terms, patch, &window, boxes, scaled, costs)?;
        Ok(Some(window))
    }

    /// How much less all samples of a window that a label agrees with better would cost with it, whatever its seams.
    pub(crate) fn promise(
        &self,
        labelling: &Labelling<'_>,
        patch: &Patch<2>,
        within: &Window<2>,
        desk: &mut Desk,
    ) -> Result<i64, Error> {
        let Some(window) =
            self.priced(labelling, patch, first_of(within, labelling.map.domain()), Some(within), desk)?
        else {
            return Ok(0);
        };
        let (output, standing) = (labelling.map.domain(), labelling.map.ids.plane(0));
        let price = |id: SampleId| i64::from(labelling.uses.price(id));
        let places = window.places(output).zip(&desk.costs).zip(patch.samples(self.exemplars, &window));
        let saved = places.filter_map(|((place, &cost), new)| {
            let place = place.filter(|_| new.is_assigned())?;
            let saved = i64::from(labelling.own[place]) - i64::from(cost);
            Some((saved + price(standing[place]) - price(new)).max(0))
        });
        Ok(saved.sum())
    }

    /// The box around all samples that could take the label whatever their neighbours do, with one more on every side;
    /// `None` without any. While there are holes it is the whole window.
    ///
    /// Taking the label costs a sample the difference of its agreements and can save no more than all seams around it.
    /// This is the first, coarsest step of the exact pruning in `selvedge-expansion`: it spares frames and norms of
    /// windows where next to nothing can happen.
    fn considered(
        &self,
        labelling: &Labelling<'_>,
        patch: &Patch<2>,
        window: &Window<2>,
        desk: &mut Desk,
        trial: &mut Trial,
    ) -> Result<Option<Window<2>>, Error> {
        let output = labelling.map.domain();
        let all = labelling.holes != 0 || !self.pruning;
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        let standing = labelling.map.ids.plane(0);
        let price = |id: SampleId| i64::from(labelling.uses.price(id));
        let wide = window.shape[1].max(1);
        for (i, (place, new)) in window.places(output).zip(patch.samples(self.exemplars, window)).enumerate() {
            let Some(place) = place else { continue };
            let (there, defined) = (desk.at(place), new.is_assigned() && labelling.may_show(new));
            trial.saturated += u64::from(defined && desk.offer[there] == MOST_AGREEMENT);
            if !defined {
                desk.offer[there] = NEVER;
            }
            let excess = i64::from(desk.offer[there]) - i64::from(labelling.own[place]);
            let excess = excess + price(new) - price(standing[place]);
            let possible = all || defined && excess <= self.most_saved;
            desk.possible[there] = possible;
            if possible {
                let at = [i as u32 / wide, i as u32 % wide];
                low = [0, 1].map(|a| low[a].min(at[a]));
                high = [0, 1].map(|a| high[a].max(at[a] + 1));
            } else {
                trial.pruned += u64::from(defined);
            }
        }
        if low[0] == u32::MAX {
            return Ok(None);
        }
        let start = [0, 1].map(|a| low[a].saturating_sub(1));
        let end = [0, 1].map(|a| (high[a] + 1).min(window.shape[a]));
        Ok(Some(Window {
            start: [0, 1].map(|a| window.start[a] + start[a] as i32),
            shape: [0, 1].map(|a| end[a] - start[a]),
        }))
    }
}

impl Trial {
    /// Lays the label where that lowers `E'`, and answers what has changed. Nothing that the trial looked at may have
    /// changed since.
    pub(crate) fn lay(self, labelling: &mut Labelling<'_>, stats: &mut Stats) -> Result<Option<Window<2>>, Error> {
        stats.expansions += 1;
        stats.saturated += self.saturated;
        stats.pruned += self.pruned;
        let Some(Change { frame, proposal, costs }) = self.change else { return Ok(None) };
        stats.nodes += proposal.free as u64;
        stats.truncated += proposal.truncated as u64;
        // Uses were priced as they are; taking many samples of a part makes it dearer for each.
        let priced = priced_uses(&labelling.uses, &frame, &proposal.taken);
        let more = labelling.uses.growth(&frame, &proposal.taken)? - priced;
        if proposal.filled == 0 && proposal.gain <= more {
            return Ok(None);
        }
        let changed = labelling.lay(&frame, &proposal.taken, &costs)?;
        stats.improvements += u64::from(changed.is_some());
        Ok(changed)
    }
}

/// The position that a window begins with.
pub(crate) fn first_of(window: &Window<2>, output: Domain<2>) -> [u32; 2] {
    [0, 1].map(|a| window.start[a].rem_euclid(output.shape[a].max(1) as i32) as u32)
}

/// What a proposal was told that uses would grow by.
fn priced_uses(uses: &Uses, frame: &Frame<2>, taken: &[bool]) -> i64 {
    if uses.is_off() {
        return 0;
    }
    let price = |id: SampleId| i64::from(uses.price(id));
    (0..taken.len()).filter(|&i| taken[i]).map(|i| price(frame.new[i]) - price(frame.old[i])).sum()
}
