//! Exemplars without their other orientations.

use selvedge_core::{Exemplars, Source};

/// The first source of each exemplar: the others show the same samples.
pub(crate) fn firsts(exemplars: &Exemplars<2>) -> impl Iterator<Item = &Source<2>> {
    let mut last = None;
    exemplars
        .sources()
        .iter()
        .map(|source| &**source)
        .filter(move |s| last.replace(s.origin.exemplar) != Some(s.origin.exemplar))
}
