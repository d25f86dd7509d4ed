//! What lies under a patch and what the patch would put there, side by side.

use selvedge_core::{Exemplars, Grid, SampleId, SourceMap};

use crate::patch::Patch;
use crate::window::{Window, over_axes};

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
    pub(crate) fn new(
        exemplars: &Exemplars<D>,
        map: &SourceMap<D>,
        allowed: Option<&Grid<u64, D>>,
        patch: &Patch<D>,
        window: &Window<D>,
    ) -> Self {
        let framed = window.grown(map.domain(), [1; D], [1; D]);
        let places = framed.indices(map.domain());
        let ids = map.ids.plane(0);
        let old = places.iter().map(|&i| ids[i as usize]).collect();
        let mut new = offered(exemplars, patch, window, &framed);
        if let Some(allowed) = allowed {
            for (new, &place) in new.iter_mut().zip(&places) {
                if allowed.plane(0)[place as usize] >> patch.source & 1 == 0 {
                    *new = SampleId::UNASSIGNED;
                }
            }
        }
        Self { window: framed, places, old, new }
    }
}

/// The patch's samples through a window, over the larger frame.
fn offered<const D: usize>(
    exemplars: &Exemplars<D>,
    patch: &Patch<D>,
    window: &Window<D>,
    frame: &Window<D>,
) -> Vec<SampleId> {
    let source = &exemplars.sources()[patch.source];
    let first = exemplars.table().first(patch.source);
    let places = over_axes::<D>(|axis| {
        let inside = |l: usize| {
            let p = frame.start[axis] + l as i32;
            window.start[axis] <= p && p < window.end(axis)
        };
        let along = patch.places(source.domain(), frame, axis).enumerate();
        along.map(|(l, place)| place.filter(|_| inside(l))).collect()
    });
    let valid = |i: u32| source.valid.as_ref().is_none_or(|v| v.samples()[i as usize]);
    let id =
        |place: Option<u32>| place.filter(|&i| valid(i)).map_or(SampleId::UNASSIGNED, |i| SampleId::new(first + i));
    places.into_iter().map(id).collect()
}
