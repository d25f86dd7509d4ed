//! Frame after frame: `selvedge analogy A A' B.####.png`.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_cms_analogies::{Constraint, as_shown, carried};
use selvedge_core::{Bytes, Domain, Flow, SourceMap, Start};
use selvedge_io::clip::ClipName;

use super::Knobs;
use super::told::failure;
use crate::clips;
use crate::failure::{Failure, n};
use crate::flows::{self, DirectionArg};
use crate::ground::{self, check_size};
use crate::inputs::Input;
use crate::loom::Loom;
use crate::outputs::{self, Outputs};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::Used;
use crate::weaving::Weaving;

/// 24 frames of a drawing that four guides lead, panned by 2 px a frame: made by themselves they change by 11.7 grey
/// levels along the flow, with 0.1 by 0.12 and with 1 by 0.06, and follow their guides to within 3.58, 3.74 and 3.90.
const TEMPORAL: f64 = 0.1;

/// The most that any constraint may weigh.
const MOST_TEMPORAL: f64 = 10_000.0;

/// Of the size that vectors are to have.
const FRAMES_HAVE: &str = "the frames have";
/// Options that a single picture has no use for.
const OF_FRAMES: [&str; 4] = ["flow", "flow-direction", "temporal", "resume"];

/// Options about B as the frames of a clip.
#[derive(Args, Clone, Debug)]
pub(super) struct SequenceArgs {
    /// How the frames of a sequence move: one file of vectors a step as 'name.####.flo' (.flo, a PNG as KITTI has it,
    /// EXR), or one for all.
    #[arg(help_heading = "Sequences", long, value_name = "FLOWS", value_hint = ValueHint::FilePath)]
    flow: Option<PathBuf>,
    /// What the vectors say: where pixels go in the next frame, or where they come from.
    #[arg(help_heading = "Sequences", long, value_enum, value_name = "HOW", default_value_t = DirectionArg::Forward)]
    flow_direction: DirectionArg,
    /// How much a frame is to look like the one before, moved, where B counts 1. With 0 each frame is made by itself.
    #[arg(help_heading = "Sequences", long, value_name = "W", default_value_t = TEMPORAL, allow_negative_numbers = true)]
    temporal: f64,
    /// Go on after the last frame that is there, with its map.
    #[arg(help_heading = "Sequences", long, requires = "map")]
    resume: bool,
}

/// What a frame has from the one before, and what the next one has from it.
pub(super) struct Frame<'a> {
    args: &'a SequenceArgs,
    /// The knobs as they were typed, for all frames.
    typed: &'a Knobs,
    before: RefCell<Option<Before>>,
    /// Vectors from that one to this one.
    flow: Option<PathBuf>,
    made: RefCell<Option<SourceMap<2>>>,
}

/// The labelling of a frame.
enum Before {
    Made(SourceMap<2>),
    File(PathBuf),
}

impl SequenceArgs {
    /// Refuses what is about frames where there are none.
    pub(super) fn check_single(session: &Session<'_>) -> Result<(), Failure> {
        let Some(option) = session.first_typed(&OF_FRAMES) else { return Ok(()) };
        let failure = Failure::new(2, format!("{option} is about frames, and B is one picture"));
        Err(failure.remedy("leave it out, or name B's frames by a pattern, such as 'name.####.png'"))
    }

    /// Without all of them, of a single picture.
    pub(super) fn idle(used: Used) -> Used {
        OF_FRAMES.into_iter().fold(used, Used::without)
    }
}

impl Frame<'_> {
    /// Bytes of what is held of the frame before: its labelling, and as it is moved, with vectors.
    pub(super) fn bytes(&self, output: Domain<2>) -> Bytes {
        Bytes::of_samples(output, 3 * 4 + 9 + size_of::<selvedge_core::CameFrom>() as u64)
    }

    /// What the frame begins with, and one more constraint.
    pub(super) fn begun(&self, loom: &mut Loom<'_>) -> Result<Option<(Start<2>, Constraint)>, Failure> {
        let map = match self.before.take() {
            Some(Before::Made(map)) => map,
            Some(Before::File(path)) => {
                let read = Input::new(loom.session, &path)?.read_map(loom.session)?;
                let of = "the frame has";
                let remedy = "leave --resume out, to make all frames again";
                check_size(&path, read.file.map.domain().shape, Some(loom.domain.shape), of, remedy)?;
                ground::rebased(&read.file, &loom.loaded).map_err(|e| e.about(&path))?
            }
            None => return Ok(None),
        };
        let flow = self.flow.as_ref().map(|path| self.read(loom, path)).transpose()?;
        let map = carried(&map, flow.as_ref(), self.args.flow_direction.into()).map_err(failure)?;
        let shown = as_shown(&loom.loaded.exemplars, &map, self.args.temporal).map_err(failure)?;
        Ok(Some((Start { map, fixed: None, sources: None }, shown)))
    }

    fn read(&self, loom: &mut Loom<'_>, path: &Path) -> Result<Flow, Failure> {
        let sized = Some((loom.domain.shape, FRAMES_HAVE));
        let (flow, fingerprint) = flows::read(path, sized, (1.0, &loom.session.limits))?;
        loom.others.push(fingerprint);
        Ok(flow)
    }

    /// The options as used: names are those of all frames.
    pub(super) fn used(&self, loom: &Loom<'_>, used: Used) -> Used {
        let used = self.typed.guides.used(loom, used).without("resume");
        match &self.args.flow {
            Some(flow) => used.set("flow", selvedge_io::display_name(flow)),
            None => used.without("flow").without("flow-direction"),
        }
    }

    /// Keeps a labelling for the next frame.
    pub(super) fn keep(&self, map: &SourceMap<2>) -> Result<(), Failure> {
        if self.args.temporal != 0.0 {
            self.made.replace(Some(carried(map, None, self.args.flow_direction.into()).map_err(failure)?));
        }
        Ok(())
    }
}

/// The files of a sequence.
struct Sequence<'a> {
    of: &'a Typed<'a>,
    /// By the name that was typed, those of its frames.
    files: BTreeMap<PathBuf, Vec<PathBuf>>,
    flows: Vec<PathBuf>,
    frames: usize,
}

/// A command as it was typed, for all frames.
pub(super) struct Typed<'a> {
    pub(super) weaving: &'a Weaving,
    pub(super) sequence: &'a SequenceArgs,
    pub(super) knobs: &'a Knobs,
}

/// Makes a frame of the names and knobs that are its own.
pub(super) type One<'o> = dyn Fn(&Weaving, &Knobs, &Frame<'_>) -> Result<Done, Failure> + 'o;

impl Typed<'_> {
    /// Makes a frame after the other: what is there stays if the run is ended.
    pub(super) fn frames(&self, session: &Session<'_>, target: &Path, make: &One<'_>) -> Result<Done, Failure> {
        let sequence = Sequence::of(self, session, target)?;
        let mut done = Done::answered(Report::new("analogy"), String::new());
        let mut before = None;
        let first = sequence.first(session)?;
        sequence.check_names(session, first)?;
        for i in first..sequence.frames {
            session.watch.turn(i + 1, sequence.frames);
            let weaving = sequence.weaving(i)?;
            let before_file = || sequence.run(i - 1).ok()?.written().map.map(Before::File);
            let frame = Frame {
                args: self.sequence,
                typed: self.knobs,
                before: RefCell::new(
                    before.take().or_else(|| (i == first && self.is_resumed(i)).then(before_file).flatten()),
                ),
                flow: i.checked_sub(1).and_then(|step| sequence.flow(step)),
                made: RefCell::new(None),
            };
            let one = make(&weaving, &sequence.knobs(i)?, &frame);
            let mut one = one
                .and_then(|one| one.outputs.write(session).map(|_| one))
                .map_err(|failure| self.after(session, failure, i))?;
            one.outputs = Outputs::default();
            done.add(one, session.global.seed(), session.global.dry_run);
            before = frame.made.take().map(Before::Made);
        }
        Ok(done)
    }

    /// What ended the run, where so many frames are there.
    fn after(&self, session: &Session<'_>, failure: Failure, frames: usize) -> Failure {
        let by_signal = session.watch.signal().is_some();
        if frames == 0 || session.global.dry_run {
            return failure;
        }
        let mut failure = failure.among(by_signal, "frame", frames);
        if let (Some(remedy), Some(_), false) = (&mut failure.remedy, &self.weaving.map, by_signal) {
            remedy.push_str(", and go on with --resume");
        }
        failure
    }

    /// Whether a frame goes on from files: only the first one that is made after others which are there does.
    fn is_resumed(&self, frame: usize) -> bool {
        0 < frame && self.sequence.resume && self.sequence.temporal != 0.0
    }
}

impl<'a> Sequence<'a> {
    /// Lists the files, and refuses frames that do not belong together, before the first is made.
    fn of(of: &'a Typed<'a>, session: &Session<'_>, target: &Path) -> Result<Self, Failure> {
        let (args, knobs) = (of.sequence, of.knobs);
        if !(0.0..=MOST_TEMPORAL).contains(&args.temporal) {
            let what = format!("a temporal weight of {} is none", args.temporal);
            return Err(Failure::new(2, what).remedy(format!("use --temporal 0 to {MOST_TEMPORAL}")));
        }
        if !knobs.start.files().is_empty() {
            let what = "frames go on from each other, and --start, --over and --fixed are of one picture";
            return Err(Failure::new(2, what).remedy("leave them out, or make one frame"));
        }
        if args.flow.is_some() && args.temporal == 0.0 {
            let what = "--flow moves the frame before, which --temporal 0 leaves out";
            return Err(Failure::new(2, what).remedy("leave out one of them"));
        }
        if let (None, Some(option)) = (&args.flow, session.first_typed(&["flow-direction"])) {
            let failure = Failure::new(2, format!("{option} says what vectors mean, and there are none"));
            return Err(failure.remedy("leave it out, or give --flow"));
        }
        let mut files = BTreeMap::from([(target.to_path_buf(), clips::files(target, None)?)]);
        let frames = files[target].len();
        for path in knobs.guides.targets().chain(&knobs.follow_where).filter(|path| clips::is_pattern(path)) {
            let all = clips::files(path, None)?;
            if all.len() != frames {
                let what = format!("{} for {}", n("file", all.len()), n("frame", frames));
                return Err(Failure::new(3, what).about(path).remedy("give one a frame, or one for all"));
            }
            files.insert(path.clone(), all);
        }
        let flows = args.flow.as_deref().map_or(Ok(Vec::new()), flows::files)?;
        if let Some(path) = args.flow.as_ref().filter(|path| clips::is_pattern(path) && flows.len() + 1 < frames) {
            let what = format!("{} for {}", n("flow", flows.len()), n("step", frames - 1));
            return Err(Failure::new(3, what).about(path).remedy("give one a step, or the name of one for all"));
        }
        let sequence = Self { of, files, flows, frames };
        sequence.check_sizes(session)?;
        (0..frames).try_for_each(|i| sequence.weaving(i).map(|_| ()))?;
        Ok(sequence)
    }

    /// All frames are of one size.
    fn check_sizes(&self, session: &Session<'_>) -> Result<(), Failure> {
        let options = self.of.weaving.read_options(session);
        for all in self.files.values() {
            let mut first = None;
            for path in all {
                let info = Input::new(session, path)?.probe(&options)?;
                let shape = [info.height, info.width];
                check_size(path, shape, first, "the first frame has", "give frames of one size")?;
                first = Some(shape);
            }
        }
        let target = Input::new(session, &self.files[self.target()][0])?.probe(&options)?;
        let sized = Some(([target.height, target.width], FRAMES_HAVE));
        let read = |flow: &PathBuf| flows::read(flow, sized, (1.0, &session.limits)).map(|_| ());
        self.flows.iter().try_for_each(read)
    }

    /// The name of B's frames.
    fn target(&self) -> &Path {
        self.of.weaving.input.exemplars.last().expect("A, A' and B")
    }

    /// No frame may be written over what is read for any: a frame's own check knows its own files.
    fn check_names(&self, session: &Session<'_>, first: usize) -> Result<(), Failure> {
        let mut written = Vec::new();
        for frame in first..self.frames {
            let run = self.run(frame)?;
            written.extend(run.files_written(session, &run.written(), run.input.exemplars.len() / 2));
            written.extend(self.knobs(frame)?.mapped);
        }
        let read = self.files.values().flatten().chain(&self.flows).cloned();
        outputs::check(session, &written, &read.collect::<Vec<_>>())
    }

    /// The first frame to make: with --resume, after those that are there.
    fn first(&self, session: &Session<'_>) -> Result<usize, Failure> {
        if !self.of.sequence.resume {
            return Ok(0);
        }
        let is_there = |i: &usize| {
            let names = self.run(*i).map(|run| run.written());
            names.is_ok_and(|names| names.output.is_file() && names.map.is_some_and(|map| map.is_file()))
        };
        let there = (0..self.frames).take_while(is_there).count();
        if 0 < there {
            session.say(&format!("{} of {} are there", there, n("frame", self.frames)));
        }
        Ok(there)
    }

    /// A frame's file by the name that was typed.
    fn file(&self, path: &Path, frame: usize) -> PathBuf {
        self.files.get(path).map_or_else(|| path.to_path_buf(), |all| all[frame].clone())
    }

    fn flow(&self, step: usize) -> Option<PathBuf> {
        self.flows.get(step.min(self.flows.len().saturating_sub(1))).cloned()
    }

    /// The knobs as a frame has them.
    fn knobs(&self, frame: usize) -> Result<Knobs, Failure> {
        let knobs = self.of.knobs;
        let at = |path: &Path| self.file(path, frame);
        let mapped = knobs.mapped.as_ref().map(|path| self.numbered(path, frame)).transpose()?;
        let follow_where = knobs.follow_where.as_deref().map(at);
        Ok(Knobs { guides: knobs.guides.over(at), follow_where, mapped, ..knobs.clone() })
    }

    /// The same as its own run has it, whose first exemplar is A'.
    fn run(&self, frame: usize) -> Result<Weaving, Failure> {
        let mut weaving = self.weaving(frame)?;
        weaving.input.exemplars.remove(0);
        Ok(weaving)
    }

    /// A name of a frame, counted from 1.
    fn numbered(&self, path: &Path, frame: usize) -> Result<PathBuf, Failure> {
        ClipName::parse(path).and_then(|name| name.file(frame as u32 + 1)).ok_or_else(|| {
            let failure = Failure::new(2, format!("{} would have this name", n("frame", self.frames)));
            failure.about(path).remedy("name frames by a pattern, such as 'name.####.png'")
        })
    }

    /// Exemplars and a frame, and the frame's own names, counted from 1.
    fn weaving(&self, frame: usize) -> Result<Weaving, Failure> {
        let typed = self.of.weaving;
        let mut weaving = typed.clone();
        if let Some(target) = weaving.input.exemplars.last_mut() {
            *target = self.file(target, frame);
        }
        let numbered = |path: &PathBuf| self.numbered(path, frame);
        let maybe = |path: &Option<PathBuf>| path.as_ref().map(numbered).transpose();
        weaving.output = numbered(&typed.output)?;
        (weaving.map, weaving.explain) = (maybe(&typed.map)?, maybe(&typed.explain)?);
        (weaving.preview, weaving.report) = (maybe(&typed.preview)?, maybe(&typed.report)?);
        Ok(weaving)
    }
}
