//! Fields of motion: Middlebury's `.flo`, KITTI's PNG, and vectors in EXR.

mod flo;
mod kitti;
mod vectors;

use std::path::Path;

use selvedge_core::{Domain, Flow, Grid, Limits};

use crate::error::{Error, Problem};
use crate::name::{display_name, file_of};
use crate::read::{read_bytes, split_selector};
use crate::{Fingerprint, Format, ReadOptions};

/// From here on a component says that its vector is unknown, as Middlebury has it.
const UNKNOWN: f32 = 1e9;

/// A field as read.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowFile {
    /// The vectors.
    pub flow: Flow,
    /// The file by name and content.
    pub fingerprint: Fingerprint,
}

/// Whether a name is that of a file of vectors, in which numbers stand for frames.
pub fn is_flow_name(path: &Path) -> bool {
    let named = file_of(path).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("flo"));
    named || matches!(Format::of_name(file_of(path)), Some(Format::Png | Format::Exr))
}

/// Reads a field, by its content:
/// - `.flo`: two floats each, across and down; from 1e9 on, of either, a vector is unknown.
/// - PNG of 16 bits in three channels: `(value - 2^15) / 64` across and down, and unknown where the third is 0.
/// - EXR: the first two of its channels, or those chosen by `file.exr[...]`, are across and down; `x`, `y` and `u`, `v`
///   are chosen
///   by themselves.
///
/// # Errors
/// [`Error`] with the file, the numbers and a remedy: damaged files, sides over the caps, vectors that are no numbers.
pub fn read_flow(path: impl AsRef<Path>, limits: &Limits) -> Result<FlowFile, Error> {
    let named = path.as_ref();
    let options = ReadOptions { limits: *limits, ..ReadOptions::default() };
    let (path, options) = split_selector(named, &options);
    let read = || {
        let bytes = read_bytes(&path, limits)?;
        let flow = decode(&bytes, &path, &options)?;
        let blake3 = blake3::hash(&bytes).to_hex().to_string();
        Ok(FlowFile { flow, fingerprint: Fingerprint { name: display_name(&path), blake3 } })
    };
    read().map_err(|problem: Problem| Error::new(named, problem))
}

fn decode(bytes: &[u8], name: &Path, options: &ReadOptions) -> Result<Flow, Problem> {
    let flow = match Format::of_content(bytes) {
        _ if bytes.is_empty() => return Err(Problem::Empty),
        _ if flo::is_flo(bytes) => flo::decode(bytes, &options.limits)?,
        Some(Format::Png) => kitti::decode(bytes, name, options)?,
        Some(Format::Exr) => vectors::decode(bytes, name, options)?,
        _ => return Err(Problem::NotFlow { found: "something else".into() }),
    };
    let first = flow.odd().next();
    match first {
        Some(at) => Err(Problem::NotFinite {
            count: flow.odd().count() as u64,
            channel: usize::from(flow.by.get(1, at).is_finite()),
            x: at[1],
            y: at[0],
        }),
        None => Ok(flow),
    }
}

/// Vectors by their places, across and down.
fn of(domain: Domain<2>, vector: impl Fn(usize) -> [f32; 2]) -> Result<Flow, Problem> {
    let mut by = Grid::try_filled(domain, 2, 0.0)?;
    let mut known = Grid::try_filled(domain, 1, true)?;
    for i in 0..domain.len() {
        let [across, down] = vector(i);
        if UNKNOWN <= across.abs() || UNKNOWN <= down.abs() {
            known.plane_mut(0)[i] = false;
        } else {
            (by.plane_mut(0)[i], by.plane_mut(1)[i]) = (down, across);
        }
    }
    let all = known.samples().iter().all(|known| *known);
    Ok(Flow { by, known: (!all).then_some(known) })
}

#[cfg(test)]
mod tests;
