//! Which of a few labels shows where: merging, filling and tiling as one problem, solved by expansions. `[Kwatra03 6B]`
//!
//! A label is a source at an offset. Pictures that are merged are labels, and so is one picture moved over itself: what
//! fills a hole in it, or closes it around a border. Seams between labels have the prices of
//! [`SeamCosts`](selvedge_core::SeamCosts); each label in turn is offered wherever it may show, and a cut decides: an
//! expansion.

mod expand;
mod extend;
mod fill;
mod first;
pub(crate) mod label;
mod merge;
mod nearby;
mod offsets;
mod options;
mod parts;
mod patches;
mod place;
mod prefer;
mod prices;
mod sets;
mod sweeps;
mod tile;
mod two;
mod windows;

pub use expand::{estimate_labels, expand};
pub use extend::extend;
pub use fill::{FillOptions, FillStats, estimate_fill, fill};
pub use label::{Label, MOST_LABELS};
pub use merge::{Merge, StrokeDelta};
pub use offsets::{OffsetOptions, dominant_offsets};
pub use options::{LabelOptions, LabelStats};
pub use place::{aligned, estimate_aligned};
pub use prefer::{Prefer, preferred};
pub use tile::{banded, check_band, check_overlap, close, close_period, overlaps};
