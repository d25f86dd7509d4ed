//! Copies that meet their own reflection, or themselves.

use selvedge_core::{Domain, Exemplars, Patch, Window};

/// How many sides of the region may lie between the exemplar's places that two patches show in it, for them to meet:
/// what one shows around the region's middle lies within half a side of it, the same holds for the other, and the
/// symmetry is still found at once with as much again between them.
const NEAR: f64 = 1.5;

/// True if two patches show about the same place of an exemplar in a region, in different orientations. The exemplar
/// meets its own reflection there: seams cost next to nothing, but the eye finds the symmetry at once.
pub(crate) fn reflects<const D: usize>(
    one: &Patch<D>,
    other: &Patch<D>,
    exemplars: &Exemplars<D>,
    region: &Window<D>,
) -> bool {
    let [a, b] = [one, other].map(|p| exemplars.sources()[p.source].origin);
    if D < 2 || a.exemplar != b.exemplar || a.transform.orientation() == b.transform.orientation() {
        return false;
    }
    let [here, there] = [one, other].map(|p| place(p, exemplars, region));
    let side = f64::from(region.shape[D - 2].max(region.shape[D - 1]));
    (0..2).all(|axis| (here[axis] - there[axis]).abs() < NEAR * side)
}

/// True if two patches show the same, moved by less than `apart` along every axis: a stutter. Where the source goes
/// around, so does what it is moved by.
pub(crate) fn stutters<const D: usize>(one: &Patch<D>, other: &Patch<D>, source: Domain<D>, apart: u32) -> bool {
    let moved = |axis: usize| {
        let by = one.offset[axis].abs_diff(other.offset[axis]);
        let around = if source.periodic[axis] { by % source.shape[axis] } else { by };
        if source.periodic[axis] { around.min(source.shape[axis] - around) } else { around }
    };
    one.source == other.source && (0..D).any(|a| moved(a) != 0) && (0..D).all(|a| moved(a) < apart)
}

/// The exemplar's place under the middle of a region, on the last two axes, from the exemplar's centre.
fn place<const D: usize>(patch: &Patch<D>, exemplars: &Exemplars<D>, region: &Window<D>) -> [f64; 2] {
    let source = &exemplars.sources()[patch.source];
    let from_centre = |axis: usize| {
        let middle = f64::from(region.start[axis] - patch.offset[axis]) + f64::from(region.shape[axis]) / 2.0;
        middle - f64::from(source.domain().shape[axis]) / 2.0
    };
    source.origin.transform.from_centre([from_centre(D - 2), from_centre(D - 1)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Grid, Origin, Source, Transform};

    #[test]
    fn copies_of_one_source_stutter_that_lie_nearer_than_asked() {
        let patch = |source, y, x| Patch { source, offset: [y, x] };
        let one = patch(0, -5, 40);
        let open = Domain::open([50, 60]);
        let at = |other| stutters(&one, &other, open, 10);
        assert!(at(patch(0, -5, 49)) && at(patch(0, 4, 31)) && !at(patch(0, -5, 50)) && !at(patch(0, 5, 40)));
        assert!(!at(one) && !at(patch(1, -5, 41)) && !stutters(&one, &patch(0, -5, 41), open, 0));
        let around = |other| stutters(&one, &other, Domain { periodic: [false, true], ..open }, 10);
        assert!(
            around(patch(0, -5, -11))
                && !around(patch(0, -5, -20))
                && !around(patch(0, -5, 50))
                && !at(patch(0, -5, -11))
        );
    }

    #[test]
    fn reflections_are_found_where_they_meet() {
        let source = |mirror| {
            let features = Grid::from_vec(Domain::open([40, 60]), 1, vec![0; 2400]).unwrap();
            let transform = Transform::Exact { quarter_turns: 0, mirror };
            Source { features, valid: None, origin: Origin { exemplar: 0, transform } }
        };
        let exemplars = Exemplars::from_sources(vec![source(false), source(true)], vec![1]).unwrap();
        let plain = Patch { source: 0, offset: [0, 0] };
        // A copy mirrored about x = 59.5 meets the plain one at its right end.
        let mirrored = Patch { source: 1, offset: [0, 60] };
        let region = |x: i32| Window { start: [10, x], shape: [8, 8] };
        assert!(reflects(&mirrored, &plain, &exemplars, &region(56)));
        assert!(!reflects(&mirrored, &plain, &exemplars, &region(30)));
        let lower = Patch { source: 1, offset: [14, 60] };
        assert!(!reflects(&lower, &plain, &exemplars, &region(56)), "other rows of the exemplar");
        assert!(!reflects(&plain, &Patch { source: 0, offset: [0, 3] }, &exemplars, &region(30)), "one orientation");
    }
}
