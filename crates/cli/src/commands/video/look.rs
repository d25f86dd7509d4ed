//! A loop as one picture: frames, slices through time with the seam drawn, when each pixel jumps, and which jumps there
//! were.

use selvedge_core::{Domain, Exemplars, Grid, Plane, Render as _, Role, Samples, SourceMap, par};
use selvedge_graphcut_textures::video::{FrameDistances, Jump, Loop};

use crate::failure::Failure;

/// Between pictures.
const GAP: usize = 6;
/// Of seams, and of the jump that was taken.
const RED: [u8; 3] = [255, 40, 40];
/// Of other jumps.
const YELLOW: [u8; 3] = [255, 210, 0];
/// Longer clips have every so many frames in the matrix of distances.
const MATRIX: u32 = 256;

/// A picture that grows by others.
struct Sheet {
    size: [usize; 2],
    panels: Vec<([usize; 2], Panel)>,
}

/// Red, green and blue of a picture.
struct Panel {
    size: [usize; 2],
    pixels: Vec<[u8; 3]>,
}

/// What is shown.
pub(super) struct Shown<'a> {
    /// Features of the output.
    pub(super) output: &'a Grid<u8, 3>,
    pub(super) map: &'a SourceMap<3>,
    /// Of what was cut at a jump.
    pub(super) jumps: Option<Cut<'a>>,
}

/// A loop of one jump.
pub(super) struct Cut<'a> {
    pub(super) looped: &'a Loop,
    pub(super) distances: &'a FrameDistances<'a>,
    pub(super) jumps: &'a [Jump],
}

/// The features that an output of one clip has.
pub(super) fn features(exemplars: &Exemplars<3>, map: &SourceMap<3>) -> Result<Grid<u8, 3>, Failure> {
    let source = &exemplars.sources()[0].features;
    let plane = Plane::new(Role::Scalar, Samples::U8(source.map(|v| v)?));
    let Samples::U8(output) = map.render(&[&plane])?.samples else {
        return Err(Failure::new(70, "features are 8 bits"));
    };
    Ok(output)
}

impl Shown<'_> {
    /// The picture of `--preview`.
    pub(super) fn picture(&self) -> Result<Plane<2>, Failure> {
        let [frames, height, width] = self.output.domain().shape;
        let mut sheet = Sheet { size: [0, 0], panels: Vec::new() };
        sheet.row([0, frames / 2, frames - 1].map(|t| self.frame(t)).into());
        let (rows, columns) = (height as usize / 2, width as usize / 2);
        sheet.row(vec![self.slice_x(rows as u32, false), self.slice_x(rows as u32, true)]);
        sheet.row(vec![self.slice_y(columns as u32, false), self.slice_y(columns as u32, true)]);
        if let Some(cut) = &self.jumps {
            sheet.row(vec![cut.times(), cut.matrix()]);
        }
        sheet.plane()
    }

    fn pixel(&self, at: [u32; 3]) -> [u8; 3] {
        let last = self.output.channels() - 1;
        [0, 1, 2].map(|c: usize| self.output.get(c.min(last), at))
    }

    fn frame(&self, t: u32) -> Panel {
        let [_, height, width] = self.output.domain().shape;
        Panel::of([width, height], |x, y| self.pixel([t, y, x]))
    }

    /// Frames of a slice: two turns of a loop.
    fn turns(&self) -> u32 {
        self.output.domain().shape[0] * (1 + u32::from(self.map.domain().periodic[0]))
    }

    /// One row through two turns of the loop, time downwards.
    fn slice_x(&self, y: u32, seam: bool) -> Panel {
        let [frames, _, width] = self.output.domain().shape;
        let drawn = |t: u32, x: u32| seam && self.map.is_seam([t, y, x], 0);
        Panel::of([width, self.turns()], |x, t| if drawn(t % frames, x) { RED } else { self.pixel([t % frames, y, x]) })
    }

    /// One column through two turns of the loop, time to the right.
    fn slice_y(&self, x: u32, seam: bool) -> Panel {
        let [frames, height, _] = self.output.domain().shape;
        let drawn = |t: u32, y: u32| seam && self.map.is_seam([t, y, x], 0);
        Panel::of(
            [self.turns(), height],
            |t, y| if drawn(t % frames, y) { RED } else { self.pixel([t % frames, y, x]) },
        )
    }
}

impl Cut<'_> {
    /// When each pixel jumps: the earlier the darker.
    fn times(&self) -> Panel {
        let time = &self.looped.surface.time;
        let [height, width] = time.domain().shape;
        let (least, most) = time.samples().iter().fold((u16::MAX, 0), |(a, b), v| (a.min(*v), b.max(*v)));
        let grey = |v: u16| (u32::from(v - least) * 255 / u32::from(most - least).max(1)) as u8;
        Panel::of([width, height], |x, y| [grey(time.get(0, [y, x])); 3])
    }

    /// How much frames differ, the more the brighter, and the jumps.
    fn matrix(&self) -> Panel {
        let frames = self.distances.frames();
        let every = frames.div_ceil(MATRIX);
        let side = frames.div_ceil(every);
        // Frames may have to be compared for each.
        let between = |a: u32, b: u32| self.distances.between(a, b);
        let across = par::map_indexed(frames as usize / 2, |a| between(a as u32, frames - 1 - a as u32));
        let greatest = across.into_iter().max().unwrap_or(0).max(1);
        let row = |y: usize| (0..y as u32).map(|x| between(x * every, y as u32 * every)).collect::<Vec<u64>>();
        let rows = par::map_indexed(side as usize, row);
        let grey = |x: u32, y: u32| {
            let known = rows[x.max(y) as usize].get(x.min(y) as usize).copied().unwrap_or(0);
            [((known as f64 / greatest as f64).sqrt() * 255.0).min(255.0) as u8; 3]
        };
        let mut panel = Panel::of([side, side], grey);
        let chosen = std::iter::once((&self.looped.jump, RED));
        for (jump, color) in self.jumps.iter().map(|jump| (jump, YELLOW)).chain(chosen) {
            let (x, y) = ((jump.from / every) as usize, (jump.to / every) as usize);
            panel.pixels[y * panel.size[0] + x] = color;
        }
        panel
    }
}

impl Panel {
    fn of(size: [u32; 2], pixel: impl Fn(u32, u32) -> [u8; 3]) -> Self {
        let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        Self { size: size.map(|side| side as usize), pixels }
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
