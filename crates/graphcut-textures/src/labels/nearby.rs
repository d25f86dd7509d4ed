//! Labels moved by a sample, where they show: of a map that was decided at half the size, offsets are right to within
//! one, and seams lie near where they should.

use std::collections::BTreeSet;

use selvedge_core::{Domain, Event, Exemplars, Grid, Run, SeamCosts, SourceMap, Window, reserve, try_vec};
use selvedge_expansion::{Choice, Frame, Holes, Pin, Scratch, expand};

use crate::error::Error;
use crate::labels::label::Label;
use crate::labels::options::LabelOptions;
use crate::labels::sets::Sets;

/// How far around its piece, or a tile, a label is offered. Without it seams are 4 to 10 % dearer: a label that shows
/// beside a tile is not offered in it.
const AROUND: u32 = 16;

/// Sides of tiles. With 32 seams of large holes are 2 % dearer; with 128 they are cheaper, and cuts take far longer.
const TILE: u32 = 64;

/// A map whose labels are moved, what of it stays, and what may show there.
pub(super) struct Nearby<'a, const D: usize> {
    pub(super) exemplars: &'a Exemplars<D>,
    pub(super) costs: &'a SeamCosts<D>,
    pub(super) map: SourceMap<D>,
    /// Places whose labels are moved.
    pub(super) within: &'a [bool],
    /// Positions that stay as they are.
    pub(super) fixed: &'a Grid<bool, D>,
    pub(super) sources: Option<&'a Grid<u64, D>>,
    pub(super) run: &'a Run<'a, D>,
    pub(super) scratch: Scratch<D>,
    /// Cuts that were solved.
    pub(super) expansions: u64,
}

impl<const D: usize> Nearby<'_, D> {
    /// Offers all moves by at most a sample: of each piece of a label around it, since a piece moves as a whole; then
    /// of the labels in tiles where they show, half a tile aside the second time. False if the run was cancelled
    /// before.
    ///
    /// # Errors
    /// [`Error::Cut`], [`Error::Core`].
    pub(super) fn run(&mut self) -> Result<bool, Error> {
        match self.pieces_moved().and_then(|()| self.tiles_moved()) {
            Ok(()) => Ok(true),
            Err(error) if error.is_cancelled() => Ok(false),
            Err(error) => Err(error),
        }
    }

    fn pieces_moved(&mut self) -> Result<(), Error> {
        for (label, window) in self.pieces()? {
            self.offer(moves(label), &window)?;
        }
        Ok(())
    }

    fn tiles_moved(&mut self) -> Result<(), Error> {
        for shift in [0, TILE / 2] {
            for tile in self.tiles(shift) {
                self.offer(self.moved(&tile), &tile)?;
            }
        }
        Ok(())
    }

    /// An expansion for each of some labels over a window.
    fn offer(&mut self, labels: impl IntoIterator<Item = Label<D>>, window: &Window<D>) -> Result<(), Error> {
        let (options, mut frame) = (LabelOptions::default(), None::<Frame<D>>);
        for label in labels {
            let only = [label];
            let sets = Sets::of(self.exemplars, &only, &options, self.map.domain(), None);
            let offered = sets.offered(0, window)?.into_iter();
            let mut now = match frame.take() {
                Some(mut frame) => {
                    frame.offer(window, offered);
                    frame
                }
                None => Frame::new(&self.map, window, offered)?,
            };
            self.decide(&mut now, label.source)?;
            frame = Some(now);
        }
        self.run.observer.event(&Event::step("labels", self.expansions, 0));
        Ok(())
    }

    /// One expansion.
    fn decide(&mut self, frame: &mut Frame<D>, source: usize) -> Result<(), Error> {
        let ids = self.map.ids.plane(0);
        let is_let = |place: usize| self.sources.is_none_or(|s| s.plane(0)[place] >> source & 1 == 1);
        // Holes that stay are no places to fill.
        frame.allow(|place| ids[place].is_assigned() && is_let(place));
        let choices = frame.choices(Holes::Fill, |place| self.fixed.samples()[place].then_some(Pin::Old))?;
        let mut both = choices.iter().zip(frame.old.iter().zip(&frame.new));
        if !both.any(|(choice, (old, new))| *choice == Choice::Free && old != new) {
            return Ok(());
        }
        let proposal = expand(frame, &choices, self.costs, &mut self.scratch, &|| self.run.observer.cancelled())?;
        self.expansions += 1;
        if 0 < proposal.gain {
            proposal.lay(frame, &mut self.map);
            frame.take(&proposal.taken);
        }
        Ok(())
    }

    /// The label of a place that counts.
    fn label(&self, place: usize) -> Option<Label<D>> {
        let at = self.map.domain().position(place);
        let (source, from) = self.map.locate(at).filter(|_| self.within[place])?;
        let offset = std::array::from_fn(|a| at[a] as i32 - from[a] as i32);
        Some(Label { source, offset: self.map.domain().wrapped(offset) })
    }

    /// The labels that show in a window, and their moves, each once: many are moves of each other.
    fn moved(&self, window: &Window<D>) -> BTreeSet<Label<D>> {
        let places = window.places(self.map.domain()).flatten();
        let labels: BTreeSet<Label<D>> = places.filter_map(|place| self.label(place)).collect();
        labels.into_iter().flat_map(moves).collect()
    }

    /// Boxes of which something may change, and what is around them.
    fn tiles(&self, shift: u32) -> Vec<Window<D>> {
        let domain = self.map.domain();
        let tile = |at: [u32; D]| {
            let start = at.map(|p| (p * TILE) as i32 - shift as i32);
            let tile = Window { start, shape: [TILE; D] }.inside(Domain::open(domain.shape));
            let changes = |place: usize| self.within[place] && !self.fixed.samples()[place];
            let any = tile.places(domain).flatten().any(changes);
            any.then(|| tile.grown(domain, [AROUND; D], [AROUND; D]))
        };
        Domain::<D>::open(domain.shape.map(|n| (n + shift).div_ceil(TILE))).positions().filter_map(tile).collect()
    }

    /// The labels of connected places, and the boxes around them, in the order of their first places.
    fn pieces(&self) -> Result<Vec<(Label<D>, Window<D>)>, Error> {
        let (domain, mut found) = (self.map.domain(), Vec::new());
        let mut seen = try_vec(domain.len(), false)?;
        for place in 0..domain.len() {
            let Some(label) = self.label(place).filter(|_| !seen[place]) else { continue };
            let window = self.piece(place, &mut seen)?;
            reserve(&mut found, 1)?;
            found.push((label, window.grown(domain, [AROUND; D], [AROUND; D])));
        }
        Ok(found)
    }

    /// The box around the piece of a place, all of which is seen then.
    fn piece(&self, place: usize, seen: &mut [bool]) -> Result<Window<D>, Error> {
        let (map, domain) = (&self.map, self.map.domain());
        let first = domain.position(place).map(|p| p as i32);
        let (mut low, mut high, mut open) = (first, first, vec![first]);
        seen[place] = true;
        while let Some(at) = open.pop() {
            low = std::array::from_fn(|a| low[a].min(at[a]));
            high = std::array::from_fn(|a| high[a].max(at[a]));
            for (axis, by) in (0..D).flat_map(|axis| [(axis, 1), (axis, -1)]) {
                let mut next = at;
                next[axis] += by;
                let [Some(to), Some(here)] = [next, if by < 0 { next } else { at }].map(|p| domain.step([0; D], p))
                else {
                    continue;
                };
                let place = domain.index(to);
                let is_there = self.within[place] && !seen[place] && map.ids.plane(0)[place].is_assigned();
                if is_there && !map.is_seam(here, axis) {
                    seen[place] = true;
                    reserve(&mut open, 1)?;
                    open.push(next);
                }
            }
        }
        let shape = std::array::from_fn(|a| ((high[a] - low[a] + 1) as u32).min(domain.shape[a]));
        Ok(Window { start: low, shape })
    }
}

/// A label, and its moves by a sample.
fn moves<const D: usize>(label: Label<D>) -> impl Iterator<Item = Label<D>> {
    let by = move |step: [u32; D]| std::array::from_fn(|a| label.offset[a] + step[a] as i32 - 1);
    Domain::<D>::open([3; D]).positions().map(move |step| Label { offset: by(step), ..label })
}
