//! What a run shows besides its picture: what it has of what lies under the exemplars, and how it came about.
//! `[CMS III]`

use selvedge_cms_analogies::{Constraint, Plan, Stats};
use selvedge_core::{Domain, Exemplars, Grid, Guide, Plane, Role, Run, SampleId, Samples, SourceMap, Start, Woven};

use super::palette::Palette;
use super::told::failure;
use crate::course::{self, Course, Film, Words};
use crate::failure::Failure;
use crate::loom::Loom;

/// What the page of `--report` says of a run's course.
const COURSE: Words = Words {
    stages: &["cms/expand"],
    counts: true,
    heading: "Course",
    energy: "Disagreement and seams together at the whole size",
    begun: " once everything was covered",
    steps: ["label", "labels"],
    shows: "So far",
    legend: "What was there, and beside it what that is under the exemplars, where it is to be what is followed",
    of_all: "",
};
/// Bytes of a sample of a picture of the course: two of three channels.
const OF_PICTURE: u64 = 2 * 3;
/// Paper between the two.
const GAP: u32 = 4;

/// Bytes that a course and its page take.
pub(in crate::commands) fn bytes(output: Domain<2>) -> selvedge_core::Bytes {
    course::pictures(output, OF_PICTURE)
}

/// `O_Q`: what lies under the exemplars, as a map lays it. Labels that are channels have their colours.
pub(super) fn mapped(
    constraint: &Constraint,
    map: &SourceMap<2>,
    palette: Option<&Palette>,
) -> Result<Plane<2>, Failure> {
    let under = Under { guide: &constraint.guide, palette };
    let channels = if under.is_grey() { 1 } else { 3 };
    let mut grid = Grid::try_filled(map.domain(), channels, 0)?;
    for (i, id) in map.ids.plane(0).iter().enumerate() {
        let color = under.color(*id);
        (0..channels).for_each(|c| grid.plane_mut(c)[i] = color[c]);
    }
    let role = if channels == 1 { Role::Scalar } else { Role::Color };
    Ok(Plane::new(role, Samples::U8(grid)))
}

/// Does a plan; with its course, where a page is written.
pub(in crate::commands) fn woven(
    loom: &Loom<'_>,
    plan: &Plan<'_>,
    start: &Start<2>,
    palette: Option<&Palette>,
) -> Result<(Woven<SourceMap<2>, Stats>, Option<Course>), Failure> {
    let run = loom.session.run();
    if loom.args.report.is_none() {
        return Ok((plan.weave_from(start, &run).map_err(failure)?, None));
    }
    let under = Under { guide: &plan.constraints()[0].guide, palette };
    let (exemplars, colors) = (&loom.loaded.exemplars, loom.loaded.payload[0].color_channels());
    let draw = move |map: &SourceMap<2>| beside(map, &|id| color(exemplars, colors, id), &|id| under.color(id));
    let film = Film::new(&loom.session.watch, &COURSE, Box::new(draw));
    let woven = plan.weave_from(start, &Run { observer: &film, ..run }).map_err(failure)?;
    let course = film.course(&woven.result, &woven.stats.energy, 1);
    Ok((woven, Some(course)))
}

/// A map by two colours of each sample, side by side, every so many samples where it is large.
fn beside(
    map: &SourceMap<2>,
    left: &dyn Fn(SampleId) -> [u8; 3],
    right: &dyn Fn(SampleId) -> [u8; 3],
) -> Option<Plane<2>> {
    let side = course::side(map.domain());
    let [height, width] = map.domain().shape.map(|n| n.div_ceil(side));
    let mut grid = Grid::try_filled(Domain::open([height, 2 * width + GAP]), 3, 255).ok()?;
    for [y, x] in Domain::open([height, width]).positions() {
        let id = map.ids.get(0, [y * side, x * side]);
        for (color, x) in [(left(id), x), (right(id), x + width + GAP)] {
            (0..3).for_each(|c| grid.set(c, [y, x], color[c]));
        }
    }
    Some(Plane::new(Role::Color, Samples::U8(grid)))
}

/// What lies under the exemplars.
struct Under<'a> {
    guide: &'a Guide<2>,
    palette: Option<&'a Palette>,
}

impl Under<'_> {
    fn is_grey(&self) -> bool {
        self.palette.is_none() && self.guide.weights().len() < 3
    }

    fn color(&self, id: SampleId) -> [u8; 3] {
        let (exemplars, channels) = (self.guide.exemplars(), self.guide.weights().len());
        match self.palette {
            Some(palette) => {
                let label = (0..channels).max_by_key(|&c| feature(exemplars, id, c));
                palette.color(label.unwrap_or_default())
            }
            None => color(exemplars, channels, id),
        }
    }
}

/// A sample as its features of so many colours show it; black for nothing.
fn color(exemplars: &Exemplars<2>, colors: usize, id: SampleId) -> [u8; 3] {
    std::array::from_fn(|c| feature(exemplars, id, if colors < 3 { 0 } else { c }))
}

fn feature(exemplars: &Exemplars<2>, id: SampleId, channel: usize) -> u8 {
    exemplars.locate(id).map_or(0, |(source, at)| exemplars.sources()[source].features.get(channel, at))
}
