//! Vectors in EXR, as renderers write them.

use std::path::Path;

use selvedge_core::{Flow, Samples};

use crate::ReadOptions;
use crate::error::Problem;

/// Names that renderers give to what is across and down, tried one after the other before a file's default channels.
const NAMES: [&str; 4] = ["u,v", "x,y", "X,Y", "U,V"];

pub(super) fn decode(bytes: &[u8], name: &Path, options: &ReadOptions) -> Result<Flow, Problem> {
    let read = |channels: Option<String>| {
        let options = ReadOptions { channels: channels.or_else(|| options.channels.clone()), ..options.clone() };
        crate::decode(bytes, name, &options).map_err(|e| e.problem)
    };
    let named = NAMES.iter().filter(|_| options.channels.is_none());
    let by_name = named.map(|names| read(Some((*names).to_owned()))).find(|read| {
        // A layer, or channels, that are not there; all else is told.
        !matches!(read, Err(Problem::NoChannel { .. }))
    });
    let samples = by_name.unwrap_or_else(|| read(None))?.plane.samples;
    if samples.channels() < 2 {
        return Err(Problem::NotFlow { found: "one channel".into() });
    }
    let value = |c: usize, i: usize| match &samples {
        Samples::F32(samples) => samples.plane(c)[i],
        other => other.value(c, i) as f32,
    };
    super::of(samples.domain(), |i| [value(0, i), value(1, i)])
}
