//! Middlebury's format: a mark, width and height, and pairs of floats row by row, all least byte first.

use selvedge_core::{Flow, Limits};

use crate::Depth;
use crate::clip::ClipProblem;
use crate::error::Problem;
use crate::header::Header;

/// What a file begins with: 202021.25 as a float.
const MARK: &[u8; 4] = b"PIEH";
/// Bytes before the vectors.
const HEAD: usize = 12;

pub(super) fn is_flo(bytes: &[u8]) -> bool {
    bytes.starts_with(MARK)
}

pub(super) fn decode(bytes: &[u8], limits: &Limits) -> Result<Flow, Problem> {
    let damaged = |cause: String| Problem::Clip(ClipProblem::Damaged { container: "flo", cause });
    let ends_early = |needed: u64| damaged(format!("{} of {needed} bytes", bytes.len()));
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
    let side = |at: usize| word(at).map(i32::from_le_bytes).ok_or_else(|| ends_early(HEAD as u64));
    let [width, height] = [side(4)?, side(8)?];
    if width < 0 || height < 0 {
        return Err(damaged(format!("{width}x{height} vectors")));
    }
    let header = Header { width: width as u64, height: height as u64, channels: 2, alpha: false, depth: Depth::F32 };
    header.check(limits, bytes.len() as u64)?;
    let needed = HEAD as u64 + header.bytes();
    if bytes.len() as u64 != needed {
        return Err(ends_early(needed));
    }
    let value = |at: usize| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    super::of(header.domain(), |i| [value(HEAD + 8 * i), value(HEAD + 8 * i + 4)])
}
