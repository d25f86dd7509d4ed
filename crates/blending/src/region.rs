//! Windows in one another, and the patches that show in them.

use selvedge_core::{Patch, SourceMap, Window};

/// `by` more samples of another window on every side; `None` if both share nothing.
pub(crate) fn grown<const D: usize>(window: &Window<D>, by: u32, within: &Window<D>) -> Option<Window<D>> {
    let start = window.start.map(|s| s - by as i32);
    Window { start, shape: window.shape.map(|n| n + 2 * by) }.shared(within)
}

/// The rows of a window that lies in an outer one: places in the outer one's buffer.
pub(crate) fn rows<const D: usize>(
    outer: &Window<D>,
    inner: &Window<D>,
) -> impl Iterator<Item = std::ops::Range<usize>> + use<D> {
    let (outer, by) = (outer.local(), std::array::from_fn::<u32, D, _>(|a| (inner.start[a] - outer.start[a]) as u32));
    let (mut rows, width) = (inner.local(), inner.shape[D - 1] as usize);
    rows.shape[D - 1] = 1;
    rows.positions().map(move |at| {
        let first = outer.index(std::array::from_fn(|a| at[a] + by[a]));
        first..first + width
    })
}

/// A patch, and the box around the places of a window where it shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown<const D: usize> {
    pub(crate) patch: Patch<D>,
    pub(crate) around: Window<D>,
}

/// The patches that show in a window, in order, each once.
///
/// Time: the window's samples, and for each run of them the patches that were found.
pub(crate) fn shown<const D: usize>(map: &SourceMap<D>, window: &Window<D>) -> Vec<Shown<D>> {
    let mut found: Vec<Shown<D>> = Vec::new();
    let ids = map.ids.plane(0);
    let local = window.local();
    // The sample that goes on in the same patch, and how many more of its row do.
    let (mut next, mut left, mut one) = (u32::MAX, 0, 0);
    for (i, place) in window.places(map.domain()).enumerate() {
        let Some(id) = place.map(|place| ids[place]) else { continue };
        let at = local.position(i);
        let at: [i32; D] = std::array::from_fn(|a| window.start[a] + at[a] as i32);
        if id.get() != next || left == 0 || at[D - 1] == window.start[D - 1] {
            left = 0;
            let Some((source, from)) = map.table.locate(id) else { continue };
            let domain = map.table.sources()[source].1;
            // A source that repeats itself is one patch however often it does.
            let offset = domain.wrapped(std::array::from_fn(|a| at[a] - from[a] as i32));
            let patch = Patch { source, offset };
            left = domain.shape[D - 1] - from[D - 1];
            // Neighbours mostly belong to the patch found last.
            one = found.iter().rposition(|f| f.patch == patch).unwrap_or(found.len());
            if one == found.len() {
                found.push(Shown { patch, around: Window { start: at, shape: [1; D] } });
            }
        }
        (next, left) = (id.get().wrapping_add(1), left - 1);
        let around = &mut found[one].around;
        for (a, at) in at.into_iter().enumerate() {
            let (start, end) = (around.start[a].min(at), around.end(a).max(at + 1));
            (around.start[a], around.shape[a]) = (start, (end - start) as u32);
        }
    }
    found.sort_unstable_by_key(|f| f.patch);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Origin, SampleId, Seed, SourceTable, Transform};

    #[test]
    fn patches_are_found_with_the_box_around_them() {
        let mut rng = Seed(5).rng();
        for round in 0..100 {
            let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
            let periodic = [round % 2 == 0, round % 4 < 2];
            let sources = [Domain { shape: [3, 4], periodic }, Domain::open([2, 5])];
            let table = SourceTable::new(sources.map(|d| (origin, d)).to_vec()).unwrap();
            let output = Domain { shape: [4, 5], periodic: [round % 3 == 0, true] };
            let first = rng.below(22);
            // Runs and jumps, and holes.
            let id = |i: u32, rng: &mut selvedge_core::Rng| match rng.below(4) {
                0 => SampleId::new(rng.below(22)),
                1 if i.is_multiple_of(5) => SampleId::UNASSIGNED,
                _ => SampleId::new((first + i) % 22),
            };
            let ids = (0..20).map(|i| id(i, &mut rng)).collect();
            let map = SourceMap::new(Grid::from_vec(output, 1, ids).unwrap(), table).unwrap();
            let y = if output.periodic[0] { -2 } else { 1 };
            let window = Window { start: [y, -3], shape: [3, 7] };
            let found = shown(&map, &window);
            let mut expected: Vec<(Patch<2>, [i32; 2])> = Vec::new();
            for at in Domain::open(window.shape).positions() {
                let at = [0, 1].map(|a| window.start[a] + at[a] as i32);
                let wrapped = [0, 1].map(|a| at[a].rem_euclid(output.shape[a] as i32) as u32);
                let Some((source, from)) = map.locate(wrapped) else { continue };
                let offset = [0, 1].map(|a| {
                    let (offset, side) = (at[a] - from[a] as i32, sources[source].shape[a] as i32);
                    if sources[source].periodic[a] { offset.rem_euclid(side) } else { offset }
                });
                expected.push((Patch { source, offset }, at));
            }
            for f in &found {
                let at = expected.iter().filter(|e| e.0 == f.patch).map(|e| e.1);
                let range =
                    |a: usize| (at.clone().map(|p| p[a]).min().unwrap(), at.clone().map(|p| p[a]).max().unwrap() + 1);
                assert_eq!([0, 1].map(|a| (f.around.start[a], f.around.end(a))), [0, 1].map(range));
            }
            let mut patches: Vec<Patch<2>> = expected.into_iter().map(|e| e.0).collect();
            patches.sort_unstable();
            patches.dedup();
            assert_eq!(found.iter().map(|f| f.patch).collect::<Vec<_>>(), patches);
        }
    }
}
