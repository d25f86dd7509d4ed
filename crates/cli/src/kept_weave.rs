//! A run of patches that is kept.

use std::cell::Cell;
use std::time::{Duration, Instant};

use selvedge_core::{Run, SourceMap, Start, Woven};
use selvedge_graphcut_textures::{Checkpoint, Error, Plan, Stats};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::kept::{Begun, Kept, KeptArgs};
use crate::session::Session;

/// How much time of a run may be lost at most, where no signal says that it ends.
const EVERY: Duration = Duration::from_secs(10);

/// A weave that is kept.
pub(crate) struct KeptWeave<'a, const D: usize> {
    session: &'a Session<'a>,
    kept: Kept<'a>,
    begun: Option<Begun<Checkpoint<D>>>,
    /// Whether anything is kept, or gone on from.
    is_asked: bool,
}

impl<'a, const D: usize> KeptWeave<'a, D> {
    /// Reads what there is to go on from; a run of other inputs, options or another seed is refused.
    pub(crate) fn open(
        args: &KeptArgs,
        session: &'a Session<'a>,
        (what, inputs): (&str, Value),
        options: &str,
    ) -> Result<Self, Failure> {
        let mut head = json!({"version": env!("CARGO_PKG_VERSION"), "seed": session.global.seed(), "options": options});
        head[what] = inputs;
        let begun = args.begun(&head, |bytes| Checkpoint::of_bytes(bytes).ok())?;
        Ok(Self { session, kept: args.open(session, head)?, begun, is_asked: args.is_asked() })
    }

    /// Weaves from where it was, and keeps where it is, if that is asked.
    pub(crate) fn weave(
        &self,
        plan: &Plan<'_, D>,
        start: Start<D>,
        run: &Run<'_, D>,
    ) -> Result<Woven<SourceMap<D>, Stats<D>>, Error> {
        if !self.is_asked {
            return plan.weave(start, run);
        }
        let last = Cell::new(Instant::now());
        let mut keep = |made: &dyn Fn() -> Checkpoint<D>| {
            if last.get().elapsed() < EVERY && self.session.watch.signal().is_none() {
                return;
            }
            self.kept.keep(&[], &|| made().to_bytes());
            last.set(Instant::now());
        };
        plan.weave_on(start, self.begun.as_ref().map(|begun| &begun.from), run, &mut keep)
    }
}
