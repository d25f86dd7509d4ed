//! Vectors whose lengths follow from input: making them can fail.

use crate::Error;

/// A vector of `len` equal values; a refusal of the system is an error, not an abort.
///
/// # Errors
/// [`Error::Allocation`].
pub fn try_vec<T: Clone>(len: usize, value: T) -> Result<Vec<T>, Error> {
    let mut samples = Vec::new();
    let bytes = (len as u64).saturating_mul(size_of::<T>() as u64);
    samples.try_reserve_exact(len).map_err(|_| Error::Allocation { bytes })?;
    spare(bytes)?;
    samples.resize(len, value);
    Ok(samples)
}

/// Small things are made without asking, and a process ends where one of them finds no memory: so much is left to them
/// by whatever is large. Without, one of a hundred address limits at which a run does not fit ended it.
const SPARE: usize = 2 << 20;
/// Below, a vector is one of those small things itself, and is not worth the question.
const LARGE: u64 = 1 << 18;

/// Refuses the last memory that there is.
fn spare(bytes: u64) -> Result<(), Error> {
    let left = bytes < LARGE || std::hint::black_box(Vec::<u8>::new()).try_reserve_exact(SPARE).is_ok();
    if left { Ok(()) } else { Err(Error::Allocation { bytes }) }
}

/// Makes room for that many items more; a refusal of the system is an error, not an abort.
///
/// # Errors
/// [`Error::Allocation`].
pub fn reserve<T>(items: &mut Vec<T>, more: usize) -> Result<(), Error> {
    let bytes = (items.len() as u64).saturating_add(more as u64).saturating_mul(size_of::<T>() as u64);
    let grows = items.capacity() - items.len() < more;
    items.try_reserve(more).map_err(|_| Error::Allocation { bytes })?;
    if grows { spare(bytes) } else { Ok(()) }
}

/// All of an iterator; a refusal of the system is an error, not an abort.
///
/// # Errors
/// [`Error::Allocation`].
pub fn collected<T>(items: impl IntoIterator<Item = T>) -> Result<Vec<T>, Error> {
    let items = items.into_iter();
    let mut all = Vec::new();
    reserve(&mut all, items.size_hint().0)?;
    for item in items {
        if all.len() == all.capacity() {
            // Doubles it, as pushing would.
            reserve(&mut all, 1)?;
        }
        all.push(item);
    }
    Ok(all)
}
