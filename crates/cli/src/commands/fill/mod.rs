//! `selvedge fill`: holes of a picture filled from the picture itself. `[Kwatra03 6B]`

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Grid, SampleId, SourceMap, Start};
use selvedge_graphcut_textures::labels::{FillOptions, FillStats, estimate_fill, fill};
use serde_json::json;

use crate::blending::Blending;
use crate::exemplars::NO_MASK;
use crate::failure::{Failure, n};
use crate::loom::{Loom, Outcome};
use crate::method::{Method, Planned};
use crate::report::Done;
use crate::session::Session;
use crate::setup::{OutputSize, Setup};
use crate::values::{SeamArg, orientations};
use crate::weaving::Weaving;

/// Options of `fill`.
#[derive(Args, Debug)]
#[command(mut_arg("exemplars", |arg| arg
    .value_names(["PICTURE"])
    .num_args(1)
    .help("The picture; '-' is standard input, 'a.exr[R,G,B]' chooses channels or a layer")))]
#[command(mut_arg("mask", |arg| arg
    .help("What to fill: white, from half of full light on. Default: what is transparent in the picture")))]
pub(crate) struct Fill {
    #[command(flatten)]
    weaving: Weaving,
    /// Another picture to fill from as well. May be given several times.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    from: Vec<PathBuf>,
    /// Use a picture of --from only where this one is white. Give one for each of them, in order, or 'none'.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    source_mask: Vec<PathBuf>,
    /// How seams are priced: by their difference, or by difference over gradient.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = SeamArg::Difference)]
    seam: SeamArg,
    /// Turn what is filled in by quarter turns as well.
    #[arg(long)]
    turn: bool,
    /// Mirror what is filled in as well.
    #[arg(long)]
    mirror: bool,
    #[command(flatten)]
    blending: Blending,
}

/// A run whose files were told apart.
struct Job<'a> {
    args: &'a Fill,
    /// The picture and all others.
    weaving: Weaving,
    domain: &'a dyn Fn(&[Domain<2>]) -> Domain<2>,
}

impl Method for Job<'_> {
    type Read = Start<2>;

    fn setup(&self) -> Result<Setup<'_>, Failure> {
        Ok(Setup {
            transforms: orientations(self.args.turn, self.args.mirror),
            blending: self.args.blending,
            keeps: true,
            ..Setup::new("fill", &self.weaving, OutputSize::Laid(self.domain))
        })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        Bytes(estimate_fill(sources, channels, output, &self.args.options()))
    }

    fn read(&self, loom: &mut Loom<'_>) -> Result<Start<2>, Failure> {
        loom.files = Some(self.args.weaving.input.exemplars.clone());
        self.args.start(loom)
    }

    fn plan<'l>(&'l self, loom: &'l Loom<'_>, start: Start<2>) -> Result<Planned<'l>, Failure> {
        let how = format!("with {} filled", n("pixel", start.map.holes()));
        Ok(Planned::new(self.args.blending.used_if_any(loom.used()), how, move || {
            let kept = start.fixed.clone();
            let woven = fill(&loom.loaded.exemplars, start, &self.args.options(), &loom.session.run());
            let woven = woven.map_err(|e| loom.loaded.about(Failure::from(e)))?;
            let (stats, how) = (counts(&woven.stats), self.args.how(&woven.stats));
            Ok(Outcome { kept, ..Outcome::new(Box::new(woven.result), woven.complete, stats, how) })
        }))
    }
}

impl Fill {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let weaving = self.all()?;
        let domain = |sources: &[Domain<2>]| weaving.tiled(sources[0].shape);
        Job { args: self, weaving: weaving.clone(), domain: &domain }.run(session)
    }

    /// The picture with its holes, and the others after it.
    fn all(&self) -> Result<Weaving, Failure> {
        let mut all = self.weaving.clone();
        let (masks, others, of_others) = (all.input.mask.len(), self.from.len(), self.source_mask.len());
        if 1 < masks {
            return Err(Failure::new(2, format!("{masks} masks for one picture")).remedy("give one --mask"));
        }
        if of_others != 0 && of_others != others {
            let what = format!("{} for {} of --from", n("--source-mask", of_others), n("picture", others));
            return Err(Failure::new(2, what).remedy("give one for each, or '--source-mask none'"));
        }
        all.input.holes = true;
        all.input.exemplars.extend(self.from.iter().cloned());
        if masks != 0 || of_others != 0 {
            let none = PathBuf::from(NO_MASK);
            all.input.mask.resize(1, none.clone());
            all.input.mask.extend(self.source_mask.iter().cloned());
            all.input.mask.resize(1 + others, none);
        }
        Ok(all)
    }

    /// All of the picture but its holes, which stays.
    fn start(&self, loom: &Loom<'_>) -> Result<Start<2>, Failure> {
        let exemplars = &loom.loaded.exemplars;
        let mut map = SourceMap::unassigned(exemplars, loom.domain)?;
        let shown = match &loom.loaded.masks[0] {
            Some(mask) => Some(mask.samples()),
            None => exemplars.sources()[0].valid.as_ref().map(Grid::samples),
        };
        for (i, id) in map.ids.plane_mut(0).iter_mut().enumerate() {
            if shown.is_none_or(|shown| shown[i]) {
                *id = SampleId::new(i as u32);
            }
        }
        let fixed = map.ids.map(SampleId::is_assigned)?;
        Ok(Start { map, fixed: Some(fixed), sources: None })
    }

    fn options(&self) -> FillOptions {
        FillOptions { seam: self.seam.into(), ..FillOptions::default() }
    }

    fn how(&self, stats: &FillStats) -> String {
        if stats.filled == 0 {
            let why =
                if self.weaving.input.mask.is_empty() { "nothing is transparent" } else { "the mask has no white" };
            return format!("as it was: {why}");
        }
        let grown = if stats.grown == 0 { String::new() } else { format!(", {} grown by patches", stats.grown) };
        format!("with {} filled from {}{grown}", n("pixel", stats.filled), n("place", stats.used))
    }
}

fn counts(stats: &FillStats) -> serde_json::Value {
    json!({
        "filled": stats.filled,
        "grown": stats.grown,
        "levels": stats.levels,
        "offsets": stats.offsets,
        "used": stats.used,
        "expansions": stats.expansions,
        "refined": stats.refined,
        "energy": stats.energy,
    })
}
