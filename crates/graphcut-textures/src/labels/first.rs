//! The first labelling: the nearest stroke, or the least price.

use selvedge_core::{SourceMap, reserve, try_vec};

use crate::error::Error;
use crate::labels::options::LabelOptions;
use crate::labels::prices::NONE;
use crate::labels::sets::Sets;

/// What holes were filled with.
pub(super) struct First {
    /// By place, the label that shows; [`NONE`] for what stood there, and for holes that stay.
    pub(super) standing: Vec<u8>,
    /// By place, the labels that may show in what was a hole, as bits.
    pub(super) may: Vec<u64>,
    /// Holes that stay.
    pub(super) holes: usize,
}

/// Fills the holes of a map.
///
/// # Errors
/// [`Error::NoLabel`] unless holes may stay, [`Error::Core`].
pub(super) fn first<const D: usize>(
    sets: &Sets<'_, D>,
    options: &LabelOptions<D>,
    map: &mut SourceMap<D>,
) -> Result<First, Error> {
    let domain = map.domain();
    let mut standing = try_vec(domain.len(), NONE)?;
    let mut may = try_vec(domain.len(), 0_u64)?;
    let mut near = Vec::new();
    reserve(&mut near, domain.len())?;
    let (mut stuck, mut first_stuck) = (0, None);
    for place in (0..domain.len()).filter(|&place| !map.ids.plane(0)[place].is_assigned()) {
        may[place] = sets.at(place);
        let label = match &options.own {
            // Of equal prices the first label.
            Some(own) => (0..sets.labels.len())
                .filter(|label| may[place] >> label & 1 == 1)
                .min_by_key(|&label| own.plane(label)[place]),
            None => may[place].is_power_of_two().then(|| may[place].trailing_zeros() as usize),
        };
        if may[place] == 0 {
            stuck += 1;
            first_stuck = first_stuck.or(Some(place));
        } else if let Some(label) = label {
            standing[place] = label as u8;
            near.push(place);
        }
    }
    if let Some(place) = first_stuck.filter(|_| !options.leave_holes) {
        return Err(Error::NoLabel { at: domain.position(place).to_vec(), places: stuck });
    }
    spread(sets, &may, &mut standing, near);
    let ids = map.ids.plane_mut(0);
    for place in (0..domain.len()).filter(|&place| may[place] != 0) {
        if standing[place] == NONE {
            // Nothing is near: the first label that may show.
            standing[place] = may[place].trailing_zeros() as u8;
        }
        let at = domain.position(place).map(|p| p as i32);
        ids[place] = sets.sample(usize::from(standing[place]), at);
    }
    Ok(First { standing, may, holes: stuck })
}

/// Labels spread from where they stand to neighbours at which they may show, breadth first.
fn spread<const D: usize>(sets: &Sets<'_, D>, bits: &[u64], standing: &mut [u8], mut near: Vec<usize>) {
    let (domain, mut done) = (sets.output(), 0);
    while let Some(&place) = near.get(done) {
        done += 1;
        let (at, label) = (domain.position(place), standing[place]);
        for (axis, by) in (0..D).flat_map(|axis| [(axis, 1), (axis, -1)]) {
            let mut step = [0; D];
            step[axis] = by;
            let Some(next) = domain.step(at, step).map(|next| domain.index(next)) else { continue };
            if standing[next] == NONE && bits[next] >> label & 1 == 1 {
                standing[next] = label;
                near.push(next);
            }
        }
    }
}
