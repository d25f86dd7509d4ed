//! The maps of a clip laid over other passes of the same frames, bit for bit.

use std::path::{Path, PathBuf};

use selvedge_core::{Bytes, Domain, Render as _, Role};
use selvedge_io::clip::{ClipOptions, ClipWriteOptions, ClipWriter};
use selvedge_io::{Fingerprint, Metadata};

use super::Apply;
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
        names::check_apart(&self.output, self.planes.len())?;
        let files = clips::files(&self.map, None)?;
        let maps = ClipMaps::read(session, &self.map, &mut report)?;
        let frame = inputs::options(session.limits, Role::Color, self.nonfinite);
        let options = ClipOptions { frame, ..ClipOptions::default() };
        let open = |path: &PathBuf| ClipInput::open(session, path, &options);
        let clips = self.planes.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        clips.iter().try_for_each(|clip| maps.check(clip))?;
        let written = self.check_clips(session, (&clips, files), maps.map.domain())?;
        let held = clips.iter().map(|clip| clip.bytes() * 2 + made_of(&maps, clip) * 2).sum::<Bytes>();
        let needed = memory::PROGRAM + memory::places(maps.map.domain()) * 2 + held;
        memory::check_fixed(&session.limits, needed)?;
        report.estimate = Some(needed.0);
        report.stage("read");
        let Domain { shape: [frames, height, width], .. } = maps.map.domain();
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
        for (clip, path) in clips.into_iter().zip(&written) {
            let clip = clip.read(session, &mut report)?;
            self.lay_clip(session, &maps, &clip, (path, &mut outputs))?;
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
        (clips, mut read): (&[ClipInput], Vec<PathBuf>),
        domain: Domain<3>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let [frames, height, width] = domain.shape;
        let (mut names, mut written) = (Vec::new(), Vec::new());
        for clip in clips {
            let (path, info) = (names::of_plane(&self.output, &clips::plane_name(clip.path())), clip.info());
            let options = ClipWriteOptions { rate: info.rate, ..ClipWriteOptions::default() };
            let writer = ClipWriter::create(&path, frames, Metadata::default(), options)?;
            clips::check_held(&writer, (info.channels, info.alpha), info.depth, [height, width])?;
            clips::tell_left_over(session, &writer);
            written.extend(writer.files());
            read.extend(clips::files(clip.path(), None)?);
            names.push(path);
        }
        outputs::check(session, &written, &read)?;
        Ok(names)
    }

    fn lay_clip(
        &self,
        session: &Session<'_>,
        maps: &ClipMaps,
        clip: &Clip,
        (path, outputs): (&Path, &mut Outputs),
    ) -> Result<(), Failure> {
        let other = |(own, made): (&Fingerprint, &Fingerprint)| own.name == made.name && own.blake3 != made.blake3;
        if clip.frames.iter().zip(&maps.frames).any(other) {
            session.warn(&clip.path, &"the maps were made from frames of these names, but with other contents");
        }
        let rendered = maps.map.render(&[&clip.plane])?;
        let inputs = vec![maps.fingerprint.clone(), clip.fingerprint.clone()];
        let files = [self.map.clone(), clip.path.clone()];
        let used = session.options.clone();
        let provenance = made::provenance(("apply", maps.seed), used, &files, inputs);
        let metadata = Metadata { provenance: Some(provenance), ..clip.info.metadata.clone() };
        let options = ClipWriteOptions { rate: clip.info.rate, ..ClipWriteOptions::default() };
        let mut frame = |t: u32| {
            session.check_signal()?;
            Ok(selvedge_io::clip::frame_of(&rendered, t)?)
        };
        outputs.clip(path, maps.map.domain().shape[0], &mut frame, (&metadata, options))
    }
}

/// Bytes of what is made of a clip.
fn made_of(maps: &ClipMaps, clip: &ClipInput) -> Bytes {
    memory::picture(maps.map.domain(), clip.info().channels, clip.info().depth)
}
