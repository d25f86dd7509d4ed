//! `inspect --offsets`: by which offsets a picture comes again, as `fill` goes by them. `[He12 3.1]`

use selvedge_core::{Exemplars, SourceMap};
use selvedge_graphcut_textures::labels::{OffsetOptions, dominant_offsets};

use crate::failure::Failure;

/// Those that are told to people.
const TOLD: usize = 8;

/// Pixels across and down, the most frequent first.
pub(super) fn offsets(exemplars: &Exemplars<2>) -> Result<Vec<[i32; 2]>, Failure> {
    let (mut coarse, mut times) = (exemplars.only([0])?, 1);
    while coarse.sources()[0].domain().shape.iter().any(|&n| OffsetOptions::COARSE < n) {
        (coarse, times) = (coarse.coarser()?, 2 * times);
    }
    let mut map = SourceMap::unassigned(&coarse, coarse.sources()[0].domain())?;
    map.lay_under(&coarse, 0)?;
    let found = dominant_offsets(&coarse, &map, &OffsetOptions::default())?;
    Ok(found.into_iter().map(|label| [times * label.offset[1], times * label.offset[0]]).collect())
}

/// For people.
pub(super) fn told(offsets: &[[i32; 2]]) -> String {
    let pairs: Vec<String> = offsets.iter().take(TOLD).map(|[x, y]| format!("{x},{y}")).collect();
    let more = offsets.len().saturating_sub(TOLD);
    match (offsets, more) {
        ([], _) => "none".to_owned(),
        (_, 0) => pairs.join("  "),
        _ => format!("{} and {more} more", pairs.join("  ")),
    }
}
