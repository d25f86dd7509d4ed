//! `selvedge analogy`: A is to A' as B is to B'. `[CMS V-D]`

use clap::Args;
use selvedge_cms_analogies::Constraint;
use selvedge_core::{Grid, Guide};
use selvedge_guides::luminance;

use super::frames::{Frame, SequenceArgs, Typed};
use super::job::{Job, Request};
use super::{Knobs, Task};
use crate::clips;
use crate::correspondence::Correspondence;
use crate::failure::Failure;
use crate::loom::Loom;
use crate::method::Method as _;
use crate::pairs::Pair;
use crate::report::Done;
use crate::session::Session;
use crate::weaving::Weaving;

/// The paper's for filters are 20 and 5. With them a drawing that four guides lead comes in blocks, and so does a
/// blurred picture; with 2 and 2 strokes stay whole, and edges are where the guides have them. Turned exemplars bring
/// strokes that cross, and light from below. `[CMS V-D]`
const TASK: Task = Task { weight: 2.0, neighborhood: 2, spread: 0.0, turn: false };

/// Options of `analogy`.
#[derive(Args, Debug)]
#[command(mut_arg("exemplars", |arg| arg
    .value_names(["A", "A'", "B"])
    .num_args(3..)
    .help("A picture before and after, and the one to do the same to; several pairs may come before the last")))]
pub(crate) struct Analogy {
    #[command(flatten)]
    weaving: Weaving,
    /// Compare luminance alone, B's brought to A's mean and spread: where their colours have nothing in common.
    #[arg(long)]
    luminance: bool,
    /// Follow more of B, which is made from it as from A, each with its weight: luminance, blur (what is larger than a
    /// stroke), orientation, edge (how far the nearest one is) or position (where in the picture).
    #[arg(long, value_name = "WHAT[=WEIGHT]", value_delimiter = ',')]
    auto_guides: Vec<Correspondence>,
    #[command(flatten)]
    sequence: SequenceArgs,
    #[command(flatten)]
    knobs: Knobs,
}

impl Analogy {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let target = self.weaving.input.exemplars.last().filter(|target| clips::is_pattern(target));
        if let Some(target) = target {
            let typed = Typed { weaving: &self.weaving, sequence: &self.sequence, knobs: &self.knobs };
            return typed
                .frames(session, target, &|weaving, knobs, frame| self.one(session, weaving, knobs, Some(frame)));
        }
        SequenceArgs::check_single(session)?;
        self.one(session, &self.weaving, &self.knobs, None)
    }

    /// One picture, or one frame.
    fn one(
        &self,
        session: &Session<'_>,
        typed: &Weaving,
        knobs: &Knobs,
        frame: Option<&Frame<'_>>,
    ) -> Result<Done, Failure> {
        let files = &typed.input.exemplars;
        let Some((target, before_and_after)) = files.split_last().filter(|(_, pairs)| pairs.len().is_multiple_of(2))
        else {
            let what = format!("{} pictures are no pairs and one more", files.len());
            return Err(Failure::new(2, what).remedy("give A and A' of each pair, and B last"));
        };
        let [before, after] = [0, 1].map(|k| before_and_after.iter().skip(k).step_by(2).cloned().collect::<Vec<_>>());
        let mut weaving = typed.clone();
        weaving.input.exemplars = after;
        let pair = Pair { sources: before, target: target.clone(), weight: 1.0 };
        let options = knobs.options(TASK);
        Job {
            name: "analogy",
            weaving: &weaving,
            knobs,
            task: TASK,
            options,
            first: target,
            ratio: 1,
            channels: 3,
            derived: self.auto_guides.len(),
            others: pair.files().cloned().collect(),
            read: &|_, loom| self.asked(loom, &pair),
            // Those of a frame are made by the command for all.
            files: Some(self.weaving.input.exemplars.clone()),
            frame,
        }
        .run(session)
    }

    /// The pair's, and those made from it.
    fn asked(&self, loom: &mut Loom<'_>, pair: &Pair) -> Result<Request, Failure> {
        let guide = pair.read(loom)?;
        if self.luminance && self.knobs.start.backdrop().is_some() {
            let what = "--luminance brings B to A's light, and --over lays a picture in the light of B";
            return Err(Failure::new(2, what).remedy("leave one of both out"));
        }
        let guide = if self.luminance { matched(&guide)? } else { guide };
        let light = guide.derive(luminance)?;
        let derived =
            |c: &Correspondence| Ok(Constraint { weight: c.weight, ..Constraint::new(c.what.of(&light, 0.0)?) });
        let all: Result<Vec<_>, Failure> = self.auto_guides.iter().map(derived).collect();
        Ok(Request {
            constraints: std::iter::once(Constraint::new(guide)).chain(all?).collect(),
            after: None,
            palette: None,
        })
    }
}

/// Luminance, the target's mean and spread those of the sources.
fn matched(guide: &Guide<2>) -> Result<Guide<2>, Failure> {
    let light = guide.derive(luminance)?;
    let of = |map: &Grid<u8, 2>, mask: Option<&Grid<bool, 2>>| {
        let counts = |(i, v): (usize, &u8)| mask.is_none_or(|mask| mask.samples()[i]).then_some(*v);
        map.samples().iter().enumerate().filter_map(counts).collect::<Vec<u8>>()
    };
    let sources = light.exemplars().sources().iter().map(|s| of(&s.features, s.valid.as_deref()));
    let asked = light.asked().map(|asked| asked.map(|v| v)).transpose()?;
    let (own, theirs) = (moments(&sources.collect::<Vec<_>>()), moments(&[of(light.target(), asked.as_ref())]));
    let by = if 0.0 < theirs.1 { own.1 / theirs.1 } else { 1.0 };
    let target = light.target().map(|v| ((f64::from(v) - theirs.0) * by + own.0 + 0.5).clamp(0.0, 255.0) as u8)?;
    let light = light.with_target(target)?;
    Ok(match asked {
        Some(asked) => light.asking(asked)?,
        None => light,
    })
}

/// Mean and standard deviation.
fn moments(maps: &[Vec<u8>]) -> (f64, f64) {
    let all = || maps.iter().flatten().map(|&v| u64::from(v));
    let (n, sum, squares) = all().fold((0_u64, 0_u64, 0_u64), |(n, s, q), v| (n + 1, s + v, q + v * v));
    let mean = sum as f64 / n.max(1) as f64;
    (mean, (squares as f64 / n.max(1) as f64 - mean * mean).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Exemplars, Plane, Role, Samples};

    #[test]
    fn targets_get_the_sources_mean_and_spread() {
        let row = |samples: &[u8]| Grid::from_vec(Domain::open([1, 4]), 1, samples.to_vec()).unwrap();
        let plane = [Plane::new(Role::Scalar, Samples::U8(row(&[1, 2, 3, 4])))];
        let exemplars = Exemplars::of(&[&plane[..]]).unwrap();
        let guide = Guide::new(&exemplars, &[row(&[0, 100, 0, 100])], row(&[20, 30, 20, 30])).unwrap();
        assert_eq!(matched(&guide).unwrap().target().samples(), [0, 100, 0, 100]);
        let flat = guide.with_target(row(&[7; 4])).unwrap();
        assert_eq!(matched(&flat).unwrap().target().samples(), [50; 4]);
    }
}
