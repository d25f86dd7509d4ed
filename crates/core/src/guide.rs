//! Features that steer: further channels under the exemplars and under the output.

use std::sync::Arc;

use crate::exemplars::{copied, shown, shown_validity};
use crate::{Domain, Error, Exemplars, Grid, Source};
use crate::{pyramid, weights};

/// What an output has to follow besides the look of its exemplars: the same features under every source and under the
/// output. `[Efros01 3]`
///
/// The error of a source sample at an output position is the sum over the channels of
/// `weight * (source - target)^2`, in squared 8-bit steps; 0 where nothing is [`asked`](Self::asked).
///
/// What lies under the sources is [`Exemplars`] again, of the same sources and samples in features of the guide's own:
/// whatever takes exemplars (a searcher, a pyramid) takes those.
#[derive(Clone, Debug, PartialEq)]
pub struct Guide<const D: usize> {
    exemplars: Exemplars<D>,
    target: Grid<u8, D>,
    asked: Option<Grid<bool, D>>,
}

impl<const D: usize> Guide<D> {
    /// A guide from one map an exemplar and one for the output; every channel weighs 1, and all of the target is asked
    /// for.
    ///
    /// The maps are turned, mirrored and resampled like the sources, and valid where those are. `target` also says
    /// where the output is periodic.
    ///
    /// # Errors
    /// [`Error::GuideCount`] (a map is missing), [`Error::GuideShape`] (a map and its exemplar differ),
    /// [`Error::Weights`] (channels differ), [`Error::Allocation`].
    pub fn new(exemplars: &Exemplars<D>, maps: &[Grid<u8, D>], target: Grid<u8, D>) -> Result<Self, Error> {
        let expected = exemplars.sources().iter().map(|s| usize::from(s.origin.exemplar) + 1).max().unwrap_or(0);
        if expected != maps.len() {
            return Err(Error::GuideCount { expected, found: maps.len() });
        }
        let weights = vec![1; target.channels()];
        let shown = |s: &Arc<Source<D>>| shown(&maps[usize::from(s.origin.exemplar)], s.origin.transform);
        let maps = exemplars.sources().iter().map(shown).collect::<Result<_, _>>()?;
        Ok(Self { exemplars: exemplars.with_features(maps, weights)?, target, asked: None })
    }

    /// The exemplars' own features under them: the output is to look like what `target` shows in these.
    ///
    /// # Errors
    /// [`Error::Weights`] if the target has other channels than the exemplars.
    pub fn of_look(exemplars: &Exemplars<D>, target: Grid<u8, D>) -> Result<Self, Error> {
        match (target.channels(), exemplars.channels()) {
            (found, expected) if found != expected => Err(Error::Weights { expected, found }),
            _ => Ok(Self { exemplars: exemplars.clone(), target, asked: None }),
        }
    }

    /// A guide fits the exemplars it was made for: it has a map of each source's shape.
    ///
    /// # Errors
    /// [`Error::GuideCount`], [`Error::GuideShape`].
    pub fn check(&self, exemplars: &Exemplars<D>) -> Result<(), Error> {
        let (own, sources) = (self.exemplars.sources(), exemplars.sources());
        if own.len() != sources.len() {
            return Err(Error::GuideCount { expected: sources.len(), found: own.len() });
        }
        for (map, source) in own.iter().zip(sources) {
            let (expected, found) = (source.domain().shape.to_vec(), map.domain().shape.to_vec());
            if expected != found {
                return Err(Error::GuideShape { exemplar: source.origin.exemplar.into(), expected, found });
            }
        }
        Ok(())
    }

    /// Another guide from the same places: `f` is applied to the map under each source, as the source shows it, and to
    /// the target. What it makes of one channel is compared by the weight of 1.
    ///
    /// # Errors
    /// Those of `f`, and [`Error::Weights`] if it makes different numbers of channels.
    pub fn derive<E: From<Error>>(&self, f: impl Fn(&Grid<u8, D>) -> Result<Grid<u8, D>, E>) -> Result<Self, E> {
        let maps = self.exemplars.sources().iter().map(|s| f(&s.features)).collect::<Result<Vec<_>, E>>()?;
        let target = f(&self.target)?;
        let weights = vec![1; target.channels()];
        let exemplars = self.exemplars.with_features(maps, weights)?;
        Ok(Self { exemplars, target, asked: copied(self.asked.as_ref())? })
    }

    /// The same guide with other features under each source, of as many channels: `f` is given what lies there, and
    /// where it is valid.
    ///
    /// # Errors
    /// Those of `f`, and [`Error::Weights`] if it makes another number of channels.
    pub fn over_sources<E: From<Error>>(self, f: impl Fn(&Source<D>) -> Result<Grid<u8, D>, E>) -> Result<Self, E> {
        let maps = self.exemplars.sources().iter().map(|s| f(s)).collect::<Result<Vec<_>, E>>()?;
        let exemplars = self.exemplars.with_features(maps, self.weights().to_vec())?;
        Ok(Self { exemplars, ..self })
    }

    /// The same guide with another target, all of which is asked for.
    ///
    /// # Errors
    /// [`Error::Weights`] if it has another number of channels.
    pub fn with_target(self, target: Grid<u8, D>) -> Result<Self, Error> {
        match (target.channels(), self.weights().len()) {
            (found, expected) if found != expected => Err(Error::Weights { expected, found }),
            _ => Ok(Self { target, asked: None, ..self }),
        }
    }

    /// The same guide, whose maps under the exemplars count only where a mask is true, one an exemplar: masks are
    /// turned, mirrored and resampled like the sources, and what was not valid before is not valid now.
    ///
    /// # Errors
    /// [`Error::MaskShape`] if a mask is not of its exemplar's shape, [`Error::NothingValid`], [`Error::Allocation`].
    pub fn knowing(self, masks: &[Option<Grid<bool, D>>]) -> Result<Self, Error> {
        let of = |source: &Arc<Source<D>>| {
            let exemplar = usize::from(source.origin.exemplar);
            let Some(mask) = masks.get(exemplar).and_then(Option::as_ref) else { return Ok(None) };
            let mask = shown_validity(mask.domain(), Some(mask), source.origin.transform)?;
            let expected = source.domain().shape.to_vec();
            match mask.as_ref().map(|mask| mask.domain().shape.to_vec()) {
                Some(found) if found != expected => Err(Error::MaskShape { exemplar, expected, found }),
                _ => Ok(mask.map(Arc::new)),
            }
        };
        let masks = self.exemplars.sources().iter().map(of).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { exemplars: self.exemplars.valid_with(&masks)?, ..self })
    }

    /// The same guide, of which only what stands where `asked` is true is followed, and of that only what was asked for
    /// before.
    ///
    /// # Errors
    /// [`Error::GuideTarget`] if the mask is not of the target's shape.
    pub fn asking(self, mut asked: Grid<bool, D>) -> Result<Self, Error> {
        let (expected, found) = (self.target.domain().shape.to_vec(), asked.domain().shape.to_vec());
        if expected != found {
            return Err(Error::GuideTarget { expected, found });
        }
        if let Some(before) = &self.asked {
            asked.samples_mut().iter_mut().zip(before.samples()).for_each(|(all, &one)| *all &= one);
        }
        Ok(Self { asked: Some(asked), ..self })
    }

    /// The same guide with a weight a channel.
    ///
    /// # Errors
    /// [`Error::Weights`] if there are more or fewer than channels.
    pub fn weighing(self, weights: Vec<u8>) -> Result<Self, Error> {
        Ok(Self { exemplars: self.exemplars.weighing(weights)?, ..self })
    }

    /// Several guides as one. A guide's weight is shared out over its channels, so that three channels count no more
    /// than one; weights become whole numbers up to 255 in the same proportion, rounded where there are none. What is
    /// not 0 counts at least 1. What is asked for is what all of them ask for, and what is valid is so in all of them.
    ///
    /// # Errors
    /// [`Error::GuideWeight`] (negative, no number, or all 0), [`Error::GuideProportion`], [`Error::GuideCount`] (no
    /// guide), [`Error::GuideTarget`] (targets differ), those of [`check`](Self::check) (sources differ),
    /// [`Error::Allocation`].
    pub fn join(guides: &[(Self, f64)]) -> Result<Self, Error> {
        let Some((first, _)) = guides.first() else { return Err(Error::GuideCount { expected: 1, found: 0 }) };
        for (guide, _) in guides {
            let (expected, found) = (first.target.domain().shape.to_vec(), guide.target.domain().shape.to_vec());
            if expected != found {
                return Err(Error::GuideTarget { expected, found });
            }
            guide.check(&first.exemplars)?;
        }
        let parts: Vec<(f64, &[u8])> = guides.iter().map(|(guide, weight)| (*weight, guide.weights())).collect();
        let weights = weights::of_parts(&parts)?;
        let stacked =
            |of: &dyn Fn(&Self) -> &Grid<u8, D>| stack(of(first).domain(), guides.iter().map(|(guide, _)| of(guide)));
        let maps = (0..first.exemplars.sources().len())
            .map(|s| stacked(&|guide: &Self| &guide.exemplars.sources()[s].features))
            .collect::<Result<Vec<_>, _>>()?;
        let mut asked: Option<Grid<bool, D>> = None;
        for one in guides.iter().filter_map(|(guide, _)| guide.asked.as_ref()) {
            match &mut asked {
                None => asked = Some(one.map(|v| v)?),
                Some(all) => all.samples_mut().iter_mut().zip(one.samples()).for_each(|(all, &one)| *all &= one),
            }
        }
        let mut exemplars = first.exemplars.with_features(maps, weights)?;
        for (guide, _) in guides {
            let valid: Vec<_> = guide.exemplars.sources().iter().map(|source| source.valid.clone()).collect();
            exemplars = exemplars.valid_with(&valid)?;
        }
        Ok(Self { exemplars, target: stacked(&|guide| &guide.target)?, asked })
    }

    /// The guide at half the size, for exemplars at half the size ([`Exemplars::coarser`]): maps and target are
    /// averaged, and what is asked for is what was asked for all over.
    ///
    /// # Errors
    /// [`Error::NothingValid`], [`Error::Allocation`].
    pub fn coarser(&self) -> Result<Self, Error> {
        let domain = self.target.domain().coarser();
        let asked = self.asked.as_ref().map(|asked| pyramid::all(asked, domain)).transpose()?;
        Ok(Self { exemplars: self.exemplars.coarser()?, target: pyramid::mean(&self.target, domain)?, asked })
    }

    /// Exemplars and the maps under them as one, the guide's channels last: where all of the exemplars' channels count
    /// 1 together, all of the guide's count `weight`, in whole numbers as those of [`join`](Self::join).
    ///
    /// # Errors
    /// Those of [`check`](Self::check), [`Error::GuideWeight`], [`Error::GuideProportion`], [`Error::Allocation`].
    pub fn beside(&self, exemplars: &Exemplars<D>, weight: f64) -> Result<Exemplars<D>, Error> {
        self.check(exemplars)?;
        let maps = self.exemplars.sources().iter().map(|source| source.features.map(|v| v));
        exemplars.extended(maps.collect::<Result<_, _>>()?, self.weights(), weight)
    }

    /// The maps under the sources, in the guide's own features and weights: a sample has the number that it has in the
    /// exemplars that the guide was made for.
    pub fn exemplars(&self) -> &Exemplars<D> {
        &self.exemplars
    }

    /// The map under the output.
    pub fn target(&self) -> &Grid<u8, D> {
        &self.target
    }

    /// Where the target is followed; `None` for everywhere.
    pub fn asked(&self) -> Option<&Grid<bool, D>> {
        self.asked.as_ref()
    }

    /// Weight of each channel.
    pub fn weights(&self) -> &[u8] {
        self.exemplars.weights()
    }
}

/// The channels of all grids, one after the other.
fn stack<'a, const D: usize>(
    domain: Domain<D>,
    grids: impl Iterator<Item = &'a Grid<u8, D>> + Clone,
) -> Result<Grid<u8, D>, Error> {
    let channels = grids.clone().map(Grid::channels).sum();
    let mut out = Grid::try_filled(domain, channels, 0)?;
    let mut to = 0;
    for grid in grids {
        out.samples_mut()[to..to + grid.samples().len()].copy_from_slice(grid.samples());
        to += grid.samples().len();
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Encoder, Exemplar, Plane, Role, Samples, Transform};

    fn exemplars(transforms: &[Transform]) -> Exemplars<2> {
        let grid = Grid::from_vec(Domain::open([2, 3]), 1, vec![0, 1, 2, 3, 4, 5]).unwrap();
        let plane = [Plane::new(Role::Scalar, Samples::U8(grid))];
        let encoder = Encoder::fit(&[&plane[..]]).unwrap();
        Exemplars::new(&encoder, &[Exemplar::new(&plane).shown(transforms)]).unwrap()
    }

    fn grid(shape: [u32; 2], channels: usize) -> Grid<u8, 2> {
        let n = Domain::open(shape).len() * channels;
        Grid::from_vec(Domain::open(shape), channels, (0..n as u8).collect()).unwrap()
    }

    #[test]
    fn maps_are_turned_like_the_sources() {
        let turn = Transform::Exact { quarter_turns: 1, mirror: false };
        let exemplars = exemplars(&[Transform::IDENTITY, turn]);
        let guide = Guide::new(&exemplars, &[grid([2, 3], 1)], grid([5, 4], 1)).unwrap();
        assert_eq!(guide.exemplars(), &exemplars);
    }

    #[test]
    fn maps_are_resampled_and_masked_like_the_sources() {
        let diagonal = Transform::new(45.0, 1.5, true);
        let exemplars = exemplars(&[Transform::IDENTITY, diagonal]);
        let guide = Guide::new(&exemplars, &[grid([2, 3], 1)], grid([5, 4], 1)).unwrap();
        // The map holds what the exemplar holds.
        assert_eq!(guide.exemplars(), &exemplars);
        assert!(guide.exemplars().sources()[1].valid.as_deref().is_some_and(|v| v.samples().contains(&false)));
    }

    #[test]
    fn what_is_asked_for_stays_so_in_guides_made_of_others() {
        let e = exemplars(&[Transform::IDENTITY]);
        let asked = |bits: [bool; 4]| Grid::from_vec(Domain::open([2, 2]), 1, bits.to_vec()).unwrap();
        let guide = || Guide::new(&e, &[grid([2, 3], 1)], grid([2, 2], 1)).unwrap();
        let one = guide().asking(asked([true, true, false, false])).unwrap();
        let other = guide().asking(asked([true, false, true, false])).unwrap();
        assert_eq!(one.derive::<Error>(|g| g.map(|v| v)).unwrap(), one);
        let joined = Guide::join(&[(guide(), 1.0), (one, 1.0), (other, 1.0)]).unwrap();
        assert_eq!(joined.asked().unwrap().samples(), [true, false, false, false]);
        assert_eq!(joined.with_target(grid([1, 1], 3)).unwrap().asked(), None);
        let wrong = guide().asking(Grid::try_filled(Domain::open([2, 3]), 1, true).unwrap());
        assert_eq!(wrong, Err(Error::GuideTarget { expected: vec![2, 2], found: vec![2, 3] }));
    }

    #[test]
    fn what_is_not_known_of_a_map_is_valid_in_no_guide_made_of_it() {
        let turn = Transform::Exact { quarter_turns: 1, mirror: false };
        let e = exemplars(&[Transform::IDENTITY, turn]);
        let guide = || Guide::new(&e, &[grid([2, 3], 1)], grid([2, 2], 1)).unwrap();
        let mask = |bits: [bool; 6]| Grid::from_vec(Domain::open([2, 3]), 1, bits.to_vec()).unwrap();
        let valid = |guide: &Guide<2>| guide.exemplars().sources()[0].valid.as_ref().map(|v| v.samples().to_vec());
        let known = guide().knowing(&[Some(mask([true, false, true, true, true, true]))]).unwrap();
        assert_eq!(valid(&known), Some(vec![true, false, true, true, true, true]));
        assert_eq!(known.exemplars().validity()[1].map(|v| v.samples().iter().filter(|v| !**v).count()), Some(1));
        let other = guide().knowing(&[Some(mask([false, true, true, true, true, true]))]).unwrap();
        let joined = Guide::join(&[(guide(), 1.0), (known, 1.0), (other, 1.0)]).unwrap();
        assert_eq!(valid(&joined), Some(vec![false, false, true, true, true, true]));
        assert_eq!(guide().knowing(&[Some(mask([false; 6]))]), Err(Error::NothingValid));
        let wrong = guide().knowing(&[Some(Grid::try_filled(Domain::open([2, 2]), 1, true).unwrap())]);
        assert_eq!(wrong, Err(Error::MaskShape { exemplar: 0, expected: vec![2, 3], found: vec![2, 2] }));
    }

    #[test]
    fn what_exemplars_look_like_lies_under_them() {
        let e = exemplars(&[Transform::IDENTITY]);
        let guide = Guide::of_look(&e, grid([1, 4], 1)).unwrap();
        assert_eq!((guide.exemplars(), guide.target()), (&e, &grid([1, 4], 1)));
        assert_eq!(Guide::of_look(&e, grid([1, 4], 2)), Err(Error::Weights { expected: 1, found: 2 }));
    }

    #[test]
    fn weights_are_one_a_channel() {
        let e = exemplars(&[Transform::IDENTITY]);
        let guide = || Guide::new(&e, &[grid([2, 3], 3)], grid([1, 1], 3)).unwrap();
        assert_eq!(guide().weights(), [1, 1, 1]);
        assert_eq!(guide().weighing(vec![77, 150, 29]).unwrap().weights(), [77, 150, 29]);
        assert_eq!(guide().weighing(vec![1]), Err(Error::Weights { expected: 3, found: 1 }));
    }

    #[test]
    fn maps_that_do_not_fit_are_refused_with_their_numbers() {
        let e = exemplars(&[Transform::IDENTITY]);
        assert_eq!(Guide::new(&e, &[], grid([1, 1], 1)), Err(Error::GuideCount { expected: 1, found: 0 }));
        let shape = Guide::new(&e, &[grid([3, 2], 1)], grid([1, 1], 1));
        assert_eq!(shape, Err(Error::GuideShape { exemplar: 0, expected: vec![2, 3], found: vec![3, 2] }));
        assert!(matches!(Guide::new(&e, &[grid([2, 3], 2)], grid([1, 1], 1)), Err(Error::Weights { .. })));
    }

    #[test]
    fn joined_guides_count_by_their_weights_however_many_channels_they_have() {
        let e = exemplars(&[Transform::IDENTITY]);
        let guide = |channels| Guide::new(&e, &[grid([2, 3], channels)], grid([1, 2], channels)).unwrap();
        let joined = Guide::join(&[(guide(1), 1.0), (guide(3), 2.0), (guide(2), 0.0)]).unwrap();
        assert_eq!(joined.weights(), [3, 2, 2, 2, 0, 0]);
        assert_eq!(joined.target().samples(), [0, 1, 0, 1, 2, 3, 4, 5, 0, 1, 2, 3]);
        assert_eq!(Guide::join(&[(guide(1), 1.0), (guide(1), 1e-9)]).unwrap().weights(), [255, 1]);
        assert_eq!(Guide::join(&[(guide(2), 7.5)]).unwrap().weights(), [1, 1]);
    }

    #[test]
    fn a_guide_beside_its_exemplars_counts_by_its_weight() {
        let e = exemplars(&[Transform::IDENTITY]);
        let guide = Guide::new(&e, &[grid([2, 3], 2)], grid([1, 2], 2)).unwrap();
        let both = guide.beside(&e, 0.5).unwrap();
        assert_eq!((both.weights(), both.table()), (&[4, 1, 1][..], e.table()));
        let all = [e.sources()[0].features.samples(), guide.exemplars().sources()[0].features.samples()].concat();
        assert_eq!(both.sources()[0].features.samples(), all);
        assert_eq!(guide.beside(&e, -1.0), Err(Error::GuideWeight { weight: -1.0 }));
    }

    #[test]
    fn wrong_weights_and_targets_are_refused() {
        let e = exemplars(&[Transform::IDENTITY]);
        let guide = |shape| Guide::new(&e, &[grid([2, 3], 1)], grid(shape, 1)).unwrap();
        for weight in [-1.0, f64::NAN, f64::INFINITY, 0.0] {
            let joined = Guide::join(&[(guide([1, 1]), weight)]);
            assert!(matches!(joined, Err(Error::GuideWeight { .. })), "{weight}");
        }
        let joined = |weights: [f64; 2]| Guide::join(&weights.map(|w| (guide([1, 1]), w)));
        assert_eq!(joined([1e300, 1e-300]), Err(Error::GuideProportion { weight: 1e-300, most: 1e300 }));
        assert_eq!(joined([5e-324, 1e300]), Err(Error::GuideProportion { weight: 5e-324, most: 1e300 }));
        assert_eq!(joined([f64::MAX, f64::MAX / 2.0]).unwrap().weights(), [2, 1]);
        assert_eq!(joined([5e-324, 5e-324]).unwrap().weights(), [1, 1]);
        let joined = Guide::join(&[(guide([1, 2]), 1.0), (guide([2, 1]), 1.0)]);
        assert_eq!(joined, Err(Error::GuideTarget { expected: vec![1, 2], found: vec![2, 1] }));
    }

    #[test]
    fn derived_guides_change_source_and_target_alike() {
        let e = exemplars(&[Transform::IDENTITY]);
        let guide = Guide::new(&e, &[grid([2, 3], 1)], grid([1, 2], 1)).unwrap();
        let derived = guide.derive::<Error>(|g| g.map(|v| v * 2)).unwrap();
        assert_eq!(derived.exemplars().sources()[0].features.samples(), [0, 2, 4, 6, 8, 10]);
        assert_eq!(derived.target().samples(), [0, 2]);
    }
}
