//! How a run goes on: its energy after each step as a curve, and pictures of what it was like at some of them, taken
//! while it works. Of seams they show what these cost. `[Kwatra03 4, fig. 5]`

use std::fmt::Write as _;
use std::sync::{Mutex, OnceLock, PoisonError};

use selvedge_core::{
    Bytes, Domain, Event, Exemplars, Grid, Observer, Plane, Render, Role, Samples, SeamCosts, SeamMeasure, SourceMap,
    par,
};

use crate::failure::Failure;
use crate::page;
use crate::watch::Watch;

/// Pictures that are kept at most, besides the last.
const MOST: usize = 24;
/// Samples a side of a picture at most.
const LARGEST: u32 = 384;
/// Width and height of the curve, in its own units.
const CURVE: [f64; 2] = [1000.0, 200.0];
/// Points of it at most.
const MOST_POINTS: usize = 4000;

/// Hands events on, and takes a picture after steps that changed something.
///
/// All of them are taken until there are too many. From then on every second one is: so they stay evenly spread over
/// the run, however long it takes, and only some dozen are made for each doubling of its length.
pub(crate) struct Film<'w> {
    watch: &'w Watch,
    words: &'static Words,
    draw: Box<Draw<'w>>,
    reel: Mutex<Reel>,
}

/// A picture of a map.
type Draw<'w> = dyn Fn(&SourceMap<2>) -> Option<Plane<2>> + Sync + 'w;

/// What a film is about.
pub(crate) struct Words {
    /// The stages whose steps are shown.
    pub(crate) stages: &'static [&'static str],
    /// Whether each event is a step that changed something; otherwise it says how many are done.
    pub(crate) counts: bool,
    pub(crate) heading: &'static str,
    /// What falls.
    pub(crate) energy: &'static str,
    /// When it is told first.
    pub(crate) begun: &'static str,
    /// A step by its number, and several of them.
    pub(crate) steps: [&'static str; 2],
    /// What a picture is called, and how all of them are read.
    pub(crate) shows: &'static str,
    pub(crate) legend: &'static str,
    /// What else holds of them if they show the whole run.
    pub(crate) of_all: &'static str,
}

/// What seams cost.
const SEAMS: Words = Words {
    stages: &["refine", "settle"],
    counts: false,
    heading: "Seams",
    energy: "The price of all seams",
    begun: " once everything was covered",
    steps: ["refinement", "refinements"],
    shows: "Seam costs",
    legend: "What seams cost where: black is nothing, white what all but a fiftieth of them cost at most",
    of_all: " once everything was covered",
};

/// What was taken so far.
#[derive(Default)]
struct Reel {
    /// Steps that were told.
    told: u64,
    /// Those that were taken note of.
    changes: u64,
    /// Every so many of them is kept.
    every: u64,
    /// The last of them, and the energy then.
    last: Option<(u64, i64)>,
    steps: Vec<Step>,
}

/// What a map was like after a step.
struct Step {
    /// The step's number, from 1; 0 is before the first.
    number: u64,
    energy: i64,
    /// What it is called, if not by its number.
    name: Option<String>,
    picture: Plane<2>,
}

/// A film that is over.
pub(crate) struct Course {
    words: &'static Words,
    /// At the smallest size.
    energy: Vec<i64>,
    /// At how many sizes the map was solved. Of several, only the last map is one of the exemplars, and the only
    /// picture.
    levels: u32,
    /// Steps that changed something.
    changes: u64,
    steps: Vec<Step>,
}

impl<'w> Film<'w> {
    /// A film of what `draw` makes of maps.
    pub(crate) fn new(watch: &'w Watch, words: &'static Words, draw: Box<Draw<'w>>) -> Self {
        Self { watch, words, draw, reel: Mutex::new(Reel { every: 1, ..Reel::default() }) }
    }

    /// A film of a run over exemplars that prices its seams by a measure.
    pub(crate) fn of_seams(watch: &'w Watch, exemplars: &Exemplars<2>, measure: SeamMeasure) -> Result<Self, Failure> {
        let costs = SeamCosts::new(exemplars, measure)?;
        let white = OnceLock::new();
        Ok(Self::new(watch, &SEAMS, Box::new(move |map| drawn(map, &costs, &white))))
    }

    fn note(&self, event: &Event<'_, 2>, energy: i64, map: &SourceMap<2>) {
        let mut reel = self.reel.lock().unwrap_or_else(PoisonError::into_inner);
        let number = if self.words.counts { reel.told } else { event.done };
        reel.told += 1;
        if reel.last.is_some_and(|(_, before)| before == energy) {
            return;
        }
        reel.last = Some((number, energy));
        if reel.changes.is_multiple_of(reel.every) {
            if reel.steps.len() == MOST {
                reel.thin();
            }
            reel.steps.extend((self.draw)(map).map(|picture| Step { number, energy, name: None, picture }));
        }
        reel.changes += 1;
    }

    /// Ends the film with what came out.
    pub(crate) fn course(self, map: &SourceMap<2>, energy: &[i64], levels: u32) -> Course {
        let mut reel = self.reel.into_inner().unwrap_or_else(PoisonError::into_inner);
        let is_new = |last: i64| reel.steps.last().is_some_and(|step| step.energy != last);
        if let Some((number, energy)) = reel.last.filter(|(_, last)| is_new(*last)) {
            reel.steps.extend((self.draw)(map).map(|picture| Step { number, energy, name: None, picture }));
        }
        let changes = energy.windows(2).filter(|two| two[0] != two[1]).count() as u64;
        Course { words: self.words, energy: energy.to_vec(), levels, changes, steps: reel.steps }
    }
}

impl Observer<2> for Film<'_> {
    fn event(&self, event: &Event<'_, 2>) {
        self.watch.event(event);
        let is_step = self.words.stages.contains(&event.stage);
        let map = event.so_far.filter(|_| is_step).and_then(Render::as_map);
        if let (Some(map), Some(energy)) = (map, event.energy) {
            self.note(event, energy, map);
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
}

/// What seams of some maps cost where, by a measure, all on the scale of the first.
///
/// # Errors
/// No memory.
pub(crate) fn seams<const N: usize>(
    maps: [&SourceMap<2>; N],
    exemplars: &Exemplars<2>,
    measure: SeamMeasure,
) -> Result<[Option<Plane<2>>; N], Failure> {
    let (costs, white) = (SeamCosts::new(exemplars, measure)?, OnceLock::new());
    Ok(maps.map(|map| drawn(map, &costs, &white)))
}

/// What seams cost where, on the scale of the first that was drawn.
fn drawn(map: &SourceMap<2>, costs: &SeamCosts<2>, white: &OnceLock<u32>) -> Option<Plane<2>> {
    let (shape, prices) = dearest(map, costs);
    let white = *white.get_or_init(|| self::white(&prices));
    // Of the root, so that cheap seams are seen beside dear ones.
    let tone = |price: &u32| (255.0 * (f64::from(*price) / f64::from(white)).sqrt()).min(255.0) as u8;
    let grid = Grid::from_vec(Domain::open(shape), 1, prices.iter().map(tone).collect()).ok()?;
    Some(Plane::new(Role::Scalar, Samples::U8(grid)))
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
pub(crate) fn side(output: Domain<2>) -> u32 {
    output.shape[0].max(output.shape[1]).div_ceil(LARGEST).max(1)
}

/// An upper bound of what a film of seams and its course on the page take.
pub(crate) fn memory(sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
    let prices = sources.iter().map(|source| Bytes::of_samples(*source, channels as u64 + 9)).sum::<Bytes>();
    prices + pictures(output, 1)
}

/// The same of pictures alone that have so many bytes a sample.
pub(crate) fn pictures(output: Domain<2>, each: u64) -> Bytes {
    let side = side(output);
    let small = Domain::open(output.shape.map(|n| n.div_ceil(side)));
    // Each picture, and twice as text; prices of one.
    Bytes::of_samples(small, 4 * each * (MOST as u64 + 1) + 8)
}

impl Course {
    /// Of a run with an energy after each step, and pictures of some of them by their numbers from 0, with what they
    /// are called.
    pub(crate) fn new(words: &'static Words, energy: Vec<i64>, pictures: Vec<(usize, String, Plane<2>)>) -> Self {
        let step = |(number, name, picture): (usize, String, Plane<2>)| {
            let energy = energy.get(number).copied().unwrap_or(0);
            Step { number: number as u64, energy, name: Some(name), picture }
        };
        let (steps, changes) = (pictures.into_iter().map(step).collect(), energy.len() as u64);
        Self { words, energy, levels: 1, changes, steps }
    }

    /// The curve and the pictures, for the page.
    pub(crate) fn html(&self) -> Result<String, Failure> {
        let Words { heading, energy, begun, steps: [step, steps], shows, legend, of_all, .. } = self.words;
        let (done, changes) = (self.energy.len().saturating_sub(1), self.changes);
        let (first, last) = (self.energy.first().unwrap_or(&0), self.energy.last().unwrap_or(&0));
        let of_them = if self.words.counts { String::new() } else { format!(", {changes} of which changed something") };
        let (size, below, of_all) = if self.levels == 1 {
            (String::new(), "; dots are the pictures below", *of_all)
        } else {
            (format!(" at 1/{} of the size", 1 << (self.levels - 1)), "; below are those of the whole size", "")
        };
        let mut html = format!(
            "<h2>{heading}</h2>\n<figure>{}<figcaption>{energy}{size}, from {first}{begun} to {last} after {done} {steps}{of_them}{below}</figcaption></figure>\n\
             <p>{legend}{of_all}.</p>\n<div class=\"steps\">\n",
            self.curve()
        );
        for Step { number, energy, name, picture } in &self.steps {
            let when = match (self.levels, number) {
                _ if name.is_some() => name.clone().unwrap_or_default(),
                (1, 0) => "covered".to_owned(),
                (1, n) => format!("{step} {n}"),
                _ => "at the whole size".to_owned(),
            };
            html += &page::figure(picture, &format!("{shows}, {when}"), &format!("{when}: {energy}"))?;
        }
        Ok(html + "</div>\n")
    }

    /// The energy over steps, from the least to the most.
    fn curve(&self) -> String {
        let [width, height] = CURVE;
        let most = self.energy.iter().copied().max().unwrap_or(0);
        let least = self.energy.iter().copied().min().unwrap_or(0);
        let range = (most - least).max(1) as f64;
        let step = width / self.energy.len().saturating_sub(1).max(1) as f64;
        let point = |number: u64, energy: i64| (number as f64 * step, (most - energy) as f64 / range * height);
        let mut svg =
            format!("<svg viewBox=\"-8 -8 {} {}\" role=\"img\"><polyline points=\"", width + 16.0, height + 16.0);
        // No screen shows more points.
        let every = self.energy.len().div_ceil(MOST_POINTS).max(1);
        for (number, &energy) in (0..).zip(&self.energy).step_by(every) {
            let (x, y) = point(number, energy);
            let _ = write!(svg, "{x:.1},{y:.1} ");
        }
        svg += "\"/>";
        for step in self.steps.iter().filter(|_| self.levels == 1) {
            let (x, y) = point(step.number, step.energy);
            let _ = write!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>");
        }
        svg + "</svg>"
    }
}
