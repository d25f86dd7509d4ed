//! `selvedge graphcut`: graphcut textures. `[Kwatra03 3-6]`

mod scales;
mod sources;

use clap::Args;
use selvedge_core::{Bytes, Domain, Observer, Run, Start};
use selvedge_graphcut_textures::{Error, Options, Placement, Plan, Stats, estimate, plan};
use serde_json::json;

use self::scales::{Field, Range, Scales};
use crate::blending::Blending;
use crate::course::{self, Film};
use crate::failure::Failure;
use crate::ground::{Ground, StartArgs};
use crate::loom::{Loom, Outcome};
use crate::method::{Method, Planned};
use crate::repairing::Repairing;
use crate::report::Done;
use crate::session::Session;
use crate::setup::{OutputSize, Setup};
use crate::used::Used;
use crate::values::{Auto, SeamArg, auto, choices, name_of, parsed, sides, sides_typed};
use crate::weaving::{Sizing, Weaving};
use crate::wrong::Wrong;

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
    /// How seams are priced: by their difference, or by difference over gradient.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = SeamArg::Gradient)]
    seam: SeamArg,
    /// Size of the regions that patches are found for: 32, 48x32, or auto.
    #[arg(long, value_name = "SIZE|auto", default_value = "auto", allow_negative_numbers = true,
        value_parser = auto("number", "write 32, 48x32 (width by height), or auto", sides))]
    region: Auto<[u32; 2]>,
    /// How far patches may reach beyond their region: 16, or 24x16 across and down; auto chooses, all is as far as the
    /// exemplar does.
    #[arg(long, value_name = "N|NxM|auto|all", default_value = "auto", allow_negative_numbers = true,
        value_parser = auto("number", "write 16, 24x16 (across by down), auto or all", reach))]
    reach: Auto<[u32; 2]>,
    /// How freely patches are drawn among those that fit worse than the best; the paper uses 0.001 to 1.
    #[arg(long, value_name = "K", default_value_t = Options::<2>::default().randomness)]
    randomness: f64,
    /// How much patches avoid to stand to each other as others do already; auto: 0.5 for entire placement, else 0.25.
    #[arg(long, value_name = "V|auto", default_value = "auto", allow_negative_numbers = true,
        value_parser = auto("variety", "write a number from 0 on, or auto", parsed::<f64>))]
    variety: Auto<f64>,
    /// Patches laid over the worst seams at the end, or auto: until seams stop becoming cheaper.
    #[arg(long, value_name = "N|auto", default_value = "auto", allow_negative_numbers = true,
        value_parser = auto("number", "write a number, or auto", parsed::<u32>))]
    refine: Auto<u32>,
    /// Refinements in a row that bring nothing before the seams count as settled.
    #[arg(long, value_name = "N", default_value_t = Options::<2>::default().patience)]
    patience: u32,
    /// Patches that are tried at each step, of which the best is taken.
    #[arg(long, value_name = "N", default_value_t = Options::<2>::default().tries)]
    tries: u32,
    /// At how many sizes the map is solved, each half of the one before, or auto: as many as leave 192 px of exemplars
    /// and 4 of structures. From the second on, only what lies near seams is decided again. What starts from a map or a
    /// picture, or follows scales, has one.
    #[arg(long, value_name = "N|auto", default_value = "auto", allow_negative_numbers = true,
        value_parser = auto("number", "write a number, or auto", parsed::<u32>))]
    levels: Auto<u32>,
    /// The paper to the letter: whole exemplars, the first that is drawn: --reach all --variety 0 --tries 1 --levels 1.
    #[arg(long, conflicts_with_all = ["reach", "variety", "tries", "levels"])]
    paper: bool,
    #[command(flatten)]
    start: StartArgs,
    #[command(flatten)]
    repairing: Repairing,
    #[command(flatten)]
    blending: Blending,
    /// Turn exemplars by quarter turns as well.
    #[arg(long)]
    turn: bool,
    /// Mirror exemplars as well.
    #[arg(long)]
    mirror: bool,
    /// Turn exemplars clockwise by these angles in degrees as well; their samples are interpolated.
    #[arg(long, value_name = "DEGREES", value_delimiter = ',', allow_hyphen_values = true, value_parser = angle)]
    rotate: Vec<f64>,
    /// Magnify exemplars by these factors as well, from 0.0625 to 16.
    #[arg(long, value_name = "FACTOR", value_delimiter = ',', value_parser = scales::scale)]
    #[arg(allow_negative_numbers = true, conflicts_with = "scale_field")]
    scale: Vec<f64>,
    /// How large the texture is at each place, for perspective: top=0.5,bottom=1.5 (and left=, right=) from side to
    /// side, or a picture that is stretched over the output.
    #[arg(long, value_name = "FIELD")]
    scale_field: Option<Field>,
    /// The scales that black and white of a picture of scales stand for.
    #[arg(long, value_name = "LOW..HIGH", requires = "scale_field")]
    scale_range: Option<Range>,
    /// The factor between scales that a field is made of. Each place copies from those nearest to its own.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.2, value_parser = scales::step,
        allow_negative_numbers = true)]
    scale_step: f64,
}

choices!(PlacementArg for Placement {
    /// Entire where the exemplar repeats itself, else sub.
    Auto,
    /// Anywhere.
    Random,
    /// Where the whole exemplar agrees with what is there.
    Entire,
    /// Where the exemplar agrees with what is there in the region.
    Sub,
});

/// How far from a region.
fn reach(text: &str) -> Option<[u32; 2]> {
    // What is beyond the longest side there is was meant otherwise.
    let sane = |sides: &[u32; 2]| sides.iter().all(|&side| side <= u32::from(u16::MAX));
    if text == "all" { Some([u32::MAX; 2]) } else { sides(text).filter(sane) }
}

/// An angle in degrees.
fn angle(text: &str) -> Result<f64, Wrong> {
    let angle = text.parse().ok().filter(|a: &f64| a.is_finite());
    angle.ok_or_else(|| Wrong::new(format!("'{text}' is no angle"), "write degrees, such as 30"))
}

/// A run whose options were understood, and whose map was read.
struct Job<'a> {
    args: &'a Graphcut,
    field: Option<Scales>,
    /// The scales of the exemplars.
    levels: Vec<f64>,
    ground: Ground,
}

impl Method for Job<'_> {
    type Read = Start<2>;

    fn setup(&self) -> Result<Setup<'_>, Failure> {
        let Graphcut { weaving, sizing, start, blending, .. } = self.args;
        Ok(Setup {
            others: start.files().into_iter().chain(self.field.as_ref().and_then(Scales::file).cloned()).collect(),
            transforms: self.args.transforms(&self.levels),
            backdrop: start.backdrop(),
            blending: *blending,
            keeps: true,
            ..Setup::new("graphcut", weaving, OutputSize::Ground(&self.ground, *sizing))
        })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let args = self.args;
        // A bit for each source at each place.
        let field = if self.field.is_some() { Bytes::of_samples(output, 8) } else { args.start.bytes(output) };
        let filmed = args.weaving.report.is_some();
        let film = if filmed { course::memory(sources, channels, output) } else { Bytes(0) };
        let method = Bytes(estimate(sources, channels, output, &args.options()));
        method + field + film + args.repairing.bytes(sources, channels, output)
    }

    fn read(&self, loom: &mut Loom<'_>) -> Result<Start<2>, Failure> {
        let mut start = self.ground.start(loom)?;
        if let Some(field) = &self.field {
            // Of two, one at a time.
            start.sources = None;
            start.sources = Some(self.args.sources(loom, field)?);
        }
        Ok(start)
    }

    fn plan<'l>(&'l self, loom: &'l Loom<'_>, start: Start<2>) -> Result<Planned<'l>, Failure> {
        let (args, exemplars, session) = (self.args, &loom.loaded.exemplars, loom.session);
        let options = args.options();
        let planned = plan(exemplars, loom.domain, start.sources.as_ref(), &options, &session.limits);
        let plan = planned.map_err(|e| failure(loom, e))?;
        let [height, width] = plan.region;
        let how = format!("from patches for regions of {width}x{height} px, {} placement", name_of(plan.placement));
        Ok(Planned::new(args.used(loom, self.field.as_ref(), &plan), how, move || {
            let (kept, sources) = (start.fixed.clone(), start.sources.clone().filter(|_| args.repairing.is_on()));
            let filmed = args.weaving.report.is_some();
            let film = filmed.then(|| Film::new(&session.watch, exemplars, options.seam)).transpose()?;
            let observer: &dyn Observer<2> = film.as_ref().map_or(&session.watch, |film| film);
            let run = Run { observer, ..session.run() };
            let woven = plan.weave(exemplars, start, &options, &run).map_err(|e| failure(loom, e))?;
            args.warn_of_small(loom, plan.region);
            let course = film.map(|film| film.course(&woven.result, &woven.stats.energy, woven.stats.levels));
            let untouched = args.start.backdrop().is_some() && woven.stats.patches == 0;
            let told = (counts(&woven.stats), how_woven(&woven.stats));
            let mut outcome = args.repairing.outcome(session, exemplars, woven, (kept, sources), told)?;
            if untouched {
                outcome.how = "as it was: the picture has no holes, and no --fixed makes some".to_owned();
            }
            Ok(Outcome { course, ..outcome })
        }))
    }
}

impl Graphcut {
    fn options(&self) -> Options<2> {
        let options = Options {
            placement: self.placement.into(),
            seam: self.seam.into(),
            region: self.region.0,
            randomness: self.randomness,
            refine: self.refine.0,
            patience: self.patience,
            ..Options::paper()
        };
        if self.paper {
            return options;
        }
        // What begins with something in it has one.
        let starts = self.scale_field.is_some() || !self.start.files().is_empty();
        let levels = self.levels.0.or(starts.then_some(1));
        Options { reach: self.reach.0, variety: self.variety.0, tries: self.tries, levels, ..options }
    }

    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        self.options().validate()?;
        self.blending.validate()?;
        self.repairing.validate()?;
        let field = self.scale_field.clone().map(|f| Scales::new(f, self.scale_range, self.scale_step)).transpose()?;
        let levels = match &field {
            Some(field) => field.levels(),
            None => std::iter::once(1.0).chain(self.scale.iter().copied()).collect(),
        };
        let (exemplars, backdrop) = (self.weaving.input.exemplars.len(), self.start.backdrop());
        if field.is_some() || backdrop.is_some() {
            scales::check_number(exemplars, self.orientations().len(), levels.len(), backdrop.is_some())?;
        }
        let ground = self.start.ground(session)?;
        field.as_ref().map_or(Ok(()), |field| field.check(ground.topology(&self.weaving)))?;
        Job { args: self, field, levels, ground }.run(session)
    }

    /// The options as used.
    fn used(&self, loom: &Loom<'_>, field: Option<&Scales>, plan: &Plan<2>) -> Used {
        let used = loom
            .used()
            .set("placement", name_of(plan.placement))
            .set("region", sides_typed(plan.region))
            .set("reach", sides_typed(plan.reach))
            .set("variety", plan.variety)
            .set("refine", self.refine.0)
            .set("tries", self.options().tries);
        // Most have one, and would choose it again; where it was asked for, another might be chosen.
        let chosen = self.levels.0.is_none() && !self.paper;
        let used = if plan.levels == 1 && chosen { used.without("levels") } else { used.set("levels", plan.levels) };
        let used = self.repairing.used_if_any(self.blending.used(self.start.used(used)));
        match field {
            Some(field) => field.used(used),
            None => used.without("scale-field").without("scale-range").without("scale-step"),
        }
    }
}

fn counts(stats: &Stats<2>) -> serde_json::Value {
    let mut counts = json!({
        "regularity": stats.regularity,
        "patches": stats.patches,
        "refinements": stats.refinements,
        "improvements": stats.improvements,
        "cuts": stats.cuts,
        "cut_nodes": stats.cut_nodes,
        "energy": stats.energy,
    });
    // Energies are those of the smallest of several sizes.
    if 1 < stats.levels {
        counts["levels"] = json!(stats.levels);
        counts["settled"] = json!(stats.settled);
    }
    counts
}

fn how_woven(stats: &Stats<2>) -> String {
    let placement = name_of(stats.placement);
    let (patches, improvements) = (stats.patches, stats.improvements);
    let why = stats.regularity.map_or(String::new(), |r| format!(" at a regularity of {r}"));
    format!("from {patches} patches and {improvements} refinements, {placement} placement{why}")
}

/// Errors about exemplars name the file, and options by their flags.
fn failure(loom: &Loom<'_>, error: Error) -> Failure {
    match &error {
        Error::RegionExceedsExemplar { largest, .. } => {
            let most = largest.iter().min().copied().unwrap_or(0);
            let remedy = format!("use --region {most} or a larger exemplar");
            loom.loaded.about(Failure::from(error).remedy(remedy))
        }
        Error::Core(selvedge_core::Error::NoSource { .. }) => Failure::from(error).remedy("mask less of the exemplars"),
        _ => Failure::from(error),
    }
}
