//! What a level ends with, for those who watch: made only if it is looked at.

use std::sync::OnceLock;

use selvedge_core::{Error, Plane, Render, SourceMap};

/// A map that is made when it is asked for; none if that fails.
pub(crate) struct SoFar<'a> {
    make: &'a dyn Fn() -> Option<SourceMap<2>>,
    map: OnceLock<Option<SourceMap<2>>>,
}

impl<'a> SoFar<'a> {
    pub(crate) fn new(make: &'a dyn Fn() -> Option<SourceMap<2>>) -> Self {
        Self { make, map: OnceLock::new() }
    }
}

impl Render<2> for SoFar<'_> {
    fn render(&self, planes: &[&Plane<2>]) -> Result<Plane<2>, Error> {
        self.as_map().ok_or(Error::NothingValid)?.render(planes)
    }

    fn as_map(&self) -> Option<&SourceMap<2>> {
        self.map.get_or_init(self.make).as_ref()
    }

    fn into_map(self: Box<Self>) -> Option<SourceMap<2>> {
        self.as_map();
        self.map.into_inner().flatten()
    }
}
