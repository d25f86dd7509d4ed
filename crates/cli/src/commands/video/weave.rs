//! The work of what is woven: from what it begins, and all frames at once or some at a time.

use selvedge_core::{Domain, Exemplars, SourceMap, Start, Woven};
use selvedge_graphcut_textures::video::{Ends, woven_in_windows};
use selvedge_graphcut_textures::{Error, Options, Stats, plan};

use super::modes::Way;
use crate::kept_weave::KeptWeave;
use crate::session::Session;

/// What a run came to.
type Made = Result<Woven<SourceMap<3>, Stats<3>>, Error>;

/// Weaves what the way asks for, from what there is, and keeps it.
pub(super) fn weave(
    session: &Session<'_>,
    exemplars: &Exemplars<3>,
    (way, kept, start): (&Way, &KeptWeave<'_, 3>, Option<Start<3>>),
    options: &Options<3>,
) -> Made {
    let run = session.run();
    let in_windows = |start: Start<3>, frames| woven_in_windows(exemplars, start, frames, options, &run);
    let from = |start: Start<3>| match way.at_once {
        Some(frames) => in_windows(start, frames),
        None => kept.weave(&plan(exemplars, start.map.domain(), None, options, &run.limits)?, start, &run),
    };
    if way.keep == 0 {
        return from(start.map_or_else(|| Start::empty(exemplars, way.output), Ok)?);
    }
    let Domain { shape: [frames, height, width], periodic } = way.output;
    let of_clip = exemplars.sources()[0].domain().shape[1..] == [height, width] && periodic == [false; 3];
    let ends = if of_clip {
        Ends::of_clip(exemplars, way.keep)?
    } else {
        let output = Domain { shape: [way.keep, height, width], periodic };
        let woven = in_windows(Start::empty(exemplars, output)?, way.at_once.unwrap_or(way.keep))?;
        if !woven.complete {
            return Ok(woven);
        }
        Ends::woven(woven.result)
    };
    // Ends that were woven are woven again by a run that goes on, to the same frames.
    let woven = from(ends.start(frames)?)?;
    Ok(Woven { result: ends.closed(&woven.result)?, stats: woven.stats, complete: woven.complete })
}
