//! What labels cost: their seams, and by themselves.

use selvedge_core::{Grid, SampleId, SeamCosts, SourceMap};
use selvedge_expansion::{Prices, Quad};

/// Stands where the start's own sample shows.
pub(super) const NONE: u8 = u8::MAX;

/// Prices of one expansion.
pub(super) struct LabelPrices<'a, const D: usize> {
    pub(super) costs: &'a SeamCosts<D>,
    pub(super) own: Option<&'a Grid<i32, D>>,
    /// By place, the sample and the label that show.
    pub(super) ids: &'a [SampleId],
    pub(super) standing: &'a [u8],
    /// The label that is offered.
    pub(super) offered: usize,
}

/// The price of a label at a place; what the start has costs nothing.
pub(super) fn own_price<const D: usize>(own: Option<&Grid<i32, D>>, label: u8, place: usize) -> i32 {
    own.filter(|_| label != NONE).map_or(0, |own| own.plane(usize::from(label))[place])
}

/// The price of all seams of a map, and of the labels that show.
pub(super) fn price_of<const D: usize>(
    costs: &SeamCosts<D>,
    own: Option<&Grid<i32, D>>,
    map: &SourceMap<D>,
    standing: &[u8],
) -> i64 {
    let labels = |_| standing.iter().enumerate().map(|(place, label)| i64::from(own_price(own, *label, place))).sum();
    costs.total(map) + own.map_or(0_i64, labels)
}

impl<const D: usize> Prices<D> for LabelPrices<'_, D> {
    #[inline]
    fn pair(&self, axis: usize, here: SampleId, there: SampleId) -> i32 {
        Prices::pair(self.costs, axis, here, there)
    }

    #[inline]
    fn unary(&self, place: usize, sample: SampleId) -> i32 {
        // A sample that shows already is its own label's, also where the offer is the same sample.
        let label = if sample == self.ids[place] { self.standing[place] } else { self.offered as u8 };
        own_price(self.own, label, place)
    }

    #[inline]
    fn difference(&self, old: SampleId, new: SampleId) -> u32 {
        Prices::difference(self.costs, old, new)
    }

    #[inline]
    fn quad(&self, axis: usize, old: [SampleId; 2], new: [SampleId; 2], differences: [u32; 2]) -> Quad {
        self.costs.quad(axis, old, new, differences)
    }
}
