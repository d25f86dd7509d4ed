//! `selvedge tile`: a picture that tiles.

use clap::{Args, ValueEnum};
use selvedge_analysis::Texture;
use selvedge_core::{Bytes, Domain};
use selvedge_graphcut_textures::labels::{
    FillOptions, banded, check_band, check_overlap, close, close_period, estimate_fill, fill, overlaps,
};
use serde_json::json;

use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::loom::Loom;
use crate::method::{Method, Planned};
use crate::options::{Seams, option};
use crate::outcome::Outcome;
use crate::session::Session;
use crate::setup::{OutputSize, Setup};
use crate::size::Tile;
use crate::used::Used;
use crate::values::{Auto, auto, count, sides};
use crate::weaving::Weaving;

/// Options of `tile`.
#[derive(Args, Debug)]
#[command(mut_arg("exemplars", |arg| arg
    .value_names(["PICTURE"])
    .num_args(1)
    .help("The picture; '-' is standard input, 'a.exr[R,G,B]' chooses channels or a layer")))]
#[command(mut_args(option("seam", |arg| arg.default_value("difference"))))]
#[command(mut_arg("tile", |arg| arg.help("Along which axes it is to tile. Default: both")))]
pub(crate) struct TileCommand {
    #[command(flatten)]
    weaving: Weaving,
    /// How it is closed.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = MethodArg::Overlap)]
    method: MethodArg,
    /// How far the picture is laid over itself by --method overlap, in pixels along both axes; auto: by the price of
    /// the seam.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = count())]
    overlap: Auto<u32>,
    /// Cut one period out of the picture, and close it: across and down in pixels, or auto, as far as its lattice comes
    /// again.
    #[arg(long, value_name = "WxH|auto", conflicts_with = "overlap", value_parser = auto("period", "write 64, 64x48 or auto", sides))]
    period: Option<Auto<[u32; 2]>>,
    /// Width of the border that --method band fills anew, in pixels; auto: an eighth of the shorter side.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = count())]
    band: Auto<u32>,
    #[command(flatten)]
    seams: Seams,
    #[command(flatten)]
    blending: Blending,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodArg {
    /// The picture is laid over itself, and cut along the least seam: nothing is made up, and it becomes smaller.
    Overlap,
    /// A border is filled anew from the middle, which stays to the bit: the size stays.
    Band,
}

/// Sides of less have no border that could be closed.
const LEAST: u32 = 4;

/// How far a picture is laid over itself, or the width of its border, or its period, along each axis.
type Widths = [u32; 2];

/// Ways after which a lattice closes that are looked through for one of whole samples.
const OFTEN: u32 = 4;
/// What they may be off by to be whole, in parts of a sample.
const WHOLE: f64 = 0.15;

impl Method for TileCommand {
    fn setup(&self, _: &Session<'_>) -> Result<Setup<'_>, Failure> {
        self.validate()?;
        // The picture's own size is the most that it can have; what an overlap takes off is known once it is read.
        let size = OutputSize::Arranged(Box::new(|sources| Tile::domain(Some(self.axes()), sources[0].shape)));
        Ok(Setup { blending: self.blending, keeps: true, ..Setup::new("tile", &self.weaving, size) })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        estimate_fill(sources, channels, output, &FillOptions::default())
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<Planned<'l>, Failure> {
        let widths = if self.period.is_some() { self.period(loom)? } else { self.widths(loom)? };
        let loom = &*loom;
        let how = self.how(widths);
        Ok(Planned::new(self.used(loom, widths), how.clone(), move || self.weave(loom, widths, how)))
    }
}

impl TileCommand {
    fn axes(&self) -> Tile {
        self.weaving.tile.unwrap_or(Tile::Xy)
    }

    fn validate(&self) -> Result<(), Failure> {
        let (given, other) = match self.method {
            MethodArg::Overlap => (self.band.0, "--band is for --method band"),
            MethodArg::Band => (self.overlap.0, "--overlap is for --method overlap"),
        };
        let masks = self.weaving.input.mask.len();
        if 1 < masks {
            return Err(Failure::new(2, format!("{masks} masks for one picture")).remedy("give one --mask"));
        }
        if [self.overlap.0, self.band.0].contains(&Some(0)) {
            return Err(Failure::new(2, "a border of 0 px closes nothing").remedy("give 1 px or more, or leave it out"));
        }
        if self.period.is_some() && self.method == MethodArg::Band {
            return Err(Failure::new(2, "--period is for --method overlap").remedy("leave it out, or change --method"));
        }
        given.map_or(Ok(()), |_| Err(Failure::new(2, other).remedy("leave it out, or change --method")))
    }

    fn widths(&self, loom: &mut Loom<'_>) -> Result<Widths, Failure> {
        let axes = Tile::domain(Some(self.axes()), [1, 1]).periodic;
        let along = |n: u32| std::array::from_fn(|a| if axes[a] { n } else { 0 });
        let (exemplars, shape) = (&loom.loaded.exemplars, loom.domain.shape);
        let about = |e| loom.loaded.about(Failure::from(e));
        if let Some(axis) = (0..2).find(|&a| axes[a] && shape[a] < LEAST) {
            let what = format!(
                "its {} is {}, and a picture of less than {LEAST} px has no border to close",
                ["height", "width"][axis],
                n("pixel", shape[axis] as usize)
            );
            return Err(loom
                .loaded
                .about(Failure::new(3, what).remedy("give a larger picture, or close the other axis")));
        }
        let widths = match (self.method, self.overlap.0, self.band.0) {
            (MethodArg::Overlap, Some(n), _) | (MethodArg::Band, _, Some(n)) => along(n),
            (MethodArg::Band, ..) => along((shape[0].min(shape[1]) / 8).max(1)),
            (MethodArg::Overlap, ..) => {
                overlaps(exemplars, axes, self.seams.measure(), &loom.session.run()).map_err(about)?
            }
        };
        match self.method {
            MethodArg::Overlap => check_overlap(shape, widths).map_err(about)?,
            MethodArg::Band => check_band(shape, widths).map_err(about)?,
        }
        if self.method == MethodArg::Overlap {
            loom.domain.shape = std::array::from_fn(|a| shape[a].saturating_sub(widths[a]).max(1));
        }
        Ok(widths)
    }

    /// The shape of one period, which the output has; along axes that are not closed all of the picture.
    fn period(&self, loom: &mut Loom<'_>) -> Result<Widths, Failure> {
        let (source, shape) = (&loom.loaded.exemplars.sources()[0], loom.domain.shape);
        let about = |what: String| loom.loaded.about(Failure::new(3, what));
        let mut period = match self.period {
            Some(Auto(Some(period))) => period,
            _ => {
                let weights = loom.loaded.exemplars.weights();
                let texture = Texture::of(&source.features, source.valid.as_ref(), weights)?;
                let mut period = shape;
                for axis in (0..2).filter(|&a| loom.domain.periodic[a]) {
                    let along = texture.order().and_then(|lattice| lattice.along[axis]);
                    let Some(along) = along else {
                        let what = format!("it comes again nowhere straight {}", ["down", "across"][axis]);
                        return Err(about(what).remedy("leave --period out, or say how long it is"));
                    };
                    period[axis] = whole(along);
                }
                period
            }
        };
        for axis in 0..2 {
            if !loom.domain.periodic[axis] {
                period[axis] = shape[axis];
            } else if period[axis] < 2 || shape[axis] < period[axis].saturating_add(2) {
                let what = format!("a period of {} does not lie in its {}", period[axis], shape[axis]);
                return Err(about(what).remedy("give a period of 2 px or more, and 2 less than the picture"));
            }
        }
        loom.domain.shape = period;
        Ok(period)
    }

    fn weave(&self, loom: &Loom<'_>, widths: Widths, how: String) -> Result<Outcome, Failure> {
        let (exemplars, run, seam) = (&loom.loaded.exemplars, loom.session.run(), self.seams.measure());
        let about = |e| loom.loaded.about(Failure::from(e));
        if self.period.is_some() || self.method == MethodArg::Overlap {
            let (by, woven) = if self.period.is_some() {
                let period = [0, 1].map(|a| loom.domain.periodic[a].then_some(widths[a]));
                ("period", close_period(exemplars, period, seam, &run))
            } else {
                ("overlap", close(exemplars, widths, seam, &run))
            };
            let woven = woven.map_err(about)?;
            let (holes, energy) = (woven.stats.holes, &woven.stats.energy);
            loom.check_holes(holes)?;
            let stats = json!({ by: widths, "energy": energy, "holes": holes });
            let outcome = Outcome::new(Box::new(woven.result), woven.complete, stats, how);
            return Ok(Outcome { holes: 0 < holes, ..outcome });
        }
        let (exemplars, start) = banded(exemplars, widths).map_err(about)?;
        let kept = start.fixed.clone();
        let woven = fill(&exemplars, start, &FillOptions { seam, ..FillOptions::default() }, &run).map_err(about)?;
        let stats = json!({ "band": widths, "filled": woven.stats.filled, "energy": woven.stats.energy });
        Ok(Outcome { kept, ..Outcome::new(Box::new(woven.result), woven.complete, stats, how) })
    }

    /// The options as used.
    fn used(&self, loom: &Loom<'_>, widths: Widths) -> Used {
        let width = widths.into_iter().max().unwrap_or(0);
        // Overlaps that were chosen differ along the axes: chosen again, they are the same.
        if self.period.is_some() {
            return loom
                .used()
                .without("band")
                .without("overlap")
                .set("period", format!("{}x{}", widths[1], widths[0]));
        }
        match self.method {
            MethodArg::Overlap => loom.used().without("band").without("period"),
            MethodArg::Band => loom.used().without("overlap").without("period").set("band", width),
        }
    }

    fn how(&self, [down, across]: Widths) -> String {
        if self.period.is_some() {
            return "that tile, one period of the picture".to_owned();
        }
        match self.method {
            MethodArg::Overlap => format!("that tile, laid over themselves by {across} across and {down} down"),
            MethodArg::Band => format!("that tile, a border of {} filled anew", n("pixel", down.max(across) as usize)),
        }
    }
}

/// A length after which what comes again `times` on `samples` does so after whole samples, nearly; of the first few the
/// shortest, or the nearest to it.
fn whole((samples, times): (u32, u32)) -> u32 {
    let length = |often: u32| f64::from(often) * f64::from(samples) / f64::from(times);
    let off = |often: u32| (length(often) - length(often).round()).abs();
    let near = (1..=OFTEN).find(|&often| off(often) <= WHOLE);
    let nearest = (1..=OFTEN).min_by(|&a, &b| off(a).total_cmp(&off(b)));
    length(near.or(nearest).unwrap_or(1)).round() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn periods_of_part_samples_close_after_some() {
        assert_eq!([(24, 1), (72, 3), (135, 2), (100, 3), (61, 4)].map(whole), [24, 24, 135, 100, 61]);
        // Never within four: the second is nearest, 26.8.
        assert_eq!(whole((67, 5)), 27);
    }
}
