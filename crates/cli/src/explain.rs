//! A source map for eyes: the seams, where every part came from, and what of the exemplars was used.

use selvedge_core::{Domain, Encoder, Error, Grid, Plane, Role, Samples, SourceMap};

/// White between the panels.
const GAP: u32 = 8;
/// The colour of a seam in the picture.
const SEAM: Rgb = [255, 40, 40];
/// What was never used.
const UNUSED: Rgb = [40, 40, 40];
/// Colours of an exemplar's corners: top left, top right, bottom left, bottom right.
const CORNERS: [Rgb; 4] = [[50, 90, 230], [40, 200, 120], [225, 60, 70], [250, 215, 60]];

type Rgb = [u8; 3];

/// Three panels side by side, 8-bit RGB: the picture with its seams; the picture in the colours of the places that its
/// parts came from; and the sources in those colours, dark where nothing was used.
///
/// # Errors
/// No memory for the panels.
pub(crate) fn explain(map: &SourceMap<2>, picture: &Plane<2>) -> Result<Plane<2>, Error> {
    let planes = std::slice::from_ref(picture);
    let features = Encoder::fit(&[planes])?.encode(planes)?;
    let sources = map.table.sources().iter().map(|(_, domain)| domain.shape);
    let [height, width] = map.domain().shape;
    let tall = sources.clone().map(|[h, _]| h + GAP).sum::<u32>().saturating_sub(GAP);
    let wide = sources.map(|[_, w]| w).max().unwrap_or(0);
    let shape = [height.max(tall), 2 * (width + GAP) + wide];
    let mut canvas = Canvas(Grid::try_filled(Domain::open(shape), 3, 255)?);
    for at in map.domain().positions() {
        let shown = color_of(&features, at);
        let seam = (0..2).any(|axis| map.is_seam(at, axis));
        canvas.paint(at, [0, 0], if seam { SEAM } else { shown.map(|v| 48 + v / 4 * 3) });
        canvas.paint(at, [0, width + GAP], origin_color(map, at, shown, seam));
    }
    legend(map, &mut canvas, 2 * (width + GAP))?;
    Ok(Plane::new(Role::Color, Samples::U8(canvas.0)))
}

struct Canvas(Grid<u8, 2>);

impl Canvas {
    fn paint(&mut self, at: [u32; 2], panel: [u32; 2], color: Rgb) {
        let at = [at[0] + panel[0], at[1] + panel[1]];
        (0..3).for_each(|c| self.0.set(c, at, color[c]));
    }
}

/// The sources below each other in the colours of their places.
fn legend(map: &SourceMap<2>, canvas: &mut Canvas, left: u32) -> Result<(), Error> {
    let mut used = selvedge_core::try_vec(map.table.len() as usize, false)?;
    let assigned = map.ids.plane(0).iter().filter(|id| id.is_assigned());
    assigned.for_each(|id| used[id.get() as usize] = true);
    let mut top = 0;
    for (source, (_, domain)) in map.table.sources().iter().enumerate() {
        for at in domain.positions() {
            let is_used = used[map.table.id(source, at).get() as usize];
            let color = if is_used { place_color(source, at, domain.shape) } else { UNUSED };
            canvas.paint(at, [top, left], color);
        }
        top += domain.shape[0] + GAP;
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

/// The picture's colour; grey as three equal channels.
fn color_of(features: &Grid<u8, 2>, at: [u32; 2]) -> Rgb {
    let last = features.channels() - 1;
    std::array::from_fn(|c| features.get(c.min(last), at))
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
        assert_eq!(out.domain().shape, [1, 4 + 8 + 4 + 8 + 4]);
        let color = |x: u32| [0, 1, 2].map(|c| out.get(c, [0, x]));
        assert_eq!([0, 1, 2, 3].map(|x| color(x) == SEAM), [false, true, false, false]);
        assert_eq!(color(12), color(14), "the same place in the same colour");
        assert_ne!(color(12), color(13));
        assert_eq!([24, 25, 26, 27].map(|x| color(x) == UNUSED), [false, false, true, true]);
        assert_eq!(color(24), CORNERS[0]);
        assert_eq!(color(4), [255; 3], "the gap");
    }
}
