//! What lies under a patch and what the patch would put there, side by side.

use selvedge_core::{Exemplars, Grid, Patch, SampleId, SourceMap, Window, try_vec};

use crate::error::Error;

/// A window of the output with one more sample on every side, row-major: what is there and what is offered.
#[derive(Debug)]
pub(crate) struct Frame<const D: usize> {
    /// The window with its ring.
    pub(crate) window: Window<D>,
    /// Place in the output's buffer.
    pub(crate) places: Vec<u32>,
    /// What is there.
    pub(crate) old: Vec<SampleId>,
    /// What is offered; unassigned on the ring, and where the source ends or is masked.
    pub(crate) new: Vec<SampleId>,
}

impl<const D: usize> Frame<D> {
    /// Looks at a patch through a window that lies in the output; `allowed` says by position which sources may show.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub(crate) fn new(
        exemplars: &Exemplars<D>,
        map: &SourceMap<D>,
        allowed: Option<&Grid<u64, D>>,
        patch: &Patch<D>,
        window: &Window<D>,
    ) -> Result<Self, Error> {
        let framed = window.grown(map.domain(), [1; D], [1; D]);
        let mut places = Vec::new();
        framed.indices(map.domain(), &mut places)?;
        let ids = map.ids.plane(0);
        let old = places.iter().map(|&i| ids[i as usize]).collect();
        let mut new = offered(exemplars, patch, window, &framed)?;
        if let Some(allowed) = allowed {
            for (new, &place) in new.iter_mut().zip(&places) {
                if allowed.plane(0)[place as usize] >> patch.source & 1 == 0 {
                    *new = SampleId::UNASSIGNED;
                }
            }
        }
        Ok(Self { window: framed, places, old, new })
    }
}

/// The patch's samples through a window, over the larger frame.
fn offered<const D: usize>(
    exemplars: &Exemplars<D>,
    patch: &Patch<D>,
    window: &Window<D>,
    frame: &Window<D>,
) -> Result<Vec<SampleId>, Error> {
    let mut offered = try_vec(frame.len(), SampleId::UNASSIGNED)?;
    let places = window.moved(frame.start.map(|s| -s)).places(frame.local());
    for (place, id) in places.zip(patch.samples(exemplars, window)) {
        if let Some(place) = place {
            offered[place] = id;
        }
    }
    Ok(offered)
}
