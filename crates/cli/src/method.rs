//! A command that weaves, as a page of options: what it tells of itself, in the order in which it is asked. All else is
//! one way for all of them: files, masks, budget, maps, reports, provenance.

use selvedge_core::{Bytes, Domain, Guide};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::loom::Loom;
use crate::outcome::Outcome;
use crate::report::Done;
use crate::session::Session;
use crate::setup::Setup;
use crate::used::Used;

/// A method of the program.
pub(crate) trait Method {
    /// What is known before exemplars are read. Refuses options that are wrong by themselves, cheapest first.
    fn setup(&self, session: &Session<'_>) -> Result<Setup<'_>, Failure>;

    /// An upper bound of its own memory, as far as it is known before exemplars are read: domains of the sources,
    /// feature channels, output. What follows from what they show is [admitted](Method::admit) by the plan.
    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes;

    /// What it takes on top of that where not all of the sources may be used.
    fn masking(&self, _: &[Domain<2>], _channels: usize, _output: Domain<2>) -> Bytes {
        Bytes(0)
    }

    /// What choosing by what exemplars show takes, with masks or without, before the work.
    fn choosing(&self, _: &[Domain<2>], _: usize, _masked: bool) -> Bytes {
        Bytes(0)
    }

    /// Refuses a plan that takes too much: `own` bytes for an output, with what is known without it.
    fn admit(&self, loom: &Loom<'_>, own: &dyn Fn(Domain<2>) -> Bytes) -> Result<Bytes, Failure> {
        let (sources, channels) = loom.sources();
        loom.admit(&|output| own(output) + self.bytes(&sources, channels, output))
    }

    /// Refuses what holes of a guide take that the exemplars do not have, of which no header told, where there is no
    /// room for it.
    fn admit_holes(&self, loom: &mut Loom<'_>, guides: &[&Guide<2>]) -> Result<(), Failure> {
        if !guides.iter().any(|guide| loom.loaded.has_fewer_holes(guide)) {
            return Ok(());
        }
        let (sources, channels) = loom.sources();
        loom.admit_more(self.masking(&sources, channels, loom.domain))
    }

    /// Reads what it needs besides the exemplars; all that is chosen before the work, which a dry run tells, and the
    /// work.
    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure>;

    /// Runs the command.
    fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let estimate = |sources: &[_], channels, output, masked| {
            let masking = if masked { self.masking(sources, channels, output) } else { Bytes(0) };
            (self.bytes(sources, channels, output) + masking).then(self.choosing(sources, channels, masked))
        };
        let mut loom = self.setup(session)?.begin(session, &estimate)?;
        let PlannedRun { used, how, needed, counts, work } = self.plan(&mut loom)?;
        let outcome = if session.global.dry_run {
            drop(work);
            None
        } else {
            Some(work()?)
        };
        if let Some(needed) = needed {
            loom.report.estimate = Some(needed.0);
        }
        match outcome {
            Some(outcome) => loom.finish(used, outcome),
            None => {
                loom.report.stats = counts;
                Ok(loom.would(used, &how))
            }
        }
    }
}

/// A run of which all is chosen and nothing is done.
pub(crate) struct PlannedRun<'l> {
    /// The options as used.
    pub(crate) used: Used,
    /// How it would be made, for people.
    pub(crate) how: String,
    /// Bytes that were admitted for what was chosen; else those known from headers count.
    pub(crate) needed: Option<Bytes>,
    /// How much of what would be laid, as far as that is known.
    pub(crate) counts: Value,
    pub(crate) work: Work<'l>,
}

/// Does it.
pub(crate) type Work<'l> = Box<dyn FnOnce() -> Result<Outcome, Failure> + 'l>;

impl<'l> PlannedRun<'l> {
    pub(crate) fn new(
        used: Used,
        how: impl Into<String>,
        work: impl FnOnce() -> Result<Outcome, Failure> + 'l,
    ) -> Self {
        Self { used, how: how.into(), needed: None, counts: json!({}), work: Box::new(work) }
    }

    /// The same with the bytes that were admitted for it.
    pub(crate) fn needing(self, needed: Bytes) -> Self {
        Self { needed: Some(needed), ..self }
    }

    /// The same with what is known of how much would be laid.
    pub(crate) fn counting(self, counts: Value) -> Self {
        Self { counts, ..self }
    }
}
