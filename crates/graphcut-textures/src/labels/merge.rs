//! A merge under a brush: strokes say what must show, and each is answered from where the last one ended.
//! `[Kwatra03 6B]`

use selvedge_core::{Domain, Exemplars, Grid, Run, SampleId, SeamCosts, SourceMap, Start, Window, reserve, try_vec};

use crate::error::Error;
use crate::labels::expand::estimate_labels;
use crate::labels::label::Label;
use crate::labels::options::LabelOptions;
use crate::labels::prices::{NONE, price_of};
use crate::labels::sets::Sets;
use crate::labels::sweeps::Sweeps;
use crate::labels::two::Two;

/// What a stroke of the brush changes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StrokeDelta {
    /// Places of the output's buffer, row-major.
    pub places: Vec<u32>,
    /// The label that must show there from now on; `None` for any.
    pub label: Option<usize>,
}

/// Samples that a preview looks at around a stroke, at least: a brush of one sample has room for a seam to turn. A
/// guess.
const AROUND: u32 = 32;

/// Labels that are decided again and again while strokes come and go.
///
/// With two labels, [`update`](Self::update) goes on from the last flow: its answer is the cut of least price, and
/// *the same one* that a merge made anew of all strokes would find. It is exact unless prices are no metric, as around
/// the border of a periodic output; then, and with more labels, it goes on from the last labelling and
/// changes what is around the stroke, as far as that makes it cheaper. What it ends with then follows from that
/// labelling and the strokes alone, on any number of threads. It is never dearer than the old labelling with the stroke
/// laid over it, and need not be what a merge made anew ends with.
///
/// ```
/// use selvedge_core::{Domain, Exemplars, Plane, Role, Run};
/// use selvedge_graphcut_textures::labels::{Label, LabelOptions, Merge, StrokeDelta};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let planes = [b"#..##..##..#", b".##..##..##."].map(|row| Plane::of_bytes(Role::Scalar, [1, 12], 1, row));
/// let [a, b] = planes;
/// let (a, b) = (a?, b?);
/// let exemplars = Exemplars::of(&[std::slice::from_ref(&a), std::slice::from_ref(&b)])?;
/// let labels = vec![Label { source: 0, offset: [0, 0] }, Label { source: 1, offset: [0, 0] }];
/// let run = Run::seeded(0);
/// let mut merge = Merge::new(&exemplars, Domain::open([1, 12]), labels, LabelOptions::default(), &run)?;
/// merge.solve(&run)?;
/// merge.update(&StrokeDelta { places: vec![0, 1], label: Some(0) }, &run)?;
/// merge.update(&StrokeDelta { places: vec![11], label: Some(1) }, &run)?;
/// assert_eq!(merge.seam().len(), 1);
/// merge.undo();
/// assert_eq!(merge.seam().len(), 0);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Merge<'e, const D: usize> {
    exemplars: &'e Exemplars<D>,
    labels: Vec<Label<D>>,
    options: LabelOptions<D>,
    costs: SeamCosts<D>,
    map: SourceMap<D>,
    /// By place, the label that shows; [`NONE`] in holes.
    standing: Vec<u8>,
    /// By place, the label that must show.
    strokes: Vec<u8>,
    /// The cut of two labels, if it is exact.
    two: Option<Two<D>>,
    solved: bool,
    past: Vec<Step>,
}

/// What one update changed, to be taken back.
#[derive(Debug, Default)]
struct Step {
    /// Places, and the label that had to show there.
    strokes: Vec<(u32, u8)>,
    /// Places, and what showed there.
    shown: Vec<(u32, SampleId, u8)>,
}

impl<'e, const D: usize> Merge<'e, D> {
    /// A merge without strokes, not yet solved.
    ///
    /// # Errors
    /// Those of [`expand`](crate::labels::expand).
    pub fn new(
        exemplars: &'e Exemplars<D>,
        output: Domain<D>,
        labels: Vec<Label<D>>,
        options: LabelOptions<D>,
        run: &Run<'_, D>,
    ) -> Result<Self, Error> {
        options.validate(&labels, exemplars.sources().len(), output)?;
        let domains = exemplars.domains();
        run.limits.admit(output, estimate_labels(&domains, exemplars.channels(), output))?;
        let costs = SeamCosts::new(exemplars, options.seam)?;
        let map = SourceMap::unassigned(exemplars, output)?;
        let (standing, strokes) = (try_vec(output.len(), NONE)?, try_vec(output.len(), NONE)?);
        let two = match labels.len() {
            2 => Two::new(exemplars, &costs, output, &labels, &options)?,
            _ => None,
        };
        Ok(Self { exemplars, labels, options, costs, map, standing, strokes, two, solved: false, past: Vec::new() })
    }

    /// Decides all positions anew, under the strokes that there are, which are there for good: nothing is undone beyond
    /// it. False if the run was cancelled; then the map is what it was, or on the way.
    ///
    /// # Errors
    /// Those of [`expand`](crate::labels::expand).
    pub fn solve(&mut self, run: &Run<'_, D>) -> Result<bool, Error> {
        self.past.clear();
        if self.two.is_none() {
            self.map.ids.samples_mut().fill(SampleId::UNASSIGNED);
        }
        self.settle(run)
    }

    /// Decides all positions, from what shows.
    fn settle(&mut self, run: &Run<'_, D>) -> Result<bool, Error> {
        self.solved = if self.two.is_some() { self.cut(run)? } else { self.sweep(None, run)? };
        Ok(self.solved)
    }

    /// Lays a stroke and decides again what it changes; solves first if nothing was solved yet. False if the run was
    /// cancelled: then what is to be decided still is decided by the next call.
    ///
    /// # Errors
    /// [`Error::Stroke`] for a label that cannot show at a place, or a place that there is not: then nothing has
    /// changed. Those of [`expand`](crate::labels::expand).
    pub fn update(&mut self, stroke: &StrokeDelta, run: &Run<'_, D>) -> Result<bool, Error> {
        self.check(stroke)?;
        let whole = !self.solved;
        let label = stroke.label.map_or(NONE, |label| label as u8);
        let mut step = Step::default();
        reserve(&mut step.strokes, stroke.places.len())?;
        for &place in &stroke.places {
            let was = std::mem::replace(&mut self.strokes[place as usize], label);
            if was != label {
                step.strokes.push((place, was));
            }
        }
        self.past.push(step);
        if self.two.is_some() {
            return self.settle(run);
        }
        if let Some(label) = stroke.label {
            for &place in &stroke.places {
                self.show(place as usize, label);
            }
        }
        // What a cancelled call left is anywhere.
        if whole {
            return self.settle(run);
        }
        self.solved = self.around(stroke, run)?;
        Ok(self.solved)
    }

    /// What a map would show near a stroke, without laying it: one expansion of its label in the box around it, so that
    /// far seams stay where they are. For a stroke that lets go, the map as it is.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    pub fn preview(&self, stroke: &StrokeDelta, run: &Run<'_, D>) -> Result<SourceMap<D>, Error> {
        self.check(stroke)?;
        let mut map = self.map.clone();
        let (Some(label), Some(window)) = (stroke.label, self.window(stroke, 1)) else { return Ok(map) };
        let sets = self.sets(&self.labels);
        let mut strokes = self.strokes.clone();
        let mut standing = self.standing.clone();
        for &place in &stroke.places {
            let place = place as usize;
            let at = self.domain().position(place).map(|p| p as i32);
            map.ids.plane_mut(0)[place] = sets.sample(label, at);
            (strokes[place], standing[place]) = (label as u8, label as u8);
        }
        let fixed = self.fixed(&strokes, Some(&window))?;
        // All labels are handed over, so that their numbers stay; the others may show nowhere.
        let mut only = Grid::try_filled(self.domain(), 1, 1_u64 << label)?;
        if let Some(field) = &self.options.only {
            only.samples_mut().iter_mut().zip(field.plane(0)).for_each(|(bits, field)| *bits &= field);
        }
        let options = LabelOptions { only: Some(only), leave_holes: true, sweeps: 1, ..self.options.clone() };
        let start = Start { map, fixed: Some(fixed), sources: None };
        let known = Some(standing.as_slice());
        let mut sweeps = Sweeps::new(self.exemplars, &self.costs, known, start, &self.labels, &options, run)?;
        let complete = sweeps.run_to_end()?;
        Ok(sweeps.answer(complete).result)
    }

    /// What shows.
    pub fn map(&self) -> &SourceMap<D> {
        &self.map
    }

    /// By place, the number of the label that shows; `None` in holes.
    pub fn label(&self, place: usize) -> Option<usize> {
        self.standing.get(place).filter(|label| **label != NONE).map(|label| usize::from(*label))
    }

    /// The seams: places, and the axis along which their next neighbour shows another label.
    pub fn seam(&self) -> Vec<(u32, usize)> {
        let domain = self.domain();
        let differs = |&(place, axis): &(usize, usize)| {
            let next = domain.next(domain.position(place), axis).map(|next| self.standing[domain.index(next)]);
            next.is_some_and(|next| next != self.standing[place] && next != NONE && self.standing[place] != NONE)
        };
        let pairs = (0..domain.len()).flat_map(|place| (0..D).map(move |axis| (place, axis)));
        pairs.filter(differs).map(|(place, axis)| (place as u32, axis)).collect()
    }

    /// The price of all seams and labels.
    pub fn price(&self) -> i64 {
        price_of(&self.costs, self.options.own.as_ref(), &self.map, &self.standing)
    }

    /// Takes the last update back; false if there is none. What showed before it shows again.
    pub fn undo(&mut self) -> bool {
        let Some(step) = self.past.pop() else { return false };
        for &(place, id, label) in step.shown.iter().rev() {
            self.map.ids.plane_mut(0)[place as usize] = id;
            self.standing[place as usize] = label;
        }
        for &(place, label) in step.strokes.iter().rev() {
            self.strokes[place as usize] = label;
        }
        true
    }

    fn domain(&self) -> Domain<D> {
        self.map.domain()
    }

    fn sets<'a>(&'a self, labels: &'a [Label<D>]) -> Sets<'a, D> {
        Sets::of(self.exemplars, labels, &self.options, self.domain(), None)
    }

    /// Refuses a stroke whose label cannot show somewhere.
    fn check(&self, stroke: &StrokeDelta) -> Result<(), Error> {
        let domain = self.domain();
        let refused = |place: &u32| {
            if domain.len() <= *place as usize {
                return true;
            }
            let at = domain.position(*place as usize).map(|p| p as i32);
            let sets = self.sets(&self.labels);
            stroke.label.is_some_and(|label| {
                self.labels.len() <= label
                    || !sets.lets(label, *place as usize)
                    || !sets.sample(label, at).is_assigned()
            })
        };
        match stroke.places.iter().find(|place| refused(place)) {
            None => Ok(()),
            Some(&place) => Err(Error::Stroke { place: place as usize, label: stroke.label }),
        }
    }

    /// Shows a label at a place.
    fn show(&mut self, place: usize, label: usize) {
        let at = self.domain().position(place).map(|p| p as i32);
        let id = self.sets(&self.labels).sample(label, at);
        self.put(place, id, label as u8);
    }

    /// Shows a sample, and notes what was there.
    fn put(&mut self, place: usize, id: SampleId, label: u8) {
        let was = std::mem::replace(&mut self.map.ids.plane_mut(0)[place], id);
        let stood = std::mem::replace(&mut self.standing[place], label);
        if let Some(step) = self.past.last_mut().filter(|_| (was, stood) != (id, label)) {
            step.shown.push((place as u32, was, stood));
        }
    }

    /// The exact cut of two labels.
    fn cut(&mut self, run: &Run<'_, D>) -> Result<bool, Error> {
        let Some(two) = &mut self.two else { return Ok(true) };
        match two.cut(&self.strokes, &|| run.observer.cancelled()) {
            Err(error) if error.is_cancelled() => return Ok(false),
            other => other?,
        }
        for place in 0..self.standing.len() {
            let label = self.two.as_ref().map_or(NONE, |two| two.labels[place]);
            if label != self.standing[place] {
                self.show(place, usize::from(label));
            }
        }
        Ok(true)
    }

    /// Sweeps around a stroke, in a box that grows until nothing changes at its border.
    fn around(&mut self, stroke: &StrokeDelta, run: &Run<'_, D>) -> Result<bool, Error> {
        let mut times = 1;
        loop {
            let Some(window) = self.window(stroke, times) else { return Ok(true) };
            let before = self.past.last().map_or(0, |step| step.shown.len());
            if !self.sweep(Some(&window), run)? {
                return Ok(false);
            }
            let domain = self.domain();
            let whole = (0..D).all(|a| domain.shape[a] <= window.shape[a]);
            let inner = |place: u32| {
                let at = domain.position(place as usize);
                (0..D).all(|a| {
                    let from = (at[a] as i32 - window.start[a]).rem_euclid(domain.shape[a] as i32);
                    domain.shape[a] <= window.shape[a]
                        || (1..window.shape[a] as i32 - 1).contains(&from)
                        // Where the output ends nothing more can change.
                        || !domain.periodic[a] && (at[a] == 0 || at[a] + 1 == domain.shape[a])
                })
            };
            let changed = self.past.last().map_or(&[][..], |step| &step.shown[before..]);
            if whole || changed.iter().all(|(place, ..)| inner(*place)) {
                return Ok(true);
            }
            times *= 2;
        }
    }

    /// The box of a stroke, with so many times as much around it.
    fn window(&self, stroke: &StrokeDelta, times: u32) -> Option<Window<D>> {
        let domain = self.domain();
        let first = domain.position(*stroke.places.first()? as usize);
        let (mut low, mut high) = (first, first);
        for &place in &stroke.places {
            let at = domain.position(place as usize);
            low = std::array::from_fn(|a| low[a].min(at[a]));
            high = std::array::from_fn(|a| high[a].max(at[a]));
        }
        let window = Window { start: low.map(|l| l as i32), shape: std::array::from_fn(|a| high[a] - low[a] + 1) };
        let by = window.shape.map(|n| n.max(AROUND).saturating_mul(times).min(1 << 20));
        let grown = window.grown(domain, by, by);
        Some(grown.inside(domain))
    }

    /// Where strokes are, and what is outside of a window.
    fn fixed(&self, strokes: &[u8], window: Option<&Window<D>>) -> Result<Grid<bool, D>, Error> {
        let domain = self.domain();
        let mut fixed = Grid::try_filled(domain, 1, window.is_some())?;
        if let Some(window) = window {
            for place in window.places(domain).flatten() {
                fixed.samples_mut()[place] = false;
            }
        }
        let stays = |(fixed, stroke): (&mut bool, &u8)| *fixed |= *stroke != NONE;
        fixed.samples_mut().iter_mut().zip(strokes).for_each(stays);
        Ok(fixed)
    }

    /// Sweeps over a window, or all.
    fn sweep(&mut self, window: Option<&Window<D>>, run: &Run<'_, D>) -> Result<bool, Error> {
        let fixed = self.fixed(&self.strokes, window)?;
        let mut only = match &self.options.only {
            Some(only) => only.clone(),
            None => Grid::try_filled(self.domain(), 1, u64::MAX)?,
        };
        let strokes = only.samples_mut().iter_mut().zip(&self.strokes);
        strokes.filter(|(_, stroke)| **stroke != NONE).for_each(|(bits, stroke)| *bits = 1 << stroke);
        let options = LabelOptions { only: Some(only), ..self.options.clone() };
        let start = Start { map: self.map.clone(), fixed: Some(fixed), sources: None };
        let known = Some(self.standing.as_slice());
        let mut sweeps = Sweeps::new(self.exemplars, &self.costs, known, start, &self.labels, &options, run)?;
        let complete = sweeps.run_to_end()?;
        let standing = sweeps.standing().to_vec();
        let map = sweeps.answer(complete).result;
        for (place, label) in standing.into_iter().enumerate() {
            self.put(place, map.ids.plane(0)[place], label);
        }
        Ok(complete)
    }
}

#[cfg(test)]
mod tests;
