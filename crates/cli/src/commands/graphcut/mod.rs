//! `selvedge graphcut`: graphcut textures. `[Kwatra03 3-6]`

mod choices;
mod scales;
mod sources;
pub(crate) mod start;

use std::path::PathBuf;

use clap::Args;
use selvedge_core::{Domain, Observer, Run, Transform};
use selvedge_graphcut_textures::{Error, Options, Placement, Plan, Start, Stats, estimate, graphcut_from, plan};
use serde_json::json;

use self::choices::{Auto, PlacementArg, SeamArg, Sides, number, reach, sides, typed};
use self::scales::{Field, Range, Scales};
use self::start::{Begun, StartArgs};
use crate::backdrop::Backdrop;
use crate::blending::Blending;
use crate::course::{self, Film};
use crate::failure::Failure;
use crate::loom::{Loom, Outcome};
use crate::method::{Method, OutputSize};
use crate::repairing::{self, Repairing, with_repair};
use crate::report::Done;
use crate::session::Session;
use crate::used::Used;
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
    #[arg(long, value_name = "SIZE|auto", default_value = "auto", value_parser = sides, allow_negative_numbers = true)]
    region: Sides,
    /// How far patches may reach beyond their region: 16, or 24x16 across and down; auto chooses, all is as far as the
    /// exemplar does.
    #[arg(long, value_name = "N|NxM|auto|all", default_value = "auto", value_parser = reach,
        allow_negative_numbers = true)]
    reach: Sides,
    /// How freely patches are drawn among those that fit worse than the best; the paper uses 0.001 to 1.
    #[arg(long, value_name = "K", default_value_t = Options::<2>::default().randomness)]
    randomness: f64,
    /// How much patches avoid to stand to each other as others do already; auto: 0.5 for entire placement, else 0.25.
    #[arg(long, value_name = "V|auto", default_value = "auto", value_parser = variety, allow_negative_numbers = true)]
    variety: Variety,
    /// Patches laid over the worst seams at the end, or auto: until seams stop becoming cheaper.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = number, allow_negative_numbers = true)]
    refine: Auto,
    /// Refinements in a row that bring nothing before the seams count as settled.
    #[arg(long, value_name = "N", default_value_t = Options::<2>::default().patience)]
    patience: u32,
    /// Patches that are tried at each step, of which the best is taken.
    #[arg(long, value_name = "N", default_value_t = Options::<2>::default().tries)]
    tries: u32,
    /// The paper to the letter: whole exemplars, the first that is drawn: --reach all --variety 0 --tries 1.
    #[arg(long, conflicts_with_all = ["reach", "variety", "tries"])]
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
    #[arg(long, value_name = "FACTOR", value_delimiter = ',', value_parser = scales::scale, allow_negative_numbers = true, conflicts_with = "scale_field")]
    scale: Vec<f64>,
    /// How large the texture is at each place, for perspective: top=0.5,bottom=1.5 (and left=, right=) from side to side,
    /// or a picture that is stretched over the output.
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

/// How much variety, or a choice by the program.
#[derive(Clone, Copy, Debug)]
struct Variety(Option<f64>);

fn variety(text: &str) -> Result<Variety, Wrong> {
    match text {
        "auto" => Ok(Variety(None)),
        _ => text
            .parse()
            .map(|v| Variety(Some(v)))
            .map_err(|_| Wrong::new(format!("'{text}' is no variety"), "write a number from 0 on, or auto")),
    }
}

/// An angle in degrees.
fn angle(text: &str) -> Result<f64, Wrong> {
    let angle = text.parse().ok().filter(|a: &f64| a.is_finite());
    angle.ok_or_else(|| Wrong::new(format!("'{text}' is no angle"), "write degrees, such as 30"))
}

/// A run whose options were understood, and whose map was read.
struct Job<'a> {
    args: &'a Graphcut,
    options: Options<2>,
    field: Option<&'a Scales>,
    /// The scales of the exemplars.
    levels: &'a [f64],
    begun: &'a Begun<'a>,
    domain: &'a dyn Fn(&[Domain<2>]) -> Result<Domain<2>, Failure>,
}

impl Method for Job<'_> {
    type Read = Start<2>;

    fn name(&self) -> &'static str {
        "graphcut"
    }

    fn weaving(&self) -> &Weaving {
        &self.args.weaving
    }

    fn validate(&self) -> Result<(), Failure> {
        Ok(self.options.validate()?)
    }

    fn blending(&self) -> Blending {
        self.args.blending
    }

    fn keeps(&self) -> bool {
        true
    }

    fn size(&self) -> OutputSize<'_> {
        OutputSize::Start(self.domain)
    }

    fn others(&self) -> Vec<PathBuf> {
        self.args.start.files().into_iter().chain(self.field.and_then(Scales::file).cloned()).collect()
    }

    fn transforms(&self) -> Vec<Transform> {
        self.args.transforms(self.levels)
    }

    fn backdrop(&self) -> Option<Backdrop<'_>> {
        self.args.start.backdrop()
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> u64 {
        // A bit for each source at each place.
        let steered = self.field.is_some() || self.backdrop().is_some();
        let field = if steered { bits_of_sources(output) } else { 0 };
        let filmed = self.args.weaving.report.is_some();
        let film = if filmed { course::memory(sources, channels, output) } else { 0 };
        let method = estimate(sources, channels, output, &self.options);
        let repair = self.args.repairing.bytes(sources, channels, output);
        method.saturating_add(field).saturating_add(film).saturating_add(repair)
    }

    fn read(&self, loom: &mut Loom<'_>) -> Result<Start<2>, Failure> {
        let (map, fixed) = self.begun.stand(loom)?;
        Ok(Start { map, fixed, sources: self.args.sources(loom, self.field)? })
    }

    fn plan(&self, loom: &Loom<'_>, start: Start<2>) -> Result<(Used, String), Failure> {
        let (exemplars, limits) = (&loom.loaded.exemplars, &loom.session.limits);
        let plan = plan(exemplars, loom.domain, start.sources.as_ref(), &self.options, limits);
        let chosen = Chosen::from(&plan.map_err(|e| failure(loom, e))?);
        let [height, width] = chosen.region;
        let placement = format!("{:?}", chosen.placement).to_lowercase();
        let how = format!("from patches for regions of {width}x{height} px, {placement} placement");
        Ok((self.args.used(loom, self.field, &chosen), how))
    }

    fn weave(&self, loom: &Loom<'_>, start: Start<2>) -> Result<Outcome, Failure> {
        let (args, exemplars, session) = (self.args, &loom.loaded.exemplars, loom.session);
        let (kept, sources) = (start.fixed.clone(), start.sources.clone().filter(|_| args.repairing.is_on()));
        let filmed = args.weaving.report.is_some();
        let film = filmed.then(|| Film::new(&session.watch, exemplars, self.options.seam)).transpose()?;
        let observer: &dyn Observer<2> = film.as_ref().map_or(&session.watch, |film| film);
        let run = Run { observer, ..session.run() };
        let mut woven = graphcut_from(exemplars, start, &self.options, &run).map_err(|e| failure(loom, e))?;
        args.warn_of_small(loom, woven.stats.region);
        let course = film.map(|film| film.course(&woven.result, &woven.stats.energy));
        let repair = args.repairing.mend(session, exemplars, &mut woven, (kept.as_ref(), sources))?;
        Ok(Outcome {
            woven: Box::new(woven.result),
            complete: woven.complete,
            kept,
            options: args.used(loom, self.field, &Chosen::from(&woven.stats)),
            stats: with_repair(counts(&woven.stats), repair.as_ref()),
            how: if self.backdrop().is_some() && woven.stats.patches == 0 {
                "as it was: the picture has no holes, and no --fixed makes some".to_owned()
            } else {
                how(&woven.stats) + &repairing::how(repair.as_ref())
            },
            course,
        })
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
        Options { reach: self.reach.0, variety: self.variety.0, tries: self.tries, ..options }
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
        let begun = self.start.begin(session)?;
        let domain = |exemplars: &[Domain<2>]| {
            let (first, sizing) = (exemplars[0].shape, self.sizing);
            let output = begun.domain(exemplars, sizing.typed(first), self.weaving.tiled(sizing.shape(first)))?;
            field.as_ref().map_or(Ok(()), |field| field.check(output))?;
            Ok(output)
        };
        let options = self.options();
        Job { args: self, options, field: field.as_ref(), levels: &levels, begun: &begun, domain: &domain }.run(session)
    }

    /// The options as used.
    fn used(&self, loom: &Loom<'_>, field: Option<&Scales>, chosen: &Chosen) -> Used {
        let used = loom
            .used()
            .set("placement", format!("{:?}", chosen.placement).to_lowercase())
            .set("region", typed(chosen.region))
            .set("reach", typed(chosen.reach))
            .set("variety", chosen.variety)
            .set("refine", self.refine.0)
            .set("tries", self.options().tries);
        let used = if self.start.is_blended_in() { used } else { used.without("blend-in") };
        let used = self.repairing.used_if_any(self.blending.used(used));
        match field {
            Some(field) => field.used(used),
            None => used.without("scale-field").without("scale-range").without("scale-step"),
        }
    }
}

/// What was left to the program.
struct Chosen {
    placement: Placement,
    region: [u32; 2],
    reach: [u32; 2],
    variety: f64,
}

impl From<&Plan<2>> for Chosen {
    fn from(plan: &Plan<2>) -> Self {
        Self { placement: plan.placement, region: plan.region, reach: plan.reach, variety: plan.variety }
    }
}

impl From<&Stats<2>> for Chosen {
    fn from(stats: &Stats<2>) -> Self {
        Self { placement: stats.placement, region: stats.region, reach: stats.reach, variety: stats.variety }
    }
}

/// Bytes of one set of sources a position.
fn bits_of_sources(output: Domain<2>) -> u64 {
    let [h, w] = output.shape.map(u64::from);
    h.saturating_mul(w).saturating_mul(u64::BITS.into()) / 8
}

fn counts(stats: &Stats<2>) -> serde_json::Value {
    json!({
        "regularity": stats.regularity,
        "patches": stats.patches,
        "refinements": stats.refinements,
        "improvements": stats.improvements,
        "cuts": stats.cuts,
        "cut_nodes": stats.cut_nodes,
        "energy": stats.energy,
    })
}

fn how(stats: &Stats<2>) -> String {
    let placement = format!("{:?}", stats.placement).to_lowercase();
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
