//! A run that was checked: exemplars, constraints and options fit each other, and there is room.

use std::borrow::Cow;

use selvedge_core::{Bytes, Domain, Exemplars, Run, SourceMap, Start, Woven};

use crate::constraint::Constraint;
use crate::error::Error;
use crate::estimate::{Sizes, bytes};
use crate::options::Options;
use crate::stats::Stats;
use crate::synthesis;

/// A run that was checked, and is then woven.
#[derive(Debug)]
pub struct Plan<'a> {
    exemplars: &'a Exemplars<2>,
    constraints: Cow<'a, [Constraint]>,
    options: Options,
    output: Domain<2>,
    needed: Bytes,
}

impl<'a> Plan<'a> {
    /// Checks options and constraints, which the plan borrows or owns, and that the run is within its limits.
    ///
    /// # Errors
    /// [`Range`](selvedge_core::Error::Range), [`Error::NoConstraint`], [`Error::Target`], [`Error::Neighborhood`], and
    /// of the core those of a guide that does not fit the exemplars and of limits.
    pub fn new(
        exemplars: &'a Exemplars<2>,
        constraints: impl Into<Cow<'a, [Constraint]>>,
        options: &Options,
        run: &Run<'_, 2>,
    ) -> Result<Self, Error> {
        let constraints = constraints.into();
        options.validate()?;
        let first = constraints.first().ok_or(Error::NoConstraint)?;
        constraints.iter().try_for_each(|constraint| constraint.check(exemplars, first, options))?;
        let output = first.guide.target().domain();
        let sources = exemplars.domains();
        let sizes = Sizes {
            sources: &sources,
            channels: exemplars.channels(),
            constraints: &constraints.iter().map(|c| (c.guide.weights().len(), c.ratio)).collect::<Vec<_>>(),
            output,
            holes: exemplars.is_masked() || constraints.iter().any(|c| c.guide.exemplars().is_masked()),
        };
        let needed = bytes(&sizes, options)?;
        run.limits.admit(output, needed)?;
        Ok(Self { exemplars, constraints, options: options.clone(), output, needed })
    }

    /// The output's shape and topology.
    pub fn output(&self) -> Domain<2> {
        self.output
    }

    /// What the output follows.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// An upper bound of the memory that the run takes, beside exemplars and constraints.
    pub fn needed(&self) -> Bytes {
        self.needed
    }

    /// Does it, from nothing.
    ///
    /// # Errors
    /// [`Error::Search`], [`Error::Cut`] and [`Error::Core`] if memory is short.
    pub fn weave(&self, run: &Run<'_, 2>) -> Result<Woven<SourceMap<2>, Stats>, Error> {
        self.weave_from(&Start::empty(self.exemplars, self.output)?, run)
    }

    /// Does it, from what is there. A source is used if it may be everywhere.
    ///
    /// # Errors
    /// [`Error::Start`], those of [`Start::check`], and those of [`weave`](Self::weave).
    pub fn weave_from(&self, start: &Start<2>, run: &Run<'_, 2>) -> Result<Woven<SourceMap<2>, Stats>, Error> {
        self.weave_by(start, run, true)
    }

    /// The same, with pruning or without.
    pub(crate) fn weave_by(
        &self,
        start: &Start<2>,
        run: &Run<'_, 2>,
        pruning: bool,
    ) -> Result<Woven<SourceMap<2>, Stats>, Error> {
        if start.map.domain() != self.output {
            return Err(Error::Start { expected: self.output.shape.to_vec() });
        }
        start.check(self.exemplars)?;
        let (result, stats, complete) =
            synthesis::weave(self.exemplars, &self.constraints, start, &self.options, run, pruning)?;
        Ok(Woven { result, stats, complete })
    }
}
