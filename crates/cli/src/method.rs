//! A command that weaves, as a page of options: what it tells of itself, in the order in which it is asked. All else is
//! one way for all of them: files, masks, budget, maps, reports, provenance.

use selvedge_core::{Bytes, Domain};

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

    /// An upper bound of its own memory: domains of the sources, feature channels, output.
    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes;

    /// The same where all samples of the exemplars are valid.
    fn bytes_of_whole(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        self.bytes(sources, channels, output)
    }

    /// Reads what it needs besides the exemplars; all that is chosen before the work, which a dry run tells, and the
    /// work.
    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<Planned<'l>, Failure>;

    /// Runs the command.
    fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let estimate = |sources: &[_], channels, output, masked| match masked {
            true => self.bytes(sources, channels, output),
            false => self.bytes_of_whole(sources, channels, output),
        };
        let mut loom = self.setup(session)?.begin(session, &estimate)?;
        let Planned { used, how, work } = self.plan(&mut loom)?;
        if session.global.dry_run {
            drop(work);
            return Ok(loom.would(used, &how));
        }
        let outcome = work()?;
        loom.finish(used, outcome)
    }
}

/// A run of which all is chosen and nothing is done.
pub(crate) struct Planned<'l> {
    /// The options as used.
    pub(crate) used: Used,
    /// How it would be made, for people.
    pub(crate) how: String,
    pub(crate) work: Work<'l>,
}

/// Does it.
pub(crate) type Work<'l> = Box<dyn FnOnce() -> Result<Outcome, Failure> + 'l>;

impl<'l> Planned<'l> {
    pub(crate) fn new(
        used: Used,
        how: impl Into<String>,
        work: impl FnOnce() -> Result<Outcome, Failure> + 'l,
    ) -> Self {
        Self { used, how: how.into(), work: Box::new(work) }
    }
}
