//! A run of patches that is kept.

use std::cell::Cell;
use std::time::{Duration, Instant};

use selvedge_core::{Exemplars, Run, SourceMap, Start, Woven};
use selvedge_graphcut_textures::video::{WindowsCheckpoint, woven_in_windows_on};
use selvedge_graphcut_textures::{Checkpoint, Error, Options, Plan, Stats};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::kept::{Begun, Kept, KeptArgs};
use crate::session::Session;

/// How much time of a run may be lost at most, where no signal says that it ends.
const EVERY: Duration = Duration::from_secs(10);

/// A weave that is kept, as checkpoints of this kind.
pub(crate) struct KeptWeave<'a, C> {
    session: &'a Session<'a>,
    kept: Kept<'a>,
    begun: Option<Begun<C>>,
    /// Whether anything is kept, or gone on from.
    is_asked: bool,
}

impl<'a, C> KeptWeave<'a, C> {
    /// Takes what there is to go on from, as `read` does; a run of other inputs, options or another seed is refused.
    fn opened(
        args: &KeptArgs,
        session: &'a Session<'a>,
        (follows, options): (&[(&str, Value)], &str),
        read: impl FnOnce(&[u8]) -> Result<C, Error>,
    ) -> Result<Self, Failure> {
        let mut head = json!({"version": env!("CARGO_PKG_VERSION"), "seed": session.global.seed(), "options": options});
        follows.iter().for_each(|(what, value)| head[*what] = value.clone());
        let begun = args.begun(&head, |bytes| read(bytes).ok())?;
        Ok(Self { session, kept: args.open(session, head)?, begun, is_asked: args.is_asked() })
    }

    fn from(&self) -> Option<&C> {
        self.begun.as_ref().map(|begun| &begun.from)
    }
}

impl<'a, const D: usize> KeptWeave<'a, Checkpoint<D>> {
    /// Reads what there is to go on from; a run of other inputs, options or another seed is refused.
    pub(crate) fn open(
        args: &KeptArgs,
        session: &'a Session<'a>,
        follows: &[(&str, Value)],
        options: &str,
    ) -> Result<Self, Failure> {
        Self::opened(args, session, (follows, options), Checkpoint::of_bytes)
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
        plan.weave_on(start, self.from(), run, &mut keep)
    }
}

impl<'a> KeptWeave<'a, WindowsCheckpoint> {
    /// The same of a run in windows.
    pub(crate) fn open_windows(
        args: &KeptArgs,
        session: &'a Session<'a>,
        follows: &[(&str, Value)],
        options: &str,
    ) -> Result<Self, Failure> {
        Self::opened(args, session, (follows, options), WindowsCheckpoint::of_bytes)
    }

    /// Weaves so many frames at once from the window that it had come to, and keeps it before each.
    pub(crate) fn in_windows(
        &self,
        exemplars: &Exemplars<3>,
        (start, at_once): (Start<3>, u32),
        options: &Options<3>,
        run: &Run<'_, 3>,
    ) -> Result<Woven<SourceMap<3>, Stats<3>>, Error> {
        let mut keep = |made: &dyn Fn() -> WindowsCheckpoint| {
            if self.is_asked {
                self.kept.keep(&[], &|| made().to_bytes());
            }
        };
        woven_in_windows_on(exemplars, start, (at_once, self.from()), options, run, &mut keep)
    }
}
