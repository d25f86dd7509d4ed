//! `selvedge extend`: a picture made larger, what it shows goes on around it. `[Kwatra03 6B]`

use clap::{Args, ValueEnum};
use selvedge_core::{Bytes, Domain, Grid};
use selvedge_graphcut_textures::labels::extend;

use crate::commands::fill::{Fill, check_opaque, counts, start};
use crate::failure::{Failure, n};
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::options::option;
use crate::outcome::Outcome;
use crate::output_size::OutputSize;
use crate::session::Session;
use crate::setup::Setup;
use crate::size::Size;

const FUSE: &str = "Fuse patches: they are raised and lowered until they meet, and keep their detail";
const SPLINE: &str = "Spline seams over this many bands of detail, up to 5, or 'auto': coarse detail is blended widely, \
    fine detail closely";

/// Options of `extend`.
#[derive(Args, Debug)]
#[command(mut_args(option("fuse", |arg| arg.help(FUSE))))]
#[command(mut_args(option("spline", |arg| arg.help(SPLINE))))]
#[command(mut_arg("mask", |arg| arg
    .help("What of the picture to fill as well: white, from half of full light on. Default: what is transparent")))]
pub(crate) struct Extend {
    #[command(flatten)]
    fill: Fill,
    /// Size of the output: 1024, 1024x768, or a factor of the picture such as 1.5x.
    #[arg(long, value_name = "SIZE")]
    size: Size,
    /// Where in the output the picture lies.
    #[arg(long, value_enum, ignore_case = true, value_name = "WHERE", default_value_t = Anchor::C)]
    anchor: Anchor,
}

/// Where a smaller picture lies in a larger one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Anchor {
    /// In the middle.
    C,
    /// In the middle of the upper side.
    N,
    /// In the upper right corner.
    Ne,
    /// In the middle of the right side.
    E,
    /// In the lower right corner.
    Se,
    /// In the middle of the lower side.
    S,
    /// In the lower left corner.
    Sw,
    /// In the middle of the left side.
    W,
    /// In the upper left corner.
    Nw,
}

impl Anchor {
    /// The first sample of a picture of a shape in an output that is not smaller.
    fn place(self, picture: [u32; 2], output: [u32; 2]) -> [u32; 2] {
        let halves = match self {
            Self::Nw => [0, 0],
            Self::N => [0, 1],
            Self::Ne => [0, 2],
            Self::W => [1, 0],
            Self::C => [1, 1],
            Self::E => [1, 2],
            Self::Sw => [2, 0],
            Self::S => [2, 1],
            Self::Se => [2, 2],
        };
        [0, 1].map(|axis| {
            let more = output[axis] - picture[axis];
            // Of an odd number the smaller half is above and to the left.
            if halves[axis] == 2 { more } else { more / 2 * halves[axis] }
        })
    }
}

impl Method for Extend {
    fn setup(&self, session: &Session<'_>) -> Result<Setup<'_>, Failure> {
        let size = OutputSize::First(Some(self.size));
        let (blending, of_planes) = (self.fill.blending, None);
        Ok(Setup { command: "extend", size, blending, of_planes, ..self.fill.setup(session)? })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        // The map of the step before.
        self.fill.bytes(sources, channels, output) + Bytes::of_samples(output, 4)
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        let picture = loom.loaded.exemplars.sources()[0].domain();
        let ([height, width], [rows, columns]) = (picture.shape, loom.domain.shape);
        if rows < height || columns < width {
            let what = format!("it has {width}x{height} px, and {columns}x{rows} px do not hold it");
            let remedy = "give a --size that is not smaller, or crop the picture";
            return Err(Failure::new(3, what).about(&loom.loaded.paths[0]).remedy(remedy));
        }
        check_opaque(loom)?;
        self.fill.fuse_keep.read(loom)?;
        let (start, loom) = (start(loom, picture)?, &*loom);
        let at = self.anchor.place(picture.shape, loom.domain.shape);
        let mut kept = Grid::try_filled(loom.domain, 1, false)?;
        for ([y, x], id) in picture.positions().zip(start.map.ids.plane(0)) {
            kept.set(0, [y + at[0], x + at[1]], id.is_assigned());
        }
        let new = kept.samples().iter().filter(|kept| !**kept).count();
        let how = format!("with {} filled", n("pixel", new));
        Ok(PlannedRun::new(self.fill.used(loom), how, move || {
            let (exemplars, run) = (&loom.loaded.exemplars, loom.session.run());
            let woven = extend(exemplars, start.map, at, loom.domain, &self.fill.options(), &run);
            let woven = woven.map_err(|e| loom.loaded.about(Failure::from(e)))?;
            let (stats, how) = (counts(&woven.stats), self.fill.how(&woven.stats));
            Ok(Outcome { kept: Some(kept), ..Outcome::new(Box::new(woven.result), woven.complete, stats, how) })
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_lie_where_they_are_anchored() {
        let place = |anchor: Anchor| anchor.place([4, 10], [9, 16]);
        assert_eq!(place(Anchor::C), [2, 3]);
        assert_eq!([Anchor::Nw, Anchor::N, Anchor::Ne].map(place), [[0, 0], [0, 3], [0, 6]]);
        assert_eq!([Anchor::W, Anchor::E].map(place), [[2, 0], [2, 6]]);
        assert_eq!([Anchor::Sw, Anchor::S, Anchor::Se].map(place), [[5, 0], [5, 3], [5, 6]]);
    }
}
