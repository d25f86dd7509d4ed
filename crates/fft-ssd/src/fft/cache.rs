//! What a searcher keeps between searches, within a budget of bytes.

use super::size::Tiling;
use super::spectra::Spectra;
use crate::Error;
use crate::axes::Shape;
use crate::extension::{Extension, Key};
use crate::memory::push;
use crate::placement::Range;
use crate::prepared::Prepared;
use crate::source::SourceView;
use std::sync::{Arc, Mutex, PoisonError};

/// What a searcher keeps of its sources, the last used first. Beyond the budget the longest unused is dropped.
#[derive(Debug, Default)]
pub(crate) struct Cache {
    entries: Mutex<Vec<Entry>>,
}

/// What is kept, and the bytes that it may take.
#[derive(Clone, Copy)]
pub(crate) struct Keep<'a> {
    pub(crate) cache: &'a Cache,
    pub(crate) budget: u64,
}

#[derive(Debug)]
struct Entry {
    source: usize,
    key: Key,
    kept: Kept,
}

#[derive(Debug)]
enum Kept {
    /// Tables and copies.
    Tables(Arc<Prepared>),
    /// The spectra of one tiling, and the bytes that they are going to take.
    Spectra(Arc<Spectra>, u64),
}

impl Kept {
    fn bytes(&self) -> u64 {
        match self {
            Self::Tables(tables) => tables.bytes(),
            Self::Spectra(spectra, expected) => spectra.bytes().max(*expected),
        }
    }
}

impl Cache {
    /// What is kept of a source as far as the positions of a range touch it.
    pub(crate) fn tables(
        &self,
        number: usize,
        source: &SourceView<'_>,
        range: &Range,
        template: Shape,
        budget: u64,
    ) -> Result<Arc<Prepared>, Error> {
        let key = Extension::key(source.shape, range, template);
        self.get(number, key, budget, Kept::as_tables, || {
            Ok(Kept::Tables(Arc::new(Prepared::new(source, range, template, number, key)?)))
        })
    }

    /// Transforms of a tiling over what a source of that name was prepared for, with the spectra that were needed so
    /// far. `expected` tells how many bytes of them are going to be kept.
    pub(crate) fn spectra(
        &self,
        (number, key): (usize, Key),
        tiling: &Tiling,
        is_scalar: bool,
        budget: u64,
        expected: impl FnOnce(&Spectra) -> u64,
    ) -> Result<Arc<Spectra>, Error> {
        let same = |kept: &Kept| kept.as_spectra().filter(|s| s.tiling.shares_spectra(tiling));
        self.get(number, key, budget, same, || {
            let spectra = Spectra::new(*tiling, is_scalar);
            let expected = expected(&spectra);
            Ok(Kept::Spectra(Arc::new(spectra), expected))
        })
    }

    /// The entry of that name of which `find` makes something, made if it is not there. Others are dropped until all
    /// fit the budget.
    fn get<T>(
        &self,
        source: usize,
        key: Key,
        budget: u64,
        find: impl Fn(&Kept) -> Option<Arc<T>>,
        make: impl FnOnce() -> Result<Kept, Error>,
    ) -> Result<Arc<T>, Error> {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        match entries.iter().position(|e| e.source == source && e.key == key && find(&e.kept).is_some()) {
            Some(at) => entries[..=at].rotate_right(1),
            None => {
                push(&mut entries, Entry { source, key, kept: make()? })?;
                entries.rotate_right(1);
            }
        }
        let mut held = 0;
        let mut first = true;
        entries.retain(|e| {
            held += e.kept.bytes();
            std::mem::take(&mut first) || held <= budget
        });
        Ok(find(&entries[0].kept).expect("it is what was looked for"))
    }

    /// Sets of spectra that are kept, and bytes of all.
    #[cfg(test)]
    pub(crate) fn held(&self) -> (usize, u64) {
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let spectra = entries.iter().filter(|e| e.kept.as_spectra().is_some()).count();
        (spectra, entries.iter().map(|e| e.kept.bytes()).sum())
    }
}

impl Kept {
    fn as_tables(&self) -> Option<Arc<Prepared>> {
        if let Self::Tables(tables) = self { Some(Arc::clone(tables)) } else { None }
    }

    fn as_spectra(&self) -> Option<Arc<Spectra>> {
        if let Self::Spectra(spectra, _) = self { Some(Arc::clone(spectra)) } else { None }
    }
}
