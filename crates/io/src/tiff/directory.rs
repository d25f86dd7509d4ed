//! The directory of a file's picture, to change what the decoder cannot take.

use std::ops::Range;

use crate::Format;
use crate::error::Problem;

/// Where the entries of a directory lie, and how wide its numbers are.
#[derive(Clone, Copy)]
pub(super) struct Directory {
    little: bool,
    /// BigTIFF: everything that counts bytes has 64 bits.
    big: bool,
    first: usize,
    entries: usize,
}

/// Tags that several have to do with.
pub(super) const PHOTOMETRIC: u16 = 262;
pub(super) const SAMPLES: u16 = 277;
pub(super) const EXTRA_SAMPLES: u16 = 338;
/// Offsets and byte counts of tiles.
pub(super) const TILES: [u16; 2] = [324, 325];
/// What kind of picture it is.
const KIND: u16 = 254;
/// Pages that are looked through for the first that is no thumbnail.
pub(super) const PAGES: usize = 64;
/// Types of values.
const BYTE: u64 = 1;
const SHORT: u64 = 3;
const LONG: u64 = 4;
const LONG8: u64 = 16;

impl Directory {
    /// That of a file with a right signature: the first that is no smaller version of another, as thumbnails are.
    pub(super) fn of(file: &[u8]) -> Result<Self, Problem> {
        let little = file.starts_with(b"II");
        let big = file.get(if little { 2 } else { 3 }) == Some(&43);
        let start = Self { little, big, first: 0, entries: 0 };
        let first = start.after(file, if big { 8 } else { 4 }).ok_or_else(|| Problem::ends_early(Format::Tiff))?;
        let mut all = std::iter::successors(Some(first), |last| last.next(file)).take(PAGES);
        Ok(all.find(|one| !is_reduced(one.first(file, KIND))).unwrap_or(first))
    }

    /// The directory whose place stands here.
    fn after(self, file: &[u8], at: usize) -> Option<Self> {
        let directory = usize::try_from(self.number(file, at, self.wide())?).ok().filter(|at| *at != 0)?;
        let count = if self.big { 8 } else { 2 };
        let entries = usize::try_from(self.number(file, directory, count)?).ok()?;
        Some(Self { first: directory.checked_add(count)?, entries, ..self })
    }

    fn next(self, file: &[u8]) -> Option<Self> {
        self.after(file, self.entries()?.end)
    }

    /// Where its entries lie.
    pub(super) fn entries(self) -> Option<Range<usize>> {
        let bytes = self.entries.checked_mul(self.size())?;
        Some(self.first..self.first.checked_add(bytes)?)
    }

    /// Bytes of an entry.
    fn size(self) -> usize {
        if self.big { 20 } else { 12 }
    }

    /// Bytes of an offset.
    fn wide(self) -> usize {
        if self.big { 8 } else { 4 }
    }

    fn number(self, file: &[u8], at: usize, len: usize) -> Option<u64> {
        let bytes = file.get(at..at.checked_add(len)?)?;
        let push = |n: u64, b: &u8| n << 8 | u64::from(*b);
        Some(if self.little { bytes.iter().rev().fold(0, push) } else { bytes.iter().fold(0, push) })
    }

    fn put(self, file: &mut [u8], at: usize, len: usize, value: u64) -> Option<()> {
        let bytes =
            if self.little { value.to_le_bytes()[..len].to_vec() } else { value.to_be_bytes()[8 - len..].to_vec() };
        file.get_mut(at..at.checked_add(len)?)?.copy_from_slice(&bytes);
        Some(())
    }

    /// Where the entry of a tag begins: the tag, its type, its count, its value or where that is.
    fn entry(self, file: &[u8], tag: u16) -> Option<usize> {
        let all = (0..self.entries).map_while(|i| self.first.checked_add(i.checked_mul(self.size())?));
        all.take_while(|at| *at < file.len()).find(|at| self.number(file, *at, 2) == Some(tag.into()))
    }

    /// The first number of a tag.
    pub(super) fn first(self, file: &[u8], tag: u16) -> Option<u64> {
        self.numbers(file, tag)?.first().copied()
    }

    /// The numbers of a tag.
    pub(super) fn numbers(self, file: &[u8], tag: u16) -> Option<Vec<u64>> {
        let at = self.entry(file, tag)?;
        let len = match self.number(file, at + 2, 2)? {
            BYTE => 1,
            SHORT => 2,
            LONG => 4,
            LONG8 => 8,
            _ => return None,
        };
        let count = usize::try_from(self.number(file, at + 4, self.wide())?).ok()?;
        let bytes = count.checked_mul(len).filter(|bytes| *bytes <= file.len())?;
        let value = at + 4 + self.wide();
        let from =
            if bytes <= self.wide() { value } else { usize::try_from(self.number(file, value, self.wide())?).ok()? };
        (0..count).map(|i| self.number(file, from.checked_add(i * len)?, len)).collect()
    }

    /// Makes a tag that is there say one short number.
    pub(super) fn set(self, file: &mut [u8], tag: u16, value: u16) -> Option<()> {
        let at = self.entry(file, tag)?;
        self.put(file, at + 2, 2, SHORT)?;
        self.put(file, at + 4, self.wide(), 1)?;
        self.put(file, at + 4 + self.wide(), 2, value.into())
    }

    /// Gives a tag that is there another name.
    pub(super) fn rename(self, file: &mut [u8], tag: u16, to: u16) -> Option<()> {
        let at = self.entry(file, tag)?;
        self.put(file, at, 2, to.into())
    }

    /// Makes a tag that is there say these numbers, which are put at the end of the file.
    pub(super) fn set_all(self, file: &mut Vec<u8>, tag: u16, values: &[u64]) -> Option<()> {
        let (at, wide) = (self.entry(file, tag)?, self.wide());
        self.put(file, at + 2, 2, if self.big { LONG8 } else { LONG })?;
        self.put(file, at + 4, wide, values.len() as u64)?;
        let list: Vec<u8> = values
            .iter()
            .flat_map(
                |v| if self.little { v.to_le_bytes()[..wide].to_vec() } else { v.to_be_bytes()[8 - wide..].to_vec() },
            )
            .collect();
        if list.len() <= wide {
            file.get_mut(at + 4 + wide..)?.get_mut(..list.len())?.copy_from_slice(&list);
            return Some(());
        }
        let end = file.len() as u64;
        self.put(file, at + 4 + wide, wide, end)?;
        file.extend(list);
        Some(())
    }
}

/// Whether a kind of picture is a smaller version of another one [TIFF 6.0 8].
pub(super) fn is_reduced(kind: Option<u64>) -> bool {
    kind.is_some_and(|kind| kind & 1 == 1)
}
