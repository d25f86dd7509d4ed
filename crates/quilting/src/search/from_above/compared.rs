//! Places at one size, compared exactly as far as it matters.

use selvedge_core::reserve;
use selvedge_fft_ssd::{Pattern, Place, SsdSearcher, Template};

use crate::options::Error;
use crate::search::{Candidate, Within};

/// Places that are compared with a pattern, each no further than it matters.
pub(super) struct Compared<'c, 'e> {
    searcher: &'c SsdSearcher<'e, 2>,
    pattern: Pattern<'c>,
    places: &'c mut Vec<Place>,
}

impl<'c, 'e> Compared<'c, 'e> {
    /// Compares a part of the pattern everywhere, and puts what is likest in it first: its error is soon too little for
    /// most others.
    pub(super) fn new(
        searcher: &'c SsdSearcher<'e, 2>,
        template: Template<'c, 2>,
        places: &'c mut Vec<Place>,
    ) -> Result<Self, Error> {
        let pattern = Pattern::new(&template, searcher.channels())?;
        places.iter_mut().for_each(|place| searcher.compare(&pattern, place, 0));
        places.sort_unstable_by_key(|p| (p.error, p.source, p.at));
        Ok(Self { searcher, pattern, places })
    }

    /// The candidate at a place, if its error is no more than so much.
    fn at(&mut self, number: usize, most: u64) -> Option<Candidate> {
        let place = &mut self.places[number];
        if place.error <= most {
            self.searcher.compare(&self.pattern, place, most);
        }
        let is_near = self.pattern.is_done(place) && place.error <= most;
        is_near.then_some(Candidate { error: place.error, source: place.source, at: place.at })
    }

    /// The first `k` by error, source and position.
    pub(super) fn least(&mut self, k: usize, to: &mut Vec<Candidate>) -> Result<(), Error> {
        to.clear();
        reserve(to, k + 1)?;
        for number in 0..self.places.len() {
            let most = if to.len() < k { u64::MAX } else { to[k - 1].error };
            if let Some(found) = self.at(number, most) {
                to.insert(to.partition_point(|c| *c < found), found);
                to.truncate(k);
            }
        }
        Ok(())
    }

    /// All within a tolerance of the first, in the order of source and position.
    pub(super) fn near(&mut self, within: Within<'_>, to: &mut Vec<Candidate>) -> Result<(), Error> {
        self.least(1, to)?;
        let Some(best) = to.pop() else { return Ok(()) };
        let limit = u128::from(best.error) * (1000 + u128::from(within(&best))) / 1000;
        let limit = u64::try_from(limit).unwrap_or(u64::MAX);
        reserve(to, self.places.len())?;
        for number in 0..self.places.len() {
            to.extend(self.at(number, limit));
        }
        to.sort_unstable_by_key(|c| (c.source, c.at));
        Ok(())
    }
}
