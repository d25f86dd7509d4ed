//! What `video` writes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Depth, Plane, Render as _};
use selvedge_io::clip::{ClipWriteOptions, ClipWriter, Flipbook, Rate};
use selvedge_io::{Destination, Fingerprint, Format, Metadata, Provenance, WriteOptions};
use serde_json::Value;

use super::modes::Way;
use super::read::ReadArgs;
use super::still::Still;
use super::{ClipOutcome, blended};
use crate::blending::Blending;
use crate::clips::{self, Clip, ClipInput, Encode};
use crate::failure::{Failure, shown};
use crate::options::option;
use crate::outputs::{self, Outputs};
use crate::reel::Reel;
use crate::report::Report;
use crate::session::Session;
use crate::stdio::STREAM;
use crate::used::Used;
use crate::{clip_look, clip_maps, made, names, page};

/// How often the loop is written, how, and what beside it.
#[derive(Args, Clone, Debug)]
#[command(mut_args(option("fuse", |arg| arg.hide(true))))]
#[command(mut_args(option("feather", |arg| arg
    .help("Feather seams within each frame with a Gaussian kernel of this many pixels (its sigma), up to 16; not in time, \
           nor those of --with"))))]
pub(super) struct WriteArgs {
    /// Write the loop so many times.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(super) repeat: u32,
    /// Write the first frame once more at the end, for programs that interpolate.
    #[arg(long)]
    pub(super) closing_frame: bool,
    /// Frames a second, such as 25 or 30000/1001. Default: as the clip says.
    #[arg(long, value_name = "RATE", value_parser = clips::rate)]
    pub(super) rate: Option<Rate>,
    /// Write one picture of so many columns and rows of frames, and OUT.json; the loop has as many frames unless
    /// --period says otherwise.
    #[arg(help_heading = "Files that are written", long, value_name = "COLSxROWS", value_parser = clips::flipbook)]
    pub(super) flipbook: Option<Flipbook>,
    /// Pixels around each frame of --flipbook that repeat its border, against bleeding.
    #[arg(help_heading = "Files that are written", long, value_name = "PX", requires = "flipbook")]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=4096))]
    pub(super) pad: Option<u32>,
    /// The clip to write: 'name.####.png' and the like, name.gif, name.png (animated), name.y4m, '-' for y4m,
    /// or name.mp4, .mov, .webm, .mkv, .avi by ffmpeg.
    #[arg(help_heading = "Files that are written", short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub(super) output: PathBuf,
    #[command(flatten)]
    encode: Encode,
    #[command(flatten)]
    pub(super) blending: Blending,
    /// Write when each pixel jumps: its first frame that is not shown.
    #[arg(help_heading = "Files that are written", long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    pub(super) surface: Option<PathBuf>,
    /// Write source maps, one a frame: 'maps.####.exr'. Their sources are the clip's frames.
    #[arg(help_heading = "Files that are written", long, value_name = "MAPS.####.exr", value_hint = ValueHint::FilePath)]
    #[arg(conflicts_with = "blend")]
    pub(super) map: Option<PathBuf>,
    /// Write a picture of frames, slices through time with the seam, the seam, and the jumps, for eyes.
    #[arg(help_heading = "Files that are written", long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    pub(super) preview: Option<PathBuf>,
    /// Write a page about the run: DIR/index.html.
    #[arg(help_heading = "Files that are written", long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(super) report: Option<PathBuf>,
}

impl WriteArgs {
    /// Refuses one name for several outputs, and a folder of a page that is none.
    pub(super) fn check_names(&self, outputs: usize) -> Result<(), Failure> {
        names::check_apart(&self.output, outputs)?;
        self.report.as_deref().map_or(Ok(()), page::check)
    }

    /// A name beside which a run may keep what it needs: that of its clip, or one among what passes.
    pub(super) fn beside(&self) -> PathBuf {
        let is_stream = self.output.as_os_str() == STREAM;
        if is_stream { std::env::temp_dir().join("selvedge.y4m") } else { self.output.with_extension("y4m") }
    }

    /// The name of a clip's output.
    fn name(&self, clip: &Path) -> PathBuf {
        names::of_plane(&self.output, &clips::plane_name(clip))
    }

    /// What a dry run says of the clips that would be written, of so many frames where that is known.
    pub(super) fn planned(&self, of: &ReadArgs, way: &Way, frames: Option<u32>) -> Vec<Value> {
        let [_, height, width] = way.output.shape;
        let planned = |clip| outputs::planned_clip(&self.name(clip), [height, width], frames);
        of.paths().map(|path| planned(path)).collect()
    }

    /// Frames that are written of a loop of so many.
    pub(super) fn written(&self, period: u32) -> u32 {
        period.saturating_mul(self.repeat).saturating_add(u32::from(self.closing_frame))
    }

    /// Frames that are written, in words, where these are not the loop's own.
    pub(super) fn more(&self, made: &ClipOutcome) -> String {
        let frames = self.count(made);
        if frames == made.frames { String::new() } else { format!(", written as {frames} frames") }
    }

    fn count(&self, made: &ClipOutcome) -> u32 {
        made.played.unwrap_or_else(|| self.written(made.frames))
    }

    /// Frames of a loop that fills a flipbook.
    pub(super) fn filled(&self) -> Option<u32> {
        self.flipbook.filter(|_| self.repeat == 1 && !self.closing_frame).map(Flipbook::cells)
    }

    /// Frames that are written at most.
    pub(super) fn most(&self, way: &Way, clip: &ClipInput) -> u32 {
        // No loop is longer than its flipbook; what is woven has as many frames as are asked for.
        let book = self.flipbook.filter(|_| way.jumps() && way.play.is_none()).map(Flipbook::cells);
        book.unwrap_or_else(|| self.written(way.most(clip.domain())[0]))
    }

    /// One that tells what it would write.
    fn writer(&self, output: &Path, frames: u32) -> Result<ClipWriter, Failure> {
        Ok(ClipWriter::create(output, frames, Metadata::default(), self.write_options(None, None))?)
    }

    /// Tells of frames of a longer run once it is known how many of `most` are written.
    pub(super) fn tell_left_over<'p>(
        &self,
        session: &Session<'_>,
        mut clips: impl Iterator<Item = &'p Path>,
        (most, made): (u32, &ClipOutcome),
    ) -> Result<(), Failure> {
        let count = self.count(made);
        let tell = |clip| self.writer(&self.name(clip), count).map(|writer| clips::tell_left_over(session, &writer));
        if count < most { clips.try_for_each(tell) } else { Ok(()) }
    }

    fn write_options(&self, rate: Option<Rate>, period: Option<u32>) -> ClipWriteOptions {
        let rate = self.rate.or(rate);
        let flipbook = self.flipbook.map(|book| Flipbook { pad: self.pad.unwrap_or(0), ..book });
        ClipWriteOptions { frame: WriteOptions::default(), rate, period, flipbook, encode: self.encode.arguments() }
    }

    /// Refuses what could not be written, before any work.
    pub(super) fn check(
        &self,
        session: &Session<'_>,
        of: &ReadArgs,
        (clips, way): (&[ClipInput], &Way),
        others: &[PathBuf],
    ) -> Result<(), Failure> {
        let mut read: Vec<PathBuf> = of.paths().chain(others).cloned().collect();
        let mut written: Vec<PathBuf> = Vec::new();
        for (path, clip) in of.paths().zip(clips) {
            let files = of.files(path)?;
            let output = self.name(path);
            let info = clip.info();
            let [_, height, width] = way.most(clip.domain());
            let writer = self.writer(&output, self.most(way, clip))?;
            clips::check_held(&writer, (info.channels, info.alpha), info.depth, [height, width])?;
            let made = writer.files();
            let inputs: BTreeSet<Destination> = files.iter().map(|file| Destination::of(file)).collect();
            let is_read = |file: &&PathBuf| file.as_os_str() != STREAM && inputs.contains(&Destination::of(file));
            if let Some(input) = made.iter().find(is_read) {
                let failure = Failure::new(4, format!("is the same file as the input '{}'", shown(input)));
                return Err(failure.about(input).remedy("choose another name"));
            }
            // The ends stand for all frames between.
            written.extend(made.first().cloned());
            written.extend((1 < made.len()).then(|| made.last().cloned()).flatten());
            clips::tell_left_over(session, &writer);
            clips::tell_rate(session, &output, self.rate.or(info.rate));
            read.extend(files);
        }
        if let Some(name) = &self.map {
            let all = clip_maps::files(name, way.most(clips[0].domain())[0])?;
            written.extend([all.first(), all.last()].into_iter().flatten().cloned());
        }
        written.extend(self.surface.iter().chain(&self.preview).cloned());
        written.extend(self.report.as_deref().map(page::checked));
        for path in self.surface.iter().chain(&self.preview) {
            let depth = if Format::of_name(path) == Some(Format::Exr) { Depth::F32 } else { Depth::U16 };
            outputs::format(path, None, Some(depth).filter(|_| Some(path) == self.surface.as_ref()))?;
        }
        outputs::check(session, &written, &read)
    }

    fn provenance<'c>(
        session: &Session<'_>,
        clip: &PathBuf,
        clips: impl Iterator<Item = &'c Fingerprint>,
        options: Used,
    ) -> Provenance {
        let own = ("video", session.global.seed());
        made::provenance(own, options, std::slice::from_ref(clip), clips.cloned().collect())
    }

    /// The files of clips that are read again: `frame` makes each frame of each of them, by their numbers.
    pub(super) fn reread(
        &self,
        session: &Session<'_>,
        (reels, read): (&[Reel<'_>], &[Fingerprint]),
        made: &ClipOutcome,
        frame: &mut dyn FnMut(usize, u32) -> Result<Plane<2>, Failure>,
    ) -> Result<Outputs, Failure> {
        let provenance = Some(Self::provenance(session, &reels[0].path, read.iter(), made.options.clone()));
        let mut outputs = Outputs::beside(session);
        for (number, reel) in reels.iter().enumerate() {
            let metadata = Metadata { provenance: provenance.clone(), ..reel.info.metadata.clone() };
            let options = self.write_options(reel.info.rate, made.loops.then_some(made.frames));
            let mut frame = |t: u32| frame(number, t % made.frames);
            outputs.clip(&self.name(&reel.path), self.count(made), &mut frame, (&metadata, options))?;
        }
        self.add_surface(&mut outputs, session, (&reels[0].path, read.iter()), made)?;
        Ok(outputs)
    }

    /// The surface, if it is asked for: its file tells the jump that was taken.
    fn add_surface<'c>(
        &self,
        outputs: &mut Outputs,
        session: &Session<'_>,
        (clip, clips): (&PathBuf, impl Iterator<Item = &'c Fingerprint>),
        made: &ClipOutcome,
    ) -> Result<(), Failure> {
        let (Some(path), Some(plane)) = (&self.surface, &made.surface) else { return Ok(()) };
        let made_by = Self::provenance(session, clip, clips, made.options.clone());
        let metadata = Metadata { provenance: Some(made_by), ..Metadata::default() };
        outputs.picture(path, outputs::format(path, None, None)?, plane, &metadata)
    }

    /// Whether all that is written can be made of a few frames at once.
    pub(super) fn needs_few_frames(&self) -> bool {
        let whole = self.map.is_some() || self.preview.is_some() || self.report.is_some();
        !whole && self.blending.is_none()
    }

    /// All files of a run.
    pub(super) fn outputs(
        &self,
        report: &mut Report,
        session: &Session<'_>,
        (clips, still): (&[Clip], Option<&Still>),
        (made, streams): (&ClipOutcome, bool),
    ) -> Result<Outputs, Failure> {
        let read = || clips.iter().map(|clip| &clip.fingerprint);
        let provenance = made.complete.then(|| Self::provenance(session, &clips[0].path, read(), made.options.clone()));
        let mut outputs = if streams { Outputs::beside(session) } else { Outputs::default() };
        let mut blended = match &made.map {
            // Other passes are copied: no blend of vectors is a vector.
            Some(map) if made.complete && !self.blending.is_none() => {
                let still = still.map(|still| &still.mask);
                Some(blended::frames(session, self.blending, (map, &clips[0].plane), still)?)
            }
            _ => None,
        };
        for clip in clips {
            let name = self.name(&clip.path);
            let name = if made.complete { name } else { outputs::partial(&name) };
            let blended = blended.take();
            let metadata = Metadata { provenance: provenance.clone(), ..clip.info.metadata.clone() };
            let options = self.write_options(clip.info.rate, made.loops.then_some(made.frames));
            let mut frame = |t: u32| {
                // What is kept of a run that was ended is written whole.
                made.complete.then(|| session.check_signal()).transpose()?;
                let t = t % made.frames;
                match (&blended, &made.map, &made.mixed) {
                    (Some(frames), _, _) => Ok(frames[t as usize].clone()),
                    (None, Some(map), _) => {
                        Ok(selvedge_io::clip::frame_of(&clip_maps::frames(map, &[t])?.render(&[&clip.plane])?, 0)?)
                    }
                    (None, None, Some(mixed)) => Ok(selvedge_io::clip::frame_of(mixed, t)?),
                    (None, None, None) => unreachable!("a map or mixed frames"),
                }
            };
            outputs.clip(&name, self.count(made), &mut frame, (&metadata, options))?;
        }
        report.stage("encode");
        if !made.complete {
            return Ok(outputs);
        }
        let metadata = Metadata { provenance: provenance.clone(), ..Metadata::default() };
        if let (Some(name), Some(map)) = (&self.map, &made.map) {
            clip_maps::add(&mut outputs, name, map, (&clips[0].frames, &metadata))?;
        }
        self.add_surface(&mut outputs, session, (&clips[0].path, read()), made)?;
        if let (Some(path), Some(plane)) = (&self.preview, &made.preview) {
            outputs.picture(path, outputs::format(path, None, None)?, plane, &metadata)?;
        }
        if let (Some(folder), Some(made_by)) = (&self.report, provenance) {
            let what = "Frames; slices through two turns of the loop, the second with its seam; when each pixel jumps; the jumps";
            let made_by = (folder.as_path(), made_by.command.as_str());
            clip_look::add_page(&mut outputs, session, report, made_by, (what, made.preview.as_ref()))?;
        }
        Ok(outputs)
    }

    /// Keeps the best so far if that is wanted.
    pub(super) fn interrupted(
        &self,
        session: &Session<'_>,
        report: &mut Report,
        clips: &[Clip],
        made: &ClipOutcome,
    ) -> Failure {
        let signal = session.watch.signal().unwrap_or(2);
        if !session.global.keep_partial || self.output.as_os_str() == STREAM {
            return session.interrupted(signal);
        }
        let partial = outputs::partial(&self.name(&clips[0].path));
        match self.outputs(report, session, (clips, None), (made, false)).and_then(|outputs| outputs.write(session)) {
            Ok(()) => Failure::kept(signal, &partial),
            Err(e) => e,
        }
    }
}
