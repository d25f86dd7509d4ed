//! Exemplars without their other orientations.

use crate::{Exemplars, Source};

impl<const D: usize> Exemplars<D> {
    /// The first source of each exemplar: the others show the same samples, turned or resampled.
    pub fn firsts(&self) -> impl Iterator<Item = &Source<D>> {
        let mut last = None;
        let is_first = move |s: &&Source<D>| last.replace(s.origin.exemplar) != Some(s.origin.exemplar);
        self.sources().iter().map(|source| &**source).filter(is_first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Domain, Grid, Origin, Transform};

    #[test]
    fn an_exemplar_has_one_first_source() {
        let source = |exemplar: u16, degrees: f64| {
            let origin = Origin { exemplar, transform: Transform::new(degrees, 1.0, false) };
            Source { features: Grid::try_filled(Domain::open([2, 2]), 1, 0).unwrap(), valid: None, origin }
        };
        let all = vec![source(0, 90.0), source(0, 0.0), source(1, 0.0), source(1, 180.0)];
        let firsts = [all[0].origin, all[2].origin];
        let exemplars = Exemplars::from_sources(all, vec![1]).unwrap();
        assert_eq!(exemplars.firsts().map(|s| s.origin).collect::<Vec<_>>(), firsts);
    }
}
