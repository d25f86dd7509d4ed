//! Clips merged: the seam is a surface in space and time. `[Kwatra03 6B]` `[Kwatra03 7]`

use std::path::{Path, PathBuf};

use selvedge_core::{Bytes, Depth, Domain, Exemplars, Grid, Plane, Render as _, Role, SourceMap, Start};
use selvedge_graphcut_textures::labels::{Label, LabelOptions, LabelStats, estimate_labels, expand, preferred};
use selvedge_io::clip::{ClipOptions, ClipWriteOptions, ClipWriter, Rate, frame_of};
use selvedge_io::{Fingerprint, Metadata};

use super::placed::{apart, arrange, shows};
use super::strokes::keep;
use super::{Merge, told};
use crate::args::NonFiniteArg;
use crate::clips::{self, Clip, ClipInput, is_pattern};
use crate::failure::{Failure, n, shown};
use crate::ground::check_size;
use crate::inputs::{self, Input, white};
use crate::options::names_of;
use crate::outputs::{self, Outputs};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::stdio::STREAM;
use crate::{made, memory};

/// Options that mean the same for clips.
const OF_CLIPS: [&str; 9] = ["at", "strokes", "color", "keep", "prefer", "seam", "nonfinite", "output", "label-map"];

/// Options that do nothing for them.
fn of_pictures() -> Vec<String> {
    names_of::<Merge>().into_iter().filter(|name| !OF_CLIPS.contains(&name.as_str())).collect()
}

/// Clips that were looked at, and where they lie.
struct Laid {
    clips: Vec<ClipInput>,
    labels: Vec<Label<3>>,
    output: Domain<3>,
    rate: Option<Rate>,
}

/// What was merged.
struct Merged {
    map: SourceMap<3>,
    stats: LabelStats,
}

impl Merge {
    /// True if there is a clip among the pictures.
    pub(super) fn is_of_clips(&self, session: &Session<'_>) -> Result<bool, Failure> {
        let options = inputs::options(session.limits, Role::Color, self.weaving.input.nonfinite);
        for path in self.weaving.input.exemplars.iter().filter(|path| path.as_os_str() != STREAM) {
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
        self.validate()?;
        self.check_typed(session)?;
        let laid = self.lay_clips(session)?;
        let needed = self.need(&laid);
        memory::check_fixed(&session.limits, needed)?;
        self.check_written(session, &laid)?;
        report.estimate = Some(needed.0);
        let [frames, height, width] = laid.output.shape;
        let (size, name) =
            (format!("{} of {width}x{height} px", n("frame", frames as usize)), shown(&self.weaving.output));
        let of_pictures = of_pictures().into_iter().filter(|name| session.options.has(name));
        let used = of_pictures.fold(session.options.clone(), |used, name| used.without(&name));
        if session.global.dry_run {
            report.options = used;
            report.inputs.extend(laid.clips.iter().map(|clip| clip.noted(None)));
            let of = n("clip", laid.clips.len());
            let line = format!("{name}: would be {size} from {of}, with about {needed} of memory");
            let planned = vec![outputs::planned_clip(&self.weaving.output, [height, width], Some(frames))];
            return Ok(Done::would(report, line, planned));
        }
        let Laid { clips, labels, output, rate } = laid;
        let clips = clips.into_iter().map(|clip| clip.read(session, &mut report)).collect::<Result<Vec<_>, _>>()?;
        let planes: Vec<&[Plane<3>]> = clips.iter().map(|clip| std::slice::from_ref(&clip.plane)).collect();
        let exemplars = Exemplars::of(&planes)?;
        let mut others = Vec::new();
        let only = self.only_of_clips(session, (&exemplars, &labels, output), (&mut report, &mut others))?;
        report.stage("read");
        let merged = self.merged(session, &exemplars, (&labels, output), only)?;
        session.watch.finish();
        report.stage("synthesis");
        let moved = moved(&merged.map);
        report.options = used;
        report.stats = told::counts(&merged.stats, &labels);
        report.stats["seam_moves"] = moved.into();
        let outputs = self.written(&mut report, session, (&clips, &merged.map, rate), others)?;
        let line = format!(
            "{name}: {size} {}, the seam moving by {moved:.2} px a frame, in {:.2} s",
            told::how(&merged.stats, "clip"),
            report.elapsed()
        );
        Ok(Done::made(report, line, outputs))
    }

    /// Options that are about pictures do nothing.
    fn check_typed(&self, session: &Session<'_>) -> Result<(), Failure> {
        let Some(option) = session.first_typed(&of_pictures()) else { return Ok(()) };
        Err(Failure::new(2, format!("{option} is for pictures, and these are clips")).remedy("leave it out"))
    }

    /// Looks at the clips, which have the same frames, rate and samples, and lays them beside each other.
    fn lay_clips(&self, session: &Session<'_>) -> Result<Laid, Failure> {
        let frame = inputs::options(session.limits, Role::Color, self.weaving.input.nonfinite);
        let options = ClipOptions { frame, ..ClipOptions::default() };
        let paths = &self.weaving.input.exemplars;
        inputs::check_streams(paths.iter().chain(&self.strokes))?;
        let clips = paths.iter().map(|path| ClipInput::open(session, path, &options)).collect::<Result<Vec<_>, _>>()?;
        clips[1..].iter().try_for_each(|clip| check_alike(clip, &clips[0]))?;
        if let Some(further) = self.at.iter().position(|at| at.0.is_none()) {
            let failure = Failure::new(2, "--at auto is for pictures").about(&paths[further + 1]);
            return Err(failure.remedy("say where the clip lies, by pixels"));
        }
        let frames: Vec<Domain<2>> =
            clips.iter().map(|clip| Domain::open([clip.info().height, clip.info().width])).collect();
        let at = |source: usize| Label { source, offset: self.at(source).0.unwrap_or([0, 0]) };
        let mut labels: Vec<Label<2>> = (0..clips.len()).map(at).collect();
        let [height, width] = arrange(&mut labels, &frames).map_err(|alone| apart(&paths[alone]))?;
        let in_time = |Label { source, offset: [y, x] }: Label<2>| Label { source, offset: [0, y, x] };
        let output = Domain::open([clips[0].info().frames, height, width]);
        let rate = clips.iter().find_map(|clip| clip.info().rate);
        Ok(Laid { labels: labels.into_iter().map(in_time).collect(), clips, output, rate })
    }

    /// An upper bound of the memory of a run.
    fn need(&self, laid: &Laid) -> Bytes {
        let (info, count) = (laid.clips[0].info(), laid.clips.len() as u64);
        let colors = info.channels - usize::from(info.alpha);
        let sources: Vec<Domain<3>> = laid.clips.iter().map(ClipInput::domain).collect();
        let kept: Bytes = laid.clips.iter().map(ClipInput::bytes).sum();
        // What may show, and what each label costs by itself.
        let own = if self.prefer.is_some() { 4 * count } else { 0 };
        let work = estimate_labels(&sources, colors, laid.output) + Bytes::of_samples(laid.output, own + 8 + 1);
        // The map, what it renders, and the same as files.
        let output =
            memory::picture(laid.output, info.channels, info.depth) * 2 + Bytes::of_samples(laid.output, 4 + 2);
        memory::PROGRAM + kept + memory::sources(&sources, colors) * 2 + work.max(output)
    }

    /// Refuses what could not be written, before any work.
    fn check_written(&self, session: &Session<'_>, laid: &Laid) -> Result<(), Failure> {
        let (info, [frames, height, width]) = (laid.clips[0].info(), laid.output.shape);
        let (mut written, mut read) = (Vec::new(), Vec::new());
        let outputs = [(Some(&self.weaving.output), (info.channels, info.alpha), info.depth)];
        for (path, channels, depth) in outputs.into_iter().chain([(self.label_map.as_ref(), (1, false), Depth::U8)]) {
            let Some(path) = path else { continue };
            let writer = ClipWriter::create(path, frames, Metadata::default(), options(laid.rate))?;
            clips::check_held(&writer, channels, depth, [height, width])?;
            clips::tell_left_over(session, &writer);
            written.extend(writer.files());
        }
        for path in self.files() {
            read.extend(if is_pattern(&path) { clips::files(&path, None)? } else { vec![path] });
        }
        outputs::check(session, &written, &read)
    }

    /// All files and sequences that are read.
    fn files(&self) -> impl Iterator<Item = PathBuf> {
        let kept = self.keep.chunks(2).map(|pair| PathBuf::from(&pair[1]));
        self.weaving.input.exemplars.iter().chain(&self.strokes).cloned().chain(kept)
    }

    /// By place, which clips may show; none if all may everywhere.
    fn only_of_clips(
        &self,
        session: &Session<'_>,
        (exemplars, labels, output): (&Exemplars<3>, &[Label<3>], Domain<3>),
        (report, others): (&mut Report, &mut Vec<Fingerprint>),
    ) -> Result<Option<Grid<u64, 3>>, Failure> {
        if let Some(at) = output.positions().find(|at| !labels.iter().any(|label| shows(exemplars, label, *at))) {
            let what = format!("no clip shows anything at {},{}", at[2], at[1]);
            return Err(Failure::new(3, what).remedy("lay clips with --at so that they fill their box"));
        }
        if self.strokes.is_none() && self.keep.is_empty() {
            return Ok(None);
        }
        let mut only = Grid::try_filled(output, 1, u64::MAX >> (64 - labels.len()))?;
        let painted = self.strokes.iter().map(|path| (path.as_path(), None));
        let kept = self.keep.chunks(2).map(|pair| (Path::new(&pair[1]), pair[0].parse::<usize>().ok()));
        for (path, number) in painted.chain(kept) {
            let mut wanted: Vec<u8> = Vec::new();
            for (file, plane) in held(session, path, output, (report, others))? {
                // No number is above 64.
                match number {
                    None => wanted.extend(self.wanted(&file, &plane)?.into_iter().map(|n| n.unwrap_or(0) as u8)),
                    Some(number) => {
                        wanted.extend(white(&plane, &file)?.samples().iter().map(|&w| u8::from(w) * number as u8));
                    }
                }
            }
            let at = |i: usize| usize::from(wanted[i % wanted.len()]);
            keep(&mut only, (exemplars, labels), path, |i| Some(at(i)).filter(|number| 0 < *number))?;
        }
        Ok(Some(only))
    }

    fn merged(
        &self,
        session: &Session<'_>,
        exemplars: &Exemplars<3>,
        (labels, output): (&[Label<3>], Domain<3>),
        only: Option<Grid<u64, 3>>,
    ) -> Result<Merged, Failure> {
        let own = self.prefer.map(|prefer| preferred(exemplars, labels, output, prefer.into())).transpose()?;
        let options = LabelOptions { seam: self.seams.measure(), only, own, ..LabelOptions::default() };
        let woven = expand(exemplars, Start::empty(exemplars, output)?, labels, &options, &session.run())?;
        session.check_signal()?;
        Ok(Merged { map: woven.result, stats: woven.stats })
    }

    fn written(
        &self,
        report: &mut Report,
        session: &Session<'_>,
        (clips, map, rate): (&[Clip], &SourceMap<3>, Option<Rate>),
        others: Vec<Fingerprint>,
    ) -> Result<Outputs, Failure> {
        let inputs = clips.iter().map(|clip| clip.fingerprint.clone()).chain(others).collect();
        let of = ("merge", session.global.seed());
        let made_by = made::provenance(of, report.options.clone(), &self.weaving.input.exemplars, inputs);
        let told = Metadata { provenance: Some(made_by.clone()), ..Metadata::default() };
        let metadata = Metadata { provenance: Some(made_by), ..clips[0].info.metadata.clone() };
        let planes: Vec<&Plane<3>> = clips.iter().map(|clip| &clip.plane).collect();
        let numbers = self.label_map.as_ref().map(|path| Ok::<_, Failure>((path, told::numbered(map)?, &told)));
        let merged = Ok((&self.weaving.output, map.render(&planes)?, &metadata));
        let mut outputs = Outputs::default();
        for written in std::iter::once(merged).chain(numbers) {
            let (path, shown, metadata) = written?;
            let mut frame = |t: u32| {
                session.check_signal()?;
                Ok(frame_of(&shown, t)?)
            };
            outputs.clip(path, shown.domain().shape[0], &mut frame, (metadata, options(rate)))?;
        }
        report.stage("encode");
        Ok(outputs)
    }
}

fn options(rate: Option<Rate>) -> ClipWriteOptions {
    ClipWriteOptions { rate, ..ClipWriteOptions::default() }
}

/// Refuses a clip of other frames, another rate or other samples than the first.
fn check_alike(clip: &ClipInput, first: &ClipInput) -> Result<(), Failure> {
    let (a, b) = (clip.info(), first.info());
    let layout = |channels: usize, depth: Depth| format!("{} of {}", n("channel", channels), depth.name());
    let (found, expected) = match (a.rate, b.rate) {
        _ if a.frames != b.frames => (n("frame", a.frames as usize), n("frame", b.frames as usize)),
        (Some(rate), Some(of)) if rate != of => (format!("{rate} frames a second"), of.to_string()),
        _ if (a.channels, a.alpha, a.depth) != (b.channels, b.alpha, b.depth) => {
            (layout(a.channels, a.depth), layout(b.channels, b.depth))
        }
        _ => return Ok(()),
    };
    let failure = Failure::new(3, format!("has {found}, but the first clip has {expected}")).about(clip.path());
    Err(failure.remedy("give clips of the same frames, rate and samples"))
}

/// The picture that holds for all frames, or one a frame, with their files.
fn held(
    session: &Session<'_>,
    path: &Path,
    output: Domain<3>,
    (report, others): (&mut Report, &mut Vec<Fingerprint>),
) -> Result<Vec<(PathBuf, Plane<2>)>, Failure> {
    let [frames, height, width] = output.shape;
    let files = if is_pattern(path) { clips::files(path, None)? } else { vec![path.to_path_buf()] };
    if is_pattern(path) && files.len() != frames as usize {
        let what = format!("{}, but the clips have {frames}", n("frame", files.len()));
        return Err(Failure::new(3, what).about(path).remedy("give one picture for all frames, or one for each"));
    }
    let options = inputs::options(session.limits, Role::Scalar, NonFiniteArg::Error);
    let mut all = Vec::new();
    for file in files {
        let picture = Input::new(session, &file)?.read(session, &options, report)?;
        let size = picture.plane.domain().shape;
        check_size(&file, size, Some([height, width]), "the output has", "paint over a frame of that size")?;
        others.push(inputs::fingerprint(&file, &picture));
        all.push((file, picture.plane));
    }
    Ok(all)
}

/// How far the seam moves from frame to frame: pixels that show another clip than before, for each pixel of its length.
fn moved(map: &SourceMap<3>) -> f64 {
    let domain = map.domain();
    let source = |at: [u32; 3]| map.table.source(map.ids.get(0, at));
    let mut faces = [0_u64; 2];
    for at in domain.positions() {
        for axis in 0..3 {
            let other = domain.next(at, axis).is_some_and(|next| source(next) != source(at));
            faces[usize::from(0 < axis)] += u64::from(other);
        }
    }
    // Changes lie between frames, of which there is one less.
    let [frames, ..] = domain.shape;
    let [changes, length] = faces.map(|count| count as f64);
    if length == 0.0 || frames < 2 { 0.0 } else { changes / f64::from(frames - 1) / (length / f64::from(frames)) }
}
