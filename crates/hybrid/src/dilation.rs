//! In which order waiting samples are re-synthesised: layer by layer from what is known inwards, so that each has known
//! neighbours when its turn comes. `[Ding 3.3]`

use selvedge_core::{Error, collected, reserve};

use crate::canvas::Canvas;

/// The order of the waiting samples of `places`, all that wait, and how many of the eight neighbours each has that are
/// known or come in a layer before its own. Layers are dilations of what is known; within one the order is that of the
/// map's buffer. Samples that nothing known reaches are left out.
///
/// Time `O(places * log(places))`, space `O(places)`.
///
/// # Errors
/// No memory.
pub(crate) fn order(canvas: &mut Canvas, places: &[usize]) -> Result<Vec<(usize, u32)>, Error> {
    let domain = canvas.domain();
    let around = |place: usize| {
        let at = domain.position(place);
        (0..9)
            .filter(|&i| i != 4)
            .filter_map(move |i| domain.step(at, [i / 3 - 1, i % 3 - 1]))
            .map(|to| domain.index(to))
    };
    let mut order: Vec<(usize, u32)> = Vec::new();
    reserve(&mut order, places.len())?;
    let is_first = |&place: &usize| canvas.is_waiting(place) && around(place).any(|to| canvas.is_known(to));
    let mut layer: Vec<usize> = collected(places.iter().copied().filter(is_first))?;
    while !layer.is_empty() {
        layer.sort_unstable();
        layer.dedup();
        for &place in &layer {
            let known = |&to: &usize| canvas.is_known(to) || canvas.is_ordered(to);
            order.push((place, around(place).filter(known).count() as u32));
        }
        layer.iter().for_each(|&place| canvas.order(place));
        let next = layer.iter().flat_map(|&place| around(place)).filter(|&to| canvas.is_waiting(to));
        layer = collected(next)?;
    }
    Ok(order)
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
        let found = order(&mut canvas, &hole).unwrap();
        assert_eq!(found.len(), hole.len());
        let layer = |[y, x]: [u32; 2]| y.min(3 - (i64::from((x + 2) % 12) - 2).unsigned_abs() as u32);
        let layers: Vec<u32> = found.iter().map(|&(place, _)| layer(output.position(place))).collect();
        assert!(layers.is_sorted() && layers.contains(&3), "{layers:?}");
        assert!(found.iter().all(|&(_, neighbors)| (1..=8).contains(&neighbors)));
        let corner = output.index([1, 10]);
        assert!(found.contains(&(corner, 5)), "three above and two beside");
        // Where nothing is known, nothing has a turn.
        (0..output.len()).for_each(|place| canvas.wait(place));
        assert!(order(&mut canvas, &hole).unwrap().is_empty());
    }
}
