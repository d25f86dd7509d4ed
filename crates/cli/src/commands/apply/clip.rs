//! The maps of a clip laid over other passes of the same frames, bit for bit.

use std::path::{Path, PathBuf};

use selvedge_core::{Bytes, Domain, Plane, Render as _, Role};
use selvedge_io::clip::{ClipWriteOptions, ClipWriter};
use selvedge_io::{Fingerprint, Metadata};

use super::Apply;
use crate::clip_given::{check_alike, opened};
use crate::clip_maps::ClipMaps;
use crate::clips::{self, Clip, ClipInput};
use crate::failure::{Failure, n, shown};
use crate::inputs;
use crate::options::names_of;
use crate::outputs::{self, Outputs};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::{made, memory, names};

impl Apply {
    /// True for the maps of a clip: one a frame, under names that go by numbers.
    pub(super) fn is_of_clip(&self) -> bool {
        clips::is_pattern(&self.map)
    }

    /// Runs the command over clips.
    pub(super) fn over_clips(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("apply");
        self.check_options(session)?;
        inputs::check_streams(&self.planes)?;
        let files = clips::files(&self.map, None)?;
        let maps = ClipMaps::read(session, &self.map, &mut report)?;
        let frame = inputs::options(session.limits, Role::Color, self.nonfinite);
        // What was held over all frames has one picture a pass.
        let clips = opened(session, &self.planes, Some(maps.of_each()), &frame)?;
        let of_each = of_each(session, &maps, &clips)?;
        names::check_apart(&self.output, clips.len() / of_each)?;
        let written = self.check_clips(session, (&clips, of_each, files), maps.domain())?;
        let made = clips.iter().step_by(of_each).map(|clip| made_of(&maps, clip) * 2).sum::<Bytes>();
        let held = clips.iter().map(|clip| clip.bytes() * 2).sum::<Bytes>() + made;
        let needed = memory::PROGRAM + memory::places(maps.domain()) * 3 + held;
        memory::check_fixed(&session.limits, needed)?;
        report.estimate = Some(needed.0);
        report.stage("read");
        let Domain { shape: [frames, height, width], .. } = maps.domain();
        let size = format!("{} of {width}x{height} px", n("frame", frames as usize));
        let told: Vec<String> = written.iter().map(|path| shown(path)).collect();
        let (told, through) = (told.join(", "), shown(&self.map));
        if session.global.dry_run {
            report.inputs.extend(clips.iter().map(|clip| clip.noted(None)));
            let line = format!("{told}: would be {size} through {through}, with about {needed} of memory");
            let planned = written.iter().map(|path| outputs::planned_clip(path, [height, width], Some(frames)));
            return Ok(Done::would(report, line, planned.collect()));
        }
        let mut outputs = Outputs::default();
        let mut clips = clips.into_iter();
        for path in &written {
            let of_one = clips.by_ref().take(of_each).map(|clip| clip.read(session, &mut report));
            self.lay_clips(session, &maps, &of_one.collect::<Result<Vec<_>, _>>()?, (path, &mut outputs))?;
        }
        let line = format!("{told}: {size} through {through}, in {:.2} s", report.elapsed());
        Ok(Done::made(report, line, outputs))
    }

    /// Samples of clips are copied: whatever turns or mixes them does nothing.
    fn check_options(&self, session: &Session<'_>) -> Result<(), Failure> {
        let idle: Vec<String> =
            names_of::<Self>().into_iter().filter(|name| !["output", "nonfinite"].contains(&name.as_str())).collect();
        match session.first_typed(&idle) {
            Some(option) => {
                let what = format!("{option} does nothing with the maps of a clip, whose samples are copied");
                Err(Failure::new(2, what).remedy("leave it out"))
            }
            None => Ok(()),
        }
    }

    /// Refuses what could not be written; the names of what is.
    fn check_clips(
        &self,
        session: &Session<'_>,
        (clips, of_each, mut read): (&[ClipInput], usize, Vec<PathBuf>),
        domain: Domain<3>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let [frames, height, width] = domain.shape;
        let (mut names, mut written) = (Vec::new(), Vec::new());
        for clip in clips {
            read.extend(clips::files(clip.path(), None)?);
        }
        for clip in clips.iter().step_by(of_each) {
            let (path, info) = (names::of_plane(&self.output, &clips::plane_name(clip.path())), clip.info());
            let options = ClipWriteOptions { rate: info.rate, ..ClipWriteOptions::default() };
            let writer = ClipWriter::create(&path, frames, Metadata::default(), options)?;
            clips::check_held(&writer, (info.channels, info.alpha), info.depth, [height, width])?;
            clips::tell_left_over(session, &writer);
            written.extend(writer.files());
            names.push(path);
        }
        outputs::check(session, &written, &read)?;
        Ok(names)
    }

    fn lay_clips(
        &self,
        session: &Session<'_>,
        maps: &ClipMaps,
        clips: &[Clip],
        (path, outputs): (&Path, &mut Outputs),
    ) -> Result<(), Failure> {
        let mut made = maps.frames.iter();
        for clip in clips {
            let other = |(own, made): (&Fingerprint, &Fingerprint)| own.name == made.name && own.blake3 != made.blake3;
            if clip.frames.iter().zip(made.by_ref()).filter(|both| other(*both)).count() != 0 {
                session.warn(&clip.path, &"the maps were made from frames of these names, but with other contents");
            }
        }
        let domains: Vec<Domain<3>> = clips.iter().map(|clip| clip.plane.domain()).collect();
        let planes: Vec<&Plane<3>> = clips.iter().map(|clip| &clip.plane).collect();
        let rendered = maps.over(&domains)?.render(&planes)?;
        let inputs = std::iter::once(&maps.fingerprint).chain(clips.iter().map(|clip| &clip.fingerprint));
        let files: Vec<PathBuf> =
            std::iter::once(&self.map).chain(clips.iter().map(|clip| &clip.path)).cloned().collect();
        let used = session.options.clone();
        let provenance = made::provenance(("apply", maps.seed), used, &files, inputs.cloned().collect());
        let metadata = Metadata { provenance: Some(provenance), ..clips[0].info.metadata.clone() };
        let options = ClipWriteOptions { rate: clips[0].info.rate, ..ClipWriteOptions::default() };
        let mut frame = |t: u32| {
            session.check_signal()?;
            Ok(selvedge_io::clip::frame_of(&rendered, t)?)
        };
        outputs.clip(path, maps.domain().shape[0], &mut frame, (&metadata, options))
    }
}

/// How many clips are one output: as many as the maps were made from, alike in samples.
fn of_each(session: &Session<'_>, maps: &ClipMaps, clips: &[ClipInput]) -> Result<usize, Failure> {
    let of_each = maps.laid_over(clips)?;
    for of_one in clips.chunks(of_each) {
        maps.laid_over(of_one)?;
        check_alike(session, of_one)?;
    }
    Ok(of_each)
}

/// Bytes of what is made of a clip.
fn made_of(maps: &ClipMaps, clip: &ClipInput) -> Bytes {
    memory::picture(maps.domain(), clip.info().channels, clip.info().depth)
}
