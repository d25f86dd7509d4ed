//! `selvedge graphcut`: graphcut textures. `[Kwatra03 3-6]`

mod laying;
mod scales;
mod sources;
mod told;

use clap::Args;
use selvedge_core::{Bytes, Domain, Observer, Run};
use selvedge_graphcut_textures::{Options, measuring, plan};
use serde_json::json;

use self::laying::StutterArg;
pub(super) use self::laying::{Drawing, PlacementArg, Refining};
use self::sources::SourceArgs;
use crate::blending::Blending;
use crate::course::{self, Film};
use crate::failure::{Failure, n};
use crate::fuse_keep::FuseKeep;
use crate::ground::StartArgs;
use crate::kept::KeptArgs;
use crate::kept_weave::KeptWeave;
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::options::Seams;
use crate::outcome::Outcome;
use crate::repairing::Repairing;
use crate::session::Session;
use crate::setup::Setup;
use crate::values::{Auto, auto, count, name_of, pixels, sides};
use crate::weaving::{Sizing, Weaving};

/// Options of `graphcut`.
#[derive(Args, Debug)]
pub(crate) struct Graphcut {
    #[command(flatten)]
    weaving: Weaving,
    #[command(flatten)]
    sizing: Sizing,
    /// How the next patch is found.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = PlacementArg::Auto)]
    placement: PlacementArg,
    #[command(flatten)]
    seams: Seams,
    /// Size of the regions that patches are found for: 32, 48x32, or auto.
    #[arg(long, value_name = "SIZE|auto", default_value = "auto",
        value_parser = auto("number", "write 32, 48x32 (width by height), or auto", sides))]
    region: Auto<[u32; 2]>,
    /// How far patches may reach beyond their region: 16, or 24x16 across and down; auto chooses, all is as far as the
    /// exemplar does.
    #[arg(long, value_name = "N|NxM|auto|all", default_value = "auto",
        value_parser = auto("number", "write 16, 24x16 (across by down), auto or all", reach))]
    reach: Auto<[u32; 2]>,
    #[command(flatten)]
    drawing: Drawing,
    /// No patch is laid where a neighbour shows the same, moved by less than so many pixels, if there is any other, or
    /// as --stutter has it; auto: one and a half regions without a lattice or a --region, else 0.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = pixels())]
    apart: Auto<u32>,
    /// Which patches may lie nearer than --apart all the same.
    #[arg(long, value_enum, value_name = "WHICH", default_value_t = StutterArg::Auto)]
    stutter: StutterArg,
    #[command(flatten)]
    refining: Refining,
    /// At how many sizes the map is solved, each half of the one before, or auto: as many as leave 192 px of exemplars
    /// and 4 of structures. From the second on, only what lies near seams is decided again. What starts from a map or a
    /// picture, follows scales, or is kept by --checkpoint, has one.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = count())]
    levels: Auto<u32>,
    /// The paper to the letter: whole exemplars, the first that is drawn: --reach all --variety 0 --apart 0 --tries 1
    /// --levels 1.
    #[arg(long)]
    paper: bool,
    #[command(flatten)]
    start: StartArgs,
    #[command(flatten)]
    kept: KeptArgs,
    #[command(flatten)]
    repairing: Repairing,
    #[command(flatten)]
    blending: Blending,
    #[command(flatten)]
    fuse_keep: FuseKeep,
    #[command(flatten)]
    sources: SourceArgs,
}

/// How far from a region.
fn reach(text: &str) -> Option<[u32; 2]> {
    // What is beyond the longest side there is was meant otherwise.
    let sane = |sides: &[u32; 2]| sides.iter().all(|&side| side <= u32::from(u16::MAX));
    if text == "all" { Some([u32::MAX; 2]) } else { sides(text).filter(sane) }
}

impl Method for Graphcut {
    fn setup(&self, session: &Session<'_>) -> Result<Setup<'_>, Failure> {
        self.kept.check_levels(self.levels.0)?;
        self.options().validate()?;
        self.sources.validate(self.weaving.input.exemplars.len(), self.start.backdrop().is_some())?;
        let mut setup = Setup::on("graphcut", &self.weaving, self.sizing, &self.start, session)?;
        setup.others.extend(self.sources.file().cloned());
        let (transforms, blending) = (self.sources.transforms()?, self.blending.told());
        Ok(self.fuse_keep.setup(Setup { transforms, blending, repairing: self.repairing, ..setup }))
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        // A bit for each source at each place.
        let field = if self.sources.have_field() { Bytes::of_samples(output, 8) } else { self.start.bytes(output) };
        let film = if self.is_filmed() { course::memory(sources, channels, output) } else { Bytes(0) };
        field + film + self.kept.bytes(output) + self.repairing.bytes(sources, channels, output)
    }

    fn choosing(&self, sources: &[Domain<2>], channels: usize, masked: bool) -> Bytes {
        measuring(sources, channels, masked, &self.options())
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        self.fuse_keep.read(loom)?;
        let (start, loom) = (self.sources.start(loom)?, &*loom);
        let (options, exemplars, session) = (self.options(), &loom.loaded.exemplars, loom.session);
        let planned = plan(exemplars, loom.domain, start.sources.as_ref(), &options, &session.limits);
        let mut plan = planned.and_then(|plan| plan.on(&start)).map_err(|e| told::failure(loom, e))?;
        let is_kept_small = self.kept.is_asked() && 1 < plan.settings.levels;
        if is_kept_small {
            plan.settings.levels = 1;
        }
        let needed = self.admit(loom, &|output| plan.bytes_of(output))?;
        let settings = plan.settings;
        let ([height, width], placement) = (settings.region, name_of(settings.placement));
        let (patches, refinements) = (plan.patches(), plan.refinements());
        let how = format!(
            "from about {patches} patches and at most {}, for regions of {width}x{height} px, {placement} placement",
            n("refinement", refinements as usize)
        );
        let used = self.used(loom, &settings, is_kept_small);
        let command = used.command("graphcut", &[]);
        Ok(PlannedRun::new(used, how, move || {
            let inputs = loom.report.inputs.iter().map(|input| input["blake3"].clone()).collect();
            let checkpoint = KeptWeave::open(&self.kept, session, &[("set of inputs", inputs)], &command)?;
            let (kept, sources) = (start.fixed.clone(), start.sources.clone().filter(|_| self.repairing.is_on()));
            let film = self.is_filmed().then(|| Film::of_seams(&session.watch, exemplars, options.seam)).transpose()?;
            let observer: &dyn Observer<2> = film.as_ref().map_or(&session.watch, |film| film);
            let run = Run { observer, ..session.run() };
            let woven = checkpoint.weave(&plan, start, &run).map_err(|e| told::failure(loom, e))?;
            told::warn_of_small(loom, settings.region);
            let course = film.map(|film| film.course(&woven.result, &woven.stats.energy, woven.stats.settings.levels));
            let untouched = self.start.backdrop().is_some() && woven.stats.patches == 0;
            let told = (told::counts(&woven.stats), told::how(&woven.stats, untouched));
            let shown = loom.is_explained();
            Ok(Outcome { course, ..self.repairing.outcome(session, exemplars, woven, (kept, sources), told, shown)? })
        })
        .needing(needed)
        .counting(json!({ "patches": patches, "refinements": refinements })))
    }
}

impl Graphcut {
    fn options(&self) -> Options<2> {
        // What begins with something in it has one.
        let starts = self.sources.have_field() || !self.start.files().is_empty();
        Options {
            placement: self.placement.into(),
            seam: self.seams.measure(),
            region: self.region.0,
            reach: self.reach.0,
            apart: self.apart.0,
            stutter: self.stutter.into(),
            levels: self.levels.0.or(starts.then_some(1)),
            ..self.drawing.of(self.refining.of(Options::default()))
        }
    }

    /// Whether the page shows how seams become cheaper.
    fn is_filmed(&self) -> bool {
        self.weaving.report.is_some()
    }
}
