//! What lies in a region: features for the search, and the patches that meet there.

use selvedge_core::{Domain, Exemplars, SourceMap};

use crate::patch::Patch;
use crate::window::{Window, over_axes};

/// The output's features over a box that may reach beyond the output, planar, and where they are known.
pub(crate) struct Patchwork {
    pub(crate) features: Vec<u8>,
    pub(crate) known: Vec<bool>,
}

/// Looks at the output through a window. Positions outside of open axes and holes are unknown.
pub(crate) fn look<const D: usize>(exemplars: &Exemplars<D>, map: &SourceMap<D>, window: &Window<D>) -> Patchwork {
    let len = window.len();
    let mut patchwork = Patchwork { features: vec![0; len * exemplars.channels()], known: vec![false; len] };
    let ids = map.ids.plane(0);
    for (i, place) in places(map.domain(), window).into_iter().enumerate() {
        let Some(id) = place.map(|p| ids[p as usize]).filter(|id| id.is_assigned()) else { continue };
        let Some(source) = exemplars.table().source(id) else { continue };
        let index = (id.get() - exemplars.table().first(source)) as usize;
        patchwork.known[i] = true;
        for c in 0..exemplars.channels() {
            patchwork.features[c * len + i] = exemplars.sources()[source].features.plane(c)[index];
        }
    }
    patchwork
}

/// Place in the output of each position of a window; `None` outside of the output.
fn places<const D: usize>(output: Domain<D>, window: &Window<D>) -> Vec<Option<u32>> {
    over_axes::<D>(|axis| window.places(output, axis).collect())
}

/// The patches that meet in a window, in the window's own unwrapped coordinates, each once.
pub(crate) fn patches<const D: usize>(map: &SourceMap<D>, window: &Window<D>) -> Vec<Patch<D>> {
    let mut found: Vec<Patch<D>> = Vec::new();
    let local = Domain::open(window.shape);
    let ids = map.ids.plane(0);
    for (i, place) in places(map.domain(), window).into_iter().enumerate() {
        let Some(id) = place.map(|p| ids[p as usize]) else { continue };
        let Some((source, from)) = map.table.locate(id) else { continue };
        let at = local.position(i);
        let domain = map.table.sources()[source].1;
        let offset = std::array::from_fn(|a| {
            let offset = window.start[a] + at[a] as i32 - from[a] as i32;
            // A source that repeats itself is one patch however often it does.
            if domain.periodic[a] { offset.rem_euclid(domain.shape[a] as i32) } else { offset }
        });
        let patch = Patch { source, offset };
        // Neighbours mostly belong to the patch found last.
        if !found.iter().rev().any(|f| *f == patch) {
            found.push(patch);
        }
    }
    found
}
