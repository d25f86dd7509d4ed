//! `selvedge video`: video textures.

mod choices;
mod fade;
mod look;
mod transition;

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Depth, Plane, Role, SourceMap};
use selvedge_io::clip::{ClipOptions, ClipWriteOptions, ClipWriter, Flipbook, Range, Rate};
use selvedge_io::{Fingerprint, Metadata, Provenance, WriteOptions};

use self::choices::{JumpArg, Period};
use crate::args::NonFiniteArg;
use crate::clips::{self, Clip, ClipInput};
use crate::failure::{Failure, shown};
use crate::outputs::{self, Outputs};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::stdio::STREAM;
use crate::used::Used;
use crate::values::SeamArg;
use crate::{inputs, made, memory, names, page};

/// Options of `video`.
#[derive(Args, Clone, Debug)]
pub(crate) struct Video {
    /// The clip.
    #[arg(help = "The clip: 'name.####.png', a folder, a quoted glob, an animation, or '-' for y4m")]
    #[arg(value_name = "CLIP", value_hint = ValueHint::FilePath)]
    clip: PathBuf,
    /// Other passes of the same frames, such as normals or velocities: the same seam on each, bit for bit.
    #[arg(long, value_name = "CLIP", value_delimiter = ',', value_hint = ValueHint::FilePath)]
    with: Vec<PathBuf>,
    /// Frames to use, such as 1-100 or 1-100x2: by their numbers, or by their places from 1 in an animation.
    #[arg(long, value_name = "RANGE", value_parser = clips::range)]
    range: Option<Range>,
    /// The clip is one picture of so many columns and rows of frames.
    #[arg(long, value_name = "COLSxROWS", value_parser = clips::flipbook, conflicts_with = "range")]
    from_flipbook: Option<Flipbook>,
    /// Pixels around each frame of --from-flipbook that are no part of it.
    #[arg(long, value_name = "PX", requires = "from_flipbook")]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=4096))]
    from_pad: Option<u32>,
    /// What becomes of float samples that are infinite or no numbers.
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = NonFiniteArg::Error)]
    nonfinite: NonFiniteArg,
    /// Frames of the loop: auto, a number, or a range.
    #[arg(long, value_name = "PERIOD", default_value = "auto")]
    period: Period,
    /// Frames around the jump in which pixels may jump.
    #[arg(long, value_name = "FRAMES", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=65_534))]
    window: u32,
    /// Jumps that are cut, of which the one with the cheapest seam is taken.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1000))]
    jumps: u32,
    /// Loop over this jump alone: its last and its first frame, counted from 0.
    #[arg(long, value_name = "LAST,FIRST", conflicts_with = "period")]
    jump: Option<JumpArg>,
    /// How seams are priced.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = SeamArg::Gradient)]
    seam: SeamArg,
    /// Take the seam that another run wrote with --surface; its jump is given by --jump.
    #[arg(long, value_name = "FILE.png", requires = "jump", value_hint = ValueHint::FilePath)]
    surface_from: Option<PathBuf>,
    /// Fade over so many frames instead of a seam, to compare with.
    #[arg(long, value_name = "FRAMES", conflicts_with_all = ["surface_from", "with", "surface", "preview"])]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=65_534))]
    blend: Option<u32>,
    /// Write the loop so many times.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    repeat: u32,
    /// Write the first frame once more at the end, for programs that interpolate.
    #[arg(long)]
    closing_frame: bool,
    /// Frames a second, such as 25 or 30000/1001. Default: as the clip says.
    #[arg(long, value_name = "RATE", value_parser = clips::rate)]
    rate: Option<Rate>,
    /// Write one picture of so many columns and rows of frames, and OUT.json; the loop has as many frames unless
    /// --period says otherwise.
    #[arg(help_heading = "Files that are written", long, value_name = "COLSxROWS", value_parser = clips::flipbook)]
    flipbook: Option<Flipbook>,
    /// Pixels around each frame of --flipbook that repeat its border, against bleeding.
    #[arg(help_heading = "Files that are written", long, value_name = "PX", requires = "flipbook")]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=4096))]
    pad: Option<u32>,
    /// The clip to write: 'name.####.png' and the like, name.gif, name.png (animated), name.y4m, or '-' for y4m.
    #[arg(help_heading = "Files that are written", short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    output: PathBuf,
    /// Write when each pixel jumps: its first frame that is not shown.
    #[arg(help_heading = "Files that are written", long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    surface: Option<PathBuf>,
    /// Write a picture of frames, slices through time with the seam, the seam, and the jumps, for eyes.
    #[arg(help_heading = "Files that are written", long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    preview: Option<PathBuf>,
    /// Write a page about the run: DIR/index.html.
    #[arg(help_heading = "Files that are written", long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    report: Option<PathBuf>,
}

/// What a mode made.
struct Made {
    /// `None` where samples were mixed.
    map: Option<SourceMap<3>>,
    /// Frames that were mixed.
    mixed: Option<Plane<3>>,
    /// Frames after which it begins again.
    period: u32,
    options: Used,
    stats: serde_json::Value,
    how: String,
    /// Pictures beside it.
    surface: Option<Plane<2>>,
    preview: Option<Plane<2>>,
    complete: bool,
}

impl Video {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("video");
        let paths: Vec<PathBuf> = std::iter::once(&self.clip).chain(&self.with).cloned().collect();
        let streams: Vec<PathBuf> = paths.iter().chain(&self.surface_from).cloned().collect();
        inputs::check_streams(&streams)?;
        names::check_apart(&self.output, paths.len())?;
        self.report.as_deref().map_or(Ok(()), page::check)?;
        let read_options = ClipOptions {
            frame: inputs::options(session.limits, Role::Color, self.nonfinite),
            range: self.range,
            rate: self.rate,
            flipbook: self.from_flipbook.map(|book| Flipbook { pad: self.from_pad.unwrap_or(0), ..book }),
        };
        let open = |path: &PathBuf| ClipInput::open(session, path, &read_options);
        let clips = paths.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        let [first, passes @ ..] = &clips[..] else { return Err(Failure::new(2, "no clip")) };
        passes.iter().try_for_each(|pass| pass.check_like(first))?;
        let frames = first.info().frames;
        if frames < 2 {
            let failure = Failure::new(3, "has one frame, of which no loop is made");
            return Err(failure.about(&self.clip).remedy("give a clip of more frames"));
        }
        self.check_outputs(session, &clips, &streams)?;
        let needed = self.need(&clips);
        memory::check_fixed(&session.limits, needed).map_err(|e| e.about(&self.clip))?;
        session.detail(&format!("memory: about {needed} of {}", Bytes(session.limits.memory)));
        report.estimate = Some(needed.0);
        let used = session.options.clone();
        let used = if self.with.is_empty() { used.without("with") } else { used };
        if session.global.dry_run {
            let ([_, h, w], name) = (first.domain().shape, shown(&self.output));
            report.options = used;
            let line =
                format!("{name}: would be a loop of {frames} frames of {w}x{h} px, with about {needed} of memory");
            return Ok(Done::would(report, line));
        }
        let clips = clips.into_iter().map(|clip| clip.read(session, &mut report)).collect::<Result<Vec<_>, _>>()?;
        report.stage("read");
        let made = self.transition(session, &clips[0], used)?;
        session.watch.finish();
        report.stage("synthesis");
        (report.options, report.stats) = (made.options.clone(), made.stats.clone());
        if !made.complete {
            return Err(self.interrupted(session, &mut report, &clips, &made));
        }
        session.check_signal()?;
        let outputs = self.outputs(&mut report, session, &clips, &made)?;
        let name = shown(&self.output);
        let line = format!("{name}: {}, in {:.2} s", made.how, report.elapsed());
        Ok(Done::made(report, line, outputs))
    }

    /// The name of a clip's output.
    fn name(&self, clip: &Path) -> PathBuf {
        names::of_plane(&self.output, &clips::plane_name(clip))
    }

    /// Frames that are written for a period.
    fn written(&self, period: u32) -> u32 {
        period.saturating_mul(self.repeat).saturating_add(u32::from(self.closing_frame))
    }

    fn write_options(&self, clip: Option<&Clip>, period: Option<u32>) -> ClipWriteOptions {
        let rate = self.rate.or(clip.and_then(|clip| clip.info.rate));
        let flipbook = self.flipbook.map(|book| Flipbook { pad: self.pad.unwrap_or(0), ..book });
        ClipWriteOptions { frame: WriteOptions::default(), rate, period, flipbook }
    }

    /// Refuses what could not be written, before any work.
    fn check_outputs(&self, session: &Session<'_>, clips: &[ClipInput], others: &[PathBuf]) -> Result<(), Failure> {
        let mut read: Vec<PathBuf> = others.to_vec();
        let mut written: Vec<PathBuf> = Vec::new();
        let paths = std::iter::once(&self.clip).chain(&self.with);
        for (path, clip) in paths.zip(clips) {
            let files = if self.from_flipbook.is_some() { vec![path.clone()] } else { clips::files(path, self.range)? };
            let output = self.name(path);
            let info = clip.info();
            // No loop is longer than its clip, or than its flipbook.
            let most = self.flipbook.map_or_else(|| self.written(info.frames), Flipbook::cells);
            let writer = ClipWriter::create(&output, most, Metadata::default(), self.write_options(None, None))?;
            let held = writer.check((info.channels, info.alpha), info.depth, [info.height, info.width]);
            // Clips keep their depth.
            held.map_err(|e| Failure::from(e).remedy("write a sequence of png, tiff or exr that holds it"))?;
            let made = writer.files();
            if let Some(input) = made.iter().find(|file| files.iter().any(|input| selvedge_io::same_file(file, input)))
            {
                let failure = Failure::new(4, format!("is the same file as the input '{}'", shown(input)));
                return Err(failure.about(input).remedy("choose another name"));
            }
            // The ends stand for all frames between.
            written.extend(made.first().cloned());
            written.extend((1 < made.len()).then(|| made.last().cloned()).flatten());
            if let Some(left) = writer.left_over().first() {
                let count = writer.left_over().len();
                session.warn(left, &format!("is left over from a longer run, as are {} more", count - 1));
            }
            read.extend(files);
        }
        written.extend(self.surface.iter().chain(&self.preview).cloned());
        written.extend(self.report.as_deref().map(page::checked));
        for path in self.surface.iter().chain(&self.preview) {
            outputs::format(path, None, Some(Depth::U16).filter(|_| Some(path) == self.surface.as_ref()))?;
        }
        outputs::check(session, &written, &read)
    }

    /// An upper bound of the memory of a run.
    fn need(&self, clips: &[ClipInput]) -> Bytes {
        // For each voxel of the window: the graph, the prices of both sides of the seam, and features.
        const WINDOW: u64 = 110;
        let (domain, info) = (clips[0].domain(), clips[0].info());
        let [frames, height, width] = domain.shape.map(u64::from);
        let kept: Bytes = clips.iter().map(ClipInput::bytes).sum();
        let colors = info.channels - usize::from(info.alpha);
        let features = memory::sources(&[domain], colors);
        let window = Bytes(WINDOW) * frames.min(self.window.into()).saturating_mul(height).saturating_mul(width);
        let distances = Bytes(8) * frames.saturating_mul(frames);
        // The map, one rendered clip, and all of them as files that were not compressed.
        let most = clips.iter().map(ClipInput::bytes).max().unwrap_or_default();
        let output = memory::places(domain) + most + kept * u64::from(self.repeat) + Bytes(64 << 20);
        memory::PROGRAM + kept + features * 2 + distances + window.max(output)
    }

    fn provenance(&self, session: &Session<'_>, clips: &[Clip], made: &Made) -> Provenance {
        let inputs: Vec<Fingerprint> = clips.iter().map(|clip| clip.fingerprint.clone()).collect();
        let own = ("video", session.global.seed());
        made::provenance(own, made.options.clone(), std::slice::from_ref(&self.clip), inputs)
    }

    /// All files of a run.
    fn outputs(
        &self,
        report: &mut Report,
        session: &Session<'_>,
        clips: &[Clip],
        made: &Made,
    ) -> Result<Outputs, Failure> {
        let provenance = made.complete.then(|| self.provenance(session, clips, made));
        let mut outputs = Outputs::default();
        for clip in clips {
            let name = self.name(&clip.path);
            let name = if made.complete { name } else { outputs::partial(&name) };
            let rendered =
                made.map.as_ref().map(|map| selvedge_core::Render::render(map, &[&clip.plane])).transpose()?;
            let Some(shown) = rendered.as_ref().or(made.mixed.as_ref()) else { continue };
            let metadata = Metadata { provenance: provenance.clone(), ..clip.info.metadata.clone() };
            let options = self.write_options(Some(clip), Some(made.period));
            let mut frame = |t: u32| {
                session.check_signal()?;
                Ok(selvedge_io::clip::frame_of(shown, t % made.period)?)
            };
            outputs.clip(&name, self.written(made.period), &mut frame, (&metadata, options))?;
        }
        report.stage("encode");
        if !made.complete {
            return Ok(outputs);
        }
        let metadata = Metadata { provenance: provenance.clone(), ..Metadata::default() };
        for (path, plane) in [(&self.surface, &made.surface), (&self.preview, &made.preview)] {
            if let (Some(path), Some(plane)) = (path, plane) {
                outputs.picture(path, outputs::format(path, None, None)?, plane, &metadata)?;
            }
        }
        if let (Some(folder), Some(made_by)) = (&self.report, provenance) {
            let threads = rayon::current_num_threads();
            let mut run = report.json(&[session.global.seed()], threads, false);
            run["outputs"] = outputs.noted().into();
            let what = "Frames; slices through two turns of the loop, the second with its seam; when each pixel jumps; the jumps";
            let pictures: Vec<(&str, &Plane<2>)> = made.preview.iter().map(|plane| (what, plane)).collect();
            let page = page::page(&run, &made_by.command, &pictures, "")?;
            outputs.bytes(&page::file(folder), page.into_bytes());
        }
        Ok(outputs)
    }

    /// Keeps the best so far if that is wanted.
    fn interrupted(&self, session: &Session<'_>, report: &mut Report, clips: &[Clip], made: &Made) -> Failure {
        let signal = session.watch.signal().unwrap_or(2);
        if !session.global.keep_partial || self.output.as_os_str() == STREAM {
            return Failure::interrupted(signal);
        }
        let partial = outputs::partial(&self.name(&self.clip));
        match self.outputs(report, session, clips, made).and_then(|outputs| outputs.write(session)) {
            Ok(()) => Failure::kept(signal, &partial),
            Err(e) => e,
        }
    }
}
