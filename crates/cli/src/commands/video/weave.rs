//! The work of what is woven: from what it begins, all frames at once or some at a time, and kept.

use selvedge_core::{Domain, Exemplars, SourceMap, Start, Woven};
use selvedge_graphcut_textures::video::{Ends, WindowsCheckpoint, woven_in_windows};
use selvedge_graphcut_textures::{Checkpoint, Error, Options, Stats, plan};
use selvedge_io::Fingerprint;
use serde_json::Value;

use super::modes::Way;
use crate::failure::Failure;
use crate::kept::KeptArgs;
use crate::kept_weave::KeptWeave;
use crate::session::Session;

/// What a run came to.
type Made = Result<Woven<SourceMap<3>, Stats<3>>, Error>;

/// A run that is kept.
pub(super) enum Keeping<'a> {
    Whole(KeptWeave<'a, Checkpoint<3>>),
    /// So many frames at once.
    Windows(u32, KeptWeave<'a, WindowsCheckpoint>),
}

impl<'a> Keeping<'a> {
    /// Reads what there is to go on from; a run of another clip, other options, windows or another seed is refused.
    pub(super) fn open(
        args: &KeptArgs,
        session: &'a Session<'a>,
        (clip, way): (&Fingerprint, &Way),
        options: &str,
    ) -> Result<Self, Failure> {
        let at_once = way.at_once.map_or_else(|| "all".into(), Value::from);
        let blake3 = clip.blake3.clone();
        let follows = [("clip", blake3.into()), ("number of frames at once", at_once)];
        Ok(match way.at_once {
            None => Self::Whole(KeptWeave::open(args, session, &follows, options)?),
            Some(frames) => Self::Windows(frames, KeptWeave::open_windows(args, session, &follows, options)?),
        })
    }

    /// Weaves what the way asks for, from what there is.
    pub(super) fn weave(
        &self,
        session: &Session<'_>,
        exemplars: &Exemplars<3>,
        (way, start): (&Way, Option<Start<3>>),
        options: &Options<3>,
    ) -> Made {
        if way.keep == 0 {
            let start = start.map_or_else(|| Start::empty(exemplars, way.output), Ok)?;
            return self.from(session, exemplars, start, options);
        }
        let Domain { shape: [frames, height, width], periodic } = way.output;
        let of_clip = exemplars.sources()[0].domain().shape[1..] == [height, width] && periodic == [false; 3];
        let ends = if of_clip {
            Ends::of_clip(exemplars, way.keep)?
        } else {
            let output = Domain { shape: [way.keep, height, width], periodic };
            let at_once = way.at_once.unwrap_or(way.keep);
            let woven =
                woven_in_windows(exemplars, Start::empty(exemplars, output)?, at_once, options, &session.run())?;
            if !woven.complete {
                return Ok(woven);
            }
            Ends::woven(woven.result)
        };
        // Ends that were woven are woven again by a run that goes on, to the same frames.
        let woven = self.from(session, exemplars, ends.start(frames)?, options)?;
        Ok(Woven { result: ends.closed(&woven.result)?, stats: woven.stats, complete: woven.complete })
    }

    fn from(&self, session: &Session<'_>, exemplars: &Exemplars<3>, start: Start<3>, options: &Options<3>) -> Made {
        let run = session.run();
        match self {
            Self::Whole(kept) => {
                let plan = plan(exemplars, start.map.domain(), None, options, &run.limits)?;
                kept.weave(&plan, start, &run)
            }
            Self::Windows(frames, kept) => kept.in_windows(exemplars, (start, *frames), options, &run),
        }
    }
}
