//! The output in the making.

use selvedge_core::{Domain, Exemplars, Grid, Patch, SampleId, SeamCosts, SourceMap, Window};
use selvedge_expansion::{Frame, Holes, Pin, Proposal, Scratch, expand};

use crate::error::Error;
use crate::error_cells::ErrorCells;

/// The map so far, the cost of its seams, and what must not change.
#[derive(Debug)]
pub(crate) struct Canvas<'e, const D: usize> {
    pub(crate) exemplars: &'e Exemplars<D>,
    pub(crate) costs: SeamCosts<D>,
    pub(crate) map: SourceMap<D>,
    /// Positions whose sample stays.
    pub(crate) fixed: Option<Grid<bool, D>>,
    /// By position, which sources may show.
    pub(crate) allowed: Option<Grid<u64, D>>,
    pub(crate) cells: ErrorCells<D>,
    /// Positions without a sample.
    pub(crate) holes: usize,
}

/// A patch cut into the canvas, but not laid yet.
#[derive(Debug)]
pub(crate) struct Offer<const D: usize> {
    pub(crate) frame: Frame<D>,
    pub(crate) proposal: Proposal,
}

impl<const D: usize> Offer<D> {
    /// How much the seams' cost falls by it; only comparable between offers that fill nothing.
    pub(crate) fn gain(&self) -> i64 {
        self.proposal.gain
    }
}

impl<'e, const D: usize> Canvas<'e, D> {
    /// A canvas that starts from a map; `cell` are the sides of the boxes over which seam costs are summed.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub(crate) fn new(
        exemplars: &'e Exemplars<D>,
        costs: SeamCosts<D>,
        map: SourceMap<D>,
        fixed: Option<Grid<bool, D>>,
        allowed: Option<Grid<u64, D>>,
        cell: [u32; D],
    ) -> Result<Self, Error> {
        let holes = map.holes();
        let mut cells = ErrorCells::new(map.domain(), cell)?;
        cells.update(&map, &costs, &Window::all(map.domain()));
        Ok(Self { exemplars, costs, map, fixed, allowed, cells, holes })
    }

    pub(crate) fn domain(&self) -> Domain<D> {
        self.map.domain()
    }

    /// The cost of all seams.
    pub(crate) fn energy(&self) -> i64 {
        self.cells.total()
    }

    /// The sample that a patch may show at a position, given unwrapped.
    pub(crate) fn offered(&self, patch: &Patch<D>, at: [i32; D]) -> Option<SampleId> {
        let source = &self.exemplars.sources()[patch.source];
        let from = source.domain().step([0; D], std::array::from_fn(|a| at[a] - patch.offset[a]))?;
        let valid = source.valid.as_deref().is_none_or(|v| v.get(0, from));
        let here = self.domain().step([0; D], at)?;
        let allowed = self.allowed.as_ref().is_none_or(|a| a.get(0, here) >> patch.source & 1 == 1);
        (valid && allowed).then(|| self.exemplars.table().id(patch.source, from))
    }

    /// Cuts a patch, seen through a window, into what is there.
    ///
    /// # Errors
    /// [`Error::Cut`]
    pub(crate) fn offer(
        &self,
        patch: &Patch<D>,
        window: &Window<D>,
        scratch: &mut Scratch<D>,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Offer<D>, Error> {
        let mut frame = Frame::of_patch(self.exemplars, &self.map, patch, window)?;
        if let Some(allowed) = &self.allowed {
            frame.allow(|place| allowed.plane(0)[place] >> patch.source & 1 == 1);
        }
        let fixed = self.fixed.as_ref().map(Grid::samples);
        let choices = frame.choices(Holes::Fill, |place| fixed.filter(|f| f[place]).map(|_| Pin::Old))?;
        let proposal = expand(&frame, &choices, &self.costs, scratch, cancelled)?;
        Ok(Offer { frame, proposal })
    }

    /// Takes an offer.
    pub(crate) fn lay(&mut self, offer: &Offer<D>) {
        offer.proposal.lay(&offer.frame, &mut self.map);
        self.holes -= offer.proposal.filled;
        self.cells.update(&self.map, &self.costs, &offer.frame.window);
    }

    /// Fills all holes, each with the next sample.
    pub(crate) fn fill_each(&mut self, mut next: impl FnMut() -> SampleId) {
        self.map.ids.plane_mut(0).iter_mut().filter(|id| !id.is_assigned()).for_each(|id| *id = next());
        self.holes = 0;
        self.cells.update(&self.map, &self.costs, &Window::all(self.map.domain()));
    }

    /// Takes an offer if the cost of all seams falls by it; says whether it did.
    pub(crate) fn improve(&mut self, offer: &Offer<D>) -> bool {
        if offer.gain() <= 0 {
            return false;
        }
        let before = self.energy();
        self.lay(offer);
        debug_assert!(0 < offer.proposal.filled || before - self.energy() == offer.gain(), "gains are true");
        true
    }
}
