//! How much memory a run that is planned holds.

use std::collections::BTreeMap;

use selvedge_core::par::{at_once, threads};
use selvedge_core::{Bytes, Domain, Exemplars};
use selvedge_fft_ssd::{Holdings, Placement, Sizes, held};

use crate::block_grid::BlockGrid;
use crate::options::Options;
use crate::search::halved;

// What follows was added up from the structures and held against the peak of processes (`tests/it/memory.rs`): never
// below, and not half as much again.

/// What a run takes however small it is: a searcher of its own for each thread.
const A_RUN: u64 = 1 << 20;
/// Bytes of a candidate in the lists that it goes through, which double; of a flat exemplar every place is one, and
/// from above all are that are within half as much again as the best.
const A_CANDIDATE: u64 = 64;
/// Bytes of the error of a place.
const AN_ERROR: u64 = 8;
/// Bytes that tell of a place how much of a mask lies before it: for two searchers, and for draws.
const A_MASK: u64 = 3 * 4;
/// Bytes that are kept for each block laid.
const A_BLOCK: u64 = 48;
/// Bytes for each sample of a block while it is cut.
const A_CUT: u64 = 64;
/// Bytes for each row of a block that is compared, which a mask parts in two.
const A_ROW: u64 = 2 * 96;
/// Bytes for each channel of a sample that is compared.
const A_TAP: u64 = 40;

/// What choosing a block holds at most beside the exemplars: they are looked at one after the other.
pub fn measuring(exemplars: &[Domain<2>], channels: usize, masked: bool, options: &Options) -> Bytes {
    let size = |exemplar: &Domain<2>| selvedge_analysis::estimate_size(*exemplar, channels, masked);
    exemplars.iter().filter(|_| options.block.is_none()).map(size).max().unwrap_or_default()
}

/// An upper bound of what a planned run holds, of exemplars that are there: blocks of one size are looked for, on so
/// many threads, in exemplars that were halved so often.
pub(crate) fn planned(exemplars: &Exemplars<2>, output: Domain<2>, grid: &BlockGrid, halvings: u32) -> Bytes {
    let (channels, masked, whole) = (exemplars.channels(), exemplars.is_masked(), exemplars.domains());
    let (searched, halves) = searched(&whole, channels, halvings);
    let workers = at_once(places(&searched)).min(threads() as u64).min(grid.longest_wave() as u64);
    let templates = grid.templates();
    // A sample on an edge may be one more, and which engine answers follows from how many there are.
    let small = |&(shape, samples): &([u32; 2], u64)| {
        let small = halved(shape, halvings);
        let least = samples >> (2 * halvings);
        let edges = if halvings == 0 { 0 } else { 2 * small.map(u64::from).iter().sum::<u64>() };
        [(small, least), (small, (least + edges).min(small.map(u64::from).iter().product()))]
    };
    let small = templates.iter().flat_map(small).collect::<Vec<_>>();
    let search = searches(&searched, channels, masked, workers, &small);
    let [height, width] = [0, 1].map(|a| templates.iter().map(|(shape, _)| shape[a]).max().unwrap_or(1));
    let samples = templates.iter().map(|(_, samples)| *samples).max().unwrap_or(0);
    // What is compared of a block, and its halves: features, masks, stretches.
    let compared = match halvings {
        0 => Bytes(samples) * (A_TAP * channels as u64),
        _ => Bytes::of_box([height.into(), width.into()], 2 * channels as u64 + 3) + Bytes(height.into()) * A_ROW,
    };
    let block = Bytes::of_box([height.into(), width.into()], A_CUT + 2 * channels as u64) + compared;
    let lists =
        Bytes(places(&searched)) * A_CANDIDATE * workers + Bytes(if masked { places(&whole) } else { 0 }) * A_MASK;
    let woven = Bytes(grid.len() as u64) * A_BLOCK + Bytes::of_samples(output, 4 + 1);
    Bytes(A_RUN) + halves + search + lists + block * workers + woven
}

/// The same of a planned transfer: its grids of blocks, pass by pass, and how often exemplars are halved for each.
pub(crate) fn planned_transfer(
    exemplars: &Exemplars<2>,
    guide_channels: usize,
    output: Domain<2>,
    passes: &[(BlockGrid, u32)],
) -> Bytes {
    let most = passes.iter().map(|(_, halvings)| *halvings).max().unwrap_or(0);
    let at = |halvings: u32| {
        let grids: Vec<&BlockGrid> = passes.iter().filter(|(_, n)| *n == halvings).map(|(grid, _)| grid).collect();
        if grids.is_empty() { Bytes(0) } else { steered(exemplars, guide_channels, &grids, halvings) }
    };
    let searched = (0..=most).map(at).max().unwrap_or_default();
    let laid = passes.iter().map(|(grid, _)| grid.len()).max().unwrap_or(0) as u64;
    let woven = Bytes(laid) * A_BLOCK + Bytes::of_samples(output, 2 * 4 + 1);
    let marks = Bytes(if exemplars.is_masked() { places(&exemplars.domains()) } else { 0 }) * A_MASK;
    Bytes(A_RUN) + searched + marks + woven
}

/// Passes of a transfer that look for blocks in exemplars that were halved so often.
fn steered(exemplars: &Exemplars<2>, guide_channels: usize, grids: &[&BlockGrid], halvings: u32) -> Bytes {
    let (channels, masked) = (exemplars.channels(), exemplars.is_masked());
    let (searched, halves) = searched(&exemplars.domains(), channels + guide_channels, halvings);
    let wave = grids.iter().map(|grid| grid.longest_wave()).max().unwrap_or(1);
    let workers = at_once(places(&searched)).min(threads() as u64).min(wave as u64);
    // What agrees with the pass before is all of a block, and so is what the guide says.
    let small = |(shape, samples): ([u32; 2], u64)| {
        let small = halved(shape, halvings);
        let all = small.map(u64::from).iter().product();
        (small, if halvings == 0 { samples } else { all })
    };
    let templates: Vec<_> = grids.iter().flat_map(|grid| grid.templates()).collect();
    let overlaps: Vec<_> = templates.iter().copied().map(small).collect();
    let blocks: Vec<_> =
        overlaps.iter().map(|&(shape, _)| (shape, u64::from(shape[0]) * u64::from(shape[1]))).collect();
    let all: Vec<_> = overlaps.iter().chain(&blocks).copied().collect();
    let search = searches(&searched, channels, masked, 2 * workers, &all)
        + searches(&searched, guide_channels, masked, workers, &blocks);
    let samples = templates.iter().map(|(shape, _)| u64::from(shape[0]) * u64::from(shape[1])).max().unwrap_or(0);
    let compared = (2 * channels + guide_channels) as u64;
    let block = Bytes(samples) * (A_CUT + compared + A_TAP * compared);
    let lists = Bytes(places(&searched)) * (A_CANDIDATE + AN_ERROR) * workers;
    halves + search + lists + block * workers
}

/// What is searched of exemplars that were halved so often, and the bytes of all their halves, of so many channels.
fn searched(exemplars: &[Domain<2>], channels: usize, halvings: u32) -> (Vec<Domain<2>>, Bytes) {
    let (mut searched, mut halves) = (exemplars.to_vec(), Bytes(0));
    for _ in 0..halvings {
        searched.iter_mut().for_each(|domain| *domain = domain.coarser());
        halves += searched.iter().map(|domain| Bytes::of_samples(*domain, channels as u64)).sum();
    }
    (searched, halves)
}

/// Searches of so many workers for some templates: shapes, each with the samples of it that are compared.
fn searches(
    exemplars: &[Domain<2>],
    channels: usize,
    holes: bool,
    workers: u64,
    templates: &[([u32; 2], u64)],
) -> Bytes {
    let (weights, options) = (vec![1; channels], selvedge_fft_ssd::Options::default());
    let most = Holdings { tables: Bytes::MOST, ..Holdings::default() };
    let (mut all, mut tables) = (Holdings::default(), [Bytes(0); 2]);
    // Templates of one shape share spectra, if they are transformed at all.
    let mut spectra: BTreeMap<[u32; 2], Bytes> = BTreeMap::new();
    for &(template, samples) in templates {
        let sizes = Sizes { sources: exemplars, weights: &weights, holes, template, samples, noisy_masks: false };
        let held = held(&sizes, Placement::INSIDE, &options).unwrap_or(most);
        let of_shape = spectra.entry(template).or_default();
        *of_shape = held.spectra.max(*of_shape);
        // Both engines keep tables of their own.
        let engine = &mut tables[usize::from(held.spectra != Bytes(0))];
        *engine = held.tables.max(*engine);
        all.working = held.working.max(all.working);
    }
    let largest = spectra.values().copied().max().unwrap_or_default() * workers;
    let kept = spectra.into_values().sum::<Bytes>().min(Bytes(options.cache).max(largest));
    tables[0] + tables[1] + kept + all.working * workers
}

fn places(exemplars: &[Domain<2>]) -> u64 {
    exemplars.iter().map(|domain| Bytes::of_samples(*domain, 1)).sum::<Bytes>().0
}
