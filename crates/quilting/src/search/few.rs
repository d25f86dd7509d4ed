//! Masks that leave few places for a block: those alone are compared.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use selvedge_core::{Exemplars, reserve};
use selvedge_fft_ssd::{Pattern, Place, SsdSearcher};

use super::{Avoid, Candidate, Term, Within};
use crate::options::Error;

/// Of so many samples one place: with more of them, a search of all is as fast. One comparison of a small block costs
/// what a search does at some two hundred places.
const SEARCHED: u64 = 256;
/// So few are compared by themselves in any case.
const LEAST: u64 = 16;

/// The places for blocks of all shapes that were asked for so far.
#[derive(Debug)]
pub(super) struct Few<'e> {
    exemplars: &'e Exemplars<2>,
    is_masked: bool,
    most: usize,
    known: Mutex<Known>,
}

/// By shape; `None` where many places hold a block.
type Known = BTreeMap<[u32; 2], Option<Arc<Vec<Place>>>>;

impl<'e> Few<'e> {
    pub(super) fn new(exemplars: &'e Exemplars<2>) -> Self {
        let is_masked = exemplars.sources().iter().all(|source| source.valid.is_some());
        let most = (u64::from(exemplars.table().len()) / SEARCHED).max(LEAST) as usize;
        Self { exemplars, is_masked, most, known: Mutex::default() }
    }

    /// All places for a block, by source and position; `None` if they are not few.
    pub(super) fn of(&self, shape: [u32; 2]) -> Result<Option<Arc<Vec<Place>>>, Error> {
        if !self.is_masked {
            return Ok(None);
        }
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known().get(&shape) {
            return Ok(found.clone());
        }
        // Who asks for a shape that is known does not wait; two who ask for a new one at once list the same.
        let found = self.list(shape)?;
        Ok(known().entry(shape).or_insert(found).clone())
    }

    fn list(&self, shape: [u32; 2]) -> Result<Option<Arc<Vec<Place>>>, Error> {
        let mut all = Vec::new();
        for (number, source) in self.exemplars.sources().iter().enumerate() {
            let Some(places) = source.few_places(shape, self.most)? else { return Ok(None) };
            reserve(&mut all, places.len())?;
            all.extend(places.into_iter().map(|at| Place::new(number, at)));
        }
        Ok((all.len() <= self.most).then(|| Arc::new(all)))
    }
}

/// The weighted sum of all terms at each of some places.
pub(super) fn compare<'t, 'e: 't>(
    few: &[Place],
    terms: impl Iterator<Item = (&'t SsdSearcher<'e, 2>, &'t Term<'t>)>,
    places: &mut Vec<Place>,
    all: &mut Vec<Candidate>,
) -> Result<(), Error> {
    all.clear();
    reserve(all, few.len())?;
    all.extend(few.iter().map(|place| Candidate { error: 0, source: place.source, at: place.at }));
    for (searcher, term) in terms {
        let pattern = Pattern::new(&term.template, searcher.channels())?;
        places.clear();
        reserve(places, few.len())?;
        places.extend_from_slice(few);
        for (place, candidate) in places.iter_mut().zip(&mut *all) {
            searcher.compare(&pattern, place, u64::MAX);
            candidate.error = candidate.error.saturating_add(term.weight.saturating_mul(place.error));
        }
    }
    Ok(())
}

/// What [`Search::near`](super::Search::near) finds among these, which are all that there are.
pub(super) fn near_of(
    all: &[Candidate],
    within: Within<'_>,
    avoid: Avoid<'_>,
    found: &mut Vec<Candidate>,
) -> Result<(), Error> {
    let allowed = |c: &&Candidate| !avoid(c.source, c.at);
    let is_any = all.iter().any(|c| allowed(&c));
    let passes = |c: &&Candidate| !is_any || allowed(c);
    found.clear();
    let Some(best) = all.iter().filter(passes).min() else { return Ok(()) };
    let limit = u128::from(best.error) * (1000 + u128::from(within(best)));
    reserve(found, all.len())?;
    found.extend(all.iter().filter(passes).filter(|c| u128::from(c.error) * 1000 <= limit));
    Ok(())
}
