//! Boxes of which a mask leaves few places.

use crate::{Error, Source, try_vec};

/// Places that are looked at, spread evenly, before all of them are: of most masks they tell at once that many fit.
const GLANCE: usize = 256;

impl<const D: usize> Source<D> {
    /// Where a box of this shape stands on valid samples alone, in the order of places, if there are no more than
    /// `most` such places. `None` for more of them, and for what has no mask or is periodic: there all are looked at.
    ///
    /// A search pays for every place, whether the box fits or not: so it is told of those few before.
    ///
    /// Time and space `O(samples)` where few fit, `O(samples of 256 boxes)` where most do.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn few_places(&self, shape: [u32; D], most: usize) -> Result<Option<Vec<[u32; D]>>, Error> {
        let domain = self.domain();
        let Some(valid) = self.valid.as_ref().filter(|_| domain.periodic == [false; D]) else { return Ok(None) };
        if (0..D).any(|a| shape[a] == 0 || domain.shape[a] < shape[a]) {
            return Ok((!shape.contains(&0)).then(Vec::new));
        }
        let (valid, strides) = (valid.samples(), domain.strides());
        let fits = |at: [u32; D]| {
            let first = domain.index(at);
            crate::Domain::open(shape)
                .positions()
                .all(|p| valid[first + (0..D).map(|a| p[a] as usize * strides[a]).sum::<usize>()])
        };
        let inside = |at: &[u32; D]| (0..D).all(|a| at[a] + shape[a] <= domain.shape[a]);
        // Odd, so that it is no multiple of usual widths and looks at all columns.
        let step = domain.len().div_ceil(GLANCE) | 1;
        let glance = (0..domain.len()).step_by(step).map(|i| domain.position(i)).filter(inside);
        // So many that all of them can be no fewer than asked for, but by chance: then a search looks at all, and finds
        // the same.
        if most.saturating_mul(2) < glance.filter(|&at| fits(at)).count().saturating_mul(step) {
            return Ok(None);
        }
        // Along each axis in turn, of how many samples on the box of the axes before fits.
        let mut runs = try_vec(domain.len(), 0_u32)?;
        runs.iter_mut().zip(valid).for_each(|(run, &valid)| *run = u32::from(valid));
        let mut needed = 1;
        for axis in (0..D).rev() {
            let (stride, side) = (strides[axis], domain.shape[axis] as usize);
            for i in (0..runs.len()).rev() {
                let next = if i / stride % side + 1 < side { runs[i + stride] } else { 0 };
                runs[i] = if needed <= runs[i] { 1 + next } else { 0 };
            }
            needed = shape[axis];
        }
        let mut places = Vec::new();
        for i in (0..runs.len()).filter(|&i| needed <= runs[i]) {
            if places.len() == most {
                return Ok(None);
            }
            crate::reserve(&mut places, 1)?;
            places.push(domain.position(i));
        }
        Ok(Some(places))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Domain, Grid, Origin, Seed, Transform};

    #[test]
    fn few_places_are_all_at_which_every_sample_is_valid() {
        let (mut few, mut many) = (0, 0);
        for case in 0..300 {
            let mut rng = Seed(case).rng();
            let domain = Domain::open(std::array::from_fn::<u32, 3, _>(|_| 1 + rng.below(7)));
            let (of, most) = (1 + rng.below(20), rng.below(30) as usize);
            let valid = (0..domain.len()).map(|_| 0 < rng.below(of)).collect();
            let valid = Some(Grid::from_vec(domain, 1, valid).unwrap());
            let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
            let source =
                Source { features: Grid::try_filled(domain, 1, 0).unwrap(), valid: valid.map(Into::into), origin };
            let shape = std::array::from_fn(|_| 1 + rng.below(4));
            let valid = |at: [u32; 3]| source.valid.as_deref().unwrap().get(0, at);
            let fits = |at: &[u32; 3]| {
                Domain::open(shape).positions().all(|p| domain.step(*at, p.map(|p| p as i32)).is_some_and(valid))
            };
            let all: Vec<[u32; 3]> = domain.positions().filter(fits).collect();
            match source.few_places(shape, most).unwrap() {
                Some(found) => {
                    assert_eq!(found, all, "{shape:?} in {domain:?}");
                    few += usize::from(!all.is_empty());
                }
                None => {
                    assert!(most < all.len(), "{} of {most}", all.len());
                    many += 1;
                }
            }
        }
        assert!(50 < few && 50 < many, "{few} {many}");
    }

    #[test]
    fn without_a_mask_and_around_periodic_axes_all_places_are_looked_at() {
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let of = |domain: Domain<2>, masked: bool| {
            let valid = masked.then(|| Grid::try_filled(domain, 1, true).unwrap());
            Source { features: Grid::try_filled(domain, 1, 0).unwrap(), valid: valid.map(Into::into), origin }
                .few_places([2, 2], 99)
                .unwrap()
        };
        let (open, around) = (Domain::open([3, 4]), Domain { shape: [3, 4], periodic: [false, true] });
        assert_eq!((of(open, false), of(around, true)), (None, None));
        assert_eq!(of(open, true).map(|places| places.len()), Some(6));
    }
}
