//! A source map for eyes: the seams, where every part came from, and what of the exemplars was used.

use selvedge_core::{Domain, Error, Grid, Plane, Role, Samples, SourceMap};

use crate::eyes;
use crate::failure::Failure;

/// White between the panels.
const GAP: u32 = 8;
/// The colour of a seam in the picture.
const SEAM: Rgb = [255, 40, 40];
/// What was never used.
const UNUSED: Rgb = [40, 40, 40];
/// Colours of an exemplar's corners: top left, top right, bottom left, bottom right.
const CORNERS: [Rgb; 4] = [[50, 90, 230], [40, 200, 120], [225, 60, 70], [250, 215, 60]];

/// What its colours mean, for the page of `--report`.
pub(crate) const LEGEND: [(Rgb, &str); 6] = [
    (SEAM, "a seam"),
    (CORNERS[0], "from the top left of an exemplar"),
    (CORNERS[1], "its top right"),
    (CORNERS[2], "its bottom left"),
    (CORNERS[3], "its bottom right"),
    (UNUSED, "never used"),
];

type Rgb = [u8; 3];

/// Three panels, 8-bit RGB: the picture with its seams; the picture in the colours of the places that its parts came
/// from; and the sources in those colours, dark where nothing was used. They stand side by side, or below each other
/// where the picture is wider than high.
///
/// # Errors
/// No memory for the panels.
pub(crate) fn explain(map: &SourceMap<2>, picture: &Plane<2>) -> Result<Plane<2>, Failure> {
    let seen = eyes::eight(picture)?;
    let Samples::U8(shown_as) = &seen.samples else { return Err(eyes::not_eight()) };
    let colors = seen.color_channels();
    let sources = || map.table.sources().iter().map(|(_, domain)| domain.shape);
    let panels = Panels::new(map.domain().shape, sources());
    let shape = panels.shape.map(|side| u32::try_from(side).map_err(|_| Error::Allocation { bytes: side }));
    let [height, width] = shape;
    let mut canvas = Canvas(Grid::try_filled(Domain::open([height?, width?]), 3, 255)?);
    let [_, origins] = panels.pictures();
    for at in map.domain().positions() {
        let shown = std::array::from_fn(|c| shown_as.get(c.min(colors - 1), at));
        let seam = (0..2).any(|axis| map.is_seam(at, axis));
        canvas.paint(at, [0, 0], if seam { seam_over(shown) } else { shown.map(|v| 48 + v / 4 * 3) });
        canvas.paint(at, origins, origin_color(map, at, shown, seam));
    }
    legend(map, &mut canvas, &panels)?;
    Ok(Plane::new(Role::Color, Samples::U8(canvas.0)))
}

/// Height and width of an explanation, known before anything is read.
pub(crate) fn shape(output: [u32; 2], sources: impl Iterator<Item = [u32; 2]>) -> [u64; 2] {
    Panels::new(output, sources).shape
}

/// Where the panels stand.
struct Panels {
    output: [u64; 2],
    /// The axis along which panels follow each other.
    axis: usize,
    /// Height and width of all.
    shape: [u64; 2],
    /// Top left corner of each source's panel.
    sources: Vec<[u64; 2]>,
}

impl Panels {
    /// Sources stand in rows that are as long as the picture, or the longest source.
    fn new(output: [u32; 2], sources: impl Iterator<Item = [u32; 2]>) -> Self {
        let gap = u64::from(GAP);
        let output = output.map(u64::from);
        let (axis, along) = if output[0] < output[1] { (0, 1) } else { (1, 0) };
        let shapes: Vec<[u64; 2]> = sources.map(|s| s.map(u64::from)).collect();
        let length = shapes.iter().map(|s| s[along]).fold(output[along], u64::max);
        let first = 2 * (output[axis] + gap);
        let (mut begin, mut end, mut at) = (first, first, 0);
        let mut corners = Vec::new();
        for shape in &shapes {
            if length < at + shape[along] {
                (begin, at) = (end + gap, 0);
            }
            let mut corner = [0; 2];
            (corner[axis], corner[along]) = (begin, at);
            corners.push(corner);
            at += shape[along] + gap;
            end = end.max(begin + shape[axis]);
        }
        let mut shape = [0; 2];
        (shape[axis], shape[along]) = (end, length);
        Self { output, axis, shape, sources: corners }
    }

    /// Top left corners of the two pictures.
    fn pictures(&self) -> [[u64; 2]; 2] {
        let mut second = [0; 2];
        second[self.axis] = self.output[self.axis] + u64::from(GAP);
        [[0; 2], second]
    }
}

/// Half seam, half picture: where blocks are small, seams are everywhere.
fn seam_over(shown: Rgb) -> Rgb {
    std::array::from_fn(|c| u8::midpoint(SEAM[c], shown[c]))
}

struct Canvas(Grid<u8, 2>);

impl Canvas {
    fn paint(&mut self, at: [u32; 2], panel: [u64; 2], color: Rgb) {
        let at = [0, 1].map(|axis| at[axis] + panel[axis] as u32);
        (0..3).for_each(|c| self.0.set(c, at, color[c]));
    }
}

/// The sources in the colours of their places.
fn legend(map: &SourceMap<2>, canvas: &mut Canvas, panels: &Panels) -> Result<(), Error> {
    let mut used = selvedge_core::try_vec(map.table.len() as usize, false)?;
    let assigned = map.ids.plane(0).iter().filter(|id| id.is_assigned());
    assigned.for_each(|id| used[id.get() as usize] = true);
    for (source, (_, domain)) in map.table.sources().iter().enumerate() {
        for at in domain.positions() {
            let is_used = used[map.table.id(source, at).get() as usize];
            let color = if is_used { place_color(source, at, domain.shape) } else { UNUSED };
            canvas.paint(at, panels.sources[source], color);
        }
    }
    Ok(())
}

/// The colour of the place that a sample came from, with some of the picture's light in it.
fn origin_color(map: &SourceMap<2>, at: [u32; 2], shown: Rgb, seam: bool) -> Rgb {
    let Some((source, from)) = map.locate(at) else { return UNUSED };
    let place = place_color(source, from, map.table.sources()[source].1.shape);
    let light = shown.iter().map(|&v| u32::from(v)).sum::<u32>() / 3;
    let shade = if seam { 64 } else { 144 + light * 112 / 255 };
    place.map(|v| (u32::from(v) * shade / 256) as u8)
}

/// Between the colours of the four corners; each source has its own order of red, green and blue.
fn place_color(source: usize, [y, x]: [u32; 2], [height, width]: [u32; 2]) -> Rgb {
    let part = |p: u32, len: u32| u64::from(p) * 256 / u64::from(len.max(2) - 1);
    let (down, across) = (part(y, height), part(x, width));
    let weights = [(256 - down) * (256 - across), (256 - down) * across, down * (256 - across), down * across];
    std::array::from_fn(|c| {
        let sum: u64 = CORNERS.iter().zip(weights).map(|(corner, w)| u64::from(corner[(c + source) % 3]) * w).sum();
        (sum >> 16) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Exemplars, SampleId};

    #[test]
    fn seams_and_origins_are_drawn_and_what_is_unused_is_dark() {
        let grey = Grid::from_vec(Domain::open([1, 4]), 1, vec![200_u8; 4]).unwrap();
        let plane = Plane::new(Role::Scalar, Samples::U8(grey));
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, Domain::open([1, 4])).unwrap();
        map.ids.plane_mut(0).copy_from_slice(&[0, 1, 0, 1].map(SampleId::new));
        let Samples::U8(out) = explain(&map, &plane).unwrap().samples else { unreachable!() };
        assert_eq!(out.domain().shape, [1 + 8 + 1 + 8 + 1, 4]);
        let color = |y: u32, x: u32| [0, 1, 2].map(|c| out.get(c, [y, x]));
        assert_eq!([0, 1, 2, 3].map(|x| color(0, x) == seam_over([200; 3])), [false, true, false, false]);
        assert_eq!(color(9, 0), color(9, 2), "the same place in the same colour");
        assert_ne!(color(9, 0), color(9, 1));
        assert_eq!([0, 1, 2, 3].map(|x| color(18, x) == UNUSED), [false, false, true, true]);
        assert_eq!(color(18, 0), CORNERS[0]);
        assert_eq!(color(4, 0), [255; 3], "the gap");
    }

    #[test]
    fn panels_waste_no_more_than_a_row_and_never_overlap() {
        let strips = [[16, 4000]; 8];
        assert_eq!(shape([16, 65_000], strips.into_iter()), [16 + 8 + 16 + 8 + 16, 65_000]);
        assert_eq!(shape([100, 80], [[50, 60], [42, 30], [50, 20]].into_iter()), [100, 80 + 8 + 80 + 8 + 60 + 8 + 20]);
        let far = shape([u32::MAX; 2], [[u32::MAX; 2]; 3].into_iter());
        assert_eq!(far[1], 5 * u64::from(u32::MAX) + 4 * 8);
        let panels = Panels::new([30, 90], [[10, 40], [20, 40], [5, 90], [7, 3]].into_iter());
        assert_eq!(panels.sources, [[76, 0], [76, 48], [104, 0], [117, 0]]);
        assert_eq!(panels.shape, [124, 90]);
    }
}
