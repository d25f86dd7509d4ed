//! Flipbooks: all frames of a clip beside each other in one picture, rows from the top, as game engines play them.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use selvedge_core::{Domain, Grid, Plane, Samples};

use super::info::{ClipInfo, FrameEncoder, Frames, Layout};
use super::problem::ClipProblem;
use crate::error::{Error, Problem};
use crate::read::read;
use crate::{Metadata, ReadOptions, Warning, WriteOptions, encode};

/// How frames lie in a flipbook.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flipbook {
    /// Frames beside each other.
    pub columns: u32,
    /// Frames below each other.
    pub rows: u32,
    /// Pixels around each frame that repeat its border, so that a filter finds none of its neighbours there.
    pub pad: u32,
}

impl Flipbook {
    /// Frames that it holds at most.
    pub fn cells(self) -> u32 {
        self.columns.saturating_mul(self.rows)
    }

    /// Width and height of the whole picture.
    pub(super) fn size(self, [width, height]: [u32; 2]) -> [u32; 2] {
        let side = |count: u32, side: u32| count.saturating_mul(side.saturating_add(2 * self.pad));
        [side(self.columns, width), side(self.rows, height)]
    }

    /// Width and height of the frames in a picture.
    fn frame_size(self, [width, height]: [u32; 2]) -> Result<[u32; 2], Problem> {
        let wrong = ClipProblem::Cells { width, height, columns: self.columns, rows: self.rows, pad: self.pad };
        let side = |whole: u32, count: u32| {
            let cell = whole.checked_div(count).filter(|_| whole.is_multiple_of(count))?;
            cell.checked_sub(2 * self.pad).filter(|side| 0 < *side)
        };
        match (side(width, self.columns), side(height, self.rows)) {
            (Some(width), Some(height)) => Ok([width, height]),
            _ => Err(wrong.into()),
        }
    }

    /// Where the cell of a frame begins, for cells of frames of this size.
    fn at(self, frame: u32, [width, height]: [u32; 2]) -> [u32; 2] {
        [frame % self.columns * (width + 2 * self.pad), frame / self.columns * (height + 2 * self.pad)]
    }
}

impl fmt::Display for Flipbook {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.columns, self.rows)
    }
}

/// `8x8`: columns and rows, without padding.
impl FromStr for Flipbook {
    type Err = ClipProblem;

    fn from_str(text: &str) -> Result<Self, ClipProblem> {
        let count = |text: &str| text.parse::<u32>().ok().filter(|count| (1..=4096).contains(count));
        let parsed = text.split_once(['x', 'X']).and_then(|(columns, rows)| Some((count(columns)?, count(rows)?)));
        let (columns, rows) = parsed.ok_or_else(|| ClipProblem::Flipbook { text: text.to_owned() })?;
        Ok(Self { columns, rows, pad: 0 })
    }
}

/// A flipbook that grows by frames; what no frame fills is 0.
pub(super) struct FlipbookWriter {
    path: PathBuf,
    layout: Flipbook,
    options: WriteOptions,
    metadata: Metadata,
    /// `None` before the first frame.
    sheet: Option<Plane<2>>,
    taken: u32,
}

impl FlipbookWriter {
    pub(super) fn new(path: &Path, layout: Flipbook, options: &WriteOptions, metadata: Metadata) -> Self {
        Self { path: path.to_path_buf(), layout, options: options.clone(), metadata, sheet: None, taken: 0 }
    }
}

impl FrameEncoder for FlipbookWriter {
    fn frame(&mut self, plane: &Plane<2>) -> Result<(), Problem> {
        let [height, width] = plane.domain().shape;
        let sheet = match &mut self.sheet {
            Some(sheet) => sheet,
            None => {
                let [w, h] = self.layout.size([width, height]);
                self.sheet.insert(empty(plane, Domain::open([h, w]))?)
            }
        };
        let (at, pad) = (self.layout.at(self.taken, [width, height]), self.layout.pad);
        match (&mut sheet.samples, &plane.samples) {
            (Samples::U8(to), Samples::U8(from)) => lay(to, from, at, pad),
            (Samples::U16(to), Samples::U16(from)) | (Samples::F16(to), Samples::F16(from)) => lay(to, from, at, pad),
            (Samples::F32(to), Samples::F32(from)) => lay(to, from, at, pad),
            _ => return Err(Problem::DepthNotHeld { format: crate::Format::Png, depth: plane.samples.depth() }),
        }
        self.taken += 1;
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Vec<u8>, Problem> {
        let sheet = self.sheet.ok_or(Problem::Empty)?;
        encode(&sheet, &self.metadata, &self.path, &self.options).map_err(|e| e.problem)
    }
}

/// A picture like a frame, of another size and black.
fn empty(like: &Plane<2>, domain: Domain<2>) -> Result<Plane<2>, Problem> {
    let samples = Samples::try_zeros(domain, like.samples.channels(), like.samples.depth())?;
    Ok(Plane { role: like.role, samples, alpha: like.alpha, association: like.association })
}

/// Lays a frame into its cell, and its border around it.
fn lay<T: Copy>(to: &mut Grid<T, 2>, from: &Grid<T, 2>, [left, top]: [u32; 2], pad: u32) {
    let ([height, width], whole) = (from.domain().shape, to.domain().shape[1] as usize);
    let inside = |v: u32, side: u32| v.saturating_sub(pad).min(side - 1);
    for c in 0..from.channels() {
        let plane = to.plane_mut(c);
        for y in 0..height + 2 * pad {
            let row = &mut plane[(top + y) as usize * whole + left as usize..][..(width + 2 * pad) as usize];
            for (x, v) in (0..).zip(row) {
                *v = from.get(c, [inside(y, height), inside(x, width)]);
            }
        }
    }
}

/// The frames of a flipbook.
pub(super) struct Cells {
    layout: Flipbook,
    sheet: Plane<2>,
    size: [u32; 2],
    blake3: String,
    warnings: Vec<Warning>,
    at: u32,
}

impl Cells {
    /// Reads a picture of all frames.
    pub(super) fn open(path: &Path, layout: Flipbook, options: &ReadOptions) -> Result<(ClipInfo, Self), Error> {
        let picture = read(path, options)?;
        let [height, width] = picture.plane.domain().shape;
        let size = layout.frame_size([width, height]).map_err(|p| Error::new(path, p))?;
        let [width, height] = size;
        let frame = Layout { width, height, ..Layout::of(&picture.plane) };
        let info = frame.info(layout.cells(), picture.metadata, format!("flipbook of {layout}"));
        let (sheet, blake3, warnings) = (picture.plane, picture.blake3, picture.warnings);
        Ok((info, Self { layout, sheet, size, blake3, warnings, at: 0 }))
    }
}

impl Frames for Cells {
    fn next(&mut self) -> Result<Option<Plane<2>>, Error> {
        if self.at == self.layout.cells() {
            return Ok(None);
        }
        let [x, y] = self.layout.at(self.at, self.size).map(|v| v + self.layout.pad);
        self.at += 1;
        let cut = cut(&self.sheet, [x, y], self.size);
        cut.map(Some).map_err(|p| Error::new(Path::new("flipbook"), p))
    }

    fn rewind(&mut self) -> Result<(), Error> {
        self.at = 0;
        Ok(())
    }

    fn blake3(&self) -> String {
        self.blake3.clone()
    }

    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
}

/// A part of a picture.
fn cut(sheet: &Plane<2>, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> Result<Plane<2>, Problem> {
    fn part<T: Copy>(from: &Grid<T, 2>, to: &mut Grid<T, 2>, [x, y]: [u32; 2]) {
        let domain = to.domain();
        for c in 0..from.channels() {
            for (v, [row, column]) in to.plane_mut(c).iter_mut().zip(domain.positions()) {
                *v = from.get(c, [y + row, x + column]);
            }
        }
    }
    let mut frame = empty(sheet, Domain::open([height, width]))?;
    match (&sheet.samples, &mut frame.samples) {
        (Samples::U8(from), Samples::U8(to)) => part(from, to, [x, y]),
        (Samples::U16(from), Samples::U16(to)) | (Samples::F16(from), Samples::F16(to)) => part(from, to, [x, y]),
        (Samples::F32(from), Samples::F32(to)) => part(from, to, [x, y]),
        _ => {}
    }
    Ok(frame)
}
