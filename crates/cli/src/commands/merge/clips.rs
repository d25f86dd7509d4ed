//! Clips merged: the seam is a surface in space and time. `[Kwatra03 6B]` `[Kwatra03 7]`

use std::path::PathBuf;

use selvedge_core::{Domain, Encoder, Exemplar, Exemplars, Grid, Plane, Role, SourceMap, Start, Woven};
use selvedge_graphcut_textures::labels::{Label, LabelOptions, LabelStats, expand, preferred};

use super::clip_beside::Beside;
use super::clip_laid::{Laid, Merged};
use super::clip_needs::Needs;
use super::gain::Tones;
use super::{Merge, gain, told};
use crate::clip_given::{check_alike, opened};
use crate::clips::{Clip, ClipInput, is_pattern};
use crate::failure::{Failure, n, shown};
use crate::inputs;
use crate::names;
use crate::options::names_of;
use crate::outputs;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::Used;

/// Options that mean the same for clips.
const OF_CLIPS: [&str; 21] = [
    "mask",
    "at",
    "strokes",
    "color",
    "keep",
    "prefer",
    "seam",
    "nonfinite",
    "output",
    "label-map",
    "map",
    "with",
    "feather",
    "spline",
    "fuse",
    "fuse-mixed",
    "fuse-reach",
    "fuse-keep",
    "gain",
    "preview",
    "report",
];

/// Options that do nothing for them.
fn of_pictures() -> Vec<String> {
    names_of::<Merge>().into_iter().filter(|name| !OF_CLIPS.contains(&name.as_str())).collect()
}

impl Merge {
    /// True if there is a clip among the pictures.
    pub(super) fn is_of_clips(&self, session: &Session<'_>) -> Result<bool, Failure> {
        let options = inputs::options(session.limits, Role::Color, self.weaving.input.nonfinite);
        for path in self.weaving.input.exemplars.iter().filter(|path| !inputs::is_stream(path)) {
            // What cannot be opened is told of where it is read.
            if is_pattern(path) || ClipInput::found(path, &options).is_ok_and(|clip| clip.is_some()) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Runs the command over clips.
    pub(super) fn over_clips(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("merge");
        self.check_clip_options(session)?;
        let laid = self.lay_clips(session)?;
        let needs = Needs::of(&laid);
        let needed = needs.check(session, self, laid.output)?;
        self.check_written(session, &laid)?;
        report.estimate = Some(needed.0);
        let names: Vec<PathBuf> = laid.shown().map(|clip| self.clip_name(clip.path())).collect();
        let name = names.iter().map(|path| shown(path)).collect::<Vec<_>>().join(", ");
        let used = self.used_of_clips(session);
        if session.global.dry_run {
            report.options = used;
            report.inputs.extend(laid.clips.iter().chain(&laid.passes).map(|clip| clip.noted(None)));
            let (of, size) = (n("clip", laid.clips.len()), size(laid.output));
            let line = format!("{name}: would be {size} from {of}, with about {needed} of memory");
            let [frames, frame @ ..] = laid.output.shape;
            let planned = names.iter().map(|path| outputs::planned_clip(path, frame, Some(frames)));
            return Ok(Done::would(report, line, planned.collect()));
        }
        let Laid { clips, passes, mut labels, mut output, rate } = laid;
        let mut read = |clips: Vec<ClipInput>| {
            clips.into_iter().map(|clip| clip.read(session, &mut report)).collect::<Result<Vec<_>, _>>()
        };
        let (mut clips, passes) = (read(clips)?, read(passes)?);
        let mut beside =
            Beside { session, report: &mut report, nonfinite: self.weaving.input.nonfinite, others: Vec::new() };
        let masks = self.masks_of_clips(&mut beside, &clips)?;
        if self.found().next().is_some() {
            let (found, [height, width]) = self.lay_found(session, &clips, &masks)?;
            (labels, output) = (in_time(found), Domain::open([output.shape[0], height, width]));
            beside.report.estimate = Some(needs.check(session, self, output)?.0);
        }
        let mut exemplars = exemplars_of(&clips, &masks)?;
        let tones = self.gain.then(|| even(&mut clips, &exemplars, (&labels, output))).transpose()?;
        if tones.is_some() {
            exemplars = exemplars_of(&clips, &masks)?;
        }
        self.check_bare(&clips, &passes, (&exemplars, &labels, output))?;
        let only = self.only_of_clips(&mut beside, (&exemplars, &labels, output))?;
        let unfused = self.unfused(&mut beside, output)?;
        let others = beside.others;
        report.stage("read");
        let woven = self.merged(session, &exemplars, (&labels, output), only)?;
        session.watch.finish();
        report.stage("synthesis");
        let Woven { result: map, stats, complete } = woven;
        let holes = 0 < stats.holes;
        let moved = moved(&map);
        let used = used.set("at", told::places(&labels));
        report.options = used.clone();
        report.stats = told::counts(&stats, &labels);
        report.stats["seam_moves"] = moved.into();
        if let Some(tones) = &tones {
            report.stats["tones"] = gain::told(tones);
        }
        let merged = Merged { clips, passes, exemplars, map, unfused, holes, rate, used, others, complete };
        if !complete {
            return Err(self.interrupted(session, &mut report, &merged));
        }
        session.check_signal()?;
        let outputs = self.clip_outputs(session, &mut report, &merged)?;
        let line = format!(
            "{name}: {} {}, the seam moving by {moved:.2} px a frame, in {:.2} s",
            size(output),
            told::how(&stats, "clip"),
            report.elapsed()
        );
        Ok(Done::made(report, line, outputs))
    }

    /// Refuses what is wrong by itself, and options that are about pictures.
    fn check_clip_options(&self, session: &Session<'_>) -> Result<(), Failure> {
        self.validate()?;
        self.weaving.input.validate()?;
        if let Some(option) = session.first_typed(&of_pictures()) {
            let failure = Failure::new(2, format!("{option} is for pictures, and these are clips"));
            return Err(failure.remedy("leave it out"));
        }
        self.blending.validate()?;
        self.fuse_keep.of(self.blending)?;
        let (given, with) = (self.weaving.input.exemplars.len(), &self.weaving.with);
        with.validate(given, 0)?;
        names::check_apart(&self.weaving.output, 1 + with.with.len() / given)
    }

    /// The options as used, but for what is known once clips are laid.
    fn used_of_clips(&self, session: &Session<'_>) -> Used {
        let of_pictures = of_pictures().into_iter().filter(|name| session.options.has(name));
        let used = of_pictures.fold(session.options.clone(), |used, name| used.without(&name));
        let used = used.unless("with", Vec::<String>::new()).unless("mask", Vec::<String>::new());
        self.used_of_all(self.blending.used_if_any(used))
    }

    /// Looks at the clips, which have the same frames, rate and samples, and lays them beside each other.
    fn lay_clips(&self, session: &Session<'_>) -> Result<Laid, Failure> {
        let frame = inputs::options(session.limits, Role::Color, self.weaving.input.nonfinite);
        let paths = &self.weaving.input.exemplars;
        inputs::check_streams(&self.files().collect::<Vec<_>>())?;
        let clips = opened(session, paths, None, &frame)?;
        check_alike(session, &clips)?;
        let passes = opened(session, &self.weaving.with.with, Some(clips[0].info().frames), &frame)?;
        for passes in passes.chunks(clips.len()) {
            passes.iter().zip(&clips).try_for_each(|(pass, clip)| pass.check_like(clip))?;
            check_alike(session, passes)?;
        }
        if let (Some(pass), false) = (passes.first(), self.blending.is_none()) {
            let what = "is cut by the same seam and copied, as all passes of clips are, and not blended";
            session.warn(pass.path(), &what);
        }
        let frames: Vec<Domain<2>> =
            clips.iter().map(|clip| Domain::open([clip.info().height, clip.info().width])).collect();
        let (labels, [height, width]) = self.lay_frames(paths, &frames)?;
        let output = Domain::open([clips[0].info().frames, height, width]);
        let rate = clips.iter().find_map(|clip| clip.info().rate);
        Ok(Laid { labels: in_time(labels), clips, passes, output, rate })
    }

    fn merged(
        &self,
        session: &Session<'_>,
        exemplars: &Exemplars<3>,
        (labels, output): (&[Label<3>], Domain<3>),
        only: Option<Grid<u64, 3>>,
    ) -> Result<Woven<SourceMap<3>, LabelStats>, Failure> {
        let own = self.prefer.map(|prefer| preferred(exemplars, labels, output, prefer.into())).transpose()?;
        let options =
            LabelOptions { seam: self.seams.measure(), only, own, leave_holes: true, ..LabelOptions::default() };
        let woven = expand(exemplars, Start::empty(exemplars, output)?, labels, &options, &session.run())?;
        Ok(woven)
    }
}

/// Frames and their size, in words.
fn size(output: Domain<3>) -> String {
    let [frames, height, width] = output.shape;
    format!("{} of {width}x{height} px", n("frame", frames as usize))
}

/// The same places, over all frames.
fn in_time(labels: Vec<Label<2>>) -> Vec<Label<3>> {
    labels.into_iter().map(|Label { source, offset: [y, x] }| Label { source, offset: [0, y, x] }).collect()
}

/// What may show of clips.
fn exemplars_of(clips: &[Clip], masks: &[Option<Grid<bool, 3>>]) -> Result<Exemplars<3>, Failure> {
    let planes: Vec<&[Plane<3>]> = clips.iter().map(|clip| std::slice::from_ref(&clip.plane)).collect();
    let shown: Vec<Exemplar<'_, 3>> =
        planes.iter().zip(masks).map(|(plane, mask)| Exemplar::new(plane).masked(mask.as_ref())).collect();
    Ok(Exemplars::new(&Encoder::fit(&planes)?, &shown)?)
}

/// Evens clips, over all frames at once.
fn even(
    clips: &mut [Clip],
    exemplars: &Exemplars<3>,
    (labels, output): (&[Label<3>], Domain<3>),
) -> Result<Tones, Failure> {
    let planes: Vec<&Plane<3>> = clips.iter().map(|clip| &clip.plane).collect();
    let tones = gain::tones(&planes, exemplars, output, labels)?;
    clips.iter_mut().zip(&tones).for_each(|(clip, tones)| clip.plane = clip.plane.toned(tones));
    Ok(tones)
}

/// How far the seam moves from frame to frame: pixels that show another clip than before, for each pixel of its length.
fn moved(map: &SourceMap<3>) -> f64 {
    let domain = map.domain();
    let source = |at: [u32; 3]| map.table.source(map.ids.get(0, at));
    // Beside what is in no clip there is no seam.
    let differ = |at, next| matches!((source(at), source(next)), (Some(a), Some(b)) if a != b);
    let mut faces = [0_u64; 2];
    for at in domain.positions() {
        for axis in 0..3 {
            let other = domain.next(at, axis).is_some_and(|next| differ(at, next));
            faces[usize::from(0 < axis)] += u64::from(other);
        }
    }
    // Changes lie between frames, of which there is one less.
    let [frames, ..] = domain.shape;
    let [changes, length] = faces.map(|count| count as f64);
    if length == 0.0 || frames < 2 { 0.0 } else { changes / f64::from(frames - 1) / (length / f64::from(frames)) }
}
