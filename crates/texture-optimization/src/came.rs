//! What neighborhoods of a frame go on from: what moved, and larger ones.

use selvedge_core::{Exemplars, Grid};

use crate::assignment::Place;
use crate::error::Error;
use crate::flow::Carried;
use crate::neighborhoods::Neighborhoods;
use crate::search::{Exact, Found};

/// Where neighborhoods at full resolution come from.
#[derive(Clone, Copy)]
pub(crate) struct Came<'a> {
    pub(crate) carried: &'a Carried,
    /// How far they were in the mean of the first frame that moved; by the level's number.
    pub(crate) first: &'a [f64],
    /// What larger ones found, once there are.
    pub(crate) larger: Option<(&'a Neighborhoods, &'a [Place])>,
}

/// Times by which neighborhoods beside each other may fit worse in the mean than those of the first frame that moved
/// did, and still be taken without a search of all places. Beside those of the frame before, what is allowed would grow
/// frame by frame.
const WORSE: f64 = 12.0;

impl Came<'_> {
    /// The first search of a level, by its neighborhoods and its number.
    ///
    /// Those of the first level, the largest as a rule, are looked for everywhere: what is complete, and large, is
    /// decided there. All others go on from what came, and from those before that hold them.
    pub(crate) fn search(
        &self,
        (exemplars, all, level): (&Exemplars<2>, &Neighborhoods, usize),
        exact: &mut Exact<'_>,
        x: &Grid<f64, 2>,
    ) -> Result<Option<Found>, Error> {
        let offered = |number: usize| {
            let Some((larger, found)) = self.larger else { return Vec::new() };
            let first = all.first(number);
            let mut places = self.carried.offered(exemplars, first, all.size);
            for (other, by) in larger.holding_all(first, all.size) {
                let moved = found[other].moved(exemplars, by.map(|n| n as i32));
                places.extend(moved.filter(|place| !places.contains(place)));
            }
            places
        };
        let limit = self.first.get(level).map_or(f64::NEG_INFINITY, |mean| mean * WORSE + 1.0);
        exact.search_carried(x, &offered, limit)
    }
}
