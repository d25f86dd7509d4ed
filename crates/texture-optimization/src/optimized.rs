//! What a run answers with: votes, or a map.

use selvedge_core::{Domain, Error, Exemplars, Grid, Plane, Render, SampleId, SourceMap, Votes};

use crate::assignment::Place;
use crate::falloff::Falloff;
use crate::neighborhoods::Neighborhoods;

/// An optimised texture.
#[derive(Clone, Debug, PartialEq)]
pub enum Optimized {
    /// Each sample is one of the exemplars.
    Map(SourceMap<2>),
    /// Each sample is an average of some of the exemplars: the paper's result.
    Votes(Votes<2>),
}

impl Optimized {
    /// Shape and topology.
    pub fn domain(&self) -> Domain<2> {
        match self {
            Self::Map(map) => map.domain(),
            Self::Votes(votes) => votes.domain(),
        }
    }
}

impl Render<2> for Optimized {
    fn render(&self, planes: &[&Plane<2>]) -> Result<Plane<2>, Error> {
        match self {
            Self::Map(map) => map.render(planes),
            Self::Votes(votes) => votes.render(planes),
        }
    }

    fn as_map(&self) -> Option<&SourceMap<2>> {
        match self {
            Self::Map(map) => Some(map),
            Self::Votes(_) => None,
        }
    }

    fn into_map(self: Box<Self>) -> Option<SourceMap<2>> {
        match *self {
            Self::Map(map) => Some(map),
            Self::Votes(_) => None,
        }
    }
}

/// Samples that stay.
#[derive(Clone, Copy)]
pub(crate) struct Held<'a> {
    pub(crate) map: &'a SourceMap<2>,
    pub(crate) fixed: &'a Grid<bool, 2>,
}

impl Held<'_> {
    /// The sample that stays at a position.
    pub(crate) fn at(&self, at: [u32; 2]) -> Option<SampleId> {
        self.fixed.get(0, at).then(|| self.map.ids.get(0, at))
    }

    /// Puts them where they were.
    pub(crate) fn lay(&self, map: &mut SourceMap<2>) {
        let kept = self.fixed.plane(0).iter().zip(self.map.ids.plane(0));
        for (id, (_, &own)) in map.ids.plane_mut(0).iter_mut().zip(kept).filter(|(_, (fixed, _))| **fixed) {
            *id = own;
        }
    }
}

/// What neighborhoods have at each sample, and how much each weighs: of that, [`average`](crate::average::average) is
/// the mean.
pub(crate) struct Pulls<'a> {
    pub(crate) exemplars: &'a Exemplars<2>,
    pub(crate) all: &'a Neighborhoods,
    pub(crate) found: &'a [Place],
    pub(crate) weights: &'a [f64],
    pub(crate) falloff: &'a Falloff,
}

impl Pulls<'_> {
    /// The samples at a position, in the order of neighborhoods.
    pub(crate) fn at(&self, [y, x]: [u32; 2]) -> impl Iterator<Item = (SampleId, f64)> + '_ {
        let columns = self.all.firsts[1].len();
        self.all.holding(0, y).flat_map(move |(j, dy)| {
            self.all.holding(1, x).map(move |(i, dx)| {
                let number = j * columns + i;
                let g = self.falloff.along()[dy as usize] * self.falloff.along()[dx as usize];
                (self.found[number].id(self.exemplars, [dy, dx]), self.weights[number] * g)
            })
        })
    }

    pub(crate) fn votes(&self, held: Option<Held<'_>>) -> Result<Votes<2>, Error> {
        let places = self.all.domain.positions().map(|at| {
            let kept = held.and_then(|held| held.at(at)).map(|id| (id, 1.0_f32));
            let voted = kept.is_none().then(|| self.at(at).map(|(id, weight)| (id, weight as f32)));
            kept.into_iter().chain(voted.into_iter().flatten())
        });
        Votes::new(self.all.domain, self.exemplars.table().clone(), places)
    }

    /// The heaviest sample of each position.
    pub(crate) fn map(&self) -> Result<SourceMap<2>, Error> {
        let mut map = SourceMap::unassigned(self.exemplars, self.all.domain)?;
        for (id, at) in map.ids.plane_mut(0).iter_mut().zip(self.all.domain.positions()) {
            let heavier = |a: (SampleId, f64), b: (SampleId, f64)| if a.1 < b.1 { b } else { a };
            *id = self.at(at).reduce(heavier).map_or(SampleId::UNASSIGNED, |(id, _)| id);
        }
        Ok(map)
    }
}
