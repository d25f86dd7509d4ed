//! Several samples a place, each with a weight: what methods that average answer with.

use crate::{Averaging, Domain, Error, Payload, Plane, Render, SampleId, SourceTable, reserve};

/// For each output sample the exemplar samples that are averaged there, and how much each weighs.
///
/// A place where all votes are for one sample shows it bit for bit; one without votes is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Votes<const D: usize> {
    domain: Domain<D>,
    table: SourceTable<D>,
    /// Where the votes of each place begin, and one more for the end of all.
    first: Vec<usize>,
    ids: Vec<SampleId>,
    weights: Vec<f32>,
}

impl<const D: usize> Votes<D> {
    /// Takes the votes of each place, row-major. Votes of weight 0 do not count.
    ///
    /// # Errors
    /// [`Error::UnknownSample`] if a vote is for a sample that no source holds, [`Error::Vote`] if a weight is negative
    /// or not finite, [`Error::Length`] if there are more places or fewer, [`Error::Allocation`].
    pub fn new<V: IntoIterator<Item = (SampleId, f32)>>(
        domain: Domain<D>,
        table: SourceTable<D>,
        places: impl IntoIterator<Item = V>,
    ) -> Result<Self, Error> {
        let (mut first, mut ids, mut weights) = (vec![0], Vec::new(), Vec::new());
        for votes in places {
            for (id, weight) in votes {
                if table.len() <= id.get() {
                    return Err(Error::UnknownSample { id: id.get(), samples: table.len().into() });
                }
                if !(weight.is_finite() && 0.0 <= weight) {
                    return Err(Error::Vote { place: first.len() - 1, weight });
                }
                if weight != 0.0 {
                    reserve(&mut ids, 1)?;
                    reserve(&mut weights, 1)?;
                    ids.push(id);
                    weights.push(weight);
                }
            }
            reserve(&mut first, 1)?;
            first.push(ids.len());
        }
        let (expected, found) = (domain.checked_len().unwrap_or(usize::MAX), first.len() - 1);
        if found != expected {
            return Err(Error::Length { expected, found });
        }
        Ok(Self { domain, table, first, ids, weights })
    }

    /// Shape and topology of the output.
    pub fn domain(&self) -> Domain<D> {
        self.domain
    }

    /// The sources that votes are for.
    pub fn table(&self) -> &SourceTable<D> {
        &self.table
    }

    /// The votes at a place of the output, row-major.
    pub fn at(&self, place: usize) -> impl ExactSizeIterator<Item = (SampleId, f32)> {
        let range = self.first[place]..self.first[place + 1];
        self.ids[range.clone()].iter().copied().zip(self.weights[range].iter().copied())
    }

    /// Bytes that so many votes over so many places take.
    pub fn bytes(places: u64, votes: u64) -> crate::Bytes {
        crate::Bytes(places) * size_of::<usize>() as u64 + crate::Bytes(votes) * 8
    }
}

impl<const D: usize> Render<D> for Votes<D> {
    /// Averages as [`Averaging`] does.
    fn render(&self, planes: &[&Plane<D>]) -> Result<Plane<D>, Error> {
        let payload = Payload::new(&self.table, planes)?;
        let mut shown = crate::Grid::try_filled(self.domain, 1, SampleId::UNASSIGNED)?;
        for (place, id) in shown.plane_mut(0).iter_mut().enumerate() {
            *id = self.at(place).next().map_or(SampleId::UNASSIGNED, |v| v.0);
        }
        let mut plane = payload.gather(&shown)?;
        let averaging = Averaging::of(planes);
        let mut values = vec![0.0; plane.samples.channels()];
        let mut channels = vec![Vec::new(); values.len()];
        for place in 0..self.domain.len() {
            let ids = &self.ids[self.first[place]..self.first[place + 1]];
            if ids.iter().all(|id| *id == ids[0]) {
                continue;
            }
            for (c, numbers) in channels.iter_mut().enumerate() {
                numbers.resize(ids.len(), 0.0);
                payload.numbers(c, ids, numbers);
            }
            averaging.weigh(&mut channels);
            let weights = || self.at(place).map(|v| f64::from(v.1));
            let all: f64 = weights().sum();
            for (value, numbers) in values.iter_mut().zip(&channels) {
                *value = numbers.iter().zip(weights()).map(|(v, w)| v * w).sum::<f64>() / all;
            }
            averaging.set(&mut plane.samples, place, &mut values);
        }
        Ok(plane)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grid, Origin, Role, Samples, Seed, Transform};

    fn table(domain: Domain<2>) -> SourceTable<2> {
        SourceTable::new(vec![(Origin { exemplar: 0, transform: Transform::IDENTITY }, domain)]).unwrap()
    }

    #[test]
    fn each_place_is_the_weighted_mean_of_its_votes() {
        let mut rng = Seed(4).rng();
        let (source, output) = (Domain::open([5, 7]), Domain::open([6, 4]));
        let samples: Vec<f32> = (0..source.len()).map(|_| rng.below(1000) as f32 / 8.0).collect();
        let plane = Plane::new(Role::Scalar, Samples::F32(Grid::from_vec(source, 1, samples).unwrap()));
        let vote = |rng: &mut crate::Rng| (SampleId::new(rng.below(35)), rng.below(4) as f32);
        let places: Vec<Vec<(SampleId, f32)>> =
            (0..output.len()).map(|_| (0..rng.below(5)).map(|_| vote(&mut rng)).collect()).collect();
        let votes = Votes::new(output, table(source), places.clone()).unwrap();
        let out = votes.render(&[&plane]).unwrap();
        for (i, votes) in places.iter().enumerate() {
            let all: f64 = votes.iter().map(|v| f64::from(v.1)).sum();
            let value = |id: SampleId| plane.samples.value(0, id.get() as usize);
            let sum: f64 = votes.iter().map(|v| f64::from(v.1) * value(v.0)).sum();
            let expected = if all == 0.0 { 0.0 } else { sum / all };
            assert!((out.samples.value(0, i) - expected).abs() < 1e-4, "{i}: {votes:?}");
        }
    }

    #[test]
    fn votes_for_one_sample_copy_it_bit_for_bit() {
        let domain = Domain::open([1, 2]);
        let samples = Samples::F32(Grid::from_vec(domain, 1, vec![1.0e-40_f32, 3.0]).unwrap());
        let plane = Plane::new(Role::Color, samples);
        let tiny = SampleId::new(0);
        let places = [vec![(tiny, 0.3), (tiny, 0.4)], vec![(SampleId::new(1), 0.0)]];
        let out = Votes::new(domain, table(domain), places).unwrap().render(&[&plane]).unwrap();
        assert_eq!(out.samples, Samples::F32(Grid::from_vec(domain, 1, vec![1.0e-40, 0.0]).unwrap()));
    }

    #[test]
    fn wrong_votes_are_refused() {
        let domain = Domain::open([1, 1]);
        let of = |id: u32, weight: f32| Votes::new(domain, table(domain), [[(SampleId::new(id), weight)]]);
        assert!(of(0, 1.0).is_ok());
        assert_eq!(of(1, 1.0), Err(Error::UnknownSample { id: 1, samples: 1 }));
        assert_eq!(of(0, -1.0), Err(Error::Vote { place: 0, weight: -1.0 }));
        assert!(matches!(of(0, f32::NAN), Err(Error::Vote { .. })));
        let none = Votes::new(domain, table(domain), Vec::<Vec<(SampleId, f32)>>::new());
        assert_eq!(none, Err(Error::Length { expected: 1, found: 0 }));
    }
}
