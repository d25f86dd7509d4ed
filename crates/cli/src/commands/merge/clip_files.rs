//! What `merge` of clips writes.

use std::path::{Path, PathBuf};

use selvedge_core::{Depth, Domain, Exemplars, Plane, Render as _};
use selvedge_graphcut_textures::labels::Label;
use selvedge_io::clip::{ClipWriteOptions, ClipWriter, Rate, frame_of};
use selvedge_io::{Fingerprint, Metadata};

use super::clip_blended::Blended;
use super::clip_laid::{Laid, Merged};
use super::placed::shows;
use super::{Merge, clip_seen, told};
use crate::clips::{self, Clip, is_pattern};
use crate::failure::{Failure, n};
use crate::harmonise::hidden;
use crate::outputs::{self, Outputs};
use crate::report::Report;
use crate::session::Session;
use crate::stdio::STREAM;
use crate::used::Used;
use crate::{clip_look, clip_maps, made, names, page};

/// What a preview shows.
const PREVIEW: &str = "Frames, without and with their seams; slices through time, the second of each with its seam";

impl Merge {
    /// Refuses what could not be written, before any work.
    pub(super) fn check_written(&self, session: &Session<'_>, laid: &Laid) -> Result<(), Failure> {
        let [frames, height, width] = laid.output.shape;
        let mut written = Vec::new();
        let shown = laid.shown().map(|clip| {
            let info = clip.info();
            (self.clip_name(clip.path()), (info.channels, info.alpha), info.depth)
        });
        let numbers = self.label_map.iter().map(|path| (path.clone(), (1, false), Depth::U8));
        for (path, channels, depth) in shown.chain(numbers) {
            let writer = ClipWriter::create(&path, frames, Metadata::default(), options(laid.rate))?;
            clips::check_held(&writer, channels, depth, [height, width])?;
            clips::tell_left_over(session, &writer);
            written.extend(writer.files());
        }
        if let Some(name) = &self.weaving.map {
            written.extend(clip_maps::files(name, frames)?);
            clip_maps::check_count(name, laid.clips.iter().map(|clip| u64::from(clip.info().frames)).sum())?;
        }
        if let Some(path) = &self.weaving.preview {
            outputs::format(path, None, None)?;
        }
        written.extend(self.weaving.preview.clone());
        if let Some(folder) = self.weaving.report.as_deref() {
            page::check(folder)?;
            written.push(page::checked(folder));
        }
        let mut read = Vec::new();
        for path in self.files() {
            read.extend(if is_pattern(&path) { clips::files(&path, None)? } else { vec![path] });
        }
        outputs::check(session, &written, &read)
    }

    /// All files and sequences that are read.
    pub(super) fn files(&self) -> impl Iterator<Item = PathBuf> {
        let kept = self.keep.chunks(2).map(|pair| PathBuf::from(&pair[1]));
        let kept = kept.chain(self.fuse_keep.of(self.blending).ok().flatten().cloned());
        let read = self.weaving.with.with.iter().chain(&self.strokes);
        self.weaving.input.files().into_iter().chain(read.cloned()).chain(kept)
    }

    /// Refuses outputs that cannot tell what is in no clip from black.
    pub(super) fn check_bare(
        &self,
        clips: &[Clip],
        passes: &[Clip],
        (exemplars, labels, output): (&Exemplars<3>, &[Label<3>], Domain<3>),
    ) -> Result<(), Failure> {
        let shown = |at: &[u32; 3]| labels.iter().any(|label| shows(exemplars, label, *at));
        let bare = output.positions().filter(|at| !shown(at)).count();
        let [frames, shape @ ..] = output.shape;
        for clip in std::iter::once(&clips[0]).chain(passes.iter().step_by(clips.len())).filter(|_| 0 < bare) {
            let (path, plane) = (self.clip_name(&clip.path), &clip.plane);
            let writer = ClipWriter::create(&path, frames, Metadata::default(), options(clip.info.rate))?;
            if writer.check((plane.color_channels() + 1, true), plane.samples.depth(), shape).is_err() {
                let what = format!(
                    "{} of all frames are in none of the clips, and it holds no transparency",
                    n("pixel", bare)
                );
                let failure = Failure::new(3, what).about(&path);
                return Err(failure.remedy("write frames of PNG, or lay clips with --at so that they fill their box"));
            }
        }
        Ok(())
    }

    /// The name of the output that shows a clip, or a pass, first.
    pub(super) fn clip_name(&self, clip: &Path) -> PathBuf {
        names::of_plane(&self.weaving.output, &clips::plane_name(clip))
    }

    /// All files of a run.
    pub(super) fn clip_outputs(
        &self,
        session: &Session<'_>,
        report: &mut Report,
        merged: &Merged,
    ) -> Result<Outputs, Failure> {
        let mut outputs = Outputs::default();
        let own = merged.used_for(None);
        let mut seen = (merged.complete && self.is_seen()).then(Vec::new);
        self.add_clip(&mut outputs, session, merged, (&merged.clips, own, seen.as_mut()))?;
        for passes in merged.passes.chunks(merged.clips.len()) {
            self.add_clip(&mut outputs, session, merged, (passes, merged.used_for(Some(passes)), None))?;
        }
        report.stage("encode");
        // What is not whole does not say how it was made: no command makes it again.
        if !merged.complete {
            return Ok(outputs);
        }
        let made_by = self.made(session, merged, (merged.used_for(None), &[]));
        let told = Metadata { provenance: Some(made_by.clone()), ..Metadata::default() };
        if let Some(path) = &self.label_map {
            let numbers = told::numbered(&merged.map)?;
            let mut frame = |t: u32| Ok(frame_of(&numbers, t)?);
            outputs.clip(path, merged.frames(), &mut frame, (&told, options(merged.rate)))?;
        }
        if let Some(name) = &self.weaving.map {
            let frames: Vec<Fingerprint> = merged.clips.iter().flat_map(|clip| clip.frames.clone()).collect();
            clip_maps::add(&mut outputs, name, &merged.map, (&frames, &told))?;
        }
        let preview = seen.map(|frames| clip_seen::preview(&frames, &merged.map)).transpose()?;
        if let (Some(path), Some(plane)) = (&self.weaving.preview, &preview) {
            outputs.view(path, plane, &told)?;
        }
        if let Some(folder) = &self.weaving.report {
            let made_by = (folder.as_path(), made_by.command.as_str());
            clip_look::add_page(&mut outputs, session, report, made_by, (PREVIEW, preview.as_ref()))?;
        }
        Ok(outputs)
    }

    /// Whether somebody will see frames and slices.
    pub(super) fn is_seen(&self) -> bool {
        self.weaving.preview.is_some() || self.weaving.report.is_some()
    }

    /// Adds what the map shows of clips, or of passes of them; frames that are to be `seen` are kept.
    fn add_clip(
        &self,
        outputs: &mut Outputs,
        session: &Session<'_>,
        merged: &Merged,
        (shown, used, mut seen): (&[Clip], Used, Option<&mut Vec<Plane<2>>>),
    ) -> Result<(), Failure> {
        let planes: Vec<&Plane<3>> = shown.iter().map(|clip| &clip.plane).collect();
        let passes = if std::ptr::eq(shown, merged.clips.as_slice()) { &[] } else { shown };
        let provenance = merged.complete.then(|| self.made(session, merged, (used, passes)));
        let metadata = Metadata { provenance, ..shown[0].info.metadata.clone() };
        // Other passes are copied: no blend of vectors is a vector.
        let blending = self.blending.of_whole(merged.complete && passes.is_empty());
        let blended = Blended::of(session, blending, merged)?;
        let mut frame = |t: u32| {
            // What is kept of a run that was ended is written whole.
            merged.complete.then(|| session.check_signal()).transpose()?;
            let map = clip_maps::frames(&merged.map, &[t])?;
            let frame = match &blended {
                Some(blended) => blended.frame(merged, t)?,
                None => frame_of(&map.render(&planes)?, 0)?,
            };
            // Black would be as good as any colour of the clips.
            let frame = if merged.holes { hidden(frame, |i| !map.ids.plane(0)[i].is_assigned())? } else { frame };
            if let Some(seen) = &mut seen {
                seen.push(frame.clone());
            }
            Ok(frame)
        };
        let path = self.clip_name(&shown[0].path);
        let path = if merged.complete { path } else { outputs::partial(&path) };
        outputs.clip(&path, merged.frames(), &mut frame, (&metadata, options(merged.rate)))
    }

    /// Keeps the best so far if that is wanted.
    pub(super) fn interrupted(&self, session: &Session<'_>, report: &mut Report, merged: &Merged) -> Failure {
        let signal = session.watch.signal().unwrap_or(2);
        if !session.global.keep_partial || self.weaving.output.as_os_str() == STREAM {
            return session.interrupted(signal);
        }
        let partial = outputs::partial(&self.clip_name(&merged.clips[0].path));
        match self.clip_outputs(session, report, merged).and_then(|outputs| outputs.write(session)) {
            Ok(()) => Failure::kept(signal, &partial),
            Err(e) => e,
        }
    }

    fn made(&self, session: &Session<'_>, merged: &Merged, (used, passes): (Used, &[Clip])) -> selvedge_io::Provenance {
        let read = merged.clips.iter().map(|clip| &clip.fingerprint).chain(&merged.others);
        let inputs = read.chain(passes.iter().map(|pass| &pass.fingerprint)).cloned().collect();
        made::provenance(("merge", session.global.seed()), used, &self.weaving.input.exemplars, inputs)
    }
}

fn options(rate: Option<Rate>) -> ClipWriteOptions {
    ClipWriteOptions { rate, ..ClipWriteOptions::default() }
}
