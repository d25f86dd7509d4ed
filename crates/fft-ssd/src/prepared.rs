//! What is computed once for a source, as far as some positions touch it, and kept between searches.

use crate::Error;
use crate::axes::Shape;
use crate::extension::{Extension, Key};
use crate::fft::{Spectra, Tiling};
use crate::job::Job;
use crate::memory::push;
use crate::pack::{Lanes, Packed};
use crate::placement::Range;
use crate::source::SourceView;
use crate::sums::Table;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Tables and copies of an extended source, each made when it is first asked for.
#[derive(Debug)]
pub(crate) struct Prepared {
    /// Its source and its key in the cache.
    name: (usize, Key),
    pub(crate) extension: Extension,
    /// Every sample lies on the source and is valid.
    pub(crate) is_full: bool,
    /// Every sample on the source is valid.
    pub(crate) is_box: bool,
    bytes: OnceLock<Packed>,
    pairs: OnceLock<Packed>,
    narrow: OnceLock<Table<u32>>,
    wide: OnceLock<Table<u64>>,
    valid: OnceLock<Table<u32>>,
}

impl Prepared {
    pub(crate) fn new(
        source: &SourceView<'_>,
        range: &Range,
        template: Shape,
        number: usize,
        key: Key,
    ) -> Result<Self, Error> {
        let extension = Extension::new(source.shape, range, template)?;
        let is_box = source.valid.is_none();
        Ok(Self {
            name: (number, key),
            is_full: is_box && extension.is_inside(),
            is_box,
            extension,
            bytes: OnceLock::new(),
            pairs: OnceLock::new(),
            narrow: OnceLock::new(),
            wide: OnceLock::new(),
            valid: OnceLock::new(),
        })
    }

    /// The source as words for a kernel.
    pub(crate) fn packed(&self, source: &SourceView<'_>, channels: usize, lanes: Lanes) -> Result<&Packed, Error> {
        let slot = if lanes == Lanes::Bytes { &self.bytes } else { &self.pairs };
        once(slot, || Packed::new(source, channels, &self.extension, lanes))
    }

    /// Numbers of valid samples.
    pub(crate) fn valid(&self, source: &SourceView<'_>) -> Result<&Table<u32>, Error> {
        once(&self.valid, || Table::valid(source, &self.extension))
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        let words = |p: Option<&Packed>| p.map_or(0, |p| p.words.len() * 4);
        let tables = [&self.narrow, &self.valid].map(|t| t.get().map_or(0, |t| t.sums.len() * 4));
        let wide = self.wide.get().map_or(0, |t| t.sums.len() * 8);
        (words(self.bytes.get()) + words(self.pairs.get()) + tables[0] + tables[1] + wide) as u64
    }
}

/// Words whose tables of squares a source keeps.
pub(crate) trait Squares: Sized {
    /// Sums of weighted squares; see [`Table::squares`].
    fn table<'p>(prepared: &'p Prepared, source: &SourceView<'_>, weights: &[u8]) -> Result<&'p Table<Self>, Error>;
}

impl Squares for u32 {
    fn table<'p>(prepared: &'p Prepared, source: &SourceView<'_>, weights: &[u8]) -> Result<&'p Table<Self>, Error> {
        once(&prepared.narrow, || Table::squares(source, weights, &prepared.extension))
    }
}

impl Squares for u64 {
    fn table<'p>(prepared: &'p Prepared, source: &SourceView<'_>, weights: &[u8]) -> Result<&'p Table<Self>, Error> {
        once(&prepared.wide, || Table::squares(source, weights, &prepared.extension))
    }
}

/// The value, made if it is not there. Of two makers at once, both make the same and one is kept.
fn once<T>(slot: &OnceLock<T>, make: impl FnOnce() -> Result<T, Error>) -> Result<&T, Error> {
    if let Some(value) = slot.get() {
        return Ok(value);
    }
    let made = make()?;
    Ok(slot.get_or_init(|| made))
}

/// What a searcher keeps of its sources, the last used first. Beyond the budget the longest unused is dropped.
#[derive(Debug, Default)]
pub(crate) struct Cache {
    entries: Mutex<Vec<Entry>>,
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

    /// Transforms of a tiling, with the spectra of the source that were needed so far; `planes` of them are going to be.
    pub(crate) fn spectra(&self, tiling: &Tiling, planes: usize, job: &Job<'_>) -> Result<Arc<Spectra>, Error> {
        let (number, key) = job.prepared.name;
        let same = |kept: &Kept| kept.as_spectra().filter(|s| s.tiling.shares_spectra(tiling));
        self.get(number, key, job.budget, same, || {
            let spectra = Spectra::new(*tiling, job.kernel.is_scalar());
            let expected = if job.keeps(spectra.expected(planes)) { spectra.expected(planes) } else { 0 };
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
