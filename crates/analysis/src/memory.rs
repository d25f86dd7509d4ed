//! How much memory an analysis takes, and lists whose lengths follow from input: growing them can fail.

use selvedge_core::{Bytes, Domain, reserve};
use selvedge_fft_ssd::Error;

/// Of a texture at most so many samples around the centre are looked at.
pub(crate) const SAMPLES: usize = 1 << 20;
/// So many for their structures: some five looks at them take no longer than one at [`SAMPLES`].
pub(crate) const CLOSELY: usize = 1 << 18;
/// So many for what is larger than any middle.
pub(crate) const ROUGHLY: usize = 1 << 16;

/// Bytes of an analysis for each sample and channel, spectra above all: some 125 are seen of whole pictures of 2^20
/// samples, 230 of masked ones, whose masks have spectra as well.
const A_CHANNEL: u64 = 128;
const A_MASKED_CHANNEL: u64 = 236;
/// What is as large whatever the picture is: its cells, which are at most 200 a side.
const CELLS: u64 = 3 << 20;

/// An upper bound of the bytes that an analysis of a texture of this size holds beside its features,
/// [`Texture`](crate::Texture) or any other: no more than 2^20 samples are looked at closely.
pub fn estimate<const D: usize>(domain: Domain<D>, channels: usize, masked: bool) -> Bytes {
    let each = if masked { A_MASKED_CHANNEL } else { A_CHANNEL };
    let samples = Bytes::of_samples(domain, 1).0.min(SAMPLES as u64);
    Bytes(samples) * each * channels as u64 + Bytes(CELLS)
}

/// An upper bound of the bytes that [`feature_size_of`](crate::feature_size_of) holds beside the features: no more than
/// 2^18 samples are looked at closely, and the whole is halved.
pub fn estimate_size<const D: usize>(domain: Domain<D>, channels: usize, masked: bool) -> Bytes {
    let each = if masked { A_MASKED_CHANNEL } else { A_CHANNEL };
    let samples = Bytes::of_samples(domain, 1);
    let halves = if samples.0 <= CLOSELY as u64 { Bytes(0) } else { samples * (channels as u64 + u64::from(masked)) };
    Bytes(samples.0.min(CLOSELY as u64)) * each * channels as u64 + Bytes(CELLS) + halves
}

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
