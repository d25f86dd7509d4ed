//! What stands in a window of a map and what is offered there, side by side.

use selvedge_core::{Domain, Exemplars, Patch, SampleId, SourceMap, Window, try_vec};

use crate::error::Error;

/// A window of an output with one more sample on every side, row-major: what is there, and what is offered.
///
/// The ring shows what the window's border meets. It ends where the output does. Where the window goes all the way
/// around a periodic axis, the frame is periodic there: its last samples are neighbours of its first.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame<const D: usize> {
    /// The window with its ring.
    pub window: Window<D>,
    /// The frame's own coordinates.
    pub domain: Domain<D>,
    /// Place of each sample in the output's buffer.
    pub places: Vec<u32>,
    /// What is there; unassigned in holes.
    pub old: Vec<SampleId>,
    /// What is offered; unassigned on the ring, and where nothing is.
    pub new: Vec<SampleId>,
}

impl<const D: usize> Frame<D> {
    /// A patch, seen through a window: nothing is offered where its source ends or is masked.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    ///
    /// # Panics
    /// If the window sticks out of the output, or goes more than once around it.
    pub fn of_patch(
        exemplars: &Exemplars<D>,
        map: &SourceMap<D>,
        patch: &Patch<D>,
        window: &Window<D>,
    ) -> Result<Self, Error> {
        Self::new(map, window, patch.samples(exemplars, window))
    }

    /// Anything that is offered over a window, row-major, unassigned for nothing. Samples need not be of one patch.
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    ///
    /// # Panics
    /// As [`of_patch`](Self::of_patch), and if there are not as many offers as the window has samples.
    pub fn new(
        map: &SourceMap<D>,
        window: &Window<D>,
        offered: impl ExactSizeIterator<Item = SampleId>,
    ) -> Result<Self, Error> {
        let output = map.domain();
        assert!(window.inside(output) == *window, "{window:?} sticks out of {output:?}");
        assert!((0..D).all(|a| window.shape[a] <= output.shape[a]), "{window:?} meets itself around {output:?}");
        assert!(offered.len() == window.len(), "{} offers for {window:?}", offered.len());
        let framed = window.grown(output, [1; D], [1; D]);
        let around = |a: usize| output.periodic[a] && framed.shape[a] == output.shape[a];
        let domain = Domain { shape: framed.shape, periodic: std::array::from_fn(around) };
        let mut places = Vec::new();
        framed.indices(output, &mut places)?;
        let mut old = try_vec(places.len(), SampleId::UNASSIGNED)?;
        let new = try_vec(places.len(), SampleId::UNASSIGNED)?;
        let ids = map.ids.plane(0);
        old.iter_mut().zip(&places).for_each(|(old, &place)| *old = ids[place as usize]);
        let mut frame = Self { window: framed, domain, places, old, new };
        frame.offer(window, offered);
        Ok(frame)
    }

    /// Offers something else over the window that the frame was made for, row-major, unassigned for nothing.
    pub fn offer(&mut self, window: &Window<D>, offered: impl Iterator<Item = SampleId>) {
        self.new.fill(SampleId::UNASSIGNED);
        let inner = window.moved(self.window.start.map(|s| -s)).places(Domain::open(self.window.shape));
        for (place, id) in inner.zip(offered) {
            if let Some(place) = place {
                self.new[place] = id;
            }
        }
    }

    /// Shows what was offered where it is taken.
    pub fn take(&mut self, taken: &[bool]) {
        for (i, _) in taken.iter().enumerate().filter(|(_, taken)| **taken) {
            self.old[i] = self.new[i];
        }
    }

    /// Takes offers back where they are not `allowed`, a question to each place of the output.
    pub fn allow(&mut self, allowed: impl Fn(usize) -> bool) {
        for (new, _) in self.new.iter_mut().zip(&self.places).filter(|(_, place)| !allowed(**place as usize)) {
            *new = SampleId::UNASSIGNED;
        }
    }

    /// Each sample `s` of the frame and the next one `t` along an axis, as places in its buffers.
    pub(crate) fn pairs(&self, axis: usize) -> impl Iterator<Item = (usize, usize)> + use<D> {
        let (stride, side) = (self.domain.strides()[axis], self.domain.shape[axis] as usize);
        let blocks: usize = self.domain.shape[..axis].iter().map(|&n| n as usize).product();
        let (inner, all) = (side.saturating_sub(1) * stride, side * stride);
        let around = if self.domain.periodic[axis] { stride } else { 0 };
        (0..blocks).flat_map(move |block| {
            let first = block * all;
            let within = (first..first + inner).map(move |s| (s, s + stride));
            within.chain((first..first + around).map(move |t| (t + inner, t)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Grid, Origin, Seed, Source, Transform};

    fn exemplars() -> Exemplars<3> {
        let features = Grid::try_filled(Domain::open([9, 9, 9]), 1, 0).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap()
    }

    #[test]
    fn pairs_are_all_neighbours_in_the_output_that_the_frame_holds() {
        let e = exemplars();
        let mut around = 0;
        for case in 0..200 {
            let mut rng = Seed(case).rng();
            let shape = std::array::from_fn(|_| 1 + rng.below(5));
            let output = Domain { shape, periodic: std::array::from_fn(|_| rng.below(2) == 1) };
            let sides: [u32; 3] = shape.map(|n| 1 + rng.below(n));
            let start = |a: usize| {
                if output.periodic[a] { rng.below(9) as i32 - 4 } else { rng.below(shape[a] - sides[a] + 1) as i32 }
            };
            let window = Window { start: std::array::from_fn(start), shape: sides };
            let map = SourceMap::unassigned(&e, output).unwrap();
            let frame = Frame::of_patch(&e, &map, &Patch { source: 0, offset: [-9, -9, -9] }, &window).unwrap();
            for axis in 0..3 {
                let mut found: Vec<(u32, u32)> =
                    frame.pairs(axis).map(|(s, t)| (frame.places[s], frame.places[t])).collect();
                let next = |&s: &u32| Some((s, output.index(output.next(output.position(s as usize), axis)?) as u32));
                let held = |pair: &(u32, u32)| frame.places.contains(&pair.1);
                let mut all: Vec<(u32, u32)> = frame.places.iter().filter_map(next).filter(held).collect();
                found.sort_unstable();
                all.sort_unstable();
                assert_eq!(found, all, "{window:?} in {output:?}");
                around += u32::from(frame.domain.periodic[axis]);
            }
        }
        assert!(50 < around);
    }

    #[test]
    fn offers_are_those_of_the_patch_and_none_lies_on_the_ring() {
        let e = exemplars();
        let map = SourceMap::unassigned(&e, Domain::open([4, 6, 6])).unwrap();
        let patch = Patch { source: 0, offset: [-3, -2, 3] };
        let window = Window { start: [1, 2, 2], shape: [2, 3, 3] };
        let mut frame = Frame::of_patch(&e, &map, &patch, &window).unwrap();
        for (i, local) in frame.window.local().positions().enumerate() {
            let at: [i32; 3] = std::array::from_fn(|a| frame.window.start[a] + local[a] as i32);
            let inside = (0..3).all(|a| window.start[a] <= at[a] && at[a] < window.end(a)) && 3 <= at[2];
            let from = || std::array::from_fn(|a| (at[a] - patch.offset[a]) as u32);
            assert_eq!(frame.new[i], if inside { e.table().id(0, from()) } else { SampleId::UNASSIGNED }, "{at:?}");
        }
        frame.allow(|place| place != frame_place(&map, [2, 4, 4]));
        assert_eq!(frame.new.iter().filter(|id| id.is_assigned()).count(), 2 * 3 * 2 - 1);
    }

    fn frame_place(map: &SourceMap<3>, at: [u32; 3]) -> usize {
        map.domain().index(at)
    }
}
