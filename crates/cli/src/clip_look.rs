//! A clip as one picture: frames, and slices through time, with the seam drawn.

use std::path::Path;

use selvedge_core::{Domain, Exemplars, Grid, Plane, Render as _, Role, Samples, SourceMap};

use crate::failure::Failure;
use crate::outputs::Outputs;
use crate::page;
use crate::report::Report;
use crate::session::Session;

/// Between pictures.
const GAP: usize = 6;
/// Of seams, and of the jump that was taken.
pub(crate) const RED: [u8; 3] = [255, 40, 40];

/// A picture that grows by others.
struct Sheet {
    size: [usize; 2],
    panels: Vec<([usize; 2], Panel)>,
}

/// Red, green and blue of a picture.
pub(crate) struct Panel {
    size: [usize; 2],
    pixels: Vec<[u8; 3]>,
}

/// What is shown.
pub(crate) struct Shown<'a> {
    /// Features of the output.
    pub(crate) output: &'a Grid<u8, 3>,
    pub(crate) map: &'a SourceMap<3>,
    /// Whether seams lie in space as well as in time.
    pub(crate) in_space: bool,
}

/// The features that an output has.
pub(crate) fn features(exemplars: &Exemplars<3>, map: &SourceMap<3>) -> Result<Grid<u8, 3>, Failure> {
    let copied = exemplars.sources().iter().map(|source| source.features.map(|v| v));
    let plane = |features: Grid<u8, 3>| Plane::new(Role::Scalar, Samples::U8(features));
    let planes = copied.map(|features| Ok(plane(features?))).collect::<Result<Vec<_>, Failure>>()?;
    let Samples::U8(output) = map.render(&planes.iter().collect::<Vec<_>>())?.samples else {
        return Err(Failure::new(70, "features are 8 bits"));
    };
    Ok(output)
}

/// Adds the page of a run, made by a command, with a picture of what it made.
pub(crate) fn add_page(
    outputs: &mut Outputs,
    session: &Session<'_>,
    report: &Report,
    (folder, command): (&Path, &str),
    (what, picture): (&str, Option<&Plane<2>>),
) -> Result<(), Failure> {
    let mut run = report.json(&[session.global.seed()], rayon::current_num_threads(), false);
    run["outputs"] = outputs.noted().into();
    let pictures: Vec<(&str, &Plane<2>)> = picture.map(|picture| (what, picture)).into_iter().collect();
    let page = page::page(&run, command, &pictures, "")?;
    outputs.bytes(&page::file(folder), page.into_bytes());
    Ok(())
}

impl Shown<'_> {
    /// The picture of `--preview`, with what else is to be seen below.
    pub(crate) fn picture(&self, more: Vec<Panel>) -> Result<Plane<2>, Failure> {
        let [frames, height, width] = self.output.domain().shape;
        let mut sheet = Sheet { size: [0, 0], panels: Vec::new() };
        let times = [0, frames / 2, frames - 1];
        sheet.row(times.map(|t| self.frame(t, false)).into());
        if self.in_space {
            sheet.row(times.map(|t| self.frame(t, true)).into());
        }
        let (rows, columns) = (height / 2, width / 2);
        sheet.row(vec![self.slice_x(rows, false), self.slice_x(rows, true)]);
        sheet.row(vec![self.slice_y(columns, false), self.slice_y(columns, true)]);
        if !more.is_empty() {
            sheet.row(more);
        }
        sheet.plane()
    }

    fn pixel(&self, at: [u32; 3]) -> [u8; 3] {
        let last = self.output.channels() - 1;
        [0, 1, 2].map(|c: usize| self.output.get(c.min(last), at))
    }

    /// Whether a seam is beside a position along one of these axes, of which time is always.
    fn is_drawn(&self, at: [u32; 3], axes: [usize; 2]) -> bool {
        axes.into_iter().any(|axis| (axis == 0 || self.in_space) && self.map.is_seam(at, axis))
    }

    fn frame(&self, t: u32, seam: bool) -> Panel {
        let [_, height, width] = self.output.domain().shape;
        let drawn = |at: [u32; 3]| seam && self.is_drawn(at, [1, 2]);
        Panel::of([width, height], |x, y| if drawn([t, y, x]) { RED } else { self.pixel([t, y, x]) })
    }

    /// Frames of a slice: two turns of a loop.
    fn turns(&self) -> u32 {
        self.output.domain().shape[0] * (1 + u32::from(self.map.domain().periodic[0]))
    }

    /// One row through two turns of the loop, time downwards.
    fn slice_x(&self, y: u32, seam: bool) -> Panel {
        let [frames, _, width] = self.output.domain().shape;
        let drawn = |t: u32, x: u32| seam && self.is_drawn([t, y, x], [0, 2]);
        Panel::of([width, self.turns()], |x, t| if drawn(t % frames, x) { RED } else { self.pixel([t % frames, y, x]) })
    }

    /// One column through two turns of the loop, time to the right.
    fn slice_y(&self, x: u32, seam: bool) -> Panel {
        let [frames, height, _] = self.output.domain().shape;
        let drawn = |t: u32, y: u32| seam && self.is_drawn([t, y, x], [0, 1]);
        Panel::of(
            [self.turns(), height],
            |t, y| if drawn(t % frames, y) { RED } else { self.pixel([t % frames, y, x]) },
        )
    }
}

impl Panel {
    pub(crate) fn of(size: [u32; 2], pixel: impl Fn(u32, u32) -> [u8; 3]) -> Self {
        let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        Self { size: size.map(|side| side as usize), pixels }
    }

    pub(crate) fn set(&mut self, [x, y]: [usize; 2], color: [u8; 3]) {
        self.pixels[y * self.size[0] + x] = color;
    }
}

impl Sheet {
    /// Puts panels beside each other below all others.
    fn row(&mut self, panels: Vec<Panel>) {
        let top = if self.panels.is_empty() { 0 } else { self.size[1] + GAP };
        let mut left = 0;
        for panel in panels {
            self.size = [self.size[0].max(left + panel.size[0]), self.size[1].max(top + panel.size[1])];
            let at = [left, top];
            left += panel.size[0] + GAP;
            self.panels.push((at, panel));
        }
    }

    fn plane(&self) -> Result<Plane<2>, Failure> {
        let [width, height] = self.size;
        let mut grid = Grid::try_filled(Domain::open([height as u32, width as u32]), 3, 255_u8)?;
        for (at, panel) in &self.panels {
            for (y, row) in panel.pixels.chunks(panel.size[0].max(1)).enumerate() {
                for c in 0..3 {
                    let to = &mut grid.plane_mut(c)[(at[1] + y) * width + at[0]..][..row.len()];
                    to.iter_mut().zip(row).for_each(|(to, pixel)| *to = pixel[c]);
                }
            }
        }
        Ok(Plane::new(Role::Color, Samples::U8(grid)))
    }
}
