//! What stands in the output, what it costs, and where it is worst. `[CMS IV-B2]`

use selvedge_core::{Exemplars, Patch, SampleId, SeamCosts, SeamMeasure, SourceMap, Window, try_vec};
use selvedge_expansion::Frame;

use crate::agreement::{Term, of_label, of_sample};
use crate::boxes::{Boxes, Taps};
use crate::constraint::{DUMMY, price};
use crate::error::Error;
use crate::options::Options;
use crate::pieces;
use crate::stats::Energy;
use crate::uses::Uses;
use crate::worst::{OF_HOLE, Worst};

/// A map is begun by boxes around its labels if these have no more than so many times its samples: fewer than the
/// smallest neighborhood has taps, each of which would be looked at.
const MOST_BOXES: usize = 8;

/// A labelling with all that follows from it, kept up to date where it changes.
pub(crate) struct Labelling<'a> {
    pub(crate) terms: Vec<Term<'a>>,
    pub(crate) seams: SeamCosts<2>,
    pub(crate) map: SourceMap<2>,
    /// `A'` of what stands, by place; [`DUMMY`] for nothing.
    pub(crate) own: Vec<i32>,
    /// The price between each place and the next, by axis.
    edges: [Vec<i32>; 2],
    /// By constraint, the error of what stands, packed.
    errors: Vec<Vec<u64>>,
    pub(crate) worst: Worst,
    /// Whether match errors wait: nobody asks for the worst place.
    waits: bool,
    pub(crate) holes: usize,
    /// Whether some of what lies under exemplars is masked.
    pub(crate) is_masked: bool,
    energy: Energy,
    pub(crate) uses: Uses,
    /// Half of the neighborhood whose seams count, at least 1: a sample alone has none, and no place would be bad for
    /// them.
    half: u32,
    boxes: Boxes,
}

impl<'a> Labelling<'a> {
    /// What stands in a map. Samples that `fixed` names are never bad.
    pub(crate) fn new(
        exemplars: &Exemplars<2>,
        terms: Vec<Term<'a>>,
        map: SourceMap<2>,
        fixed: Option<&selvedge_core::Grid<bool, 2>>,
        options: &Options,
    ) -> Result<Self, Error> {
        let (output, samples) = (map.domain(), map.domain().len());
        let mut labelling = Self {
            seams: SeamCosts::new(exemplars, SeamMeasure::Difference)?,
            own: try_vec(samples, DUMMY)?,
            edges: [try_vec(samples, 0)?, try_vec(samples, 0)?],
            errors: terms.iter().map(|_| try_vec(samples, 0)).collect::<Result<_, _>>()?,
            worst: Worst::new(output, fixed)?,
            waits: false,
            holes: samples,
            is_masked: terms.iter().any(|term| term.constraint.guide.exemplars().is_masked()),
            energy: Energy { agreement: i64::from(DUMMY) * samples as i64, boundary: 0, usage: 0 },
            uses: Uses::new(exemplars, samples, options.spread)?,
            half: options.neighborhood.max(1),
            boxes: Boxes::default(),
            terms,
            map: SourceMap::unassigned(exemplars, output)?,
        };
        labelling.begin(exemplars, &map)?;
        Ok(labelling)
    }

    fn begin(&mut self, exemplars: &Exemplars<2>, map: &SourceMap<2>) -> Result<(), Error> {
        let output = map.domain();
        let pieces = pieces::of(map)?;
        let boxes: usize = pieces.iter().map(|piece| piece.window.len()).sum();
        if output.periodic == [false; 2] && boxes <= MOST_BOXES * output.len() {
            for piece in pieces {
                self.begin_label(exemplars, map, &piece.patch, &piece.window)?;
            }
        }
        // The rest, also what stands on masked samples.
        for (place, &id) in map.ids.plane(0).iter().enumerate().filter(|(_, id)| id.is_assigned()) {
            if !self.map.ids.plane(0)[place].is_assigned() {
                let cost = of_sample(&self.terms, exemplars, output.position(place), id);
                self.place(place, id, cost);
            }
        }
        self.update(&Window::all(output))
    }

    /// What of a map shows a label, all inside of a window: running sums, where its boxes are small.
    fn begin_label(
        &mut self,
        exemplars: &Exemplars<2>,
        map: &SourceMap<2>,
        patch: &Patch<2>,
        window: &Window<2>,
    ) -> Result<(), Error> {
        let (output, mut costs) = (map.domain(), Vec::new());
        of_label(&self.terms, patch, window, &mut self.boxes, &mut Vec::new(), &mut costs)?;
        let shown = patch.samples(exemplars, window);
        for ((place, id), cost) in window.places(output).zip(shown).zip(costs) {
            if let Some(place) = place.filter(|&place| id.is_assigned() && map.ids.plane(0)[place] == id) {
                self.place(place, id, cost);
            }
        }
        Ok(())
    }

    /// Whether a sample may show: not where something that lies under it is masked.
    pub(crate) fn may_show(&self, id: SampleId) -> bool {
        let Some(source) = self.map.table.source(id).filter(|_| self.is_masked) else { return true };
        let index = (id.get() - self.map.table.first(source)) as usize;
        self.terms.iter().all(|term| term.uses(source, index))
    }

    /// `E'` of what stands. `[CMS eq. 6]`
    pub(crate) fn energy(&self) -> Energy {
        Energy { usage: self.uses.energy(), ..self.energy }
    }

    /// Lays what of a frame was taken, each at its cost; the window that changed.
    pub(crate) fn lay(&mut self, frame: &Frame<2>, taken: &[bool], costs: &[i32]) -> Result<Option<Window<2>>, Error> {
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for ((i, _), &cost) in taken.iter().enumerate().filter(|(_, taken)| **taken).zip(costs) {
            let (at, place) = (frame.domain.position(i), frame.places[i] as usize);
            low = [0, 1].map(|a| low[a].min(at[a]));
            high = [0, 1].map(|a| high[a].max(at[a] + 1));
            self.place(place, frame.new[i], cost);
        }
        if low[0] == u32::MAX {
            return Ok(None);
        }
        let start = [0, 1].map(|a| frame.window.start[a] + low[a] as i32);
        let changed = Window { start, shape: [0, 1].map(|a| high[a] - low[a]) };
        self.update(&changed)?;
        Ok(Some(changed))
    }

    /// Match errors wait from now on until they are wanted again. Sums over neighborhoods around each of many small
    /// changes take longer than those of a whole output, once.
    pub(crate) fn wait(&mut self, waits: bool) -> Result<(), Error> {
        self.waits = waits;
        if waits { Ok(()) } else { self.update(&Window::all(self.map.domain())) }
    }

    /// The worst places, apart from each other: what is used too often counts over a neighborhood, as seams do.
    pub(crate) fn worst_places(&self, count: usize, apart: u32) -> Vec<usize> {
        if self.uses.is_off() {
            return self.worst.places(count, apart);
        }
        let taps = i64::from(2 * self.half + 1).pow(2);
        let ids = self.map.ids.plane(0);
        self.worst.places_with(count, apart, |place| taps * i64::from(self.uses.price(ids[place])))
    }

    fn place(&mut self, place: usize, id: SampleId, cost: i32) {
        let standing = &mut self.map.ids.plane_mut(0)[place];
        self.holes -= usize::from(!standing.is_assigned());
        self.uses.replace(std::mem::replace(standing, id), id);
        self.energy.agreement += i64::from(cost) - i64::from(self.own[place]);
        self.own[place] = cost;
        self.errors.iter_mut().zip(&self.terms).for_each(|(errors, term)| errors[place] = term.standing(place, id));
    }

    /// Prices of seams and match errors, after all of a window may have changed.
    fn update(&mut self, changed: &Window<2>) -> Result<(), Error> {
        let output = self.map.domain();
        for axis in 0..2 {
            let before = [0, 1].map(|a| u32::from(a == axis));
            let grown = changed.grown(output, before, [0; 2]);
            for place in grown.places(output).flatten() {
                let price = self.seams.at(&self.map, output.position(place), axis);
                self.energy.boundary += i64::from(price) - i64::from(self.edges[axis][place]);
                self.edges[axis][place] = price;
            }
        }
        if self.waits {
            return Ok(());
        }
        let reach = self.terms.iter().map(|t| t.taps.reach()).max().unwrap_or(0).max(self.half) + 1;
        let grown = changed.grown(output, [reach; 2], [reach; 2]);
        let mut errors = try_vec(grown.len(), 0_i64)?;
        self.true_agreement(&grown, &mut errors)?;
        self.boundaries(&grown, &mut errors)?;
        let ids = self.map.ids.plane(0);
        for (place, error) in grown.places(output).zip(errors) {
            let Some(place) = place else { continue };
            self.worst.set(place, if ids[place].is_assigned() { error } else { OF_HOLE });
        }
        self.worst.renew(&grown, output);
        Ok(())
    }

    /// Adds `A` over what stands. `[CMS eq. 3]`
    fn true_agreement(&mut self, window: &Window<2>, to: &mut [i64]) -> Result<(), Error> {
        let output = self.map.domain();
        let mut scaled = try_vec(to.len(), 0_u64)?;
        for (term, errors) in self.terms.iter().zip(&self.errors) {
            let sums =
                self.boxes.of(window, term.taps, |reached, values| gather(reached, output, values, |p| errors[p]))?;
            scaled.iter_mut().zip(sums).for_each(|(to, &sum)| *to = to.saturating_add(term.scale.of_packed(sum)));
        }
        to.iter_mut().zip(scaled).for_each(|(to, s)| *to += i64::from(price(s)));
        Ok(())
    }

    /// Adds `B` of all pairs inside of each neighborhood. `[CMS eq. 7]`
    fn boundaries(&mut self, window: &Window<2>, to: &mut [i64]) -> Result<(), Error> {
        let output = self.map.domain();
        for (axis, edges) in self.edges.iter().enumerate() {
            let mut taps = Taps::around(self.half, 1);
            taps.count[axis] -= 1;
            let value = |place: usize| edges[place] as u64;
            let sums = self.boxes.of(window, taps, |reached, values| gather(reached, output, values, value))?;
            to.iter_mut().zip(sums).for_each(|(to, &sum)| *to += sum as i64);
        }
        Ok(())
    }

    /// `E` of what stands, its agreement over `O_Q` as it is. `[CMS eq. 2]`
    pub(crate) fn truth(&mut self) -> Result<Energy, Error> {
        let all = Window::all(self.map.domain());
        let mut errors = try_vec(all.len(), 0_i64)?;
        self.true_agreement(&all, &mut errors)?;
        let standing = self.map.ids.plane(0).iter().zip(errors).filter(|(id, _)| id.is_assigned());
        Ok(Energy { agreement: standing.map(|(_, e)| e).sum(), ..self.energy() })
    }
}

/// The value of each position that is a place.
fn gather(reached: &Window<2>, output: selvedge_core::Domain<2>, values: &mut [u64], of: impl Fn(usize) -> u64) {
    values.iter_mut().zip(reached.places(output)).for_each(|(v, place)| *v = place.map_or(0, &of));
}
