//! Buffers whose sizes follow from input: growing them can fail.

use crate::Error;
use selvedge_core::try_vec;

/// Makes a buffer `len` values long; what they are does not matter.
pub(crate) fn fit<T: Clone + Default>(buffer: &mut Vec<T>, len: usize) -> Result<(), Error> {
    if buffer.capacity() < len {
        // What is there need not be moved.
        *buffer = Vec::new();
        *buffer = try_vec(len, T::default())?;
    } else {
        buffer.resize(len, T::default());
    }
    Ok(())
}

/// Makes a buffer `len` times that value.
pub(crate) fn filled<T: Clone>(buffer: &mut Vec<T>, len: usize, value: T) -> Result<(), Error> {
    buffer.clear();
    reserve(buffer, len)?;
    buffer.resize(len, value);
    Ok(())
}

/// Makes room for that many values more.
pub(crate) fn reserve<T>(buffer: &mut Vec<T>, more: usize) -> Result<(), Error> {
    let bytes = (buffer.len() as u64).saturating_add(more as u64).saturating_mul(size_of::<T>() as u64);
    buffer.try_reserve(more).map_err(|_| selvedge_core::Error::Allocation { bytes }.into())
}

/// All of an iterator that knows its length.
pub(crate) fn collected<T>(items: impl ExactSizeIterator<Item = T>) -> Result<Vec<T>, Error> {
    let mut all = Vec::new();
    reserve(&mut all, items.len())?;
    all.extend(items);
    Ok(all)
}
