//! `--repair`: bad seams of a map chosen anew, whichever command made it.

use clap::Args;
use selvedge_core::{Domain, Exemplars, Grid, SourceMap, Start, Woven};
use selvedge_hybrid::{RepairOptions, RepairStats, estimate_repair, repair};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::session::Session;
use crate::used::Used;

/// Whether and how seams are repaired.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Repairing {
    /// Repair seams that show: choose the pixels around them anew, as long as all seams become cheaper.
    #[arg(long)]
    repair: bool,
    /// How far around bad seams --repair chooses pixels anew, 1 to 64. Default: 2.
    #[arg(long, value_name = "N")]
    radius: Option<u32>,
}

impl Repairing {
    /// Checks what can be checked without a map.
    pub(crate) fn validate(self) -> Result<(), Failure> {
        if self.radius.is_some() && !self.repair {
            return Err(Failure::new(2, "--radius has nothing to act on").remedy("give --repair as well"));
        }
        Ok(self.options().validate()?)
    }

    /// True if seams are repaired.
    pub(crate) fn is_on(self) -> bool {
        self.repair
    }

    /// Bytes that it takes at most.
    pub(crate) fn bytes(self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> u64 {
        if self.repair { estimate_repair(sources, channels, output) } else { 0 }
    }

    /// The map with its seams repaired, but for what is fixed, and what was done; none if that was not asked for, or the map is not
    /// whole.
    pub(crate) fn mend<S>(
        self,
        session: &Session<'_>,
        exemplars: &Exemplars<2>,
        woven: &mut Woven<SourceMap<2>, S>,
        (fixed, sources): (Option<&Grid<bool, 2>>, Option<Grid<u64, 2>>),
    ) -> Result<Option<RepairStats>, Failure> {
        if !self.repair || !woven.complete {
            return Ok(None);
        }
        let start = Start { map: woven.result.clone(), fixed: fixed.cloned(), sources };
        let mended = repair(exemplars, start, &self.options(), &session.run())?;
        (woven.result, woven.complete) = (mended.result, mended.complete);
        Ok(Some(mended.stats))
    }

    /// The options as used: none where nothing is repaired.
    pub(crate) fn used_if_any(self, used: Used) -> Used {
        if self.repair { used.set("radius", self.options().radius) } else { used.without("repair").without("radius") }
    }

    fn options(self) -> RepairOptions {
        let usual = RepairOptions::default();
        RepairOptions { radius: self.radius.unwrap_or(usual.radius), ..usual }
    }
}

/// The counts of a method with those of its repair.
pub(crate) fn with_repair(mut stats: Value, repair: Option<&RepairStats>) -> Value {
    if let (Some(of), Some(stats)) = (repair, stats.as_object_mut()) {
        let repair = json!({
            "costs": of.costs,
            "bad_before": of.bad[0],
            "bad_after": of.bad[1],
            "regions": of.regions[0],
            "better": of.regions[1],
            "pixels": of.pixels,
        });
        stats.insert("repair".into(), repair);
    }
    stats
}

/// The same for people.
pub(crate) fn how(repair: Option<&RepairStats>) -> String {
    repair.map_or(String::new(), |of| {
        let (before, after) = (of.costs.first().copied().unwrap_or(0), of.costs.last().copied().unwrap_or(0));
        let fall = if before == 0 { 0.0 } else { 100.0 * (before - after) as f64 / before as f64 };
        format!(
            ", {} of {} bad seams repaired at {} pixels, all seams {fall:.1} % cheaper",
            of.bad[0].saturating_sub(of.bad[1]),
            of.bad[0],
            of.pixels
        )
    })
}
