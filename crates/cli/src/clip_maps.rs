//! Source maps of clips: one a frame, of which the sources are the frames of a clip, or of several, one after the
//! other.

use std::path::{Path, PathBuf};

use selvedge_core::{Domain, Grid, Origin, SampleId, SourceMap, SourceTable, Transform};
use selvedge_io::clip::ClipName;
use selvedge_io::{Fingerprint, Format, MapFile, Metadata};

use crate::clips::{self, ClipInput};
use crate::failure::{Failure, n};
use crate::inputs::Input;
use crate::outputs::Outputs;
use crate::report::Report;
use crate::session::Session;

/// The maps of all frames that were read.
pub(crate) struct ClipMaps {
    /// Over the frames that they were made from, which are numbered through.
    pub(crate) ids: Grid<SampleId, 3>,
    /// Shapes of these frames: no map says where one clip ends and the next begins.
    shapes: Vec<[u32; 2]>,
    /// By frame, what that clip was.
    pub(crate) frames: Vec<Fingerprint>,
    pub(crate) fingerprint: Fingerprint,
    pub(crate) seed: u64,
    /// Whether they were made from several clips of as many frames as they are.
    are_merged: bool,
}

impl ClipMaps {
    /// Reads the maps of all frames as one.
    pub(crate) fn read(session: &Session<'_>, name: &Path, report: &mut Report) -> Result<Self, Failure> {
        let files = clips::files(name, None)?;
        let (mut ids, mut read): (Vec<SampleId>, Vec<_>) = (Vec::new(), Vec::new());
        let mut first = None;
        for path in &files {
            session.check_signal()?;
            let one = Input::new(session, path)?.read_map(session)?;
            report.inputs.push(one.entry);
            read.push(one.fingerprint);
            ids.extend_from_slice(one.file.map.ids.plane(0));
            let first = first.get_or_insert_with(|| one.file.clone());
            if first.map.domain() != one.file.map.domain() || first.exemplars != one.file.exemplars {
                let failure = Failure::new(3, "is the map of another clip than the first").about(path);
                return Err(failure.remedy("give the maps of one run"));
            }
        }
        let no_maps = || Failure::new(3, "is no map of a clip's frames").about(name);
        let first = first.ok_or_else(no_maps)?;
        let shapes = of_frames(&first.map.table);
        let shapes = shapes.ok_or_else(|| no_maps().remedy("give maps that 'video' or 'merge' of clips wrote"))?;
        let Domain { shape: [height, width], periodic: [y, x] } = first.map.domain();
        let domain = Domain { shape: [files.len() as u32, height, width], periodic: [false, y, x] };
        let made = first.metadata.provenance;
        let are_merged = made.as_ref().is_some_and(|made| made.command.starts_with("selvedge merge "));
        let seed = made.map_or(0, |made| made.seed);
        let (ids, fingerprint) = (Grid::from_vec(domain, 1, ids)?, clips::fingerprint(name, &read));
        Ok(Self { ids, shapes, frames: first.exemplars, fingerprint, seed, are_merged })
    }

    /// Shape and topology of the output.
    pub(crate) fn domain(&self) -> Domain<3> {
        self.ids.domain()
    }

    /// Frames of each clip that they were made from.
    pub(crate) fn of_each(&self) -> u32 {
        if self.are_merged { self.domain().shape[0] } else { self.shapes.len() as u32 }
    }

    /// Refuses a clip of other frames than those that the maps were made from.
    pub(crate) fn check(&self, clip: &ClipInput) -> Result<(), Failure> {
        self.laid_over(std::slice::from_ref(clip)).map(|_| ())
    }

    /// How many of these clips the maps were made from: as many as have their frames, in order.
    pub(crate) fn laid_over(&self, clips: &[ClipInput]) -> Result<usize, Failure> {
        let (all, mut left) = (self.shapes.as_slice(), self.shapes.as_slice());
        for (i, clip) in clips.iter().enumerate() {
            let [frames, shape @ ..] = clip.domain().shape;
            let alike = left.iter().take_while(|other| **other == shape).count();
            if alike < frames as usize || (i + 1 == clips.len() && left.len() != frames as usize) {
                return Err(unlike(clip, left, left.len() < all.len()));
            }
            left = &left[frames as usize..];
            if left.is_empty() {
                return Ok(i + 1);
            }
        }
        Err(Failure::new(70, "no clip is given"))
    }

    /// The map of clips of these domains, which were checked.
    pub(crate) fn over(&self, clips: &[Domain<3>]) -> Result<SourceMap<3>, Failure> {
        let origin = |exemplar| Origin { exemplar, transform: Transform::IDENTITY };
        let sources = (0..=u16::MAX).zip(clips).map(|(exemplar, domain)| (origin(exemplar), *domain));
        Ok(SourceMap::new(self.ids.clone(), SourceTable::new(sources.collect())?)?)
    }
}

/// Says that a clip has other frames than the maps' next ones.
fn unlike(clip: &ClipInput, left: &[[u32; 2]], is_further: bool) -> Failure {
    let told = |frames: usize, [h, w]: [u32; 2]| format!("{} of {w}x{h} px", n("frame", frames));
    let [frames, shape @ ..] = clip.domain().shape;
    let next = left[0];
    let alike = left.iter().take_while(|shape| **shape == next).count();
    let (found, made) = (told(frames as usize, shape), told(alike, next));
    let what = if is_further {
        format!("{found}, but after the clips before it the maps were made from {made}")
    } else {
        format!("{found}, but the maps were made from {made}")
    };
    Failure::new(3, what).about(clip.path()).remedy("give a pass of the same frames, of each clip in order")
}

/// The names of so many maps.
pub(crate) fn files(name: &Path, frames: u32) -> Result<Vec<PathBuf>, Failure> {
    let sequence = ClipName::parse(name).filter(|_| Format::of_name(name) == Some(Format::Exr));
    let files = sequence.and_then(|sequence| (1..=frames).map(|number| sequence.file(number)).collect());
    let no_maps = || Failure::new(2, "is no name of EXR files, one a frame").about(name).remedy("write maps.####.exr");
    files.ok_or_else(no_maps)
}

/// Refuses maps of more frames than their files can number.
pub(crate) fn check_count(name: &Path, frames: u64) -> Result<(), Failure> {
    let most = u64::from(u16::MAX) + 1;
    if frames <= most {
        return Ok(());
    }
    let failure = Failure::new(3, format!("would be made from {frames} frames, and maps number {most}")).about(name);
    Err(failure.remedy("leave it out, or give fewer frames"))
}

/// Adds the maps of what was made from frames of these files.
pub(crate) fn add(
    outputs: &mut Outputs,
    name: &Path,
    map: &SourceMap<3>,
    (frames, metadata): (&[Fingerprint], &Metadata),
) -> Result<(), Failure> {
    for (path, map) in files(name, map.domain().shape[0])?.iter().zip(each(map)?) {
        outputs.map(path, &MapFile::new(map?, frames.to_vec(), metadata.clone()))?;
    }
    Ok(())
}

/// Some frames of a map, one after the other.
pub(crate) fn frames(map: &SourceMap<3>, which: &[u32]) -> Result<SourceMap<3>, Failure> {
    let Domain { shape: [_, height, width], periodic: [_, y, x] } = map.domain();
    let (frame, mut ids) = (map.domain().strides()[0], Vec::new());
    which.iter().for_each(|&t| ids.extend_from_slice(&map.ids.plane(0)[t as usize * frame..][..frame]));
    let domain = Domain { shape: [which.len() as u32, height, width], periodic: [false, y, x] };
    Ok(SourceMap::new(Grid::from_vec(domain, 1, ids)?, map.table.clone())?)
}

/// By frame, the map of a picture whose sources are the frames of all clips.
pub(crate) fn each(map: &SourceMap<3>) -> Result<impl Iterator<Item = Result<SourceMap<2>, Failure>>, Failure> {
    let table = by_frames(&map.table)?;
    let Domain { shape: [_, height, width], periodic: [_, y, x] } = map.domain();
    let (domain, pixels) = (Domain { shape: [height, width], periodic: [y, x] }, height as usize * width as usize);
    let frame = move |ids: &[SampleId]| Ok(SourceMap::new(Grid::from_vec(domain, 1, ids.to_vec())?, table.clone())?);
    Ok(map.ids.plane(0).chunks(pixels.max(1)).map(frame))
}

/// Each frame of each clip as a source of its own. Samples keep their numbers: they are numbered frame by frame.
fn by_frames(table: &SourceTable<3>) -> Result<SourceTable<2>, Failure> {
    let frames = table.sources().iter().flat_map(|(_, clip)| {
        let [count, height, width] = clip.shape;
        (0..count).map(move |_| Domain::open([height, width]))
    });
    let source = |(frame, domain)| (Origin { exemplar: frame, transform: Transform::IDENTITY }, domain);
    Ok(SourceTable::new((0..=u16::MAX).zip(frames).map(source).collect())?)
}

/// The shapes of the frames that are the sources of a map; `None` for sources that are no frames.
fn of_frames(table: &SourceTable<2>) -> Option<Vec<[u32; 2]>> {
    let is_frame = |(number, (origin, _)): (usize, &(Origin, Domain<2>))| {
        usize::from(origin.exemplar) == number && origin.transform == Transform::IDENTITY
    };
    let all = table.sources();
    let are_frames = !all.is_empty() && all.iter().enumerate().all(is_frame);
    are_frames.then(|| all.iter().map(|(_, domain)| domain.shape).collect())
}
