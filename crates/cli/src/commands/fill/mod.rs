//! `selvedge fill`: holes of a picture filled from the picture itself. `[Kwatra03 6B]`

mod chosen;
mod opaque;

use std::borrow::Cow;
use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Grid, SampleId, SourceMap, Start};
use selvedge_graphcut_textures::labels::{FillOptions, FillStats, OffsetOptions, estimate_fill, fill};
use serde_json::Value;

use self::chosen::Chosen;
pub(super) use self::opaque::check_opaque;
use crate::blending::Blending;
use crate::exemplars::NO_MASK;
use crate::failure::{Failure, n};
use crate::fuse_keep::FuseKeep;
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::needs::Share;
use crate::options::{Seams, Turning, one_picture, option};
use crate::outcome::Outcome;
use crate::output_size::OutputSize;
use crate::session::Session;
use crate::setup::Setup;
use crate::used::Used;
use crate::values::counts;
use crate::weaving::Weaving;

const FUSE: &str = "Fuse what is filled in: it is raised and lowered until it meets what is around it, and keeps its \
    detail. Default, but where a picture holds light, normals, labels or few colours: that is copied";
const SPLINE: &str = "Spline seams over this many bands of detail, up to 5, or 'auto': coarse detail is blended widely, \
    fine detail closely. 0 copies what is filled in";

/// Options of `fill`.
#[derive(Args, Debug)]
#[command(mut_arg("exemplars", one_picture))]
#[command(mut_arg("mask", |arg| arg
    .help("What to fill: white, from half of full light on. Default: what is transparent in the picture")))]
#[command(mut_args(option("seam", |arg| arg.default_value("difference"))))]
#[command(mut_args(option("fuse", |arg| arg.help(FUSE))))]
#[command(mut_args(option("spline", |arg| arg.help(SPLINE))))]
#[command(mut_args(option("turn", |arg| arg.help("Turn what is filled in by quarter turns as well"))))]
#[command(mut_args(option("mirror", |arg| arg.help("Mirror what is filled in as well"))))]
pub(crate) struct Fill {
    #[command(flatten)]
    weaving: Weaving,
    /// Another picture to fill from as well. May be given several times.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    from: Vec<PathBuf>,
    /// Use a picture of --from only where this one is white. Give one for each of them, in order, or 'none'.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    source_mask: Vec<PathBuf>,
    /// Look for what is copied at least so many pixels away, so that repeats do not lie side by side. Default: a
    /// fifteenth of the longer side.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    avoid_near: Option<u32>,
    #[command(flatten)]
    seams: Seams,
    #[command(flatten)]
    turning: Turning,
    #[command(flatten)]
    pub(crate) blending: Blending,
    #[command(flatten)]
    pub(crate) fuse_keep: FuseKeep,
}

impl Method for Fill {
    fn setup(&self, _: &Session<'_>) -> Result<Setup<'_>, Failure> {
        Ok(self.fuse_keep.setup(Setup {
            weaving: Cow::Owned(self.all()?),
            transforms: self.turning.transforms(),
            blending: if self.fuses() { Blending::default() } else { self.blending },
            of_planes: Some(self.blending),
            keeps: true,
            fills: true,
            files: Some(self.weaving.input.exemplars.clone()),
            ..Setup::new("fill", &self.weaving, OutputSize::First(None))
        }))
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        estimate_fill(sources, channels, output, &self.options())
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        check_opaque(loom)?;
        let chosen = self.blending.is_none().then(|| Chosen::of(&loom.loaded));
        loom.blending = chosen.map_or(self.blending, Chosen::blending);
        self.fuse_keep.read(loom)?;
        let start = start(loom, loom.domain)?;
        if self.fuses() {
            // What is fused takes memory for the holes alone.
            let (holes, channels) = (around_holes(&start.map), loom.loaded.payload[0].samples.channels());
            let fused = loom.blending.bytes(holes, channels, true);
            loom.needs.blended = Share::of(loom.domain, |output| fused + Bytes::of_samples(output, 2));
        }
        let (needed, loom) = (self.admit(loom, &|_| Bytes(0))?, &*loom);
        let told = chosen.filter(|_| start.map.holes() != 0).map_or(String::new(), Chosen::told);
        let how = format!("with {} filled{told}", n("pixel", start.map.holes()));
        Ok(PlannedRun::new(self.used(loom), how, move || {
            let kept = start.fixed.clone();
            let woven = fill(&loom.loaded.exemplars, start, &self.options(), &loom.session.run());
            let woven = woven.map_err(|e| loom.loaded.about(Failure::from(e)))?;
            let (stats, how) = (counts(&woven.stats), self.how(&woven.stats) + &told);
            Ok(Outcome { kept, ..Outcome::new(Box::new(woven.result), woven.complete, stats, how) })
        })
        .needing(needed))
    }
}

impl Fill {
    /// The picture with its holes, and the others after it.
    fn all(&self) -> Result<Weaving, Failure> {
        let mut all = self.weaving.clone();
        let (masks, others, of_others) = (all.input.mask.len(), self.from.len(), self.source_mask.len());
        all.input.check_one_mask()?;
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

    /// True if what is filled in is fused, or may be.
    fn fuses(&self) -> bool {
        self.blending.is_none() || self.blending.is_fused()
    }

    pub(crate) fn options(&self) -> FillOptions {
        let offsets = OffsetOptions { apart: self.avoid_near, ..OffsetOptions::default() };
        FillOptions { seam: self.seams.measure(), offsets, ..FillOptions::default() }
    }

    /// The options as used.
    pub(crate) fn used(&self, loom: &Loom<'_>) -> Used {
        loom.used().unless("avoid-near", Value::Null)
    }

    /// What was done, for people.
    pub(crate) fn how(&self, stats: &FillStats) -> String {
        if stats.filled == 0 {
            let is_masked = self.weaving.input.mask.first().is_some_and(|mask| mask.as_os_str() != NO_MASK);
            let why = if is_masked { "the mask has no white" } else { "nothing is transparent" };
            return format!("as it was: {why}");
        }
        let grown = if stats.grown == 0 { String::new() } else { format!(", {} grown by patches", stats.grown) };
        format!("with {} filled from {}{grown}", n("pixel", stats.filled), n("place", stats.used))
    }
}

/// All of the picture but its holes, which stays, as an output of its shape.
pub(crate) fn start(loom: &Loom<'_>, domain: Domain<2>) -> Result<Start<2>, Failure> {
    let exemplars = &loom.loaded.exemplars;
    let mut map = SourceMap::unassigned(exemplars, domain)?;
    let shown = match &loom.loaded.masks[0] {
        Some(mask) => Some(mask.samples()),
        None => exemplars.sources()[0].valid.as_deref().map(Grid::samples),
    };
    for (i, id) in map.ids.plane_mut(0).iter_mut().enumerate() {
        if shown.is_none_or(|shown| shown[i]) {
            *id = SampleId::new(i as u32);
        }
    }
    let fixed = map.ids.map(SampleId::is_assigned)?;
    Ok(Start { map, fixed: Some(fixed), sources: None })
}

/// The box around all holes of a map, and what holds them.
fn around_holes(map: &SourceMap<2>) -> Domain<2> {
    let [mut low, mut high] = [[u32::MAX; 2], [0; 2]];
    for (at, _) in map.domain().positions().zip(map.ids.plane(0)).filter(|(_, id)| !id.is_assigned()) {
        (low, high) = ([0, 1].map(|a| at[a].min(low[a])), [0, 1].map(|a| (at[a] + 1).max(high[a])));
    }
    Domain::open([0, 1].map(|a| high[a].saturating_sub(low[a]) + 2))
}

/// What was counted, as JSON.
pub(crate) fn counts(stats: &FillStats) -> Value {
    counts!(stats, filled, grown, levels, offsets, used, expansions, refined, energy)
}
