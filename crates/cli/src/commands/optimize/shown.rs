//! What the page of `--report` says of a run: its energy, what each level ended with, and how far all is from the
//! exemplars in the end. `[Kwatra05 fig. 3]`

use std::sync::{Mutex, PoisonError};

use selvedge_core::{Bytes, Domain, Event, Exemplars, Grid, Observer, Plane, Render, Role, Samples, SourceMap};
use selvedge_texture_optimization::Stats;

use super::levels::typed;
use crate::course::{self, Course, Words};
use crate::watch::Watch;

const COURSE: Words = Words {
    stages: &[],
    counts: true,
    heading: "Course",
    energy: "Energy, in squared grey levels of a sample",
    begun: "",
    steps: ["iteration", "iterations"],
    shows: "So far",
    legend: "What each level ended with, as the heaviest sample of each place; and how far neighborhoods are from the \
             nearest of the exemplars in the end: black is not at all, white as far as all but a fiftieth are at most",
    of_all: "",
};

/// Hands events on, and keeps a picture of what each level ends with.
pub(super) struct Film<'w> {
    watch: &'w Watch,
    exemplars: &'w Exemplars<2>,
    /// Channels of features that are colours.
    colors: usize,
    pictures: Mutex<Vec<Plane<2>>>,
}

impl<'w> Film<'w> {
    pub(super) fn new(watch: &'w Watch, exemplars: &'w Exemplars<2>, colors: usize) -> Self {
        Self { watch, exemplars, colors, pictures: Mutex::default() }
    }

    /// Ends with what a run counted.
    pub(super) fn course(self, stats: &Stats) -> Course {
        let energy: Vec<i64> = stats.levels.iter().flat_map(|l| &l.energy).map(|&e| (e + 0.5) as i64).collect();
        let ends = stats.levels.iter().scan(0, |done, level| {
            *done += level.energy.len();
            Some((*done - 1, typed(&[level.level])))
        });
        let pictures = self.pictures.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut all: Vec<_> = ends.zip(pictures).map(|((number, level), picture)| (number, level, picture)).collect();
        let far = stats.distances.as_ref().and_then(far);
        all.extend(far.map(|picture| (energy.len().saturating_sub(1), "distances".to_owned(), picture)));
        Course::new(&COURSE, energy, all)
    }

    /// Every so many samples of a map where it is large.
    fn drawn(&self, map: &SourceMap<2>) -> Option<Plane<2>> {
        let side = course::side(map.domain());
        let shown = Domain::open(map.domain().shape.map(|n| n.div_ceil(side)));
        let channels = if self.colors < 3 { 1 } else { 3 };
        let mut grid = Grid::try_filled(shown, channels, 0).ok()?;
        for at in shown.positions() {
            let Some((source, from)) = self.exemplars.locate(map.ids.get(0, at.map(|p| p * side))) else { continue };
            let features = &self.exemplars.sources()[source].features;
            (0..channels).for_each(|c| grid.set(c, at, features.get(c, from)));
        }
        Some(Plane::new(if channels == 1 { Role::Scalar } else { Role::Color }, Samples::U8(grid)))
    }
}

impl Observer<2> for Film<'_> {
    fn event(&self, event: &Event<'_, 2>) {
        self.watch.event(event);
        let picture = event.so_far.and_then(Render::as_map).and_then(|map| self.drawn(map));
        self.pictures.lock().unwrap_or_else(PoisonError::into_inner).extend(picture);
    }

    fn cancelled(&self) -> bool {
        Observer::<2>::cancelled(self.watch)
    }
}

/// Distances as tones of their roots.
fn far(distances: &Grid<f32, 2>) -> Option<Plane<2>> {
    let mut sorted: Vec<f32> = distances.samples().to_vec();
    sorted.sort_by(f32::total_cmp);
    let white = sorted.get(sorted.len() * 49 / 50)?.max(1.0);
    let tones = distances.map(|d| (255.0 * (d / white).sqrt()).min(255.0) as u8).ok()?;
    Some(Plane::new(Role::Scalar, Samples::U8(tones)))
}

/// Bytes that it takes.
pub(super) fn bytes(output: Domain<2>) -> Bytes {
    course::pictures(output, 3) + Bytes::of_samples(output, 4)
}
