//! `selvedge numbers`: texture by numbers. `[CMS V-F]`

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_cms_analogies::Constraint;
use selvedge_core::{Grid, Guide, Plane};
use selvedge_guides::encode_together;

use super::job::{Job, Request};
use super::palette::Palette;
use super::{Knobs, Task};
use crate::failure::Failure;
use crate::followed::{self, Followed};
use crate::loom::Loom;
use crate::method::Method as _;
use crate::pairs::{check_under, listed, over_ground};
use crate::report::Done;
use crate::session::Session;
use crate::weaving::Weaving;

/// Between the paper's 0.5, 10 and 0.6, and its 9, 2 and 1. Of brick, grass and wall, 2 / 2 follows borders best, but
/// of the bricks hardly a joint is left; with 0.5 / 9 joints are there and broken; 2 / 4 was seen with a tolerance of
/// 100, and keeps most of them whole. With a spread of 0.05 more joints are there, with 0.4 they are dashes. Turned, as
/// in the paper, a photograph of a rock lays its waterline into the sea, and cliffs stand on their side; brick, grass
/// and wall are as good either way.
const TASK: Task = Task { weight: 2.0, neighborhood: 4, spread: 0.02, turn: false };

/// Options of `numbers`.
#[derive(Args, Debug)]
pub(crate) struct Numbers {
    #[command(flatten)]
    weaving: Weaving,
    /// A picture of the exemplar's size that has a colour for each kind of texture in it. With several exemplars write
    /// theirs as one list, separated by commas.
    #[arg(long, value_name = "LABELS", value_hint = ValueHint::FilePath)]
    labels: PathBuf,
    /// A picture that has these colours where the output is to have the textures; the output has its size.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    target: PathBuf,
    /// Take all pairs of labels for equally unlike; by default as unlike as their colours.
    #[arg(long)]
    one_hot: bool,
    #[command(flatten)]
    knobs: Knobs,
}

impl Numbers {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let sources = listed(&self.labels, self.weaving.input.exemplars.len(), "--labels one file")?;
        let options = self.knobs.options(TASK);
        Job {
            name: "numbers",
            weaving: &self.weaving,
            knobs: &self.knobs,
            task: TASK,
            options,
            first: &self.target,
            ratio: 1,
            // How many labels there are is known once they are read; two at least.
            channels: if self.one_hot { 2 } else { 3 },
            derived: 0,
            others: sources.iter().chain(std::iter::once(&self.target)).cloned().collect(),
            read: &|job, loom| self.asked(job, loom, &sources),
            files: None,
            frame: None,
        }
        .run(session)
    }

    fn asked(&self, job: &Job<'_>, loom: &mut Loom<'_>, sources: &[PathBuf]) -> Result<Request, Failure> {
        let session = loom.session;
        let labels = Followed::all(loom, sources)?;
        for (number, (path, one)) in sources.iter().zip(&labels).enumerate() {
            check_under(loom, number, path, &one.plane)?;
        }
        let wanted = Followed::read(loom, &self.target)?;
        let planes: Vec<&Plane<2>> = labels.iter().chain([&wanted]).map(|one| &one.plane).collect();
        let mut maps = encode_together(&planes).map_err(|e| Failure::from(e).about(&self.target))?;
        let target = maps.pop().expect("the target's");
        let have = Palette::of(&maps.iter().collect::<Vec<_>>())?;
        let asked = Palette::of(&[&target])?;
        have.check(&asked, &target).map_err(|f| f.about(&self.target))?;
        if self.one_hot {
            job.admit_channels(loom, have.len())?;
        }
        maps.push(target);
        let files = sources.iter().map(PathBuf::as_path).chain(std::iter::once(self.target.as_path()));
        let snaps = self.one_hot || have.is_exact && asked.is_exact;
        let mut snapped = Vec::new();
        for (map, path) in maps.into_iter().zip(files) {
            snapped.push(if snaps { self.snapped(&have, &map, |what| session.warn(path, &what))? } else { map });
        }
        if !snaps {
            let what = "it or its labels have smoothed or compressed colours, which are compared by how near they are";
            session.warn(&self.target, &what);
        }
        let target = snapped.pop().expect("the target's");
        over_ground(loom, &mut snapped, &target)?;
        let guide = Guide::new(&loom.loaded.exemplars, &snapped, target.with_periodic(loom.domain.periodic))?;
        let guide = followed::seen(guide, &labels, &wanted).map_err(|e| e.about(&sources[0]))?;
        // Two channels differ between two labels, of as many as there are labels; K was made for three that do.
        let weight = if self.one_hot { have.len() as f64 / 2.0 } else { 1.0 };
        let palette = self.one_hot.then_some(have);
        Ok(Request { palette, ..Request::one(Constraint { guide, ratio: 1, weight }) })
    }

    /// Every sample as the label that it is nearest to.
    fn snapped(&self, palette: &Palette, map: &Grid<u8, 2>, warn: impl Fn(String)) -> Result<Grid<u8, 2>, Failure> {
        let (labels, changed) = palette.nearest(map)?;
        if changed != 0 {
            let share = 100.0 * changed as f64 / labels.len().max(1) as f64;
            warn(format!("{share:.2} % of its samples are of no label's colour; each was taken for the nearest"));
        }
        Ok(if self.one_hot {
            palette.one_hot(map.domain(), &labels)?
        } else {
            palette.colored(map.domain(), &labels)?
        })
    }
}
