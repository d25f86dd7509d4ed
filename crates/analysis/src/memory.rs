//! Lists whose lengths follow from input: growing them can fail.

use selvedge_fft_ssd::Error;

/// All of an iterator.
pub(crate) fn collected<T>(items: impl IntoIterator<Item = T>) -> Result<Vec<T>, Error> {
    let mut all = Vec::new();
    for item in items {
        if all.len() == all.capacity() {
            // Doubles, as pushing would, but may fail.
            let more = all.len().max(16);
            let bytes = (all.len() + more).saturating_mul(size_of::<T>()) as u64;
            all.try_reserve(more).map_err(|_| selvedge_core::Error::Allocation { bytes })?;
        }
        all.push(item);
    }
    Ok(all)
}
