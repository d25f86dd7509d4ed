//! How much memory a run will need.

use selvedge_core::{Bytes, Domain};
use selvedge_fft_ssd::{Placement, Sizes};

use crate::layout::grown;
use crate::options::Options;
use crate::weave::AT_ONCE;

/// Bytes of a candidate in the lists that it goes through; of a flat exemplar every place is one.
const A_CANDIDATE: u64 = 40;
/// Bytes of a valid sample's number.
const A_NUMBER: u64 = 4;
/// Bytes of the error of a place.
const AN_ERROR: u64 = 8;
/// Bytes that tell of a place how much of a mask lies before it, twice.
const A_MASK: u64 = 8;
/// Bytes for each sample of a grown block: its look, errors and cut.
const A_CUT: u64 = 64;
/// Bytes for each output sample: its number, whether it waits, what it is, and what it costs to order those that wait.
const A_SAMPLE: u64 = 4 + 2 + 32;

/// What choosing a block holds at most beside the exemplars: they are looked at one after the other.
pub fn measuring(exemplars: &[Domain<2>], channels: usize, masked: bool, options: &Options) -> Bytes {
    let size = |exemplar: &Domain<2>| selvedge_analysis::estimate_size(*exemplar, channels, masked);
    exemplars.iter().filter(|_| options.block.is_none()).map(size).max().unwrap_or_default()
}

/// What laying blocks of that size holds, with masks or without, of so many channels and so many of a guide. It counts
/// on flat exemplars, of which every place is a candidate; of others less is held.
pub(crate) fn woven(
    exemplars: &[Domain<2>],
    (channels, followed): (usize, usize),
    masked: bool,
    output: Domain<2>,
    (block, options): ([u32; 2], &Options),
) -> Bytes {
    let samples = exemplars.iter().map(|&e| Bytes::of_samples(e, 1)).sum::<Bytes>();
    let channels_of = channels as u64;
    // Searches of small blocks have the most places, those of large ones the largest transforms. Spectra for cropped
    // blocks are kept as well.
    let grown = |block| grown(block, options.overlap);
    let whole = [grown(block); 5];
    let small = [grown(block.map(|n| (n / 4).max(1))), [7, 7]];
    let search = |channels| {
        let of = |&template| search(exemplars, channels, masked, template, options);
        whole.iter().chain(&small).map(of).sum::<Bytes>()
    };
    let guided = if followed == 0 { Bytes(0) } else { search(followed) };
    let search = search(channels) + guided;
    // Features side by side, links and weights of seams, numbers of valid samples, and the exemplars once more if they
    // go around.
    let features = samples * (2 * channels_of + 2 + A_NUMBER + if options.circular { channels_of + 1 } else { 0 });
    let lists = samples * (A_CANDIDATE + AN_ERROR + A_MASK);
    // Some at once, where there are several to try.
    let tried = if options.tries == 1 { 1 } else { AT_ONCE as u64 };
    let cut = Bytes::of_samples(Domain::open(grown(block)), tried * A_CUT + 8 * channels_of);
    // Its maps as they are given, around, under the sources that are used, and side by side; and its target twice.
    let guide = samples * (4 * followed as u64) + Bytes::of_samples(output, 2 * followed as u64);
    search + features + lists + cut + guide + Bytes::of_samples(output, A_SAMPLE)
}

/// Bytes of a sample of a map that is repaired, where all of it is bad: the map before; whether it waits, what it is,
/// whether seams after it are bad, and whether it is near one; the regions, in lists that grow, and those that were
/// tried in vain; one of them by itself with its map, in lists that grow; what stood there; the order of what waits.
const A_BAD_SAMPLE: u64 = 4 + 5 + 24 + 2 * 8 + (8 + 2 * 24) + 4 + (16 + 8 + 16);

/// An upper bound of the bytes that [`repair`](crate::repair()) holds beside the exemplars' features and the map;
/// `circular` as in its options.
pub fn estimate_repair(exemplars: &[Domain<2>], channels: usize, output: Domain<2>, circular: bool) -> Bytes {
    let channels = channels as u64;
    // Prices of seams by two measures, of which one has gradients.
    let each = 3 * channels + 3 + 8 + A_NUMBER + if circular { channels + 1 } else { 0 };
    let features = exemplars.iter().map(|&e| Bytes::of_samples(e, each)).sum::<Bytes>();
    features + Bytes::of_samples(output, A_BAD_SAMPLE)
}

fn search(exemplars: &[Domain<2>], channels: usize, holes: bool, template: [u32; 2], options: &Options) -> Bytes {
    let weights = vec![255; channels];
    let samples = u64::from(template[0]) * u64::from(template[1]);
    let domains: Vec<Domain<2>> = exemplars
        .iter()
        .map(|e| Domain { periodic: if options.circular { [true; 2] } else { e.periodic }, ..*e })
        .collect();
    let sizes = Sizes { sources: &domains, weights: &weights, holes, template, samples, noisy_masks: true };
    let bytes = selvedge_fft_ssd::estimate(&sizes, Placement::INSIDE, &selvedge_fft_ssd::Options::default());
    bytes.unwrap_or(Bytes::MOST)
}
