//! Memory of a search, from sizes alone.

use crate::axes::{Shape, lift};
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

/// What searches of some sizes hold beside the features and the template, by who owns it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Holdings {
    /// Tables and copies of the sources, which the searcher keeps, whatever the template.
    pub tables: Bytes,
    /// Spectra of the sources, which it keeps as far as [`Options::cache`] goes; templates of other shapes may have
    /// others.
    pub spectra: Bytes,
    /// Scratch and costs: of each search that runs beside others.
    pub working: Bytes,
}

/// Bytes that a searcher, its scratch and its costs hold during and after searches of these sizes, beside the features
/// and the template: at least what they do hold, and at most half as much again where that is more than some MiB.
/// Candidates within a tolerance come on top, 16 bytes each; and, where heavy weights and strong contrasts make a large
/// template be transformed in blocks, their spectra, within [`Options::cache`]. Needs sizes only.
///
/// # Errors
/// [`Error::TooLarge`] if the positions cannot be addressed.
pub fn estimate<const D: usize>(sizes: &Sizes<'_, D>, placement: Placement, options: &Options) -> Result<Bytes, Error> {
    let Holdings { tables, spectra, working } = held(sizes, placement, options)?;
    Ok(tables + spectra + working)
}

/// The same by owners, for runs with several searches at once, or of several templates.
///
/// # Errors
/// Those of [`estimate`].
pub fn held<const D: usize>(sizes: &Sizes<'_, D>, placement: Placement, options: &Options) -> Result<Holdings, Error> {
    let template: Shape = lift(sizes.template.map(|n| n as usize), 1);
    let range = |shape: Shape, periodic: [bool; 3]| Range::new(placement.positions, shape, periodic, template);
    held_at(sizes, &range, placement.cover, options)
}

/// The same of [`search_box`](crate::SsdSearcher::search_box), at the positions of a box.
///
/// # Errors
/// Those of [`estimate`].
pub fn held_in_box<const D: usize>(
    sizes: &Sizes<'_, D>,
    first: [i32; D],
    count: [u32; D],
    options: &Options,
) -> Result<Holdings, Error> {
    let (first, count) = (lift(first, 0).map(|n| n as isize), lift(count, 1).map(|n| n as usize));
    held_at(sizes, &|_, _| Range { first, count, wraps: [false; 3] }, Cover::AtLeast(1), options)
}

/// The same of [`search_part`](crate::SsdSearcher::search_part), for a part of this shape that starts at `start`.
///
/// # Errors
/// Those of [`estimate`].
pub fn held_of_part<const D: usize>(
    sizes: &Sizes<'_, D>,
    start: [u32; D],
    part: [u32; D],
    options: &Options,
) -> Result<Holdings, Error> {
    let [start, part] = [lift(start, 0), lift(part, 1)].map(|axes| axes.map(|n| n as usize));
    held_at(sizes, &|shape, periodic| Range::of_part(shape, periodic, start, part), Cover::AtLeast(1), options)
}

fn held_at<const D: usize>(
    sizes: &Sizes<'_, D>,
    range: &dyn Fn(Shape, [bool; 3]) -> Range,
    cover: Cover,
    options: &Options,
) -> Result<Holdings, Error> {
    let template: Shape = lift(sizes.template.map(|n| n as usize), 1);
    let samples = sizes.samples;
    let weight: u64 = sizes.weights.iter().map(|&w| u64::from(w)).sum();
    let wide = u128::from(u32::MAX) <= u128::from(samples) * u128::from(weight) * 65_025;
    let counted = matches!(cover, Cover::AtLeast(_));
    let of_position = if wide { 8 } else { 4 } + if counted { 4 } else { 0 };
    let (mut costs, mut all) = (0_u64, Holdings::default());
    for (number, domain) in sizes.sources.iter().enumerate() {
        let shape = lift(domain.shape.map(|n| n as usize), 1);
        let valid: Option<&[bool]> = sizes.holes.then_some(&[]);
        let source = SourceView { shape, periodic: lift(domain.periodic, false), features: &[], valid };
        let range = range(shape, source.periodic);
        let positions = range.checked_len().ok_or(Error::TooLarge { positions: u64::MAX })?;
        if positions == 0 {
            continue;
        }
        costs += positions as u64 * of_position;
        let key = Extension::key(shape, &range, template);
        let prepared = Prepared::new(&source, &range, template, number, key)?;
        let template = Checked { shape: template, features: &[], mask: None, samples };
        let (weights, kernel) = (sizes.weights, Kernel::new(options.simd));
        let job = Job { source: &source, weights, prepared: &prepared, template: &template, range, cover, kernel };
        let of_source = of_job(&job, sizes.noisy_masks, if wide { 8 } else { 4 }, options);
        all.tables += of_source.tables;
        all.spectra += of_source.spectra;
        all.working = all.working.max(of_source.working);
    }
    all.working += Bytes(costs);
    // Allocators round up, and small buffers are not listed. What is kept is dropped beyond the budget, but never what
    // the running search needs.
    let rounded = |bytes: Bytes| bytes + Bytes(bytes.0 / 16);
    Ok(Holdings { tables: rounded(all.tables), spectra: rounded(all.spectra), working: rounded(all.working) })
}

/// What is kept for a source, and what a search of it works in but for its costs.
fn of_job(job: &Job<'_>, noisy: bool, width: u64, options: &Options) -> Holdings {
    let extension = &job.prepared.extension;
    let (shape, channels) = (extension.shape, job.weights.len());
    let table = Table::<u32>::shape(shape).iter().map(|&n| n as u64).product::<u64>();
    // Where only borders make the number of compared samples vary, boxes tell it.
    let (varies, is_box) = (job.varies(), job.prepared.is_box);
    let valid = if job.prepared.is_full || varies && is_box { 0 } else { 4 * table };
    if crate::searcher::prefers_fft(job, options.engine) {
        let (kept, working) = fft::bytes(job, options.cache, noisy, par::threads());
        let table = if noisy { 0 } else { width * table };
        Holdings { tables: Bytes(table + valid), spectra: Bytes(kept), working: Bytes(working) }
    } else {
        let words = Packed::len(extension.len(), shape[2], channels, job.kernel.lanes());
        let taps = job.template.len() * channels * 40;
        let looked_at = if varies && !is_box { extension.len() } else { 0 };
        let tables = 4 * words as u64 + width * table + valid;
        Holdings { tables: Bytes(tables), spectra: Bytes(0), working: Bytes((taps + looked_at) as u64) }
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
