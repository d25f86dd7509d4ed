//! What is computed once for a source, as far as some positions touch it, and kept between searches.

use crate::Error;
use crate::axes::Shape;
use crate::extension::{Extension, Key};
use crate::pack::{Lanes, Packed};
use crate::placement::Range;
use crate::source::SourceView;
use crate::sums::Table;
use std::sync::OnceLock;

/// Tables and copies of an extended source, each made when it is first asked for.
#[derive(Debug)]
pub(crate) struct Prepared {
    /// Its source and its key in the cache.
    pub(crate) name: (usize, Key),
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
