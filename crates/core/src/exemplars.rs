//! Exemplars as methods see them: features and validity, one source an orientation.

use std::sync::Arc;

use crate::resample;
use crate::source_table::SourceTable;
use crate::{Domain, Encoder, Error, Grid, Origin, Plane, SampleId, Transform};

/// One exemplar in one orientation.
#[derive(Clone, Debug, PartialEq)]
pub struct Source<const D: usize> {
    /// 8-bit features, one channel after the other.
    pub features: Grid<u8, D>,
    /// Which samples may be used; `None` for all. Shared with guides over the same source.
    pub valid: Option<Arc<Grid<bool, D>>>,
    /// Where it came from.
    pub origin: Origin,
}

impl<const D: usize> Source<D> {
    /// Shape and topology.
    pub fn domain(&self) -> Domain<D> {
        self.features.domain()
    }

    fn new(features: &Grid<u8, D>, valid: Option<&Grid<bool, D>>, origin: Origin) -> Result<Self, Error> {
        let valid = shown_validity(features.domain(), valid, origin.transform)?.map(Arc::new);
        Ok(Self { features: shown(features, origin.transform)?, valid, origin })
    }
}

/// What sources are made of: one exemplar, where it may be used, and how it is shown.
///
/// ```
/// use selvedge_core::{Domain, Encoder, Exemplar, Exemplars, Grid, Plane, Role, Samples, Transform};
/// # fn main() -> Result<(), selvedge_core::Error> {
/// let plane = [Plane::new(Role::Scalar, Samples::U8(Grid::from_vec(Domain::open([1, 2]), 1, vec![7, 9])?))];
/// let mask = Grid::from_vec(Domain::open([1, 2]), 1, vec![true, false])?;
/// let turns = [Transform::IDENTITY, Transform::new(90.0, 1.0, false)];
/// let exemplar = Exemplar::new(&plane).masked(Some(&mask)).shown(&turns);
/// let exemplars = Exemplars::new(&Encoder::fit(&[&plane])?, &[exemplar])?;
/// assert_eq!(exemplars.sources()[1].domain().shape, [2, 1]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Exemplar<'a, const D: usize> {
    /// Its registered planes.
    pub planes: &'a [Plane<D>],
    /// Samples where this is false are not used; `None` for all. What is transparent in any plane is not used either.
    pub mask: Option<&'a Grid<bool, D>>,
    /// Its orientations and scales, one source each.
    pub transforms: &'a [Transform],
}

impl<'a, const D: usize> Exemplar<'a, D> {
    /// All of it, as it is.
    pub const fn new(planes: &'a [Plane<D>]) -> Self {
        Self { planes, mask: None, transforms: &[Transform::IDENTITY] }
    }

    /// The same where a mask is true.
    #[must_use]
    pub const fn masked(self, mask: Option<&'a Grid<bool, D>>) -> Self {
        Self { mask, ..self }
    }

    /// The same in these orientations and scales.
    #[must_use]
    pub const fn shown(self, transforms: &'a [Transform]) -> Self {
        Self { transforms, ..self }
    }

    /// Its sources. The one that shows it as it is takes the features as they are, so that they are held once.
    fn sources(&self, number: usize, encoder: &Encoder) -> Result<Vec<Source<D>>, Error> {
        let features = encoder.encode(self.planes)?;
        let valid = validity(number, self.planes, self.mask)?;
        if let Some(&transform) = self.transforms.iter().find(|transform| !transform.is_valid()) {
            return Err(Error::Transform { transform });
        }
        let origin = |&transform: &Transform| Origin { exemplar: number as u16, transform };
        let identity = self.transforms.iter().position(|&transform| transform == Transform::IDENTITY);
        let others = self.transforms.iter().enumerate().filter(|&(i, _)| Some(i) != identity);
        let mut sources =
            others.map(|(_, t)| Source::new(&features, valid.as_ref(), origin(t))).collect::<Result<Vec<_>, _>>()?;
        if let Some(i) = identity {
            sources.insert(i, Source { features, valid: valid.map(Arc::new), origin: origin(&Transform::IDENTITY) });
        }
        Ok(sources)
    }
}

/// The features of an exemplar, as a transform shows them.
pub(crate) fn shown<const D: usize>(features: &Grid<u8, D>, transform: Transform) -> Result<Grid<u8, D>, Error> {
    match transform.resampling() {
        Some(by) => resample::resample(features, by, f64::from, |v| (v + 0.5).clamp(0.0, 255.0) as u8),
        None => oriented(features, transform, 0),
    }
}

/// A mask like this one.
pub(crate) fn copied<const D: usize>(mask: Option<&Grid<bool, D>>) -> Result<Option<Grid<bool, D>>, Error> {
    mask.map(|mask| mask.map(|v| v)).transpose()
}

/// What of an exemplar is valid, as a transform shows it.
pub(crate) fn shown_validity<const D: usize>(
    exemplar: Domain<D>,
    valid: Option<&Grid<bool, D>>,
    transform: Transform,
) -> Result<Option<Grid<bool, D>>, Error> {
    match transform.resampling() {
        Some(resampling) => resample::validity(exemplar, valid, resampling).map(Some),
        None => valid.map(|v| oriented(v, transform, false)).transpose(),
    }
}

impl<const D: usize> SourceTable<D> {
    /// Which samples of each source may be used, `None` for all: those that the exemplar's plane (its alpha) and its
    /// mask leave, as the source shows them.
    ///
    /// # Errors
    /// [`Error::PlaneCount`] without a plane for each exemplar, [`Error::MaskShape`].
    pub fn validity(
        &self,
        planes: &[&Plane<D>],
        masks: &[Option<Grid<bool, D>>],
    ) -> Result<Vec<Option<Grid<bool, D>>>, Error> {
        let of = |(e, plane): (usize, &&Plane<D>)| {
            validity(e, std::slice::from_ref(*plane), masks.get(e).and_then(Option::as_ref))
        };
        let valid = planes.iter().enumerate().map(of).collect::<Result<Vec<_>, _>>()?;
        let shown = |(origin, _): &(Origin, Domain<D>)| {
            let e = usize::from(origin.exemplar);
            let plane = planes.get(e).ok_or(Error::PlaneCount { expected: e + 1, found: planes.len() })?;
            shown_validity(plane.domain(), valid[e].as_ref(), origin.transform)
        };
        self.sources().iter().map(shown).collect()
    }
}

/// The grid as a transform shows it.
pub(crate) fn oriented<T: Copy, const D: usize>(
    grid: &Grid<T, D>,
    transform: Transform,
    fill: T,
) -> Result<Grid<T, D>, Error> {
    if transform == Transform::IDENTITY {
        return grid.map(|v| v);
    }
    let domain = transform.domain(grid.domain());
    let mut out = Grid::try_filled(domain, grid.channels(), fill)?;
    for at in domain.positions() {
        let (to, from) = (domain.index(at), grid.domain().index(transform.origin(domain, at)));
        for c in 0..grid.channels() {
            out.plane_mut(c)[to] = grid.plane(c)[from];
        }
    }
    Ok(out)
}

/// All sources of a run, their samples numbered through, so that one number names a sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Exemplars<const D: usize> {
    /// Shared by views of some of them.
    sources: Vec<Arc<Source<D>>>,
    table: SourceTable<D>,
    weights: Vec<u8>,
}

impl<const D: usize> Exemplars<D> {
    /// Each exemplar as it is masked and shown, in order.
    ///
    /// # Errors
    /// Those of [`Encoder::encode`], [`Error::TooManySamples`], [`Error::EmptyExemplar`], [`Error::NothingValid`],
    /// [`Error::Transform`], and [`Error::MaskShape`].
    pub fn new(encoder: &Encoder, exemplars: &[Exemplar<'_, D>]) -> Result<Self, Error> {
        let mut sources = Vec::new();
        for (number, exemplar) in exemplars.iter().enumerate() {
            sources.extend(exemplar.sources(number, encoder)?);
        }
        if let Some(empty) = sources.iter().find(|source| source.domain().is_empty()) {
            let (exemplar, shape) = (empty.origin.exemplar.into(), empty.domain().shape.to_vec());
            return Err(Error::EmptyExemplar { exemplar, shape });
        }
        Self::from_sources(sources, encoder.weights().to_vec())
    }

    /// The exemplars as they are, through an encoder fitted to them.
    ///
    /// # Errors
    /// Those of [`Encoder::fit`] and [`new`](Self::new).
    pub fn of(exemplars: &[&[Plane<D>]]) -> Result<Self, Error> {
        let all: Vec<Exemplar<'_, D>> = exemplars.iter().map(|planes| Exemplar::new(planes)).collect();
        Self::new(&Encoder::fit(exemplars)?, &all)
    }

    /// Takes ready sources; each feature channel has a weight.
    ///
    /// # Errors
    /// [`Error::NoExemplars`], [`Error::NoChannels`], [`Error::Weights`], [`Error::TooManySamples`],
    /// [`Error::NothingValid`].
    pub fn from_sources(sources: Vec<Source<D>>, weights: Vec<u8>) -> Result<Self, Error> {
        Self::from_shared(sources.into_iter().map(Arc::new).collect(), weights)
    }

    /// Some of the sources, by number, as exemplars of their own: their samples are numbered anew, and nothing is
    /// copied.
    ///
    /// # Errors
    /// [`Error::NoExemplars`] for none, [`Error::NothingValid`].
    ///
    /// # Panics
    /// If there is no source of such a number.
    pub fn only(&self, sources: impl IntoIterator<Item = usize>) -> Result<Self, Error> {
        let sources = sources.into_iter().map(|number| Arc::clone(&self.sources[number])).collect();
        Self::from_shared(sources, self.weights.clone())
    }

    fn from_shared(sources: Vec<Arc<Source<D>>>, weights: Vec<u8>) -> Result<Self, Error> {
        let first = sources.first().ok_or(Error::NoExemplars)?;
        let channels = first.features.channels();
        if channels == 0 {
            return Err(Error::NoChannels { exemplar: first.origin.exemplar.into() });
        }
        if channels != weights.len() || sources.iter().any(|s| s.features.channels() != channels) {
            return Err(Error::Weights { expected: channels, found: weights.len() });
        }
        let any_valid =
            |s: &Source<D>| s.valid.as_deref().map_or(!s.domain().is_empty(), |v| v.samples().contains(&true));
        if !sources.iter().any(|s| any_valid(s)) {
            return Err(Error::NothingValid);
        }
        let table = SourceTable::new(sources.iter().map(|s| (s.origin, s.domain())).collect())?;
        Ok(Self { sources, table, weights })
    }

    /// The same sources in other features, one grid a source and a weight a channel: every sample keeps its number, and
    /// what is valid stays so.
    ///
    /// # Errors
    /// [`Error::GuideCount`], [`Error::GuideShape`] (a grid and its source differ), [`Error::Weights`],
    /// [`Error::Allocation`].
    pub fn with_features(&self, features: Vec<Grid<u8, D>>, weights: Vec<u8>) -> Result<Self, Error> {
        if features.len() != self.sources.len() {
            return Err(Error::GuideCount { expected: self.sources.len(), found: features.len() });
        }
        let like = |(source, features): (&Arc<Source<D>>, Grid<u8, D>)| {
            let (expected, found) = (source.domain().shape.to_vec(), features.domain().shape.to_vec());
            if expected != found {
                return Err(Error::GuideShape { exemplar: source.origin.exemplar.into(), expected, found });
            }
            let features = features.with_periodic(source.domain().periodic);
            Ok(Source { features, valid: source.valid.clone(), origin: source.origin })
        };
        Self::from_sources(self.sources.iter().zip(features).map(like).collect::<Result<_, _>>()?, weights)
    }

    /// The same where others of the same sources are valid as well.
    pub(crate) fn valid_with(self, others: &[Option<Arc<Grid<bool, D>>>]) -> Result<Self, Error> {
        let both = |(own, other): (Arc<Source<D>>, &Option<Arc<Grid<bool, D>>>)| match (&own.valid, other) {
            (_, None) => Ok(own),
            (Some(one), Some(other)) if Arc::ptr_eq(one, other) => Ok(own),
            (one, Some(other)) => {
                let mut valid = other.map(|v| v)?;
                if let Some(one) = one {
                    valid.samples_mut().iter_mut().zip(one.samples()).for_each(|(all, &one)| *all &= one);
                }
                let features = own.features.map(|v| v)?;
                Ok(Arc::new(Source { features, valid: Some(Arc::new(valid)), origin: own.origin }))
            }
        };
        let sources = self.sources.into_iter().zip(others).map(both).collect::<Result<_, Error>>()?;
        Self::from_shared(sources, self.weights)
    }

    /// The same sources with other weights of their channels.
    ///
    /// # Errors
    /// [`Error::Weights`] if there are more or fewer than channels.
    pub fn weighing(self, weights: Vec<u8>) -> Result<Self, Error> {
        match (self.channels(), weights.len()) {
            (expected, found) if expected != found => Err(Error::Weights { expected, found }),
            _ => Ok(Self { weights, ..self }),
        }
    }

    /// The sources, in the order of their numbering.
    pub fn sources(&self) -> &[Arc<Source<D>>] {
        &self.sources
    }

    /// The domains of all sources, in order: what estimates of memory are asked with.
    pub fn domains(&self) -> Vec<Domain<D>> {
        self.sources.iter().map(|source| source.domain()).collect()
    }

    /// True if not all samples of all sources may be used.
    pub fn is_masked(&self) -> bool {
        self.sources.iter().any(|source| source.valid.is_some())
    }

    /// The numbering of samples.
    pub fn table(&self) -> &SourceTable<D> {
        &self.table
    }

    /// Which samples of each source may be used; `None` for all.
    pub fn validity(&self) -> Vec<Option<&Grid<bool, D>>> {
        self.sources.iter().map(|s| s.valid.as_deref()).collect()
    }

    /// Weight of each feature channel.
    pub fn weights(&self) -> &[u8] {
        &self.weights
    }

    /// Feature channels.
    pub fn channels(&self) -> usize {
        self.weights.len()
    }

    /// Source and position of a sample; `None` if unassigned or unknown.
    pub fn locate(&self, id: SampleId) -> Option<(usize, [u32; D])> {
        self.table.locate(id)
    }

    /// The sample `by` away in the same source: the patch, continued.
    pub fn step(&self, id: SampleId, by: [i32; D]) -> Option<SampleId> {
        self.table.step(id, by)
    }
}

fn validity<const D: usize>(
    exemplar: usize,
    planes: &[Plane<D>],
    mask: Option<&Grid<bool, D>>,
) -> Result<Option<Grid<bool, D>>, Error> {
    let mut valid: Option<Grid<bool, D>> = None;
    let alphas = planes.iter().map(Plane::validity).collect::<Result<Vec<_>, _>>()?;
    for one in alphas.into_iter().flatten().chain(copied(mask)?) {
        let (expected, found) = (planes[0].domain().shape.to_vec(), one.domain().shape.to_vec());
        if expected != found {
            return Err(Error::MaskShape { exemplar, expected, found });
        }
        match &mut valid {
            None => valid = Some(one),
            Some(all) => all.samples_mut().iter_mut().zip(one.samples()).for_each(|(a, &b)| *a &= b),
        }
    }
    Ok(valid.filter(|v| v.samples().contains(&false)))
}

#[cfg(test)]
mod tests;
