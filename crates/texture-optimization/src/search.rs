//! The nearest neighborhoods of the exemplars: the M-step. `[Kwatra05 3]`

mod coherent;
mod displaced;
mod evenness;
mod exact;
mod reference;
mod tree;
mod weights;

pub(crate) use coherent::Listed;
pub(crate) use exact::{Exact, How};
pub(crate) use reference::Measure;

use crate::assignment::Place;

/// What a search answers for all neighborhoods, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Found {
    pub(crate) places: Vec<Place>,
    /// Mean squared distances, in squared grey levels, channels by their weights.
    pub(crate) distances: Vec<f64>,
    /// How many neighborhoods were looked for, those that kept what they had not counted.
    pub(crate) searched: usize,
}
