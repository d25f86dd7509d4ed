//! `selvedge transfer --method cms`: the same guides, followed by labels. `[CMS V-E]`

use selvedge_cms_analogies::{Constraint, Options, Plan, Sizes, estimate, fitness_from};
use selvedge_core::{Bytes, Domain, Guide, Start};

use super::{OF_BLOCKS, Transfer};
use crate::commands::analogies::told::{failure, outcome, warn_of_saturation};
use crate::commands::analogies::{fit, shown};
use crate::failure::Failure;
use crate::loom::Loom;
use crate::method::PlannedRun;
use crate::options::Turning;
use crate::outcome::{Beside, Outcome};
use crate::setup::Setup;
use crate::used::Used;

/// Between the paper's for weave, 0.4 and 4, and for rice, 0.2 and 5. `[CMS V-E]`
const WEIGHT: f64 = 0.4;
const NEIGHBORHOOD: u32 = 4;
/// Where nobody says another. Without it the dark coat of a portrait in rice is laid from its two flattest places, in
/// grey squares; from .02 on it has grains, with .05 faces are as they were and the grains more.
const SPREAD: f64 = 0.05;

impl Transfer {
    /// What labels need besides what is followed.
    pub(super) fn setup_labels<'s>(&'s self, setup: Setup<'s>) -> Result<Setup<'s>, Failure> {
        self.options_of_labels().validate()?;
        Ok(Setup { transforms: Turning { turn: true, mirror: false }.transforms(), ..setup })
    }

    /// What labels take, where some samples may not be used or all may.
    pub(super) fn bytes_of_labels(
        &self,
        sources: &[Domain<2>],
        channels: usize,
        output: Domain<2>,
        holes: bool,
    ) -> Bytes {
        let guides = self.followed.channels();
        let sizes = Sizes { sources, channels, constraints: &[(guides, 1)], output, holes };
        let each = 2 * guides as u64 + 12 + self.followed.masks();
        let maps = sources.iter().chain(std::iter::once(&output)).map(|domain| Bytes::of_samples(*domain, each)).sum();
        let page = if self.weaving.report.is_some() { shown::bytes(output) } else { Bytes(0) };
        estimate(&sizes, &self.options_of_labels()) + maps + page
    }

    pub(super) fn plan_labels<'l>(&'l self, loom: &'l Loom<'_>, guide: Guide<2>) -> Result<PlannedRun<'l>, Failure> {
        let (options, run) = (self.options_of_labels(), loom.session.run());
        let constraints = vec![Constraint::new(guide)];
        let plan = Plan::new(&loom.loaded.exemplars, constraints, &options, &run).map_err(failure)?;
        let start = Start::empty(&loom.loaded.exemplars, loom.domain)?;
        let followed = self.followed.first(&self.weaving)?;
        let seen = plan.constraints();
        let mut fits = fitness_from(&loom.loaded.exemplars, seen, &start, &options).map_err(failure)?;
        let fit = fits.remove(0);
        fit::warn(loom.session, &followed, &fit, "--match-histogram brings their light together");
        let used = self
            .followed
            .used(loom)
            .set("constraint-weight", options.constraint_weight)
            .set("neighborhood", options.neighborhood)
            .set("spread", options.spread);
        let used = OF_BLOCKS.into_iter().fold(used, Used::without);
        Ok(PlannedRun::new(used, "by labels", move || {
            let (woven, course) = shown::woven(loom, &plan, &start, None)?;
            warn_of_saturation(loom.session, &woven.stats, &followed);
            let mut outcome = Outcome { course, ..outcome(woven) };
            outcome.stats["fitness"] = std::iter::once(fit::json(&fit)).collect();
            if loom.is_explained() {
                let target = plan.constraints()[0].guide.target();
                outcome.beside = Beside { heading: fit::HEADING, pictures: vec![fit::drawn(&followed, target, &fit)?] };
            }
            Ok(outcome)
        }))
    }

    fn options_of_labels(&self) -> Options {
        Options {
            constraint_weight: self.following.constraint_weight.unwrap_or(WEIGHT),
            neighborhood: self.following.neighborhood.unwrap_or(NEIGHBORHOOD),
            spread: self.spread.unwrap_or(SPREAD),
            levels: None,
            ..Options::paper()
        }
    }
}
