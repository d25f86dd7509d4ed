//! Exemplars as methods see them: features and validity, one source an orientation.

use crate::resample;
use crate::source_map::SourceTable;
use crate::{Domain, Encoder, Error, Grid, Origin, Plane, SampleId, Transform};

/// One exemplar in one orientation.
#[derive(Clone, Debug, PartialEq)]
pub struct Source<const D: usize> {
    /// 8-bit features, one channel after the other.
    pub features: Grid<u8, D>,
    /// Which samples may be used; `None` for all.
    pub valid: Option<Grid<bool, D>>,
    /// Where it came from.
    pub origin: Origin,
}

impl<const D: usize> Source<D> {
    /// Shape and topology.
    pub fn domain(&self) -> Domain<D> {
        self.features.domain()
    }

    fn new(features: &Grid<u8, D>, valid: Option<&Grid<bool, D>>, origin: Origin) -> Result<Self, Error> {
        let valid = shown_validity(features.domain(), valid, origin.transform)?;
        Ok(Self { features: shown(features, origin.transform)?, valid, origin })
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
fn shown_validity<const D: usize>(
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
    /// Which samples of each source may be used, `None` for all: those that the exemplar's plane (its alpha) and its mask
    /// leave, as the source shows them.
    ///
    /// # Errors
    /// [`Error::PlaneCount`] without a plane for each exemplar, [`Error::Shape`] for a mask of another size.
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
    sources: Vec<Source<D>>,
    table: SourceTable<D>,
    weights: Vec<u8>,
}

impl<const D: usize> Exemplars<D> {
    /// Each exemplar (its registered planes) in each orientation. A sample is valid where no plane's alpha is 0.
    ///
    /// # Errors
    /// Those of [`Encoder::encode`], [`Error::TooManySamples`], [`Error::NothingValid`], [`Error::Transform`].
    pub fn new(encoder: &Encoder, exemplars: &[&[Plane<D>]], transforms: &[Transform]) -> Result<Self, Error> {
        Self::masked(encoder, exemplars, &vec![None; exemplars.len()], transforms)
    }

    /// Like [`new`](Self::new), with a mask for some exemplars: samples where it is false are not used.
    ///
    /// # Errors
    /// Those of [`new`](Self::new), and [`Error::Shape`] for a mask of another size.
    pub fn masked(
        encoder: &Encoder,
        exemplars: &[&[Plane<D>]],
        masks: &[Option<Grid<bool, D>>],
        transforms: &[Transform],
    ) -> Result<Self, Error> {
        Self::oriented(encoder, exemplars, masks, &vec![transforms; exemplars.len()])
    }

    /// Like [`masked`](Self::masked), with orientations for each exemplar.
    ///
    /// # Errors
    /// Those of [`masked`](Self::masked).
    pub fn oriented(
        encoder: &Encoder,
        exemplars: &[&[Plane<D>]],
        masks: &[Option<Grid<bool, D>>],
        transforms: &[&[Transform]],
    ) -> Result<Self, Error> {
        let mut sources = Vec::new();
        for (e, (planes, transforms)) in exemplars.iter().zip(transforms).enumerate() {
            let features = encoder.encode(planes)?;
            let valid = validity(e, planes, masks.get(e).and_then(Option::as_ref))?;
            for &transform in *transforms {
                if !transform.is_valid() {
                    return Err(Error::Transform { transform });
                }
                let origin = Origin { exemplar: e as u16, transform };
                sources.push(Source::new(&features, valid.as_ref(), origin)?);
            }
        }
        Self::from_sources(sources, encoder.weights().to_vec())
    }

    /// The exemplars as they are, through an encoder fitted to them.
    ///
    /// # Errors
    /// Those of [`Encoder::fit`] and [`new`](Self::new).
    pub fn of(exemplars: &[&[Plane<D>]]) -> Result<Self, Error> {
        Self::new(&Encoder::fit(exemplars)?, exemplars, &[Transform::IDENTITY])
    }

    /// Takes ready sources; each feature channel has a weight.
    ///
    /// # Errors
    /// [`Error::NoPlanes`], [`Error::Weights`], [`Error::TooManySamples`], [`Error::NothingValid`].
    pub fn from_sources(sources: Vec<Source<D>>, weights: Vec<u8>) -> Result<Self, Error> {
        let first = sources.first().ok_or(Error::NoPlanes { exemplar: 0 })?;
        let channels = first.features.channels();
        if channels != weights.len() || sources.iter().any(|s| s.features.channels() != channels) {
            return Err(Error::Weights { expected: channels, found: weights.len() });
        }
        let any_valid =
            |s: &Source<D>| s.valid.as_ref().map_or(!s.domain().is_empty(), |v| v.samples().contains(&true));
        if !sources.iter().any(any_valid) {
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
        let like = |(source, features): (&Source<D>, Grid<u8, D>)| {
            let (expected, found) = (source.domain().shape.to_vec(), features.domain().shape.to_vec());
            if expected != found {
                return Err(Error::GuideShape { exemplar: source.origin.exemplar.into(), expected, found });
            }
            let features = features.with_periodic(source.domain().periodic);
            Ok(Source { features, valid: copied(source.valid.as_ref())?, origin: source.origin })
        };
        Self::from_sources(self.sources.iter().zip(features).map(like).collect::<Result<_, _>>()?, weights)
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
    pub fn sources(&self) -> &[Source<D>] {
        &self.sources
    }

    /// The numbering of samples.
    pub fn table(&self) -> &SourceTable<D> {
        &self.table
    }

    /// Which samples of each source may be used; `None` for all.
    pub fn validity(&self) -> Vec<Option<&Grid<bool, D>>> {
        self.sources.iter().map(|s| s.valid.as_ref()).collect()
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
    for one in alphas.into_iter().flatten().chain(mask.cloned()) {
        let (expected, found) = (planes[0].domain().shape.to_vec(), one.domain().shape.to_vec());
        if expected != found {
            return Err(Error::Shape { exemplar, plane: planes.len(), expected, found });
        }
        match &mut valid {
            None => valid = Some(one),
            Some(all) => all.samples_mut().iter_mut().zip(one.samples()).for_each(|(a, &b)| *a &= b),
        }
    }
    Ok(valid.filter(|v| v.samples().contains(&false)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Role, Samples};

    fn rgba(alpha: [u8; 2]) -> Plane<2> {
        let samples = vec![1, 2, 3, 4, 5, 6, alpha[0], alpha[1]];
        Plane::with_alpha(Role::Color, Samples::U8(Grid::from_vec(Domain::open([1, 2]), 4, samples).unwrap()))
    }

    #[test]
    fn transparent_samples_are_not_valid() {
        let plane = rgba([0, 9]);
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        assert_eq!(exemplars.channels(), 3);
        assert_eq!(exemplars.sources()[0].valid.as_ref().unwrap().samples(), [false, true]);
    }

    #[test]
    fn fully_transparent_exemplars_are_refused() {
        let plane = rgba([0, 0]);
        assert_eq!(Exemplars::of(&[std::slice::from_ref(&plane)]), Err(Error::NothingValid));
    }

    #[test]
    fn each_orientation_is_a_source() {
        let plane = rgba([1, 1]);
        let planes = [std::slice::from_ref(&plane)];
        let turn = Transform::Exact { quarter_turns: 1, mirror: false };
        let encoder = Encoder::fit(&planes).unwrap();
        let exemplars = Exemplars::new(&encoder, &planes, &[Transform::IDENTITY, turn]).unwrap();
        assert_eq!(exemplars.sources()[1].domain().shape, [2, 1]);
        assert_eq!(exemplars.sources()[1].features.plane(0), [1, 2]);
        assert_eq!(exemplars.locate(SampleId::new(3)), Some((1, [1, 0])));
    }

    #[test]
    fn a_mask_of_another_size_is_refused() {
        let plane = rgba([1, 1]);
        let planes = [std::slice::from_ref(&plane)];
        let mask = Grid::try_filled(Domain::open([2, 2]), 1, true).unwrap();
        let encoder = Encoder::fit(&planes).unwrap();
        let masked = Exemplars::masked(&encoder, &planes, &[Some(mask)], &[Transform::IDENTITY]);
        assert!(matches!(masked, Err(Error::Shape { .. })));
    }
}
