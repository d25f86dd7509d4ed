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
    Ok(selvedge_core::reserve(buffer, more)?)
}

/// Appends a value.
pub(crate) fn push<T>(buffer: &mut Vec<T>, value: T) -> Result<(), Error> {
    if buffer.len() == buffer.capacity() {
        reserve(buffer, 1)?;
    }
    buffer.push(value);
    Ok(())
}

/// Becomes all of an iterator.
pub(crate) fn refill<T>(buffer: &mut Vec<T>, items: impl IntoIterator<Item = T>) -> Result<(), Error> {
    let items = items.into_iter();
    buffer.clear();
    reserve(buffer, items.size_hint().0)?;
    for item in items {
        push(buffer, item)?;
    }
    Ok(())
}
