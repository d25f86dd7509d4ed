//! How large error regions are where nobody says.

use selvedge_analysis::{Texture, feature_size};
use selvedge_core::{Exemplars, Source, ValidBoxes};

use crate::error::Error;
use crate::options::Options;
use crate::squares::squares;
use crate::stills::stills;

/// A region holds no more than so many times the largest structures: of fine textures larger patches are no better, and
/// cost more.
const STRUCTURES: u32 = 4;

/// The sides of error regions: as asked, or a fourth of the exemplar's shortest side, but no more than four times its
/// largest structures. Smaller regions make crumbs of what is larger than they are, larger ones leave few places to
/// take patches from. Of several exemplars that of the shortest side counts, but not one under half of the largest: it
/// is laid where nothing else fits. Of clips the same is said of their frames, and of time by itself: a clip's few
/// frames are no measure of what is in them.
pub(crate) fn region_sides<const D: usize>(
    exemplars: &Exemplars<D>,
    boxes: &ValidBoxes<'_, D>,
    measured: &[Texture],
    options: &Options<D>,
) -> Result<[u32; D], Error> {
    if let Some(region) = options.region {
        return held(exemplars, region).map(|()| region);
    }
    let shortest: Vec<u32> = boxes.domains().map(|domain| shortest(domain.shape)).collect();
    let largest = shortest.iter().copied().max().unwrap_or(0);
    let most = shortest.into_iter().filter(|side| largest <= side.saturating_mul(2)).min().unwrap_or(0);
    let known = measured.iter().map(|t| t.feature_size).max();
    let structure = match known {
        Some(known) => known,
        None if D == CLIP => feature_size(&stills(exemplars)?)?,
        None => feature_size(exemplars)?,
    };
    // What is flat has no structures, and measures 1: every region shows all of it, and the largest ones are the
    // fewest.
    let structure = if structure <= 1 { most } else { structure };
    let side = largest_region(most).min(structure.saturating_mul(STRUCTURES)).max(most.min(LEAST)).max(1);
    let mut sides = [side; D];
    if D == CLIP {
        // Of the clips that count for space the least, so that each of them holds a region.
        let counts = exemplars.sources().iter().filter(|s| most <= self::shortest(s.domain().shape));
        sides[0] = counts.map(|s| duration(s, exemplars.weights())).min().unwrap_or(1);
    }
    Ok(sides)
}

/// Axes of a clip, time first.
pub(crate) const CLIP: usize = 3;

/// The shortest side of an exemplar, or of a clip's frames.
pub(crate) fn shortest<const D: usize>(shape: [u32; D]) -> u32 {
    shape.into_iter().skip(usize::from(D == CLIP)).min().unwrap_or(0)
}

/// The largest sides of regions that the program chooses for exemplars of some shapes.
pub(crate) fn largest_sides<const D: usize>(shapes: impl Iterator<Item = [u32; D]> + Clone) -> [u32; D] {
    let mut sides = [largest_region(shapes.clone().map(shortest).max().unwrap_or(0)); D];
    if D == CLIP {
        sides[0] = shapes.map(|shape| longest_region(shape[0])).max().unwrap_or(1);
    }
    sides
}

/// Some source holds a region.
///
/// # Errors
/// [`Error::RegionExceedsExemplar`].
pub(crate) fn held<const D: usize>(exemplars: &Exemplars<D>, region: [u32; D]) -> Result<(), Error> {
    let domains = || exemplars.sources().iter().map(|s| s.domain());
    if domains().any(|d| (0..D).all(|a| region[a] <= d.shape[a])) {
        return Ok(());
    }
    let largest = domains().map(|d| d.shape).max_by_key(|&shape| shortest(shape)).unwrap_or([0; D]);
    Err(Error::RegionExceedsExemplar { region: region.to_vec(), largest: largest.to_vec() })
}

/// Frames that a region of a clip holds: twice as many as it takes for frames to lose four fifths of their likeness,
/// but no more than a third of the clip. In fewer a movement is not seen, and patches settle where nothing moves.
fn duration<const D: usize>(clip: &Source<D>, weights: &[u8]) -> u32 {
    let frames = clip.domain().shape[0];
    let most = longest_region(frames);
    let distances: Vec<u64> = (1..frames).map(|lag| distance(clip, weights, lag)).collect();
    let unlike = distances.iter().copied().max().unwrap_or(0) / 5 * 4;
    let lag = distances.iter().position(|&d| unlike <= d).map_or(1, |i| i as u32 + 1);
    (2 * lag).clamp(LEAST.min(most), most)
}

/// The longest region in time that the program chooses for a clip of so many frames.
pub(crate) fn longest_region(frames: u32) -> u32 {
    (frames / 3).max(frames.min(LEAST)).max(1)
}

/// Pairs of frames that are compared for each lag: enough for a mean, whatever the clip's length.
const PAIRS: u32 = 4;

/// How much frames of a clip differ that are so far apart, in the mean over some pairs.
fn distance<const D: usize>(clip: &Source<D>, weights: &[u8], lag: u32) -> u64 {
    let (last, frame) = (clip.domain().shape[0] - 1 - lag, clip.domain().strides()[0]);
    let pairs = (last + 1).min(PAIRS);
    let of = |pair: u32, c: usize| {
        let first = last * pair / pairs.saturating_sub(1).max(1);
        let [a, b] = [first, first + lag].map(|t| &clip.features.plane(c)[t as usize * frame..][..frame]);
        squares(a, b) * u64::from(weights[c])
    };
    let sum: u64 = (0..pairs).flat_map(|pair| (0..weights.len()).map(move |c| of(pair, c))).sum();
    sum / u64::from(pairs)
}

/// Smaller regions hold nothing that could be matched: a seam through them has no room for a bend, and many places
/// agree.
pub(crate) const LEAST: u32 = 8;

/// No region that the program chooses is larger, for exemplars whose longest shortest side is `side`.
fn largest_region(side: u32) -> u32 {
    (side / 4).max(side.min(LEAST)).max(1)
}
