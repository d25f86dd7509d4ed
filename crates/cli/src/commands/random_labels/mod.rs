//! `selvedge random-labels`: the simplest method, which draws patches and keeps them where seams become cheaper. It is
//! compiled for tests alone: it shows that a new method's command is a page of options.

use clap::Args;
use selvedge_core::{Bytes, Domain};
use serde_json::json;

use crate::failure::Failure;
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::outcome::Outcome;
use crate::output_size::OutputSize;
use crate::session::Session;
use crate::setup::Setup;
use crate::weaving::{Sizing, Weaving};

/// Options of `random-labels`.
#[derive(Args, Debug)]
pub(crate) struct RandomLabels {
    #[command(flatten)]
    weaving: Weaving,
    #[command(flatten)]
    sizing: Sizing,
    /// Patches that are drawn after everything is covered.
    #[arg(long, value_name = "N", default_value_t = 20)]
    steps: u64,
}

impl Method for RandomLabels {
    fn setup(&self, _: &Session<'_>) -> Result<Setup<'_>, Failure> {
        Ok(Setup::new("random-labels", &self.weaving, OutputSize::Exemplar(self.sizing)))
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let read: Bytes = sources.iter().map(|source| Bytes::of_samples(*source, channels as u64 + 9)).sum();
        read + Bytes::of_samples(output, 200)
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        let loom = &*loom;
        Ok(PlannedRun::new(loom.used(), format!("from {} random patches", self.steps), || {
            let run = loom.session.run();
            let woven = example::random_labels(&loom.loaded.exemplars, None, loom.domain, self.steps, &run);
            let woven = woven.map_err(|e| Failure::of(e.kind(), &e, e.remedy()))?;
            let (stats, how) = (json!({ "taken": woven.stats }), format!("from {} random patches", woven.stats));
            Ok(Outcome::new(Box::new(woven.result), woven.complete, stats, how))
        }))
    }
}

/// The method, which is all that a crate of its own would hold.
#[path = "../../../../expansion/examples/random_labels.rs"]
#[expect(dead_code, reason = "its `main` shows it on a picture of its own")]
mod example;
mod tests;
