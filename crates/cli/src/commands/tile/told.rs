//! What `tile` tells of a run.

use super::widths::Widths;
use super::{MethodArg, TileCommand};
use crate::failure::n;
use crate::loom::Loom;
use crate::used::Used;

impl TileCommand {
    /// The options as used.
    pub(super) fn used(&self, loom: &Loom<'_>, widths: Widths) -> Used {
        let width = widths.into_iter().max().unwrap_or(0);
        // Overlaps that were chosen differ along the axes: chosen again, they are the same.
        if self.period.is_some() {
            return loom
                .used()
                .without("band")
                .without("overlap")
                .set("period", format!("{}x{}", widths[1], widths[0]));
        }
        match self.method {
            MethodArg::Overlap => loom.used().without("band").without("period"),
            MethodArg::Band => loom.used().without("overlap").without("period").set("band", width),
        }
    }

    /// How it is made, in words.
    pub(super) fn how(&self, [down, across]: Widths) -> String {
        if self.period.is_some() {
            return "that tile, one period of the picture".to_owned();
        }
        match self.method {
            MethodArg::Overlap => format!("that tile, laid over themselves by {across} across and {down} down"),
            MethodArg::Band => format!("that tile, a border of {} filled anew", n("pixel", down.max(across) as usize)),
        }
    }
}
