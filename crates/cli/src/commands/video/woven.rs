//! Clips woven of patches that are moved in time, or in space and time. `[Kwatra03 7B]` `[Kwatra03 7C]` `[Kwatra03 7D]`
//! `[Kwatra03 7E]`

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Exemplars, SeamMeasure, SourceMap, Start, Woven};
use selvedge_graphcut_textures::video::{Usual, estimate_in_windows, least_at_once, median, step};
use selvedge_graphcut_textures::{Error, Options, Stats, estimate_clip};
use selvedge_io::Fingerprint;
use serde_json::{Value, json};

use super::ClipOutcome;
use super::choices::{reach, typed, typed_reach, volume};
use super::modes::{ModeArg, Way};
use super::still::Still;
use super::weave::Keeping;
use super::written::WriteArgs;
use crate::clip_look::{Shown, features};
use crate::clip_maps::{self, ClipMaps};
use crate::clips::{self, ClipInput};
use crate::commands::graphcut::{Drawing, PlacementArg, Refining};
use crate::failure::{Failure, n};
use crate::kept::KeptArgs;
use crate::options::option;
use crate::report::Report;
use crate::session::Session;
use crate::used::Used;
use crate::values::{Auto, auto, counts, name_of};

/// How patches are found and laid.
#[derive(Args, Clone, Debug)]
#[command(mut_args(option("checkpoint", |arg| arg
    .help("Keep what was woven so far in this folder, every ten seconds and when a signal ends the run; with --at-once \
           after each window"))))]
pub(super) struct WovenArgs {
    /// How the next patch is found.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = PlacementArg::Auto)]
    placement: PlacementArg,
    /// Size of the regions that patches are found for: 40x40x20 (width by height by frames), 20 for all, or auto.
    /// Patches that move in time alone take whole frames.
    #[arg(long, value_name = "WxHxN|auto", default_value = "auto",
        value_parser = auto("size of regions", "write 40x40x20 (width by height by frames), 20, or auto", volume))]
    region: Auto<[u32; 3]>,
    /// How far patches may reach beyond their region: 20x20x20, 20 for all, auto, or all: as far as the clip does.
    #[arg(long, value_name = "WxHxN|auto|all", default_value = "auto",
        value_parser = auto("reach", "write 20x20x20 (across by down by frames), 20, auto or all", reach))]
    reach: Auto<[u32; 3]>,
    #[command(flatten)]
    drawing: Drawing,
    #[command(flatten)]
    refining: Refining,
    /// Go on from source maps of this clip that --map wrote, whose size the output has: their seams are made better.
    #[arg(long, value_name = "MAPS.####.exr", value_hint = ValueHint::FilePath)]
    start: Option<PathBuf>,
    /// Weave so many frames at once, those of each window going on from the one before. Default: all, or as many as
    /// --max-memory holds.
    #[arg(long, value_name = "FRAMES", value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    at_once: Option<u32>,
    #[command(flatten)]
    kept: KeptArgs,
}

/// A clip that is woven: what its samples are, and where they come from.
#[derive(Clone, Copy)]
pub(super) struct Material<'a> {
    pub(super) exemplars: &'a Exemplars<3>,
    pub(super) path: &'a Path,
    pub(super) fingerprint: &'a Fingerprint,
    /// By frame, the file that it comes from.
    pub(super) frames: &'a [Fingerprint],
}

/// What a weave is made under.
#[derive(Clone, Copy)]
pub(super) struct Under<'a> {
    pub(super) way: &'a Way,
    pub(super) seam: SeamMeasure,
    /// At how many sizes, where that is typed.
    pub(super) levels: Option<u32>,
    pub(super) still: Option<&'a Still>,
    /// Maps that it goes on from.
    pub(super) start: Option<&'a ClipMaps>,
}

/// Windows that are chosen have by a half more frames than are possible: with little more than what two of them share
/// each shows the same frames again. A candle of 53 frames moved .54 times as much as the clip at 42 frames at once, of
/// which 37 are the least, and 1.05 at 60.
const MORE_THAN_LEAST: u32 = 2;

impl WovenArgs {
    /// Files that are read.
    pub(super) fn files(&self) -> Result<Vec<PathBuf>, Failure> {
        self.start.as_ref().map_or(Ok(Vec::new()), |name| clips::files(name, None))
    }

    /// Reads the maps to go on from.
    pub(super) fn begun(
        &self,
        session: &Session<'_>,
        clip: &ClipInput,
        report: &mut Report,
    ) -> Result<Option<ClipMaps>, Failure> {
        let Some(name) = &self.start else { return Ok(None) };
        if !clips::is_pattern(name) {
            let failure = Failure::new(2, "is no name of maps, one a frame").about(name);
            return Err(failure.remedy("give what --map wrote, such as 'maps.####.exr'"));
        }
        let maps = ClipMaps::read(session, name, report)?;
        maps.check(clip)?;
        Ok(Some(maps))
    }

    /// Frames that are woven at once, where these were typed and are not all.
    pub(super) fn at_once(&self, clip: Domain<3>, way: &Way) -> Result<Option<u32>, Failure> {
        if let Some(frames @ ..5) = self.at_once {
            // Five are enough for regions of a single frame.
            let least = least_at_once(clip.shape[0], &Options { region: self.region.0, ..Options::default() });
            let what = format!("--at-once {frames} is too few");
            return Err(
                Failure::new(2, what).remedy(format!("weave 5 or more at once; {least} are enough for this clip"))
            );
        }
        Ok(self.at_once.filter(|&frames| way.weaves() && frames < way.with_ends().shape[0]))
    }

    /// Frames that may be woven at once where there is no memory for all.
    pub(super) fn may_be_at_once(
        &self,
        clip: Domain<3>,
        way: &Way,
        options: &Options<3>,
    ) -> Option<RangeInclusive<u32>> {
        let (possible, all) = (least_at_once(clip.shape[0], options), way.with_ends().shape[0]);
        let least = possible + possible / MORE_THAN_LEAST;
        (self.at_once.is_none() && least < all).then(|| least..=all - 1)
    }

    /// As the library takes them.
    pub(super) fn options(&self, way: &Way, seam: SeamMeasure, levels: Option<u32>) -> Result<Options<3>, Failure> {
        // Between windows a run is kept at any number of sizes.
        let is_kept_within = self.kept.is_asked() && way.at_once.is_none();
        if is_kept_within {
            self.kept.check_levels(levels)?;
        }
        if let (Some(levels @ 2..), Some(_)) = (levels, &self.start) {
            let what = format!("what --start gives stands already, and cannot be solved at {levels} levels");
            return Err(Failure::new(2, what).remedy("use --levels 1, or leave it out"));
        }
        let is_at_one_size = self.start.is_some() || is_kept_within;
        let options = Options {
            placement: self.placement.into(),
            free: if way.mode == ModeArg::Spacetime { [true; 3] } else { [true, false, false] },
            seam,
            region: self.region.0,
            reach: self.reach.0,
            levels: levels.or(is_at_one_size.then_some(1)),
            ..self.drawing.of(self.refining.of(Options::default()))
        };
        options.validate()?;
        Ok(options)
    }

    /// Weaves, and says what came out.
    pub(super) fn made(
        &self,
        session: &Session<'_>,
        clip: Material<'_>,
        under: Under<'_>,
        write: &WriteArgs,
        used: Used,
    ) -> Result<ClipOutcome, Failure> {
        let Under { way, seam, levels, still, start } = under;
        let (about, exemplars) = (|failure: Failure| failure.about(clip.path), clip.exemplars);
        let start = start.map(|maps| begin(clip, maps, way)).transpose()?;
        let options = self.options(way, seam, levels)?;
        let used = used.without("checkpoint").without("resume").unless("start", Value::Null);
        let command = used.clone().without("at-once").command("video", &[]);
        let keeping = Keeping::open(&self.kept, session, (clip.fingerprint, way), &command)?;
        let Woven { result: map, stats, complete } =
            keeping.weave(session, exemplars, (way, start), &options).map_err(|e| match e {
                Error::RegionExceedsExemplar { .. } => about(Failure::from(e)).remedy("use a smaller --region"),
                Error::Core(selvedge_core::Error::NoSource { .. }) => {
                    about(Failure::from(e)).remedy("mask less of the clip")
                }
                e => about(e.into()),
            })?;
        let map = match still.filter(|_| complete) {
            Some(still) => still.held(session, exemplars, &map, seam)?,
            None => map,
        };
        let motion = Motion::of(exemplars, &map)?;
        let picture = || Shown { output: &features(exemplars, &map)?, map: &map, in_space: false }.picture(Vec::new());
        let preview = (write.preview.is_some() || write.report.is_some()).then(picture).transpose()?;
        let how = how(way, map.domain(), &stats, &motion);
        let used = used
            .set("placement", name_of(stats.settings.placement))
            .set("region", typed(stats.settings.region))
            .set("reach", typed_reach(stats.settings.reach))
            .set("variety", stats.settings.variety)
            .set("levels", stats.settings.levels)
            .set("at-once", way.at_once)
            .unless("at-once", Value::Null);
        let used = self.refining.used(used);
        Ok(ClipOutcome {
            frames: map.domain().shape[0],
            loops: way.loops(),
            played: None,
            how,
            stats: told(way, &stats, &motion),
            options: used,
            surface: None,
            preview,
            map: Some(map),
            mixed: None,
            step: Some(motion.worst()),
            complete,
        })
    }

    /// An upper bound of the bytes that a run takes beside the clip's features.
    pub(super) fn bytes(
        &self,
        clip: (Domain<3>, bool),
        channels: usize,
        (way, is_streamed): (&Way, bool),
        options: &Options<3>,
    ) -> Bytes {
        let output = way.with_ends();
        let kept = self.kept.bytes(output);
        let start = if self.start.is_some() { Bytes::of_samples(output, 8) } else { Bytes(0) };
        let Some(at_once) = way.at_once else {
            return estimate_clip(clip, channels, output, options) + Bytes::of_samples(output, 6) + kept + start;
        };
        let shown = if is_streamed { Bytes(0) } else { Bytes::of_samples(way.output, 6) };
        // What stays of it, and what is left of it without the ends that come twice.
        let ends = if 0 < way.keep { Bytes::of_samples(output, 5) } else { Bytes(0) };
        estimate_in_windows(clip, channels, output, at_once, options) + shown + kept + start + ends
    }
}

/// What maps of the clip show, to go on from.
fn begin(clip: Material<'_>, maps: &ClipMaps, way: &Way) -> Result<Start<3>, Failure> {
    if !clip.frames.iter().zip(&maps.frames).all(|(own, made)| own.blake3 == made.blake3) {
        let failure = Failure::new(3, "the maps of --start were made from other frames").about(clip.path);
        return Err(failure.remedy("give the clip that they were made from"));
    }
    let map = SourceMap::new(maps.ids.clone().with_periodic(way.output.periodic), clip.exemplars.table().clone())?;
    Ok(Start { map, fixed: None, sources: None })
}

/// How much an output moves beside its clip.
struct Motion {
    /// The median step beside the clip's, as root mean squares.
    usual: f64,
    /// The largest step beside the largest that is usual in the clip.
    largest: f64,
    /// The step over the end beside the largest that is usual.
    over_end: f64,
}

impl Motion {
    /// The largest of all steps as jumps are measured: squared.
    fn worst(&self) -> f64 {
        let worst = self.largest.max(self.over_end);
        worst * worst
    }

    /// Of an output whose frames are made two at a time.
    fn of(exemplars: &Exemplars<3>, map: &SourceMap<3>) -> Result<Self, Failure> {
        let (clip, frames) = (&exemplars.sources()[0].features, map.domain().shape[0]);
        // Pixels of frames differ in number where the size does.
        let root = |of: u64, domain: Domain<3>| (of as f64 / domain.strides()[0] as f64).sqrt();
        let of = |a: u32, b: u32| -> Result<f64, Failure> {
            let both = features(exemplars, &clip_maps::frames(map, &[a, b])?)?;
            Ok(root(step(&both, 0, 1).whole(), map.domain()))
        };
        let mut steps = (1..frames).map(|t| of(t - 1, t)).collect::<Result<Vec<f64>, _>>()?;
        steps.sort_by(f64::total_cmp);
        let had = root(median(clip), clip.domain());
        let usual = Usual::of(clip).map_or(0.0, |usual| root(usual.whole(), clip.domain()));
        let [has, largest] =
            [steps.len() / 2, steps.len().saturating_sub(1)].map(|i| steps.get(i).copied().unwrap_or(0.0));
        let beside = |is: f64, of: f64| if of == 0.0 { f64::from(u8::from(0.0 < is)) } else { is / of };
        let usual_of = if had == 0.0 { 1.0 } else { has / had };
        Ok(Self { usual: usual_of, largest: beside(largest, usual), over_end: beside(of(frames - 1, 0)?, usual) })
    }
}

/// What came out, in words.
fn how(way: &Way, output: Domain<3>, stats: &Stats<3>, motion: &Motion) -> String {
    let Domain { shape: [frames, height, width], periodic: [loops, ..] } = output;
    let (what, over_end) = if loops {
        ("loop", format!(", {:.2} of what is usual over its end", motion.over_end))
    } else {
        ("clip", String::new())
    };
    let moved = if way.mode == ModeArg::Temporal { "moved in time" } else { "moved in space and time" };
    let why = way.why.as_ref().map_or(String::new(), |why| format!(" ({}, since {why})", name_of(way.mode)));
    let patches = if stats.patches == 1 { "1 patch".to_owned() } else { format!("{} patches", stats.patches) };
    format!(
        "a {what} of {frames} frames of {width}x{height} px from {} {moved} and {}{why}, moving {:.2} times as much as \
         the clip{over_end}",
        patches,
        n("refinement", stats.improvements as usize),
        motion.usual,
    )
}

/// Counts of a run.
fn told(way: &Way, stats: &Stats<3>, motion: &Motion) -> Value {
    let mut all = counts!(stats, patches, refinements, improvements, cuts, cut_nodes, energy);
    // Energies are those of the smallest of several sizes.
    if 1 < stats.settings.levels || way.at_once.is_some() {
        (all["levels"], all["settled"]) = (stats.settings.levels.into(), json!(stats.settled));
    }
    all["regularity"] = stats.settings.regularity.into();
    all["mode"] = name_of(way.mode).into();
    all["why"] = json!(way.why);
    if let Some(frames) = way.at_once {
        all["at_once"] = frames.into();
    }
    all["motion"] = json!({"usual": motion.usual, "largest": motion.largest, "over_end": motion.over_end});
    all
}
