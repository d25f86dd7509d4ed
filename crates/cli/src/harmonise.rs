//! Exemplars of different depths and channels made alike, without loss.

use std::path::{Path, PathBuf};

use selvedge_core::{Association, Depth, Grid, Plane, Role, Samples};
use selvedge_io::{Info, Metadata};

use crate::failure::{Failure, shown};
use crate::session::Session;
use crate::wrong::Wrong;

/// The depth that holds the samples of all pictures as they are: the deeper of two integers or of two floats.
///
/// Integers are encoded colour and floats are linear light: between them somebody has to choose.
pub(crate) fn common_depth<'a>(depths: impl IntoIterator<Item = (&'a Path, Depth)>) -> Result<Depth, Failure> {
    let mut depths = depths.into_iter();
    let Some((first, mut common)) = depths.next() else { return Ok(Depth::U8) };
    let float = |depth| matches!(depth, Depth::F16 | Depth::F32);
    for (path, depth) in depths {
        if float(depth) != float(common) {
            let (found, other) = (depth.name(), common.name());
            let what = format!("has {found} samples, but '{}' has {other}", shown(first));
            return Err(Failure::new(3, what).about(path).remedy("use --depth float or --depth u16 to convert all"));
        }
        common = common.max(depth);
    }
    Ok(common)
}

/// Channels of a picture: of colour, and whether alpha comes after them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) colors: usize,
    pub(crate) alpha: bool,
}

impl Layout {
    /// The layout that a header tells of.
    pub(crate) fn of(info: &Info) -> Self {
        Self { colors: info.channels - usize::from(info.alpha), alpha: info.alpha }
    }

    /// Channels in all.
    pub(crate) fn channels(self) -> usize {
        self.colors + usize::from(self.alpha)
    }
}

/// The layout that holds all pictures as they are: grey becomes RGB of three equal channels, and what has no alpha is
/// opaque.
pub(crate) fn common_layout<'a>(layouts: impl IntoIterator<Item = (&'a Path, Layout)>) -> Result<Layout, Failure> {
    let mut layouts = layouts.into_iter();
    let Some((first, mut common)) = layouts.next() else { return Ok(Layout { colors: 1, alpha: false }) };
    for (path, layout) in layouts {
        let (least, most) = (common.colors.min(layout.colors), common.colors.max(layout.colors));
        if least != most && (least, most) != (1, 3) {
            let what = format!("has {} channels, but '{}' has {}", layout.colors, shown(first), common.colors);
            return Err(Failure::new(3, what).about(path).remedy("give pictures with equal channels, or grey and RGB"));
        }
        common = Layout { colors: most, alpha: common.alpha || layout.alpha };
    }
    Ok(common)
}

/// Full alpha in each depth. In binary16 it is exponent 15, as it is biased.
pub(crate) const OPAQUE: (u8, u16, u16, f32) = (255, 65_535, 15 << 10, 1.0);

/// The plane with the channels of a layout that holds it, but for alpha, which may be left out.
pub(crate) fn widened<const D: usize>(plane: Plane<D>, to: Layout) -> Result<Plane<D>, Failure> {
    if (Layout { colors: plane.color_channels(), alpha: plane.alpha }) == to {
        return Ok(plane);
    }
    let (colors, alpha) = (plane.color_channels(), plane.alpha);
    let samples = match &plane.samples {
        Samples::U8(g) => Samples::U8(channels(g, colors, alpha, to, OPAQUE.0)?),
        Samples::U16(g) => Samples::U16(channels(g, colors, alpha, to, OPAQUE.1)?),
        Samples::F16(g) => Samples::F16(channels(g, colors, alpha, to, OPAQUE.2)?),
        Samples::F32(g) => Samples::F32(channels(g, colors, alpha, to, OPAQUE.3)?),
    };
    Ok(Plane { samples, alpha: to.alpha, ..plane })
}

/// The same picture with alpha: nothing shows where it `hides`, nor stands there: light without alpha would shine.
pub(crate) fn hidden(plane: Plane<2>, hides: impl Fn(usize) -> bool) -> Result<Plane<2>, Failure> {
    let colors = plane.color_channels();
    let mut plane = widened(plane, Layout { colors, alpha: true })?;
    for c in 0..=colors {
        match &mut plane.samples {
            Samples::U8(grid) => fill(grid.plane_mut(c), &hides, 0),
            Samples::U16(grid) | Samples::F16(grid) => fill(grid.plane_mut(c), &hides, 0),
            Samples::F32(grid) => fill(grid.plane_mut(c), &hides, 0.0),
        }
    }
    Ok(plane)
}

/// Sets samples to a value where it is to be.
pub(crate) fn fill<T: Copy>(samples: &mut [T], at: impl Fn(usize) -> bool, value: T) {
    samples.iter_mut().enumerate().filter(|(i, _)| at(*i)).for_each(|(_, v)| *v = value);
}

fn channels<T: Copy, const D: usize>(
    grid: &Grid<T, D>,
    colors: usize,
    alpha: bool,
    to: Layout,
    opaque: T,
) -> Result<Grid<T, D>, Failure> {
    let mut out = Grid::try_filled(grid.domain(), to.channels(), opaque)?;
    for c in 0..to.colors {
        out.plane_mut(c).copy_from_slice(grid.plane(if colors == 1 { 0 } else { c }));
    }
    if alpha && to.alpha {
        out.plane_mut(to.colors).copy_from_slice(grid.plane(colors));
    }
    Ok(out)
}

/// A plane in another depth; says how much was lost.
pub(crate) fn converted(
    session: &Session<'_>,
    path: &Path,
    plane: Plane<2>,
    depth: Depth,
    (metadata, stops): (&Metadata, f64),
) -> Result<Plane<2>, Failure> {
    if plane.samples.depth() == depth {
        return Ok(plane);
    }
    let plane = if is_integer(depth) { exposed(path, plane, stops)? } else { plane };
    let converted = selvedge_io::convert(&plane, depth, metadata).map_err(|p| Failure::from_problem(path, p))?;
    if converted.clipped != 0 {
        let what = format!("{} sample(s) are beyond what {} holds and were clipped", converted.clipped, depth.name());
        session.warn(path, &what);
    }
    converted.warnings.iter().for_each(|warning| session.warn(path, warning));
    Ok(converted.plane)
}

/// True for samples that are integers.
pub(crate) fn is_integer(depth: Depth) -> bool {
    matches!(depth, Depth::U8 | Depth::U16)
}

/// Light of floats, so many stops brighter; all else stays as it is.
fn exposed(path: &Path, plane: Plane<2>, stops: f64) -> Result<Plane<2>, Failure> {
    if stops == 0.0 || plane.role != Role::Color || is_integer(plane.samples.depth()) {
        return Ok(plane);
    }
    let wide = selvedge_io::convert(&plane, Depth::F32, &Metadata::default());
    let mut plane = wide.map_err(|p| Failure::from_problem(path, p))?.plane;
    let (colors, factor) = (plane.color_channels(), libm::exp2(stops));
    if let Samples::F32(grid) = &mut plane.samples {
        for c in 0..colors {
            grid.plane_mut(c).iter_mut().for_each(|v| *v = (f64::from(*v) * factor) as f32);
        }
    }
    Ok(plane)
}

/// A number of stops.
pub(crate) fn stops(text: &str) -> Result<f64, Wrong> {
    // Beyond these nothing that a half holds is left between black and white.
    let stops = text.parse().ok().filter(|stops: &f64| stops.abs() <= 64.0);
    stops.ok_or_else(|| Wrong::new(format!("'{text}' is no exposure"), "write stops from -64 to 64, such as -1.5"))
}

/// How colour and alpha go together in pictures that are to be alike, by whether they have alpha: multiplied if that is
/// so in all, since light without alpha cannot be told otherwise.
pub(crate) fn common_association(all: impl IntoIterator<Item = (bool, Association)>) -> Association {
    let mut with_alpha = all.into_iter().filter(|(alpha, _)| *alpha).map(|(_, association)| association).peekable();
    let multiplied = with_alpha.peek().is_some() && with_alpha.all(|a| a == Association::Premultiplied);
    if multiplied { Association::Premultiplied } else { Association::Straight }
}

/// Planes whose colours stand to alpha in the same way.
pub(crate) fn alike(session: &Session<'_>, paths: &[PathBuf], planes: Vec<Plane<2>>) -> Result<Vec<Plane<2>>, Failure> {
    let common = common_association(planes.iter().map(|plane| (plane.alpha, plane.association)));
    paths.iter().zip(planes).map(|(path, plane)| associated(session, path, plane, common)).collect()
}

pub(crate) fn associated(
    session: &Session<'_>,
    path: &Path,
    plane: Plane<2>,
    to: Association,
) -> Result<Plane<2>, Failure> {
    if !plane.alpha || plane.association == to {
        return Ok(plane);
    }
    // An opaque picture is both.
    if plane.is_opaque() {
        return Ok(Plane { association: to, ..plane });
    }
    session.warn(
        path,
        &match to {
            Association::Straight => "its colours were divided by alpha, to be straight as those of the others",
            Association::Premultiplied => "its colours were multiplied by alpha, as those of the others",
        },
    );
    let associated = selvedge_io::associate(&plane, to).map_err(|p| Failure::from_problem(path, p))?;
    Ok(associated.plane)
}

#[cfg(test)]
mod tests {
    use selvedge_core::{Domain, Role};

    use super::*;

    #[test]
    fn depths_go_to_the_deeper_of_a_kind() {
        let common = |depths: &[Depth]| common_depth(depths.iter().map(|d| (Path::new("a"), *d))).ok();
        assert_eq!(common(&[Depth::U8, Depth::U16, Depth::U8]), Some(Depth::U16));
        assert_eq!(common(&[Depth::F32, Depth::F16]), Some(Depth::F32));
        assert_eq!(common(&[Depth::F16, Depth::U8]), None);
    }

    #[test]
    fn where_nothing_shows_nothing_stands() {
        let light = Grid::from_vec(Domain::open([1, 2]), 1, vec![2.5_f32, 0.5]).unwrap();
        let shown = hidden(Plane::new(Role::Color, Samples::F32(light)), |i| i == 0).unwrap();
        let Samples::F32(grid) = &shown.samples else { unreachable!() };
        assert_eq!(grid.samples(), [0.0, 0.5, 0.0, 1.0]);
    }

    #[test]
    fn grey_becomes_rgb_and_opaque() {
        let grey = Grid::from_vec(Domain::open([1, 2]), 1, vec![7_u16, 9]).unwrap();
        let plane = Plane::new(Role::Color, Samples::U16(grey));
        let to = Layout { colors: 3, alpha: true };
        let wide = widened(plane, to).unwrap();
        assert!(wide.alpha);
        let Samples::U16(grid) = &wide.samples else { unreachable!() };
        assert_eq!(grid.samples(), [7, 9, 7, 9, 7, 9, 65_535, 65_535]);
        assert_eq!(widened(wide.clone(), to), Ok(wide));
    }

    #[test]
    fn other_channels_do_not_mix() {
        let common = |colors: &[usize]| {
            common_layout(colors.iter().map(|&colors| (Path::new("a"), Layout { colors, alpha: colors == 1 }))).ok()
        };
        assert_eq!(common(&[3, 1, 3]), Some(Layout { colors: 3, alpha: true }));
        assert_eq!(common(&[2, 2]), Some(Layout { colors: 2, alpha: false }));
        assert_eq!(common(&[2, 3]), None);
    }

    #[test]
    fn opaque_is_one_in_any_depth() {
        let one = Grid::from_vec(Domain::open([1, 1]), 1, vec![1.0_f32]).unwrap();
        let one = Plane::new(Role::Scalar, Samples::F32(one));
        for depth in [Depth::U8, Depth::U16, Depth::F16, Depth::F32] {
            let grey = selvedge_io::convert(&one, depth, &Default::default()).unwrap().plane;
            let wide = widened(grey.clone(), Layout { colors: 1, alpha: true }).unwrap();
            assert_eq!(wide.samples.value(1, 0), grey.samples.value(0, 0), "{}", depth.name());
        }
    }
}
