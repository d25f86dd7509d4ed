//! `selvedge tile`: a picture that tiles.

mod told;
mod widths;

use std::borrow::Cow;

use clap::{Args, ValueEnum};
use selvedge_core::{Bytes, Domain};
use selvedge_graphcut_textures::labels::{
    FillOptions, banded, close, close_period, estimate_fill, estimate_labels, fill,
};
use serde_json::json;

use self::widths::Widths;
use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::options::{Seams, one_picture, option};
use crate::outcome::Outcome;
use crate::output_size::OutputSize;
use crate::session::Session;
use crate::setup::Setup;
use crate::size::Tile;
use crate::values::{Auto, auto, count, sides};
use crate::weaving::Weaving;

/// Options of `tile`.
#[derive(Args, Debug)]
#[command(mut_arg("exemplars", one_picture))]
#[command(mut_args(option("seam", |arg| arg.default_value("difference"))))]
#[command(mut_arg("tile", |arg| arg.help("Along which axes it is to tile. Default: both")))]
pub(crate) struct TileCommand {
    #[command(flatten)]
    weaving: Weaving,
    /// How it is closed.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = MethodArg::Overlap)]
    method: MethodArg,
    /// How far the picture is laid over itself by --method overlap, in pixels along both axes, 2 or more; auto: by the
    /// price of the seam.
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

impl Method for TileCommand {
    fn setup(&self, session: &Session<'_>) -> Result<Setup<'_>, Failure> {
        self.validate(session)?;
        // The picture's own size is the most that it can have; what an overlap takes off is known once it is read.
        let tiled = Weaving { tile: Some(self.axes()), ..self.weaving.clone() };
        Ok(Setup {
            blending: self.blending,
            keeps: true,
            weaving: Cow::Owned(tiled),
            ..Setup::new("tile", &self.weaving, OutputSize::First(None))
        })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let widened = sources.iter().map(|source| Bytes::of_samples(*source, channels as u64 + 1)).sum();
        match self.method {
            MethodArg::Overlap => {
                // For its period, all of the picture is looked at before.
                let look = |source: &Domain<2>| selvedge_analysis::estimate_texture(*source, channels, true);
                let looked = sources.iter().filter(|_| self.period.is_some()).map(look).max().unwrap_or_default();
                looked.then(estimate_labels(sources, channels, output) + Bytes::of_samples(output, 8))
            }
            // The picture once more, its border left out.
            MethodArg::Band => estimate_fill(sources, channels, output, &FillOptions::default()) + widened,
        }
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        let widths = if self.period.is_some() { self.period(loom)? } else { self.widths(loom)? };
        let loom = &*loom;
        let how = self.how(widths);
        Ok(PlannedRun::new(self.used(loom, widths), how.clone(), move || self.weave(loom, widths, how)))
    }
}

impl TileCommand {
    fn axes(&self) -> Tile {
        self.weaving.tile.unwrap_or(Tile::Xy)
    }

    fn validate(&self, session: &Session<'_>) -> Result<(), Failure> {
        let (of_the_other, needed) = match self.method {
            MethodArg::Overlap => (&["band"][..], "band"),
            MethodArg::Band => (&["overlap", "period"][..], "overlap"),
        };
        if let Some(option) = session.first_typed(of_the_other) {
            let what = format!("{option} is for --method {needed}");
            return Err(Failure::new(2, what).remedy("leave it out, or change --method"));
        }
        self.weaving.input.check_one_mask()?;
        for (given, least) in [(self.overlap.0, 2), (self.band.0, 1)] {
            if let Some(border) = given.filter(|border| *border < least) {
                let what = format!("a border of {border} px closes nothing");
                return Err(Failure::new(2, what).remedy(format!("give {least} px or more, or leave it out")));
            }
        }
        let pictures = self.weaving.input.exemplars.len();
        if 1 < pictures && self.method == MethodArg::Overlap {
            let what = format!("{pictures} pictures, and one is laid over itself");
            return Err(Failure::new(2, what).remedy("give one, or fill a border from all with --method band"));
        }
        Ok(())
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
            let stays = if holes == 0 { String::new() } else { format!(", {} transparent", n("pixel", holes)) };
            let outcome = Outcome::new(Box::new(woven.result), woven.complete, stats, how + &stays);
            return Ok(Outcome { holes: 0 < holes, ..outcome });
        }
        let (exemplars, start) = banded(exemplars, widths).map_err(about)?;
        let kept = start.fixed.clone();
        let woven = fill(&exemplars, start, &FillOptions { seam, ..FillOptions::default() }, &run).map_err(about)?;
        let stats = json!({ "band": widths, "filled": woven.stats.filled, "energy": woven.stats.energy });
        Ok(Outcome { kept, ..Outcome::new(Box::new(woven.result), woven.complete, stats, how) })
    }
}
