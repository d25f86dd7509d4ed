//! In which order waiting samples are re-synthesised: layer by layer from what is known inwards, so that each has known
//! neighbours when its turn comes. `[Ding 3.3]`

use crate::canvas::Canvas;

/// The order of the waiting samples of `places`, and how many of the eight neighbours each has that are known or come in a
/// layer before its own. Layers are dilations of what is known; within one the order is that of the map's buffer.
/// Samples that nothing known reaches are left out.
///
/// Time `O(places * layers)`.
pub(crate) fn order(canvas: &Canvas, places: &[usize]) -> Vec<(usize, u32)> {
    let domain = canvas.domain();
    let mut left: Vec<usize> = places.iter().copied().filter(|&place| canvas.is_waiting(place)).collect();
    left.sort_unstable();
    left.dedup();
    let mut order: Vec<(usize, u32)> = Vec::with_capacity(left.len());
    // Sorted, so that it can be asked.
    let mut reached: Vec<usize> = Vec::new();
    while !left.is_empty() {
        let known = |place: usize| canvas.is_known(place) || reached.binary_search(&place).is_ok();
        let mut layer = Vec::new();
        left.retain(|&place| {
            let at = domain.position(place);
            let around = (0..9).filter(|&i| i != 4).filter_map(|i| domain.step(at, [i / 3 - 1, i % 3 - 1]));
            let neighbors = around.filter(|&to| known(domain.index(to))).count() as u32;
            if 0 < neighbors {
                layer.push((place, neighbors));
            }
            neighbors == 0
        });
        if layer.is_empty() {
            break;
        }
        reached.extend(layer.iter().map(|&(place, _)| place));
        reached.sort_unstable();
        order.append(&mut layer);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Exemplars, Grid, Origin, SampleId, Source, SourceMap, Start, Transform};

    #[test]
    fn holes_close_from_their_edges_inwards_around_borders_too() {
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let features = Grid::try_filled(Domain::open([1, 1]), 1, 0).unwrap();
        let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        let output = Domain { shape: [7, 12], periodic: [false, true] };
        let mut map = SourceMap::unassigned(&exemplars, output).unwrap();
        map.ids.plane_mut(0).fill(SampleId::new(0));
        let mut canvas = Canvas::new(Start { map, fixed: None, sources: None }).unwrap();
        // Five columns around the border, all rows but the first.
        let hole: Vec<usize> =
            output.positions().filter(|[y, x]| 0 < *y && (*x < 3 || 10 <= *x)).map(|p| output.index(p)).collect();
        hole.iter().for_each(|&place| canvas.wait(place));
        let found = order(&canvas, &hole);
        assert_eq!(found.len(), hole.len());
        let layer = |[y, x]: [u32; 2]| y.min(3 - (i64::from((x + 2) % 12) - 2).unsigned_abs() as u32);
        let layers: Vec<u32> = found.iter().map(|&(place, _)| layer(output.position(place))).collect();
        assert!(layers.is_sorted() && layers.contains(&3), "{layers:?}");
        assert!(found.iter().all(|&(_, neighbors)| (1..=8).contains(&neighbors)));
        let corner = output.index([1, 10]);
        assert!(found.contains(&(corner, 5)), "three above and two beside");
        // Where nothing is known, nothing has a turn.
        (0..output.len()).for_each(|place| canvas.wait(place));
        assert!(order(&canvas, &hole).is_empty());
    }
}
