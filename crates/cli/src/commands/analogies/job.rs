//! A command of constrained synthesis whose options were understood: the run that all of them are.

use std::path::{Path, PathBuf};

use selvedge_cms_analogies::{Constraint, Error, Options, Plan, fitness_from};
use selvedge_core::{Bytes, Domain};

use super::frames::Frame;
use super::palette::Palette;
use super::told::{failure, outcome, warn_of_saturation};
use super::{Knobs, Task, fit, shown};
use crate::failure::{Failure, n};
use crate::ground;
use crate::inputs::Input;
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::names;
use crate::outcome::{After, Beside, Outcome};
use crate::output_size::OutputSize;
use crate::pairs::Pair;
use crate::session::Session;
use crate::setup::Setup;
use crate::weaving::Weaving;

/// Reads what a command asks for.
pub(super) type Read<'a> = dyn Fn(&Job<'_>, &mut Loom<'_>) -> Result<Request, Failure> + 'a;

/// What a command asks for.
pub(super) struct Request {
    /// Its own constraint, and those made from it.
    pub(super) constraints: Vec<Constraint>,
    /// What is done to the picture at the end.
    pub(super) after: Option<After>,
    /// The labels that are the channels of its own constraint, if they are.
    pub(super) palette: Option<Palette>,
}

impl Request {
    /// One constraint alone.
    pub(super) fn one(constraint: Constraint) -> Self {
        Self { constraints: vec![constraint], after: None, palette: None }
    }
}

/// A command of constrained synthesis whose options were understood.
pub(super) struct Job<'a> {
    pub(super) name: &'static str,
    pub(super) weaving: &'a Weaving,
    pub(super) knobs: &'a Knobs,
    pub(super) task: Task,
    pub(super) options: Options,
    /// The picture of the command's own constraint: the output has its size, or follows from it.
    pub(super) first: &'a Path,
    /// How many times larger the output is than that.
    pub(super) ratio: u32,
    /// Channels of its own constraint at most.
    pub(super) channels: usize,
    /// How many are made from that.
    pub(super) derived: usize,
    /// All other files.
    pub(super) others: Vec<PathBuf>,
    pub(super) read: &'a Read<'a>,
    /// What its canonical command has where other commands have their exemplars.
    pub(super) files: Option<Vec<PathBuf>>,
    /// What it has from the frame before, if it is one.
    pub(super) frame: Option<&'a Frame<'a>>,
}

impl Job<'_> {
    /// What brings what is followed nearer to what lies under the exemplars.
    fn alike(&self) -> &'static str {
        match self.name {
            "numbers" => "of the same colours",
            "detail" => "of the same light, and reduced by the same --kernel",
            _ => "analogy has --luminance",
        }
    }

    /// The name of `--mapped`.
    fn mapped(&self) -> Option<PathBuf> {
        self.knobs.mapped.as_ref().map(|path| names::of_plane(path, &self.weaving.input.exemplars[0]))
    }

    /// An error, with the name of the picture that is too small where it is one's.
    fn small(&self, loom: &Loom<'_>, error: Error) -> Failure {
        let small = match &error {
            Error::Neighborhood { what: "an output", .. } => Some(self.first),
            Error::Neighborhood { shape, .. } => loom.loaded.of_shape(shape),
            _ => None,
        };
        let failure = failure(error);
        match small {
            Some(path) => failure.about(path),
            None => failure,
        }
    }
}

impl Method for Job<'_> {
    fn setup(&self, session: &Session<'_>) -> Result<Setup<'_>, Failure> {
        let pairs = self.knobs.guides.pairs(self.weaving)?;
        self.options.validate()?;
        let first = Input::new(session, self.first)?;
        let start = &self.knobs.start;
        let ground = start.ground(session)?;
        let keeps = !ground.is_bare();
        let size = match keeps {
            true => OutputSize::Upon(ground.into(), first, self.ratio),
            false => OutputSize::Picture(first, self.ratio),
        };
        let followed = self.others.iter().chain(pairs.iter().flat_map(Pair::files)).cloned();
        Ok(Setup {
            writes: self.mapped().into_iter().collect(),
            others: followed.chain(self.knobs.follow_where.clone()).chain(start.files()).collect(),
            backdrop: start.backdrop(),
            keeps,
            transforms: self.knobs.turning(self.task).transforms(),
            blending: self.knobs.blending,
            guides: pairs.len(),
            files: self.files.clone(),
            ..Setup::new(self.name, self.weaving, size)
        })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        self.bytes_with((self.channels, false), sources, channels, output)
    }

    fn masking(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let of = |holes| self.bytes_with((self.channels, holes), sources, channels, output);
        Bytes(of(true).0.saturating_sub(of(false).0))
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        let mut followed = vec![self.first.to_path_buf()];
        let Request { mut constraints, after, palette } = (self.read)(self, loom)?;
        let derived = constraints.split_off(1);
        for pair in self.knobs.guides.pairs(self.weaving)? {
            constraints.push(Constraint { guide: pair.read(loom)?, ratio: 1, weight: pair.weight });
            followed.push(pair.target);
        }
        constraints.extend(derived);
        if let Some(path) = &self.knobs.follow_where {
            let asked = ground::mask(loom, path)?;
            let asking = |c: Constraint| Ok(Constraint { guide: c.guide.asking(asked.map(|v| v)?)?, ..c });
            constraints = constraints.into_iter().map(asking).collect::<Result<_, Failure>>()?;
        }
        self.admit_holes(loom, &constraints.iter().map(|c| &c.guide).collect::<Vec<_>>())?;
        let mut start = loom.start()?;
        if let Some((begun, shown)) = self.frame.map_or(Ok(None), |frame| frame.begun(loom))? {
            constraints.push(shown);
            start = begun;
        }
        let loom = &*loom;
        let (exemplars, run) = (&loom.loaded.exemplars, loom.session.run());
        let plan = Plan::new(exemplars, constraints, &self.options, &run).map_err(|e| self.small(loom, e))?;
        let seen = &plan.constraints()[..followed.len()];
        let fits = fitness_from(exemplars, seen, &start, &self.options).map_err(failure)?;
        followed.iter().zip(&fits).for_each(|(path, fit)| fit::warn(loom.session, path, fit, self.alike()));
        let how = format!("under {}", n("constraint", plan.constraints().len()));
        Ok(PlannedRun::new(self.used(loom), how, move || {
            let (woven, course) = shown::woven(loom, &plan, &start, palette.as_ref())?;
            warn_of_saturation(loom.session, &woven.stats, self.first);
            self.frame.map_or(Ok(()), |frame| frame.keep(&woven.result))?;
            let mapped = || shown::mapped(&plan.constraints()[0], &woven.result, palette.as_ref());
            let mapped = self.mapped().map(|path| Ok((path, mapped()?)));
            let others = mapped.into_iter().collect::<Result<_, Failure>>()?;
            let mut outcome = Outcome { kept: start.fixed, after, course, others, ..outcome(woven) };
            outcome.stats["fitness"] = fits.iter().map(fit::json).collect();
            if loom.is_explained() {
                let guides = followed.iter().zip(plan.constraints()).zip(&fits);
                let drawn = guides.map(|((path, constraint), fit)| fit::drawn(path, constraint.guide.target(), fit));
                let pictures = drawn.collect::<Result<_, _>>()?;
                outcome.beside = Beside { heading: fit::HEADING, pictures };
            }
            Ok(outcome)
        }))
    }
}
