//! How seams become cheaper: their price after each refinement as a curve, and pictures of what they cost at some of
//! them, taken while a run goes on. `[Kwatra03 4, fig. 5]`

use std::fmt::Write as _;
use std::sync::{Mutex, PoisonError};

use selvedge_core::{
    Bytes, Domain, Event, Exemplars, Grid, Observer, Plane, Render, Role, Samples, SeamCosts, SeamMeasure, SourceMap,
    par,
};

use crate::failure::Failure;
use crate::page;
use crate::watch::Watch;

/// Pictures that are kept at most, besides the last.
const MOST: usize = 24;
/// Samples a side of a picture at most: of a larger output each sample shows the dearest seam of a square.
const LARGEST: u32 = 384;
/// Width and height of the curve, in its own units.
const CURVE: [f64; 2] = [1000.0, 200.0];

/// Hands events on, and takes a picture of seam costs after refinements that changed something.
///
/// All of them are taken until there are too many. From then on every second one is: so they stay evenly spread over
/// the run, however long it takes, and only some dozen are made for each doubling of its length.
pub(crate) struct Film<'w> {
    watch: &'w Watch,
    costs: SeamCosts<2>,
    reel: Mutex<Reel>,
}

/// What was taken so far.
#[derive(Default)]
struct Reel {
    /// Those that were taken note of.
    changes: u64,
    /// Every so many of them is kept.
    every: u64,
    /// The last of them, and the price of all seams then.
    last: Option<(u64, i64)>,
    /// What is white; see [`white`].
    white: u32,
    steps: Vec<Step>,
}

/// The seams after a refinement.
struct Step {
    /// Its number, from 1; 0 is before the first.
    refinement: u64,
    /// The price of all seams.
    energy: i64,
    picture: Plane<2>,
}

/// A film that is over.
pub(crate) struct Course {
    /// At the smallest size.
    energy: Vec<i64>,
    /// At how many sizes the map was solved. Of several, only the last map is one of the exemplars, and the only
    /// picture.
    levels: u32,
    /// Refinements that changed something.
    changes: u64,
    steps: Vec<Step>,
}

impl<'w> Film<'w> {
    /// A film of a run over exemplars that prices its seams by a measure.
    pub(crate) fn new(watch: &'w Watch, exemplars: &Exemplars<2>, measure: SeamMeasure) -> Result<Self, Failure> {
        let reel = Mutex::new(Reel { every: 1, ..Reel::default() });
        Ok(Self { watch, costs: SeamCosts::new(exemplars, measure)?, reel })
    }

    fn note(&self, refinement: u64, energy: i64, map: &SourceMap<2>) {
        let mut reel = self.reel.lock().unwrap_or_else(PoisonError::into_inner);
        if reel.last.is_some_and(|(_, before)| before == energy) {
            return;
        }
        reel.last = Some((refinement, energy));
        if reel.changes.is_multiple_of(reel.every) {
            if reel.steps.len() == MOST {
                reel.thin();
            }
            reel.take(refinement, energy, map, &self.costs);
        }
        reel.changes += 1;
    }

    /// Ends the film with what came out.
    pub(crate) fn course(self, map: &SourceMap<2>, energy: &[i64], levels: u32) -> Course {
        let mut reel = self.reel.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some((refinement, last)) = reel.last.filter(|(_, e)| reel.steps.last().is_some_and(|s| s.energy != *e)) {
            reel.take(refinement, last, map, &self.costs);
        }
        let changes = energy.windows(2).filter(|two| two[0] != two[1]).count() as u64;
        Course { energy: energy.to_vec(), levels, changes, steps: reel.steps }
    }
}

impl Observer<2> for Film<'_> {
    fn event(&self, event: &Event<'_, 2>) {
        self.watch.event(event);
        let is_step = ["refine", "settle"].contains(&event.stage);
        let map = event.so_far.filter(|_| is_step).and_then(Render::as_map);
        if let (Some(map), Some(energy)) = (map, event.energy) {
            self.note(event.done, energy, map);
        }
    }

    fn cancelled(&self) -> bool {
        Observer::<2>::cancelled(self.watch)
    }
}

impl Reel {
    /// Leaves every second picture out.
    fn thin(&mut self) {
        let steps = std::mem::take(&mut self.steps);
        self.steps = steps.into_iter().step_by(2).collect();
        self.every *= 2;
    }

    fn take(&mut self, refinement: u64, energy: i64, map: &SourceMap<2>, costs: &SeamCosts<2>) {
        let (shape, prices) = dearest(map, costs);
        if self.steps.is_empty() {
            self.white = white(&prices);
        }
        // Of the root, so that cheap seams are seen beside dear ones.
        let tone = |price: &u32| (255.0 * (f64::from(*price) / f64::from(self.white)).sqrt()).min(255.0) as u8;
        let Ok(grid) = Grid::from_vec(Domain::open(shape), 1, prices.iter().map(tone).collect()) else { return };
        let picture = Plane::new(Role::Scalar, Samples::U8(grid));
        self.steps.push(Step { refinement, energy, picture });
    }
}

/// What all but a fiftieth of the seams cost at most: beside the dearest one the others would be black.
fn white(prices: &[u32]) -> u32 {
    let mut seams: Vec<u32> = prices.iter().copied().filter(|price| 0 < *price).collect();
    seams.sort_unstable();
    seams.get(seams.len() * 49 / 50).copied().unwrap_or(1)
}

/// The dearest seam in each square of an output, row-major, and how many squares there are down and across.
fn dearest(map: &SourceMap<2>, costs: &SeamCosts<2>) -> ([u32; 2], Vec<u32>) {
    let output = map.domain();
    let side = side(output);
    let shape = output.shape.map(|n| n.div_ceil(side));
    let price = |at: [u32; 2]| (0..2).map(|axis| costs.at(map, at, axis)).max().unwrap_or(0) as u32;
    let row = |row: usize| {
        let mut prices = vec![0; shape[1] as usize];
        let first = row as u32 * side;
        for y in first..output.shape[0].min(first + side) {
            for x in 0..output.shape[1] {
                let square = &mut prices[(x / side) as usize];
                *square = price([y, x]).max(*square);
            }
        }
        prices
    };
    (shape, par::map_indexed(shape[0] as usize, row).concat())
}

/// Samples of the output along a side of the square that becomes one sample of a picture.
fn side(output: Domain<2>) -> u32 {
    output.shape[0].max(output.shape[1]).div_ceil(LARGEST).max(1)
}

/// An upper bound of what a film and its course on the page take.
pub(crate) fn memory(sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
    let side = side(output);
    let small = Domain::open(output.shape.map(|n| n.div_ceil(side)));
    // Each picture, and twice as text; prices of one.
    let pictures = Bytes::of_samples(small, 4 * (MOST as u64 + 1) + 8);
    sources.iter().map(|source| Bytes::of_samples(*source, channels as u64 + 9)).sum::<Bytes>() + pictures
}

impl Course {
    /// The curve and the pictures, for the page.
    pub(crate) fn html(&self) -> Result<String, Failure> {
        let (refinements, changes) = (self.energy.len().saturating_sub(1), self.changes);
        let (first, last) = (self.energy.first().unwrap_or(&0), self.energy.last().unwrap_or(&0));
        let (size, below, white) = if self.levels == 1 {
            (String::new(), "; dots are the pictures below", " once everything was covered")
        } else {
            (format!(" at 1/{} of the size", 1 << (self.levels - 1)), "; below are those of the whole size", "")
        };
        let mut html = format!(
            "<h2>Seams</h2>\n<figure>{}<figcaption>The price of all seams{size}, from {first} once everything was \
             covered to {last} after {refinements} refinements, {changes} of which changed something{below}\
             </figcaption></figure>\n<p>What seams cost where: black is nothing, white what all but a fiftieth \
             of them cost at most{white}.</p>\n<div class=\"steps\">\n",
            self.curve()
        );
        for Step { refinement, energy, picture } in &self.steps {
            let when = match (self.levels, refinement) {
                (1, 0) => "covered".to_owned(),
                (1, n) => format!("refinement {n}"),
                _ => "at the whole size".to_owned(),
            };
            html += &page::figure(picture, &format!("Seam costs, {when}"), &format!("{when}: {energy}"))?;
        }
        Ok(html + "</div>\n")
    }

    /// The price of all seams over refinements, from the least to the most.
    fn curve(&self) -> String {
        let [width, height] = CURVE;
        let most = self.energy.iter().copied().max().unwrap_or(0);
        let least = self.energy.iter().copied().min().unwrap_or(0);
        let range = (most - least).max(1) as f64;
        let step = width / self.energy.len().saturating_sub(1).max(1) as f64;
        let point = |refinement: u64, energy: i64| (refinement as f64 * step, (most - energy) as f64 / range * height);
        let mut svg =
            format!("<svg viewBox=\"-8 -8 {} {}\" role=\"img\"><polyline points=\"", width + 16.0, height + 16.0);
        for (refinement, &energy) in (0..).zip(&self.energy) {
            let (x, y) = point(refinement, energy);
            let _ = write!(svg, "{x:.1},{y:.1} ");
        }
        svg += "\"/>";
        for step in self.steps.iter().filter(|_| self.levels == 1) {
            let (x, y) = point(step.refinement, step.energy);
            let _ = write!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>");
        }
        svg + "</svg>"
    }
}
