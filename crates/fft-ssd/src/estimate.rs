//! Memory of a search, from sizes alone.

use crate::axes::{Shape, lift};
use crate::cache::Cache;
use crate::extension::Extension;
use crate::fft;
use crate::job::Job;
use crate::kernel::Kernel;
use crate::pack::Packed;
use crate::placement::Range;
use crate::prepared::Prepared;
use crate::source::SourceView;
use crate::sums::Table;
use crate::template::Checked;
use crate::{Cover, Error, Options, Placement};
use selvedge_core::{Bytes, Domain, par};

/// The sizes of a search.
#[derive(Clone, Copy, Debug)]
pub struct Sizes<'a, const D: usize> {
    /// Shape and topology of each source.
    pub sources: &'a [Domain<D>],
    /// Weights of the channels.
    pub weights: &'a [u8],
    /// Whether some of their samples are not valid.
    pub holes: bool,
    /// The template's shape.
    pub template: [u32; D],
    /// Samples of the template that are not masked; all of the box is an upper bound. They tell which engine answers.
    pub samples: u64,
    /// Whether masks have more than 40 corners, as random ones do; rectangles, Ls and the like have fewer.
    pub noisy_masks: bool,
}

/// Bytes that a searcher, its scratch and its costs hold during and after searches of these sizes, beside the features
/// and the template: at least what they do hold, and at most half as much again where that is more than some MiB.
/// Candidates within a tolerance come on top, 16 bytes each; and, where heavy weights and strong contrasts make a large
/// template be transformed in blocks, their spectra, within [`Options::cache`]. Needs sizes only.
///
/// # Errors
/// [`Error::TooLarge`] if the positions cannot be addressed.
pub fn estimate<const D: usize>(sizes: &Sizes<'_, D>, placement: Placement, options: &Options) -> Result<Bytes, Error> {
    let template: Shape = lift(sizes.template.map(|n| n as usize), 1);
    let samples = sizes.samples;
    let weight: u64 = sizes.weights.iter().map(|&w| u64::from(w)).sum();
    let wide = u128::from(u32::MAX) <= u128::from(samples) * u128::from(weight) * 65_025;
    let counted = matches!(placement.cover, Cover::AtLeast(_));
    let of_position = if wide { 8 } else { 4 } + if counted { 4 } else { 0 };
    let (mut costs, mut kept, mut working) = (0_u64, 0_u64, 0_u64);
    for (number, domain) in sizes.sources.iter().enumerate() {
        let shape = lift(domain.shape.map(|n| n as usize), 1);
        let valid: Option<&[bool]> = sizes.holes.then_some(&[]);
        let source = SourceView { shape, periodic: lift(domain.periodic, false), features: &[], valid };
        let range = Range::new(placement.positions, shape, source.periodic, template);
        let positions = range.checked_len().ok_or(Error::TooLarge { positions: u64::MAX })?;
        if positions == 0 {
            continue;
        }
        costs += positions as u64 * of_position;
        let key = Extension::key(shape, &range, template);
        let prepared = Prepared::new(&source, &range, template, number, key)?;
        let template = Checked { shape: template, features: &[], mask: None, samples };
        let (weights, kernel, cache) = (sizes.weights, Kernel::new(options.simd), Cache::default());
        let job = Job {
            source: &source,
            weights,
            prepared: &prepared,
            template: &template,
            range,
            cover: placement.cover,
            kernel,
            cache: &cache,
            budget: options.cache,
        };
        let (of_source, of_search) = of_job(&job, sizes.noisy_masks, if wide { 8 } else { 4 }, options);
        kept += of_source;
        working = working.max(of_search);
    }
    // What is kept is dropped beyond the budget, but never what the running search needs.
    let all = costs + working + kept;
    // Allocators round up, and small buffers are not listed.
    Ok(Bytes(all) + Bytes(all / 16))
}

/// Bytes kept for a source, and bytes that a search of it works in.
fn of_job(job: &Job<'_>, noisy: bool, width: u64, options: &Options) -> (u64, u64) {
    let extension = &job.prepared.extension;
    let (shape, channels) = (extension.shape, job.weights.len());
    let table = Table::<u32>::shape(shape).iter().map(|&n| n as u64).product::<u64>();
    // Where only borders make the number of compared samples vary, boxes tell it.
    let (varies, is_box) = (job.varies(), job.prepared.is_box);
    let valid = if job.prepared.is_full || varies && is_box { 0 } else { 4 * table };
    if crate::searcher::prefers_fft(job, options.engine) {
        let (kept, working) = fft::bytes(job, noisy, par::threads());
        let table = if noisy { 0 } else { width * table };
        (kept + table + valid, working)
    } else {
        let words = Packed::len(extension.len(), shape[2], channels, job.kernel.lanes());
        let taps = job.template.len() * channels * 40;
        let looked_at = if varies && !is_box { extension.len() } else { 0 };
        (4 * words as u64 + width * table + valid, (taps + looked_at) as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_searches_take_more_and_impossible_ones_nothing() {
        let bytes = |side: u32, template: u32| {
            let sources = [Domain::open([side, side])];
            let sizes = Sizes {
                sources: &sources,
                weights: &[1, 1, 1],
                holes: false,
                template: [template; 2],
                samples: u64::from(template).pow(2),
                noisy_masks: false,
            };
            estimate(&sizes, Placement::INSIDE, &Options::default()).unwrap().0
        };
        assert_eq!(bytes(10, 11), 0);
        assert!(bytes(64, 8) < bytes(128, 8));
        assert!(bytes(128, 8) < bytes(1024, 64));
        // Features of 4096^2 take 48 MiB, their spectra in double precision ten times that.
        assert!((400 << 20..900 << 20).contains(&bytes(4096, 64)), "{}", bytes(4096, 64));
    }
}
