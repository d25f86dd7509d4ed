//! A run of patches that is kept.

use std::cell::Cell;
use std::time::{Duration, Instant};

use selvedge_core::{SourceMap, Start, Woven};
use selvedge_graphcut_textures::{Checkpoint, Error, Plan, Stats};
use serde_json::json;

use crate::clips::Clip;
use crate::failure::Failure;
use crate::kept::{Begun, Kept, KeptArgs};
use crate::session::Session;
use crate::used::Used;

/// How much time of a run may be lost at most, where no signal says that it ends.
const EVERY: Duration = Duration::from_secs(10);

/// A weave that is kept.
pub(super) struct KeptWeave<'a> {
    session: &'a Session<'a>,
    kept: Kept<'a>,
    begun: Option<Begun<Checkpoint<3>>>,
}

impl<'a> KeptWeave<'a> {
    /// Reads what there is to go on from; a run of another clip, options or seed is refused.
    pub(super) fn open(args: &KeptArgs, session: &'a Session<'a>, clip: &Clip, used: &Used) -> Result<Self, Failure> {
        let head = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "clip": clip.fingerprint.blake3,
            "seed": session.global.seed(),
            "options": used.command("video", &[]),
        });
        let begun = args.begun(&head, |bytes| Checkpoint::of_bytes(bytes).ok())?;
        Ok(Self { session, kept: args.open(session, head)?, begun })
    }

    /// Weaves from where it was, and keeps where it is.
    pub(super) fn weave(&self, plan: &Plan<'_, 3>, start: Start<3>) -> Result<Woven<SourceMap<3>, Stats<3>>, Error> {
        let last = Cell::new(Instant::now());
        let mut keep = |made: &dyn Fn() -> Checkpoint<3>| {
            if last.get().elapsed() < EVERY && self.session.watch.signal().is_none() {
                return;
            }
            self.kept.keep(&[], &|| made().to_bytes());
            last.set(Instant::now());
        };
        plan.weave_on(start, self.begun.as_ref().map(|begun| &begun.from), &self.session.run(), &mut keep)
    }
}
