//! How much memory a run will need.

use selvedge_core::par::at_once;
use selvedge_core::{Bytes, Domain};
use selvedge_fft_ssd::{Engine, Placement, Sizes};

use crate::auto_block::largest_block;
use crate::options::{Options, SearchBy, Stage};
use crate::search::halvings_of;
use crate::transfer_options::{TransferOptions, suggested};

/// What a run takes however small it is: a searcher of its own for each thread.
const A_RUN: u64 = 1 << 20;
/// Bytes of a candidate in the lists that it goes through; of a flat exemplar every place is one.
const A_CANDIDATE: u64 = 40;
/// Bytes of the error of a place.
const AN_ERROR: u64 = 8;
/// Bytes of the errors of a place where several searches are summed: of each of three, and of the sum.
const A_SUM: u64 = 3 * 4 + 8;
/// Bytes that tell of a place how much of a mask lies before it: for two searchers, and for draws.
const A_MASK: u64 = 3 * 4;
/// Bytes for each sample of the largest picture while a correspondence map is made of it.
const A_MAP: u64 = 64;
/// Bytes that are kept for each block laid.
const A_BLOCK: u64 = 48;
/// Bytes for each sample of a block while it is cut.
const A_CUT: u64 = 64;
/// Bytes for each row of a block that is compared, which a mask parts in two.
const A_ROW: u64 = 2 * 96;
/// Bytes for each channel of a sample that is compared.
const A_TAP: u64 = 40;

/// An upper bound of the bytes that [`quilt`](crate::quilt()) holds beside the exemplars' features, known before
/// anything is read: shapes of the exemplars, feature channels, the output. It holds for any number of threads, for any
/// masks, and for flat exemplars, of which every place is a candidate; of others less is held, on few threads several
/// times less.
pub fn estimate(exemplars: &[Domain<2>], channels: usize, output: Domain<2>, options: &Options) -> Bytes {
    let exact = Options { search: SearchBy::Exact, ..*options };
    of_blocks(exemplars, channels, output, &exact, true)
}

/// The same for exemplars of which all samples are valid: large ones are searched at a fraction of their size
/// ([`SearchBy::Auto`]).
pub fn estimate_whole(exemplars: &[Domain<2>], channels: usize, output: Domain<2>, options: &Options) -> Bytes {
    of_blocks(exemplars, channels, output, options, false)
}

/// For whatever block may be chosen, and how often exemplars are halved for it.
fn of_blocks(exemplars: &[Domain<2>], channels: usize, output: Domain<2>, options: &Options, masked: bool) -> Bytes {
    let largest = options.block.unwrap_or_else(|| largest(exemplars));
    // Blocks of the automatic size hold at least 8 by 8 samples where the exemplar does.
    let least = options.block.unwrap_or(8).min(largest);
    let overlap = |block: u32| match options.stage {
        Stage::Random => 0,
        _ => options.overlap_of(block).unwrap_or(block / 2),
    };
    let halved = |block: u32| match options.search {
        SearchBy::Auto => halvings_of(exemplars, overlap(block)),
        SearchBy::Exact => 0,
    };
    // Larger blocks have wider overlaps.
    let (mut first, mut most) = (least, Bytes(0));
    while first <= largest {
        let halvings = halved(first);
        let last = (first..=largest).take_while(|&block| halved(block) == halvings).last().unwrap_or(first);
        let laid = Laid { least: first, largest: last, overlap: overlap(last) };
        most = most.max(of_laid(exemplars, channels, output, &laid, halvings));
        let Some(next) = last.checked_add(1) else { break };
        first = next;
    }
    let measured = exemplars.iter().map(|e| selvedge_analysis::estimate_size(*e, channels, masked)).max();
    measured.filter(|_| options.block.is_none()).unwrap_or_default().then(Bytes(A_RUN) + most)
}

/// The blocks that a run may lay, and the overlap of the largest.
struct Laid {
    least: u32,
    largest: u32,
    overlap: u32,
}

/// For blocks that are searched for in exemplars that were halved so often.
fn of_laid(exemplars: &[Domain<2>], channels: usize, output: Domain<2>, laid: &Laid, halvings: u32) -> Bytes {
    let step = if laid.least == laid.largest { laid.least - laid.overlap } else { laid.least.div_ceil(2) };
    let blocks = Blocks::new(&output, laid.least, step);
    let mut small = exemplars.to_vec();
    let mut halves = Bytes(0);
    for _ in 0..halvings {
        small.iter_mut().for_each(|e| e.shape = e.shape.map(|side| (side / 2).max(side.min(1))));
        halves += small.iter().map(|e| Bytes::of_samples(*e, channels as u64)).sum();
    }
    let whole = Compared { side: laid.largest, samples: compared(&output, laid.largest, laid.overlap) };
    // A sample on an edge may be one more.
    let side = (whole.side >> halvings).saturating_add(1);
    let samples = (whole.samples >> (2 * halvings)) + 4 * u64::from(side);
    let template = Compared { side, samples: if halvings == 0 { whole.samples } else { samples } };
    let workers = at_once(places(&small)).min(blocks.at_once);
    let search = Searches { exemplars: &small, at_once: workers, templates: &[template] };
    // The block itself, and what is compared of it at each size.
    let pieces = if halvings == 0 { Bytes(0) } else { of_pieces(whole.side, channels) * workers };
    // The map, and where the blocks of a wave show.
    let woven = Bytes(blocks.all) * A_BLOCK + Bytes::of_samples(output, 4 + 1);
    search.bytes(channels) + search.lists(AN_ERROR) + search.blocks(channels) + halves + pieces + woven
}

/// A block and its halves: features, masks, stretches; and its cut.
fn of_pieces(side: u32, channels: usize) -> Bytes {
    Bytes(u64::from(side).pow(2)) * (A_CUT + 3 * channels as u64 + 3) + Bytes(u64::from(side)) * A_ROW
}

/// An upper bound of the bytes that [`transfer`](crate::transfer) holds beside the exemplars' features, known before
/// anything is read: shapes of the exemplars, channels of features and of the guide, the output.
pub fn estimate_transfer(
    exemplars: &[Domain<2>],
    channels: usize,
    guide_channels: usize,
    output: Domain<2>,
    options: &TransferOptions,
) -> Bytes {
    let first = options.block.unwrap_or_else(|| suggested(exemplars.iter().copied(), output));
    let plan = options.plan(first);
    // The smallest blocks of the last pass are the most.
    let blocks = plan.iter().map(|p| Blocks::new(&output, p.block, p.block - p.overlap));
    let (all, longest) = blocks.fold((0, 1), |(all, longest), b| (b.all.max(all), b.at_once.max(longest)));
    let templates: Vec<Compared> =
        plan.iter().map(|p| Compared { side: p.block, samples: u64::from(p.block).pow(2) }).collect();
    let workers = at_once(places(exemplars)).min(longest);
    let search = Searches { exemplars, at_once: workers, templates: &templates };
    let pictures = || exemplars.iter().chain(std::iter::once(&output)).map(|picture| Bytes::of_samples(*picture, 1));
    let maps = pictures().max().unwrap_or_default() * A_MAP;
    // This pass's map and the last one's, and where the blocks of a wave show.
    let woven = Bytes(all) * A_BLOCK + Bytes::of_samples(output, 2 * 4 + 1);
    let searchers = search.bytes(channels) + search.bytes(guide_channels);
    let searched = searchers + search.lists(A_SUM) + search.blocks(2 * channels + guide_channels);
    // Colours, luminance, and the guide's own channels before and after they are joined.
    let features = pictures().sum::<Bytes>() * (4 + 2 * guide_channels as u64);
    // Correspondence maps are made before the search.
    features + maps.then(Bytes(A_RUN) + searched + woven)
}

/// Blocks of an output.
struct Blocks {
    all: u64,
    /// Those of its longest wave, at least.
    at_once: u64,
}

impl Blocks {
    fn new(output: &Domain<2>, block: u32, step: u32) -> Self {
        let along = |axis: usize| u64::from(output.shape[axis].div_ceil(step.clamp(1, block.max(1)))).max(2);
        let (rows, columns) = (along(0), along(1));
        // Each block of a wave is two columns before the one of the row above.
        let wave = if output.periodic[1] { 1 } else { rows.min(columns.div_ceil(2)) };
        Self { all: rows.saturating_mul(columns), at_once: wave }
    }
}

/// A block as it is compared with the exemplars.
#[derive(Clone, Copy)]
struct Compared {
    side: u32,
    /// Samples that are compared, at most.
    samples: u64,
}

/// Samples of a block on its overlaps, at most.
fn compared(output: &Domain<2>, block: u32, overlap: u32) -> u64 {
    let step = (block - overlap).max(1);
    // What is left between the overlaps, which a periodic axis has at both ends and widens.
    let free = |axis: usize| {
        let (side, whole) = (output.shape[axis], u64::from(block));
        let n = side.div_ceil(step).max(side.min(2)).max(1);
        if output.periodic[axis] { (2 * u64::from(side / n)).saturating_sub(whole) } else { step.into() }
    };
    u64::from(block).pow(2).saturating_sub(free(0).saturating_mul(free(1)))
}

/// All searches of a run: how many at once, and for what.
struct Searches<'a> {
    exemplars: &'a [Domain<2>],
    at_once: u64,
    templates: &'a [Compared],
}

impl Searches<'_> {
    /// What a searcher of so many channels holds, and the scratch of searches but their errors.
    fn bytes(&self, channels: usize) -> Bytes {
        let options = selvedge_fft_ssd::Options::default();
        let weights = vec![1; channels];
        let by = |engine: Engine, side: u32, samples: u64| {
            let (template, noisy_masks) = ([side.max(1); 2], false);
            let sizes =
                Sizes { sources: self.exemplars, weights: &weights, holes: false, template, samples, noisy_masks };
            let options = selvedge_fft_ssd::Options { engine, ..options };
            selvedge_fft_ssd::estimate(&sizes, Placement::INSIDE, &options).unwrap_or(Bytes::MOST)
        };
        let (mut direct, mut fourier) = (Bytes(0), Bytes(0));
        for &Compared { side, samples } in self.templates {
            direct = by(Engine::Direct, 1, samples).max(direct);
            // At the output's border blocks are cropped. Those have more places, fewer samples, and an engine of their
            // own; rectangles have no more places than squares of their area.
            for side in [side, side - side / 4, side / 2, side / 4, 1] {
                let samples = samples.min(u64::from(side).pow(2).saturating_mul(2));
                let any = by(Engine::Auto, side, samples);
                if any != by(Engine::Direct, side, samples) {
                    fourier = any.max(fourier);
                }
            }
        }
        // Spectra for cropped blocks are kept as well, as far as there is room for them.
        let others = (fourier * 3).min(Bytes(options.cache));
        direct + fourier * self.at_once + others
    }

    /// Masks, and the errors and candidates of all searches that run at once.
    fn lists(&self, an_error: u64) -> Bytes {
        let all = Bytes(places(self.exemplars));
        all * (A_CANDIDATE + an_error) * self.at_once + all * A_MASK
    }

    /// The blocks that are looked for at once.
    fn blocks(&self, channels: usize) -> Bytes {
        let of = |t: &Compared| {
            let whole = Bytes(u64::from(t.side).pow(2)) * (A_CUT + channels as u64);
            whole + Bytes(t.samples) * (A_TAP * channels as u64)
        };
        self.templates.iter().map(of).max().unwrap_or_default() * self.at_once
    }
}

/// The largest block that is chosen for exemplars of these shapes.
fn largest(exemplars: &[Domain<2>]) -> u32 {
    // An exemplar too small for the others' blocks is passed over.
    let side = exemplars.iter().map(|e| e.shape[0].min(e.shape[1])).max().unwrap_or(1);
    largest_block(side).max(1)
}

fn places(exemplars: &[Domain<2>]) -> u64 {
    exemplars.iter().map(|domain| Bytes::of_samples(*domain, 1)).sum::<Bytes>().0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_exemplars_take_less_than_searches_of_their_full_size() {
        let (exemplar, output) = (Domain::open([4096; 2]), Domain::open([8192; 2]));
        let of = |block: Option<u32>, estimate: fn(&[Domain<2>], usize, Domain<2>, &Options) -> Bytes| {
            estimate(&[exemplar], 3, output, &Options { block, ..Options::default() }).0 >> 20
        };
        // The map alone has 256 MiB.
        let [auto, some] = [None, Some(1536)].map(|block| of(block, estimate_whole));
        assert!(256 < some && some < auto && auto < 1800, "{some} and {auto} MiB");
        assert!(4000 < of(None, estimate), "masked ones are not halved");
    }
}
