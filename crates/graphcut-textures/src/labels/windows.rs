//! Boxes of positions that may change: parts that do not touch are decided apart.

use selvedge_core::{Domain, Window, try_vec};

use crate::error::Error;

/// The boxes that hold the parts of a set, disjoint, each with one more sample on every side, in the order of their
/// first samples. Around a periodic axis a part that goes over the border has all of the axis.
///
/// # Errors
/// [`Error::Core`] if memory is short.
pub(super) fn windows<const D: usize>(domain: Domain<D>, set: &[bool]) -> Result<Vec<Window<D>>, Error> {
    let mut seen = try_vec(set.len(), false)?;
    let mut found: Vec<Window<D>> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    for first in 0..set.len() {
        if !set[first] || seen[first] {
            continue;
        }
        seen[first] = true;
        selvedge_core::reserve(&mut open, 1)?;
        open.push(first);
        let (mut low, mut high) = (domain.position(first), domain.position(first));
        while let Some(place) = open.pop() {
            let at = domain.position(place);
            low = std::array::from_fn(|a| low[a].min(at[a]));
            high = std::array::from_fn(|a| high[a].max(at[a]));
            for (axis, by) in (0..D).flat_map(|axis| [(axis, 1), (axis, -1)]) {
                let mut step = [0; D];
                step[axis] = by;
                let Some(next) = domain.step(at, step).map(|next| domain.index(next)) else { continue };
                if set[next] && !seen[next] {
                    seen[next] = true;
                    selvedge_core::reserve(&mut open, 1)?;
                    open.push(next);
                }
            }
        }
        let part = Window { start: low.map(|l| l as i32), shape: std::array::from_fn(|a| high[a] - low[a] + 1) };
        found.push(whole_around(part.grown(domain, [1; D], [1; D]), domain));
    }
    Ok(merged(found, domain))
}

/// A window that goes over the border of a periodic axis has all of it.
fn whole_around<const D: usize>(mut window: Window<D>, domain: Domain<D>) -> Window<D> {
    for axis in (0..D).filter(|&a| domain.periodic[a]) {
        if window.start[axis] < 0 || (domain.shape[axis] as i32) < window.end(axis) {
            (window.start[axis], window.shape[axis]) = (0, domain.shape[axis]);
        }
    }
    window
}

/// Windows that meet become one.
fn merged<const D: usize>(mut windows: Vec<Window<D>>, domain: Domain<D>) -> Vec<Window<D>> {
    let mut i = 0;
    while i < windows.len() {
        let one = windows[i];
        let Some(j) = (i + 1..windows.len()).find(|&j| windows[j].meets(&one, domain)) else {
            i += 1;
            continue;
        };
        let other = windows.remove(j);
        let start = std::array::from_fn(|a| one.start[a].min(other.start[a]));
        let shape = std::array::from_fn(|a| (one.end(a).max(other.end(a)) - start[a]) as u32);
        windows[i] = Window { start, shape };
        // It may meet others now, also earlier ones.
        i = 0;
    }
    windows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(domain: Domain<2>, drawn: &str) -> Vec<Window<2>> {
        windows(domain, &drawn.bytes().filter(|b| *b != b' ').map(|b| b == b'#').collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn parts_apart_have_boxes_of_their_own() {
        let drawn = "....... .#..... .##...# ....... .......";
        let found = of(Domain::open([5, 7]), drawn);
        assert_eq!(found, [Window { start: [0, 0], shape: [4, 4] }, Window { start: [1, 5], shape: [3, 2] }]);
        // A ring has what is in it.
        let found = of(Domain::open([6, 6]), "###### #....# #....# #..#.# #....# ######");
        assert_eq!(found, [Window { start: [0, 0], shape: [6, 6] }]);
    }

    #[test]
    fn a_part_over_a_border_goes_around() {
        let domain = Domain { shape: [4, 6], periodic: [false, true] };
        assert_eq!(of(domain, "...... #....# ...... ......"), [Window { start: [0, 0], shape: [3, 6] }]);
        assert_eq!(of(domain, "...... ...#.. ...... ......"), [Window { start: [0, 2], shape: [3, 3] }]);
    }
}
