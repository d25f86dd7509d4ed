//! The output in the making: what stands, what stays, and what waits to be re-synthesised.

use selvedge_core::{Domain, Error, Grid, SampleId, SourceMap, Start, Window, collected, try_vec};

use crate::stats::Stats;

/// A map of which some samples wait: they stand, but nobody looks at them.
pub(crate) struct Canvas {
    pub(crate) map: SourceMap<2>,
    /// Samples that no step changes.
    fixed: Option<Grid<bool, 2>>,
    turns: Vec<Turn>,
    /// What each sample is, as [`Stats::laid`] tells it.
    pub(crate) marks: Vec<u8>,
}

/// Whether a sample waits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Turn {
    #[default]
    Stands,
    Waits,
    /// It waits, and it is known when its turn will come.
    Ordered,
}

impl Canvas {
    pub(crate) fn new(start: Start<2>) -> Result<Self, Error> {
        let turns = try_vec(start.map.domain().len(), Turn::Stands)?;
        let marks = try_vec(turns.len(), Stats::STOOD)?;
        let mut fixed = start.fixed;
        if let Some(fixed) = &mut fixed {
            // A hole is filled, whatever is said about it.
            let ids = start.map.ids.plane(0);
            fixed.plane_mut(0).iter_mut().zip(ids).for_each(|(fixed, id)| *fixed &= id.is_assigned());
        }
        Ok(Self { map: start.map, fixed, turns, marks })
    }

    pub(crate) fn domain(&self) -> Domain<2> {
        self.map.domain()
    }

    #[inline]
    pub(crate) fn id(&self, place: usize) -> SampleId {
        self.map.ids.plane(0)[place]
    }

    /// Something stands there that may be looked at.
    #[inline]
    pub(crate) fn is_known(&self, place: usize) -> bool {
        self.turns[place] == Turn::Stands && self.id(place).is_assigned()
    }

    /// It waits, and nothing is known of its turn.
    pub(crate) fn is_waiting(&self, place: usize) -> bool {
        self.turns[place] == Turn::Waits
    }

    pub(crate) fn is_ordered(&self, place: usize) -> bool {
        self.turns[place] == Turn::Ordered
    }

    pub(crate) fn is_fixed(&self, place: usize) -> bool {
        self.fixed.as_ref().is_some_and(|fixed| fixed.plane(0)[place])
    }

    /// Writes a sample and what it is.
    pub(crate) fn set(&mut self, place: usize, id: SampleId, mark: u8) {
        self.marks[place] = mark;
        self.map.ids.plane_mut(0)[place] = id;
        self.turns[place] = Turn::Stands;
    }

    pub(crate) fn wait(&mut self, place: usize) {
        self.turns[place] = Turn::Waits;
    }

    pub(crate) fn order(&mut self, place: usize) {
        self.turns[place] = Turn::Ordered;
    }

    /// Whatever stands there counts again.
    pub(crate) fn accept(&mut self, place: usize) {
        self.turns[place] = Turn::Stands;
    }

    /// What stands in a window, and what it is.
    pub(crate) fn held(&self, window: &Window<2>) -> Result<Vec<(SampleId, u8)>, Error> {
        collected(window.places(self.domain()).flatten().map(|place| (self.id(place), self.marks[place])))
    }

    pub(crate) fn put_back(&mut self, window: &Window<2>, held: Vec<(SampleId, u8)>) {
        let places = window.places(self.domain()).flatten();
        places.zip(held).for_each(|(place, (id, mark))| self.set(place, id, mark));
    }

    /// The same once more.
    pub(crate) fn copied(&self) -> Result<Self, Error> {
        self.cut(&Window::all(self.domain()))
    }

    /// What stands in a window, all of which lies in the output, as a map by itself.
    pub(crate) fn cut(&self, window: &Window<2>) -> Result<Self, Error> {
        let (domain, all) = (self.domain(), window.local());
        // Around an axis that it has whole it goes on.
        let periodic = [0, 1].map(|a| domain.periodic[a] && all.shape[a] == domain.shape[a]);
        let local = Domain { periodic, ..all };
        let places = || window.places(domain).flatten();
        let ids = Grid::from_vec(local, 1, collected(places().map(|place| self.id(place)))?)?;
        let fixed = match &self.fixed {
            Some(fixed) => Some(Grid::from_vec(local, 1, collected(places().map(|place| fixed.plane(0)[place]))?)?),
            None => None,
        };
        Self::new(Start { map: SourceMap { ids, table: self.map.table.clone() }, fixed, sources: None })
    }

    /// A block's window, grown by its overlap on the sides where something stands, and by how much on each.
    pub(crate) fn grown(&self, core: &Window<2>, overlap: [u32; 2]) -> (Window<2>, [u32; 2], [u32; 2]) {
        let domain = self.domain();
        let (mut before, mut after) = ([0; 2], [0; 2]);
        for axis in 0..2 {
            let mut strip = *core;
            strip.shape[axis] = overlap[axis].min(domain.shape[axis]);
            let low = core.start[axis] - strip.shape[axis] as i32;
            for (start, side) in [(low, &mut before[axis]), (core.end(axis), &mut after[axis])] {
                strip.start[axis] = start;
                let stands = strip.places(domain).flatten().any(|place| self.is_known(place));
                *side = if stands { overlap[axis] } else { 0 };
            }
        }
        let grown = core.grown(domain, before, after);
        // What there was room for.
        let before = [0, 1].map(|a| (core.start[a] - grown.start[a]) as u32);
        let after = [0, 1].map(|a| (grown.end(a) - core.end(a)) as u32);
        (grown, before, after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Exemplars, Origin, Source, Transform};

    fn canvas(output: Domain<2>, stands: impl Fn([u32; 2]) -> bool) -> Canvas {
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let features = Grid::try_filled(Domain::open([1, 1]), 1, 0).unwrap();
        let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, output).unwrap();
        output.positions().filter(|&at| stands(at)).for_each(|at| map.ids.set(0, at, SampleId::new(0)));
        Canvas::new(Start { map, fixed: None, sources: None }).unwrap()
    }

    #[test]
    fn blocks_grow_where_something_stands_and_no_further_than_the_output() {
        let output = Domain { shape: [20, 20], periodic: [false, true] };
        let core = Window { start: [8, 16], shape: [4, 4] };
        let (grown, before, after) = canvas(output, |[y, x]| y < 8 || x < 1).grown(&core, [3, 2]);
        assert_eq!((before, after), ([3, 0], [0, 2]), "above, and around the border on the right");
        assert_eq!(grown, Window { start: [5, 16], shape: [7, 6] });
        let (grown, ..) = canvas(output, |_| true).grown(&Window { start: [0, 2], shape: [19, 16] }, [3, 9]);
        assert_eq!(grown, Window { start: [0, -2], shape: [20, 20] }, "no sample comes twice");
        let (grown, ..) = canvas(output, |_| false).grown(&core, [3, 2]);
        assert_eq!(grown, core);
    }
}
