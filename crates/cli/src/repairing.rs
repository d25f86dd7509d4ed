//! `--repair`: bad seams of a map chosen anew, whichever command made it.

use clap::Args;
use selvedge_core::{Bytes, Domain, Exemplars, Grid, Plane, Role, Samples, SeamMeasure, SourceMap, Start, Woven};
use selvedge_hybrid::{RepairOptions, RepairStats, estimate_repair, repair};
use serde_json::{Value, json};

use crate::course;
use crate::failure::Failure;
use crate::outcome::{Beside, Outcome};
use crate::session::Session;
use crate::thumbnail::Thumbnail;
use crate::used::Used;

/// What pictures of a repair stand under.
const HEADING: &str = "How seams were repaired";

/// Whether and how seams are repaired.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct Repairing {
    /// Repair seams that show: choose the pixels around them anew, as long as all seams become cheaper.
    #[arg(long)]
    repair: bool,
    /// How far around bad seams --repair chooses pixels anew, 1 to 64. Default: 2.
    #[arg(long, value_name = "N")]
    radius: Option<u32>,
    /// Whether exemplars were used around their borders.
    #[arg(skip)]
    circular: bool,
    /// Whether seams are repaired without being asked to, unless a radius of 0 is typed.
    #[arg(skip)]
    always: bool,
}

impl Repairing {
    /// Checks what can be checked without a map.
    pub(crate) fn validate(self) -> Result<(), Failure> {
        if self.always && !self.is_on() {
            return Ok(());
        }
        if self.radius.is_some() && !self.repair && !self.always {
            return Err(Failure::new(2, "--radius has nothing to act on").remedy("give --repair as well"));
        }
        Ok(self.options().validate()?)
    }

    /// The same for maps of exemplars that go on around their borders.
    pub(crate) fn around(self, circular: bool) -> Self {
        Self { circular, ..self }
    }

    /// The same where seams are repaired though nobody asks for it; a radius of 0 asks for none.
    pub(crate) fn always(self, always: bool) -> Self {
        Self { always, ..self }
    }

    /// True if seams are repaired.
    pub(crate) fn is_on(self) -> bool {
        self.repair || self.always && self.radius != Some(0)
    }

    /// Bytes that it takes at most.
    pub(crate) fn bytes(self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        if self.is_on() { estimate_repair(sources, channels, output, self.circular) } else { Bytes(0) }
    }

    /// What a method wove, told by its counts and how it was made, with its seams repaired but for what is fixed.
    /// Nothing is repaired if that was not asked for, or the map is not whole.
    pub(crate) fn outcome<S>(
        self,
        session: &Session<'_>,
        exemplars: &Exemplars<2>,
        mut woven: Woven<SourceMap<2>, S>,
        (kept, sources): (Option<Grid<bool, 2>>, Option<Grid<u64, 2>>),
        (mut stats, mut how): (Value, String),
        is_explained: bool,
    ) -> Result<Outcome, Failure> {
        let mut beside = Beside::default();
        if self.is_on() && woven.complete {
            let start = Start { map: woven.result.clone(), fixed: kept.clone(), sources };
            let mended = repair(exemplars, start, &self.options(), &session.run())?;
            if is_explained {
                beside = Beside { heading: HEADING, pictures: drawn(&woven.result, &mended.result, exemplars)? };
            }
            (woven.result, woven.complete) = (mended.result, mended.complete);
            stats["repair"] = counts(&mended.stats);
            how += &told(&mended.stats);
        }
        Ok(Outcome { kept, beside, ..Outcome::new(Box::new(woven.result), woven.complete, stats, how) })
    }

    /// The options as used: none where nothing is repaired.
    pub(crate) fn used_if_any(self, used: Used) -> Used {
        if self.is_on() {
            return used.set("repair", true).set("radius", self.options().radius);
        }
        let used = used.without("repair");
        if self.always { used } else { used.without("radius") }
    }

    fn options(self) -> RepairOptions {
        let usual = RepairOptions::default();
        RepairOptions { radius: self.radius.unwrap_or(usual.radius), circular: self.circular, ..usual }
    }
}

/// What seams cost before and after, and what was chosen anew.
fn drawn(before: &SourceMap<2>, after: &SourceMap<2>, exemplars: &Exemplars<2>) -> Result<Vec<Thumbnail>, Failure> {
    let seams = course::seams([before, after], exemplars, SeamMeasure::Difference)?;
    let captions = ["Seams before repair, the dearer the brighter", "Seams after it"];
    let mut pictures: Vec<Thumbnail> = seams
        .into_iter()
        .zip(captions)
        .filter_map(|(picture, caption)| Some(Thumbnail::new(picture?, caption)))
        .collect();
    let mut anew = Grid::try_filled(before.domain(), 1, 0_u8)?;
    let ids = before.ids.plane(0).iter().zip(after.ids.plane(0));
    anew.plane_mut(0)
        .iter_mut()
        .zip(ids)
        .for_each(|(anew, (before, after))| *anew = if before == after { 0 } else { 255 });
    let anew = Plane::new(Role::Scalar, Samples::U8(anew));
    pictures.push(Thumbnail::new(anew, "Pixels that repair chose anew, white"));
    Ok(pictures)
}

fn counts(of: &RepairStats) -> Value {
    json!({
        "costs": of.costs,
        "bad_before": of.bad[0],
        "bad_after": of.bad[1],
        "regions": of.regions[0],
        "better": of.regions[1],
        "pixels": of.pixels,
    })
}

/// For people, after what the method did.
fn told(of: &RepairStats) -> String {
    let (before, after) = (of.costs.first().copied().unwrap_or(0), of.costs.last().copied().unwrap_or(0));
    let fall = if before == 0 { 0.0 } else { 100.0 * (before - after) as f64 / before as f64 };
    format!(
        ", {} of {} bad seams repaired at {} pixels, all seams {fall:.1} % cheaper",
        of.bad[0].saturating_sub(of.bad[1]),
        of.bad[0],
        of.pixels
    )
}
