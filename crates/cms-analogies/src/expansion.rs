//! One alpha-expansion: who of a label's window takes it. `[CMS IV-C step 3]`

use selvedge_core::{Exemplars, Grid, Patch, SampleId, SeamCosts, Window, reserve, try_vec};
use selvedge_expansion::{Frame, Holes, Pin, Prices, Quad, Scratch, expand};

use crate::agreement::of_label;
use crate::boxes::Boxes;
use crate::constraint::DUMMY;
use crate::error::Error;
use crate::labelling::Labelling;
use crate::stats::Stats;
use crate::uses::Uses;

/// Tries labels. Its memory is used again.
pub(crate) struct Expansions<'a> {
    exemplars: &'a Exemplars<2>,
    fixed: Option<&'a Grid<bool, 2>>,
    /// `A'` of the label, by place of the output; means something in its window.
    offer: Vec<i32>,
    /// By place: true where the label could ever be taken.
    possible: Vec<bool>,
    boxes: Boxes,
    scaled: Vec<u64>,
    costs: Vec<i32>,
    scratch: Scratch<2>,
    /// No sample's pairwise prices can fall by more.
    most_saved: i64,
    pruning: bool,
}

/// `A'` and `B`. `[CMS eq. 6]`
struct Both<'a> {
    seams: &'a SeamCosts<2>,
    uses: &'a Uses,
    standing: &'a [SampleId],
    own: &'a [i32],
    offer: &'a [i32],
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
        let own = if self.standing[place] == sample { self.own[place] } else { self.offer[place] };
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

impl<'a> Expansions<'a> {
    pub(crate) fn new(
        exemplars: &'a Exemplars<2>,
        fixed: Option<&'a Grid<bool, 2>>,
        samples: usize,
        pruning: bool,
    ) -> Result<Self, Error> {
        let weight: u32 = exemplars.weights().iter().map(|&w| u32::from(w)).sum();
        let norm = (f64::from(weight).sqrt() * 255.0 * f64::from(SeamCosts::<2>::SCALE)).ceil() as i64;
        Ok(Self {
            exemplars,
            fixed,
            offer: try_vec(samples, 0)?,
            possible: try_vec(samples, false)?,
            boxes: Boxes::default(),
            scaled: Vec::new(),
            costs: Vec::new(),
            scratch: Scratch::default(),
            // Four neighbours, and a seam is two norms.
            most_saved: 4 * 2 * norm,
            pruning,
        })
    }

    /// Lays the label where that lowers `E'`, and answers what has changed. It may show at `at`, also where it is
    /// longer than an output that goes around; `within` of an output that does not, no more is tried.
    pub(crate) fn expand(
        &mut self,
        labelling: &mut Labelling<'_>,
        patch: &Patch<2>,
        at: [u32; 2],
        within: Option<&Window<2>>,
        stats: &mut Stats,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Option<Window<2>>, Error> {
        stats.expansions += 1;
        let Some((window, saturated)) = self.offered(labelling, patch, at, within)? else { return Ok(None) };
        stats.saturated += saturated;
        let Some(window) = self.considered(labelling, patch, &window, stats)? else { return Ok(None) };
        let frame = Frame::of_patch(self.exemplars, &labelling.map, patch, &window)?;
        let (fixed, possible) = (self.fixed, &self.possible);
        let pin = |place: usize| {
            let kept = !possible[place] || fixed.is_some_and(|f| f.samples()[place] && labelling.own[place] != DUMMY);
            kept.then_some(Pin::Old)
        };
        let choices = frame.choices(Holes::Fill, pin)?;
        let prices = Both {
            seams: &labelling.seams,
            uses: &labelling.uses,
            standing: labelling.map.ids.plane(0),
            own: &labelling.own,
            offer: &self.offer,
        };
        let proposal = expand(&frame, &choices, &prices, &mut self.scratch, cancelled)?;
        stats.nodes += proposal.free as u64;
        stats.truncated += proposal.truncated as u64;
        // Uses were priced as they are; taking many samples of a part makes it dearer for each.
        let priced = priced_uses(&labelling.uses, &frame, &proposal.taken);
        let more = labelling.uses.growth(&frame, &proposal.taken)? - priced;
        if proposal.filled == 0 && proposal.gain() <= more {
            return Ok(None);
        }
        let changed = labelling.lay(&frame, &proposal.taken, |place| self.offer[place])?;
        stats.improvements += u64::from(changed.is_some());
        Ok(changed)
    }

    /// Prices a label wherever it could show, in a window or everywhere; where that is, and how many were too large.
    fn offered(
        &mut self,
        labelling: &Labelling<'_>,
        patch: &Patch<2>,
        at: [u32; 2],
        within: Option<&Window<2>>,
    ) -> Result<Option<(Window<2>, u64)>, Error> {
        let output = labelling.map.domain();
        let mut window = patch.footprint(self.exemplars, &Window::all(output));
        let wide = window;
        for a in (0..2).filter(|&a| output.periodic[a] && output.shape[a] < wide.shape[a]) {
            // Once around, with the place that it was chosen for as near to the middle as it goes.
            let last = window.end(a) - output.shape[a] as i32;
            window.start[a] = (at[a] as i32 - output.shape[a] as i32 / 2).clamp(window.start[a], last);
            window.shape[a] = output.shape[a];
        }
        let window = window.inside(output);
        let shared = within.filter(|_| output.periodic == [false; 2]).map(|within| window.shared(within));
        let Some(window) = shared.unwrap_or(Some(window)) else { return Ok(None) };
        if window.is_empty() {
            return Ok(None);
        }
        let saturated = of_label(&labelling.terms, patch, &window, &mut self.boxes, &mut self.scaled, &mut self.costs)?;
        for (place, &cost) in window.places(output).zip(&self.costs) {
            if let Some(place) = place {
                self.offer[place] = cost;
            }
        }
        Ok(Some((window, saturated)))
    }

    /// How much less all samples of a window that a label agrees with better would cost with it, whatever its seams.
    pub(crate) fn promise(
        &mut self,
        labelling: &Labelling<'_>,
        patch: &Patch<2>,
        within: &Window<2>,
    ) -> Result<i64, Error> {
        let at = within.start.map(|p| p.max(0) as u32);
        let Some((window, _)) = self.offered(labelling, patch, at, Some(within))? else { return Ok(0) };
        let (output, standing) = (labelling.map.domain(), labelling.map.ids.plane(0));
        let price = |id: SampleId| i64::from(labelling.uses.price(id));
        let places = window.places(output).zip(patch.samples(self.exemplars, &window));
        let saved = places.filter_map(|(place, new)| {
            let place = place.filter(|_| new.is_assigned())?;
            let saved = i64::from(labelling.own[place]) - i64::from(self.offer[place]);
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
        &mut self,
        labelling: &Labelling<'_>,
        patch: &Patch<2>,
        window: &Window<2>,
        stats: &mut Stats,
    ) -> Result<Option<Window<2>>, Error> {
        let output = labelling.map.domain();
        let all = labelling.holes != 0 || !self.pruning;
        let (mut low, mut high, mut left) = ([u32::MAX; 2], [0; 2], 0);
        let mut defined = Vec::new();
        reserve(&mut defined, window.len())?;
        defined.extend(patch.samples(self.exemplars, window));
        let standing = labelling.map.ids.plane(0);
        let price = |id: SampleId| i64::from(labelling.uses.price(id));
        let wide = window.shape[1].max(1);
        for (i, (place, new)) in window.places(output).zip(defined).enumerate() {
            let Some(place) = place else { continue };
            let defined = new.is_assigned();
            let excess = i64::from(self.offer[place]) - i64::from(labelling.own[place]);
            let excess = excess + price(new) - price(standing[place]);
            self.possible[place] = all || defined && excess <= self.most_saved;
            if self.possible[place] {
                let at = [i as u32 / wide, i as u32 % wide];
                low = [0, 1].map(|a| low[a].min(at[a]));
                high = [0, 1].map(|a| high[a].max(at[a] + 1));
            } else {
                left += u64::from(defined);
            }
        }
        stats.pruned += left;
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

/// What a proposal was told that uses would grow by.
fn priced_uses(uses: &Uses, frame: &Frame<2>, taken: &[bool]) -> i64 {
    if uses.is_off() {
        return 0;
    }
    let price = |id: SampleId| i64::from(uses.price(id));
    (0..taken.len()).filter(|&i| taken[i]).map(|i| price(frame.new[i]) - price(frame.old[i])).sum()
}
