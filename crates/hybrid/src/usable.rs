//! Which sources may be copied from.

use selvedge_core::{Exemplars, Grid, SourceMap};

use crate::error::Error;
use crate::followed::Followed;

/// The sources that may be copied from, beside all that may stand in the output.
pub(crate) struct Usable<'e> {
    pub(crate) all: &'e Exemplars<2>,
    /// Those of them that may be copied from.
    pub(crate) some: Exemplars<2>,
    /// Their numbers among all.
    pub(crate) numbers: Vec<usize>,
    /// What is followed, under those of them that may be copied from.
    pub(crate) followed: Option<Followed>,
}

impl<'e> Usable<'e> {
    /// The sources that `field` (see [`Start::sources`](selvedge_core::Start::sources)) allows wherever something is
    /// missing.
    pub(crate) fn new(
        exemplars: &'e Exemplars<2>,
        map: &SourceMap<2>,
        field: Option<&Grid<u64, 2>>,
        followed: Option<&Followed>,
    ) -> Result<Self, Error> {
        let missing = map.ids.plane(0).iter().enumerate().filter(|(_, id)| !id.is_assigned());
        let bits =
            field.map_or(u64::MAX, |field| missing.fold(u64::MAX, |bits, (place, _)| bits & field.plane(0)[place]));
        let all = exemplars.sources().len();
        let numbers: Vec<usize> = (0..all).filter(|&s| field.is_none() || bits >> s & 1 == 1).collect();
        if numbers.is_empty() {
            return Err(Error::MixedSources);
        }
        let under = |followed: &Followed| followed.under(&followed.guide.exemplars().only(numbers.iter().copied())?);
        let followed = followed.map(under).transpose()?;
        Ok(Self { all: exemplars, some: exemplars.only(numbers.iter().copied())?, numbers, followed })
    }

    /// By source, whether it may be copied from.
    pub(crate) fn flags(&self) -> Vec<bool> {
        (0..self.all.sources().len()).map(|s| self.numbers.contains(&s)).collect()
    }
}
