//! `selvedge random-labels`: the simplest method, which draws patches and keeps them where seams become cheaper. It is
//! compiled for tests alone: it shows that a new method's command is a page of options.

use clap::Args;
use selvedge_core::{Bytes, Domain, Exemplars, Patch, Run, SampleId, SeamCosts, SeamMeasure, SourceMap, Window, Woven};
use selvedge_expansion::{Error, Frame, Holes, Scratch, expand};
use serde_json::json;

use crate::failure::Failure;
use crate::loom::{Loom, Outcome};
use crate::method::{Method, Planned};
use crate::setup::{OutputSize, Setup};
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
    type Read = ();

    fn setup(&self) -> Result<Setup<'_>, Failure> {
        Ok(Setup::new("random-labels", &self.weaving, OutputSize::Exemplar(self.sizing)))
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let read: Bytes = sources.iter().map(|source| Bytes::of_samples(*source, channels as u64 + 9)).sum();
        read + Bytes::of_samples(output, 200)
    }

    fn read(&self, _: &mut Loom<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn plan<'l>(&'l self, loom: &'l Loom<'_>, (): ()) -> Result<Planned<'l>, Failure> {
        Ok(Planned::new(loom.used(), format!("from {} random patches", self.steps), || {
            let run = loom.session.run();
            let woven = random_labels(&loom.loaded.exemplars, loom.domain, self.steps, &run);
            let woven = woven.map_err(|e| Failure::of(e.kind(), &e, e.remedy()))?;
            let (stats, how) = (json!({ "taken": woven.stats }), format!("from {} random patches", woven.stats));
            Ok(Outcome::new(Box::new(woven.result), woven.complete, stats, how))
        }))
    }
}

/// The method, as a crate of its own would have it (an example of `selvedge-expansion`).
fn random_labels(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    steps: u64,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, u64>, Error> {
    let costs = SeamCosts::new(exemplars, SeamMeasure::Difference)?;
    let valid = exemplars.validity();
    let mut map = SourceMap::unassigned(exemplars, output)?;
    let (mut scratch, mut holes, mut taken, mut step, mut draw) = (Scratch::default(), map.holes(), 0, 0, 0);
    while step < steps || 0 < holes {
        let mut rng = run.seed.derive("random-labels/patch", draw).rng();
        (draw, step) = (draw + 1, step + u64::from(holes == 0));
        let hole = map.ids.plane(0).iter().position(|id| !id.is_assigned());
        let at = output.position(hole.unwrap_or_else(|| rng.below(output.len() as u32) as usize));
        let id = SampleId::new(rng.below(exemplars.table().len()));
        let Some((source, from)) = exemplars.locate(id) else { continue };
        if valid[source].is_some_and(|v| !v.get(0, from)) {
            continue;
        }
        let patch = Patch { source, offset: std::array::from_fn(|a| at[a] as i32 - from[a] as i32) };
        let mut window = patch.footprint(exemplars, &Window::all(output));
        for a in 0..2 {
            window.shape[a] = window.shape[a].min(if output.periodic[a] { output.shape[a] } else { u32::MAX });
        }
        let frame = Frame::of_patch(exemplars, &map, &patch, &window.inside(output))?;
        let choices = frame.choices(Holes::Fill, |_| None)?;
        let proposal = match expand(&frame, &choices, &costs, &mut scratch, &|| run.observer.cancelled()) {
            Ok(proposal) => proposal,
            Err(error) if error.is_cancelled() => return Ok(Woven { result: map, stats: taken, complete: false }),
            Err(error) => return Err(error),
        };
        if 0 < proposal.filled || 0 < proposal.gain() {
            proposal.lay(&frame, &mut map);
            (holes, taken) = (holes - proposal.filled, taken + 1);
        }
    }
    Ok(Woven { result: map, stats: taken, complete: true })
}

mod tests;
