//! Lists whose lengths follow from input: growing them can fail.

use selvedge_core::reserve;
use selvedge_fft_ssd::Error;

/// All of an iterator.
pub(crate) fn collected<T>(items: impl IntoIterator<Item = T>) -> Result<Vec<T>, Error> {
    let mut all = Vec::new();
    for item in items {
        if all.len() == all.capacity() {
            // Doubles, as pushing would, but may fail.
            let more = all.len().max(16);
            reserve(&mut all, more)?;
        }
        all.push(item);
    }
    Ok(all)
}
