//! Clips that go on without a visible period: a walk from jump to jump. `[Kwatra03 7A]`

use std::ops::Range;

use selvedge_core::{Bytes, Domain, Exemplars, Grid, Run, SampleId, SourceMap, reserve};

use super::footage::the_clip;
use super::looping::Loop;
use crate::error::Error;

/// Plays a clip from its first frame for so many frames, and jumps again and again, each time by one of some loops,
/// drawn by the seed, along the loop's own surface.
///
/// From where a jump leads to, any jump may follow whose surface has not begun yet. The same may always follow itself,
/// since no surface is longer than its period: so there are no dead ends. It is drawn like all others: two that only
/// took turns would come again as one longer loop does.
///
/// # Errors
/// [`Error::NoJumps`], [`Error::Surface`] for a loop of another clip, [`Error::OneClip`],
/// [`Error::Frames`], and what [`Limits::admit`](selvedge_core::Limits::admit) refuses.
///
/// # Determinism
/// Jump number `i` is drawn from `"video/walk"`, `i`.
pub fn walk(exemplars: &Exemplars<3>, loops: &[Loop], frames: u32, run: &Run<'_, 3>) -> Result<SourceMap<3>, Error> {
    let clip = the_clip(exemplars)?;
    let [_, height, width] = clip.shape;
    let output = Domain::open([frames, height, width]);
    if loops.is_empty() {
        return Err(Error::NoJumps);
    }
    loops.iter().try_for_each(|looped| looped.surface.check(&looped.jump, clip))?;
    run.limits.admit(output, Bytes::of_samples(output, size_of::<SampleId>() as u64))?;
    let mut ids: Vec<SampleId> = Vec::new();
    reserve(&mut ids, output.len())?;
    let steps = Steps { spans: loops.iter().map(span).collect(), run };
    let mut at = 0;
    for step in 0.. {
        let next = steps.next(step, at);
        let Loop { jump, surface, .. } = &loops[next];
        for frame in at..steps.spans[next].end {
            if ids.len() == output.len() {
                return Ok(SourceMap::new(Grid::from_vec(output, 1, ids)?, exemplars.table().clone())?);
            }
            ids.extend(surface.time.plane(0).iter().zip(0..).map(|(&end, pixel)| {
                let shown = if frame < u32::from(end) { frame } else { frame - jump.period() };
                SampleId::new(shown * height * width + pixel)
            }));
        }
        at = steps.spans[next].end - jump.period();
    }
    unreachable!("the walk ends with its frames")
}

/// The frames in which the pixels of a loop jump: none has jumped before the first, all have after the last.
fn span(looped: &Loop) -> Range<u32> {
    let times = looped.surface.time.plane(0);
    let ends = |end: Option<&u16>| end.map_or(0, |&end| u32::from(end));
    ends(times.iter().min())..ends(times.iter().max())
}

/// Who may follow whom.
struct Steps<'a> {
    /// When pixels jump.
    spans: Vec<Range<u32>>,
    run: &'a Run<'a, 3>,
}

impl Steps<'_> {
    /// The next jump, where all pixels show frame `at`.
    fn next(&self, step: u64, at: u32) -> usize {
        let ahead: Vec<usize> = (0..self.spans.len()).filter(|&i| at <= self.spans[i].start).collect();
        let drawn = self.run.seed.derive("video/walk", step).rng().below(ahead.len() as u32);
        ahead[drawn as usize]
    }
}
