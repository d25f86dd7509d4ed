//! What is told of texture optimization: options as used, counts, how it was made, what is wrong.

use selvedge_core::{Encoder, Exemplar, Exemplars, Plane, Render};
use selvedge_texture_optimization::{Error, Level, LevelStats, Options, Stats};
use serde_json::{Value, json};

use super::Optimize;
use super::init::Init;
use super::levels::typed;
use crate::failure::{Failure, n};
use crate::loaded::ExemplarSet;
use crate::loom::Loom;
use crate::used::Used;
use crate::values::counts;

impl Optimize {
    /// The options as used: what was left to the program.
    pub(super) fn used(&self, loom: &Loom<'_>, init: &Init, options: &Options) -> Used {
        let used = loom
            .used()
            .set("schedule", typed(&options.schedule))
            .set("complete", options.complete.map_or_else(|| Value::from("none"), Value::from))
            .unless("spread", 0.0);
        let used = self.control.used(loom, used);
        match &self.start {
            Some(_) => used.without("init"),
            None => used.set("init", init.typed()),
        }
    }
}

/// What it starts from, for people.
pub(super) fn start(init: &Init) -> &'static str {
    match init {
        Init::Quilt => "a quilt",
        Init::Graphcut => "a graph cut",
        Init::Random => "noise",
        Init::Auto | Init::Map(_) => "a map",
    }
}

/// Counts of a run.
pub(super) fn counts(stats: &Stats) -> Value {
    let level = |l: &LevelStats| {
        let mut counts = counts!(l, neighborhoods, energy, searched, rises, settled);
        (counts["level"], counts["robust_energy"]) = (typed(&[l.level]).into(), json!(l.robust));
        counts
    };
    json!({
        "levels": stats.levels.iter().map(level).collect::<Vec<_>>(),
        "left_out": stats.left_out.iter().map(|l: &Level| typed(&[*l])).collect::<Vec<_>>(),
    })
}

/// For people.
pub(super) fn how(init: &Init, stats: &Stats) -> String {
    let (iterations, levels) = (n("iteration", stats.iterations()), n("level", stats.levels.len()));
    let energy = stats.energy().map_or(String::new(), |e| format!(", energy {e:.1}"));
    format!("from {} by {iterations} at {levels}{energy}", start(init))
}

/// The share of an output that became one blur, which is warned of.
pub(super) fn washed_out(loom: &Loom<'_>, init: &Init, woven: &dyn Render<2>) -> Result<f64, Failure> {
    let payload: Vec<&[Plane<2>]> = loom.loaded.payload.iter().map(std::slice::from_ref).collect();
    let encoder = Encoder::fit(&payload)?;
    let shown: Vec<Exemplar<'_, 2>> = payload.iter().map(|planes| Exemplar::new(planes)).collect();
    let output = woven.render(&loom.loaded.payload.iter().collect::<Vec<_>>())?;
    let features = encoder.encode(std::slice::from_ref(&output))?;
    let share = selvedge_metrics::washed_out(&Exemplars::new(&encoder, &shown)?, &features)?;
    if 0.0 < share {
        let what = format!("{:.0} % of it became a blur without the exemplars' contrast", (100.0 * share).max(1.0));
        let start = if matches!(init, Init::Graphcut | Init::Map(_)) { "" } else { "--init auto, " };
        let remedy = format!("try {start}--complete 0.1 or a smaller size in --schedule");
        loom.session.warn(loom.output(), &format!("{what}; {remedy}"));
    }
    Ok(share)
}

/// Errors about exemplars name the file, and options by their flags.
pub(in crate::commands) fn failure(loaded: &ExemplarSet, error: Error) -> Failure {
    match &error {
        Error::NothingFits { output: false, .. } => {
            let remedy = "use a larger exemplar, mask less, or add a smaller size to --schedule, such as 1:4";
            loaded.about(Failure::from(error).remedy(remedy))
        }
        Error::NothingFits { least, .. } => {
            let remedy = format!("use --size {least} or more, or a smaller size in --schedule, such as 1:4");
            Failure::from(error).remedy(remedy)
        }
        Error::Holes { .. } if loaded.masks.iter().any(Option::is_some) => {
            let what = format!("{error}, of which some may show what --mask hides");
            Failure::of(error.kind(), &what, "mask less, or fill them first: graphcut --start MAP with the same --mask")
        }
        Error::Holes { .. } => Failure::from(error).remedy("fill them first: graphcut --start MAP"),
        Error::Masked { .. } => loaded.about(Failure::from(error)),
        _ => by_flags(error),
    }
}

/// Errors of options alone, by their flags.
pub(super) fn by_flags(error: Error) -> Failure {
    match error {
        Error::Tree => Failure::from(error).remedy("use --complete none, and leave --spread out"),
        _ => Failure::from(error),
    }
}
