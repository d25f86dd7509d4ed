//! What a block is laid on, for a trial.

use selvedge_core::{Error as CoreError, SeamCosts, Window};

use crate::canvas::Canvas;
use crate::error::Error;

/// What stands where a block is to be laid, and one sample around it.
pub(crate) struct Ground<'a> {
    window: Window<2>,
    canvas: Canvas,
    shown: &'a SeamCosts<2>,
}

impl<'a> Ground<'a> {
    pub(crate) fn new(canvas: &Canvas, window: &Window<2>, shown: &'a SeamCosts<2>) -> Result<Self, CoreError> {
        let window = window.grown(canvas.domain(), [1; 2], [1; 2]);
        Ok(Self { window, canvas: canvas.cut(&window)?, shown })
    }

    /// The price of all seams here when something is laid on it, by how much it lies elsewhere here.
    pub(crate) fn price(&self, lay: impl FnOnce(&mut Canvas, [i32; 2]) -> Result<(), Error>) -> Result<i64, Error> {
        let mut canvas = self.canvas.copied()?;
        lay(&mut canvas, self.window.start.map(|v| -v))?;
        Ok(self.shown.total(&canvas.map))
    }
}
