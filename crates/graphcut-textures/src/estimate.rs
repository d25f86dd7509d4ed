//! How much memory a run needs.

use selvedge_core::{Bytes, Domain, SeamCosts, par};
use selvedge_fft_ssd::{Holdings, Placement as Positions, Sizes, held, held_of_part};

use crate::error_cells::CELLS_A_REGION;
use crate::options::{Options, Placement};
use crate::regions::{CLIP, largest_sides, shortest};
use crate::settings::{longest, reach};
use crate::sizes::{asked, covered, larger_region, levels};
use crate::weaver::{BATCH, at_once};

// What follows was added up from the structures and held against the peak of processes (`tests/it/memory.rs`): never
// below, and not absurdly above.

/// Bytes for each position where a patch may lie: its cost, and twice itself while it is drawn.
const A_CANDIDATE: u64 = 64;
/// Bytes of a frame and what was taken of it for each such sample.
const A_FRAME: u64 = 24;
/// Bytes for each patch: where it was laid, and the price of all seams after it.
const A_PATCH: u64 = 80;
/// Bytes for each way in which patches stood to each other.
const A_VECTOR: u64 = 64;
/// Bytes for each sample of an output that a map is carried up to: its own, a fourth of the coarser one's, the number
/// of its patch, and 64 for each seam in lists that double, one for each 16 samples.
const A_CARRIED: u64 = 4 + 1 + 4 + 4;
/// What a run takes however small it is. With half of it, 16x16 from 16x16 held 1.72 MB where 1.18 were told.
const A_RUN: u64 = 2 << 20;

/// An upper bound of the bytes that a run holds besides the exemplars themselves, known before anything is read: from
/// the domains of all sources, their feature channels, and the output's domain. Of the levels that a run may choose,
/// the one that takes most counts: how many follow from what exemplars show, and from their masks. What is chosen once
/// they are read tells less ([`Plan::bytes`](crate::Plan::bytes)).
pub fn estimate<const D: usize>(
    sources: &[Domain<D>],
    channels: usize,
    output: Domain<D>,
    options: &Options<D>,
) -> Bytes {
    let unknown = Known { masked: true, threads: par::threads() as u64 };
    let of = |levels| at_levels(sources, channels, output, options, levels, unknown);
    let largest = sources.iter().map(|s| shortest(s.shape)).max().unwrap_or(0);
    let most = options.levels.map_or(levels(largest, u32::MAX, output), |some| asked(largest, some));
    let run = (1..=most).map(of).max().unwrap_or_default();
    measuring(sources, channels, true, options).then(run)
}

/// The same of one clip. Where nothing of it is masked, it is known at how many sizes it is woven where the regions are
/// known; where they are chosen, they are the smaller the fewer sizes there are.
pub fn estimate_clip(
    (clip, masked): (Domain<3>, bool),
    channels: usize,
    output: Domain<3>,
    options: &Options<3>,
) -> Bytes {
    if masked {
        return estimate(&[clip], channels, output, options);
    }
    let known = Known { masked: false, threads: par::threads() as u64 };
    let of = |levels, options: &Options<3>| at_levels(&[clip], channels, output, options, levels, known);
    let side = shortest(clip.shape);
    let bound =
        |region: Option<[u32; 3]>, a: usize| if options.free[a] { region.map(|r| r[a]) } else { Some(output.shape[a]) };
    let structure = bound(options.region, 1).zip(bound(options.region, 2)).map(|(a, b)| a.min(b));
    let most = options.levels.map_or_else(|| levels(side, structure.unwrap_or(u32::MAX), output), |n| asked(side, n));
    let most = covered(options.free, output, most);
    let run = match (options.levels, structure) {
        (None, None) => (1..=most).map(|n| of(n, &if n < most { smaller(clip, n, options) } else { *options })).max(),
        _ => Some(of(most, options)),
    };
    measuring(&[clip], channels, false, options).then(run.unwrap_or_default())
}

/// Options with regions no smaller than those that are chosen for a clip of so many levels, where there may be more.
fn smaller(clip: Domain<3>, levels: u32, options: &Options<3>) -> Options<3> {
    let [frames, height, width] = largest_sides(std::iter::once(clip.shape));
    let most = larger_region(levels) - 1;
    let region = [frames, height.min(most), width.min(most)];
    let reach = reach(options, Placement::Sub, region, longest(std::iter::once(clip)));
    Options { region: Some(region), reach: Some(reach), ..*options }
}

/// What a run that is planned knows beyond its sizes.
#[derive(Clone, Copy)]
pub(crate) struct Known {
    pub(crate) masked: bool,
    pub(crate) threads: u64,
}

/// What making a [`Plan`](crate::Plan) holds at most besides the exemplars, whatever the output is: they are looked at
/// one after the other, and of clips a frame.
pub fn measuring<const D: usize>(sources: &[Domain<D>], channels: usize, masked: bool, options: &Options<D>) -> Bytes {
    let by_regions = options.region.is_none();
    let lies_apart = options.apart.is_none() && by_regions && options.placement != Placement::Random;
    let largest = sources.iter().map(|s| shortest(s.shape)).max().unwrap_or(0);
    let by_levels = D != CLIP && options.levels.is_none() && 1 < levels(largest, u32::MAX, Domain::open([u32::MAX; D]));
    let of = |source: &Domain<D>| {
        let picture = Domain::open([source.shape[D.saturating_sub(2)], source.shape[D.saturating_sub(1)]]);
        if D != CLIP && (lies_apart || options.placement == Placement::Auto) {
            selvedge_analysis::estimate_texture(picture, channels, masked)
        } else if by_regions || by_levels {
            selvedge_analysis::estimate_size(picture, channels, masked)
        } else {
            Bytes(0)
        }
    };
    sources.iter().map(of).max().unwrap_or_default()
}

/// That of a run at so many levels: at the smallest one, or while its map is carried up, whichever is more.
pub(crate) fn at_levels<const D: usize>(
    sources: &[Domain<D>],
    channels: usize,
    output: Domain<D>,
    options: &Options<D>,
    levels: u32,
    known: Known,
) -> Bytes {
    let (mut small, mut whole) = (sources.to_vec(), output);
    let mut coarse = Bytes(0);
    for _ in 1..levels {
        small.iter_mut().for_each(|s| *s = s.coarser());
        whole = whole.coarser();
        coarse += small.iter().map(|s| Bytes::of_samples(*s, channels as u64 + 1)).sum();
    }
    let halved = |sides: [u32; D]| Domain::halved(sides, levels - 1);
    let region = options.region.map(|sides| halved(sides).map(|n| n.max(1)));
    let reach = options.reach.map(halved);
    let run = of_one(&small, channels, whole, &Options { region, reach, ..*options }, known);
    let carrying = if levels == 1 { Bytes(0) } else { carrying(sources, output) };
    coarse + run.max(carrying)
}

/// What carrying a map up takes at the last level: both maps, the patch of each sample, what lies beside seams, and the
/// tiles that are decided together.
fn carrying<const D: usize>(sources: &[Domain<D>], output: Domain<D>) -> Bytes {
    let looks: Bytes = sources.iter().map(|s| Bytes::of_samples(*s, 4 * D as u64 + 2)).sum();
    Bytes(A_RUN) + looks + Bytes::of_samples(output, A_CARRIED) + selvedge_expansion::estimate_settled(output)
}

/// That of a run at one size.
fn of_one<const D: usize>(
    sources: &[Domain<D>],
    channels: usize,
    output: Domain<D>,
    options: &Options<D>,
    Known { masked, threads }: Known,
) -> Bytes {
    let samples: Bytes = sources.iter().map(|s| Bytes::of_samples(*s, 1)).sum();
    // No less than what the run may choose.
    let sides = options.region.unwrap_or_else(|| largest_sides(sources.iter().map(|s| s.shape)));
    let sides = std::array::from_fn(|a| if options.free[a] { sides[a] } else { output.shape[a] });
    let longest = longest(sources.iter().copied());
    let reach = reach(options, options.placement, sides, longest);
    let region: [u32; D] = std::array::from_fn(|a| output.shape[a].min(sides[a]).max(1));
    // As far as patches may show around a region: `Weaver::near`.
    let around: [u32; D] = std::array::from_fn(|a| {
        if options.free[a] { reach[a].min(output.shape[a]).min(longest[a].saturating_sub(region[a])) } else { 0 }
    });
    let window: [u32; D] = std::array::from_fn(|a| region[a].saturating_add(2 * around[a]));
    // The map, and the costs of its seams by cells.
    let cell = len(sides.map(|n| (n / CELLS_A_REGION).max(1)));
    let map = Bytes::of_samples(output, 5) + Bytes(len(output.shape) / cell) * 42;
    let seams = SeamCosts::<D>::bytes(samples, channels) + samples * A_CANDIDATE;
    // Each source once more, if a mask leaves a part of it: that part is searched alone.
    let singles = if masked { samples * (channels as u64 + 1) } else { Bytes(0) };
    let shown = |s: &Domain<D>| -> [u32; D] { std::array::from_fn(|a| s.shape[a].min(window[a])) };
    let nodes = Bytes(sources.iter().map(|s| len(shown(s))).max().unwrap_or_default());
    let cut = sources.iter().map(|s| selvedge_expansion::estimate(shown(s))).max().unwrap_or_default();
    // What each region of a batch waits to lay, and what it takes on a thread of its own.
    let batch = if options.refine == Some(0) { 1 } else { apart(output, region, window).min(BATCH as u64) };
    let threads = at_once(samples.0).min(batch).min(threads);
    let cuts = cut * threads + nodes * (A_FRAME * batch);
    let lists = samples * A_CANDIDATE * (threads - 1);
    let (weights, search) = (vec![1; channels], selvedge_fft_ssd::Options::default());
    let of = |template| Sizes {
        sources,
        weights: &weights,
        holes: masked,
        template,
        samples: len(template),
        noisy_masks: true,
    };
    let inside = || held(&of(region), Positions::INSIDE, &search).ok();
    let sub = || inside().map_or(Bytes::MOST, |all| searched(all, threads));
    // Where nothing stands yet a region is looked for by itself, and what was prepared for that stays.
    let entire = || {
        let both = inside().zip(held_of_part(&of(window), around, region, &search).ok());
        both.map_or(Bytes::MOST, |(first, all)| {
            searched(all, threads).max(searched(first, 1)) + first.tables + first.spectra
        })
    };
    let search = match options.placement {
        Placement::Random => Bytes(0),
        // Each place is compared by itself.
        _ if options.free.contains(&false) => Bytes(len(window)) * (channels as u64 + 1),
        Placement::Sub => sub(),
        Placement::Entire => entire(),
        // As for the run.
        Placement::Auto if D == CLIP => sub(),
        Placement::Auto => sub().max(entire()),
    };
    Bytes(A_RUN) + map + seams + singles + cuts + lists + search + history(sources, output, region, options)
}

/// Regions whose patches do not meet, at most.
fn apart<const D: usize>(output: Domain<D>, region: [u32; D], window: [u32; D]) -> u64 {
    let along = |a: usize| u64::from((output.shape[a].saturating_sub(region[a])) / window[a].saturating_add(1) + 1);
    (0..D).map(along).fold(1, u64::saturating_mul)
}

/// What is kept of every patch that was laid or tried: offsets used before, vectors to neighbours, prices.
fn history<const D: usize>(sources: &[Domain<D>], output: Domain<D>, region: [u32; D], options: &Options<D>) -> Bytes {
    // Around the first hole, half of a region along each axis is filled already.
    let filled = region.map(|n| n.div_ceil(2));
    let patches = len(output.shape) / len(filled) + 1;
    let refinements = options.refine.map_or(patches.saturating_mul(Options::<D>::REFINEMENTS_A_PATCH), u64::from);
    let steps = patches.saturating_add(refinements.saturating_mul(options.tries.into()));
    // Each has about so many neighbours; vectors are coarse and no longer than sources and regions.
    let neighbours = steps.saturating_mul(1 << D);
    let vectors = |s: &Domain<D>| len::<D>(std::array::from_fn(|a| (s.shape[a] + region[a]) / 2 + 1)) / 2;
    let vectors = sources.iter().map(vectors).fold(0, u64::saturating_add).min(neighbours);
    Bytes(steps) * A_PATCH + Bytes(vectors) * A_VECTOR
}

/// Searches in all sources, so many beside each other.
fn searched(Holdings { tables, spectra, working }: Holdings, at_once: u64) -> Bytes {
    tables + spectra + working * at_once
}

fn len<const D: usize>(shape: [u32; D]) -> u64 {
    shape.into_iter().fold(1, |n, side| n.saturating_mul(side.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_run_takes_two_mebibytes() {
        let one = Domain::open([1, 1]);
        // One that looks at nothing before.
        let options = Options { region: Some([1; 2]), placement: Placement::Sub, ..Options::default() };
        let least = estimate(&[one], 1, one, &options).0;
        assert!((2 << 20..3 << 20).contains(&least), "{least}");
    }

    #[test]
    fn no_more_patches_lie_apart_than_there_is_room_for() {
        // Regions of 10 whose patches reach 5 further on both sides: the next begins 21 samples on.
        let along = |side| apart(Domain::open([side]), [10], [20]);
        for side in 10..200 {
            let laid = (0..side).filter(|start| start % 21 == 0 && start + 10 <= side).count() as u64;
            assert_eq!(along(side), laid, "{side}");
        }
        assert_eq!(apart(Domain::open([100, 31]), [10, 10], [20, 20]), 5 * 2);
    }
}
