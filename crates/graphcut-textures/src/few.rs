//! Masks that leave a region few places, or none: these alone are compared, and where there is none nothing is.

use std::sync::Arc;

use selvedge_core::{Exemplars, Look, Patch, Source, Window, reserve};

use crate::candidates::Candidate;
use crate::error::Error;
use crate::usable::Usable;

/// Comparisons of single samples that a search is worth for each sample of a source: one by transforms takes some 100
/// nanoseconds for each.
const SEARCHED: usize = 8;

/// Samples of which one in so many is valid at most, and no two beside each other along all axes, are crumbs. Of more,
/// such as every other row, patches show something.
const CRUMBS: usize = 16;

/// Where regions of the shapes that a run may ask for stand on valid samples alone.
#[derive(Debug)]
pub(crate) struct Few<'e, const D: usize> {
    exemplars: &'e Exemplars<D>,
    /// The shape of error regions, and each half of the one before, down to one sample; none without masks.
    shapes: Vec<[u32; D]>,
    /// Of each shape and each source its places, if they are few.
    places: Vec<Vec<Option<Vec<[u32; D]>>>>,
    /// Of each source that has few places the samples that are valid.
    valid: Vec<Vec<[u32; D]>>,
}

/// Half of a region, which is tried where no source holds the region.
pub(crate) fn halved<const D: usize>(region: [u32; D]) -> [u32; D] {
    region.map(|n| n.div_ceil(2))
}

impl<'e, const D: usize> Few<'e, D> {
    /// Nothing is known.
    pub(crate) fn none(exemplars: &'e Exemplars<D>) -> Self {
        Self { exemplars, shapes: Vec::new(), places: Vec::new(), valid: Vec::new() }
    }

    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub(crate) fn new(exemplars: &'e Exemplars<D>, region: [u32; D]) -> Result<Self, Error> {
        let sources = exemplars.sources();
        let mut few = Self::none(exemplars);
        if sources.iter().all(|source| source.valid.is_none()) {
            return Ok(few);
        }
        let mut shape = region;
        loop {
            let samples = |source: &Source<D>| if shape == [1; D] { source.domain().len() / CRUMBS } else { 0 };
            let of = |source: &Arc<Source<D>>| source.few_places(shape, most(source).max(samples(source)));
            few.places.push(sources.iter().map(of).collect::<Result<_, _>>()?);
            few.shapes.push(shape);
            if shape == [1; D] {
                break;
            }
            shape = halved(shape);
        }
        let is_compared = |number: usize| {
            few.places.iter().any(|places| places[number].as_ref().is_some_and(|places| !places.is_empty()))
        };
        let list = |number: usize| if is_compared(number) { valid(&sources[number]) } else { Ok(Vec::new()) };
        few.valid = (0..sources.len()).map(list).collect::<Result<_, _>>()?;
        Ok(few)
    }

    /// The places for a shape in all usable sources, by source; `None` if they are not few.
    pub(crate) fn of(&self, shape: [u32; D], usable: Usable) -> Option<impl Iterator<Item = (usize, [u32; D])> + '_> {
        let number = self.shapes.iter().position(|&known| known == shape)?;
        let sources = move || self.places[number].iter().enumerate().filter(move |(source, _)| usable.has(*source));
        let all_are_few = sources().all(|(_, places)| places.is_some());
        all_are_few
            .then(|| sources().flat_map(|(source, places)| places.iter().flatten().map(move |&place| (source, place))))
    }

    /// The valid samples, with their sources, where masks leave no two of them beside each other along all axes, and
    /// few at all: no patch shows more than crumbs then.
    pub(crate) fn crumbs(&self) -> Option<Vec<(usize, [u32; D])>> {
        let [.., pairs, singles] = &self.places[..] else { return None };
        let none = pairs.iter().all(|places| places.as_ref().is_some_and(Vec::is_empty));
        let places: Option<Vec<&Vec<[u32; D]>>> = singles.iter().map(Option::as_ref).collect();
        let places = places.filter(|_| none)?.into_iter().enumerate();
        Some(places.flat_map(|(source, places)| places.iter().map(move |&at| (source, at))).collect())
    }

    /// The patch that lays a place over the region, and its mean squared difference where it and the look at a window
    /// are known; `None` where nothing is known of what it shows, unless that is so `everywhere`.
    pub(crate) fn candidate(
        &self,
        (source, place): (usize, [u32; D]),
        (region, window): (&Window<D>, &Window<D>),
        look: &Look,
        everywhere: bool,
    ) -> Option<Candidate<D>> {
        let offset: [i32; D] = std::array::from_fn(|a| region.start[a] - place[a] as i32);
        let (features, len) = (&self.exemplars.sources()[source].features, window.len());
        let (local, weights) = (window.local(), self.exemplars.weights());
        let (mut sum, mut samples) = (0_u64, 0_u64);
        for &from in &self.valid[source] {
            let at = std::array::from_fn(|a| (from[a] as i32 + offset[a] - window.start[a]) as u32);
            if !local.contains(at) {
                continue;
            }
            let at = local.index(at);
            if look.known()[at] {
                samples += 1;
                for (c, &weight) in weights.iter().enumerate() {
                    let difference = look.features()[c * len + at].abs_diff(features.get(c, from));
                    sum += u64::from(difference).pow(2) * u64::from(weight);
                }
            }
        }
        let cost = sum as f64 / samples.max(1) as f64;
        (everywhere || samples != 0).then_some(Candidate { patch: Patch { source, offset }, cost })
    }
}

/// Of how many places each valid sample is compared sooner than a search takes.
fn most<const D: usize>(source: &Source<D>) -> usize {
    let valid = source.valid.as_deref().map_or(source.domain().len(), |v| v.samples().iter().filter(|v| **v).count());
    source.domain().len().saturating_mul(SEARCHED) / valid.max(1)
}

fn valid<const D: usize>(source: &Source<D>) -> Result<Vec<[u32; D]>, Error> {
    let samples = || source.valid.iter().flat_map(|v| v.samples());
    let mut list = Vec::new();
    reserve(&mut list, samples().filter(|valid| **valid).count())?;
    list.extend(source.domain().positions().zip(samples()).filter(|(_, valid)| **valid).map(|(at, _)| at));
    Ok(list)
}
