//! Source maps of clips: one a frame, of which the sources are the frames of the clip.

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
    /// Over the clip that they were made from.
    pub(crate) map: SourceMap<3>,
    /// By frame, what that clip was.
    pub(crate) frames: Vec<Fingerprint>,
    pub(crate) fingerprint: Fingerprint,
    pub(crate) seed: u64,
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
        let table = of_clip(&first.map.table).ok_or_else(|| no_maps().remedy("give maps that 'video' wrote"))?;
        let Domain { shape: [height, width], periodic: [y, x] } = first.map.domain();
        let domain = Domain { shape: [files.len() as u32, height, width], periodic: [false, y, x] };
        let map = SourceMap::new(Grid::from_vec(domain, 1, ids)?, table)?;
        let seed = first.metadata.provenance.map_or(0, |made| made.seed);
        Ok(Self { map, frames: first.exemplars, fingerprint: clips::fingerprint(name, &read), seed })
    }

    /// Refuses a clip of other frames than those that the maps were made from.
    pub(crate) fn check(&self, clip: &ClipInput) -> Result<(), Failure> {
        let (made, found) = (self.map.table.sources()[0].1.shape, clip.domain().shape);
        if made == found {
            return Ok(());
        }
        let told = |[frames, h, w]: [u32; 3]| format!("{} of {w}x{h} px", n("frame", frames as usize));
        let what = format!("{}, but the maps were made from {}", told(found), told(made));
        Err(Failure::new(3, what).about(clip.path()).remedy("give a pass of the same frames"))
    }
}

/// The names of so many maps.
pub(crate) fn files(name: &Path, frames: u32) -> Result<Vec<PathBuf>, Failure> {
    let sequence = ClipName::parse(name).filter(|_| Format::of_name(name) == Some(Format::Exr));
    let files = sequence.and_then(|sequence| (1..=frames).map(|number| sequence.file(number)).collect());
    let no_maps = || Failure::new(2, "is no name of EXR files, one a frame").about(name).remedy("write maps.####.exr");
    files.ok_or_else(no_maps)
}

/// Adds the maps of a clip, whose frames come from these files.
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

/// By frame, the map of a picture whose sources are the frames of the clip.
pub(crate) fn each(map: &SourceMap<3>) -> Result<impl Iterator<Item = Result<SourceMap<2>, Failure>>, Failure> {
    let table = by_frames(&map.table)?;
    let Domain { shape: [_, height, width], periodic: [_, y, x] } = map.domain();
    let (domain, pixels) = (Domain { shape: [height, width], periodic: [y, x] }, height as usize * width as usize);
    let frame = move |ids: &[SampleId]| Ok(SourceMap::new(Grid::from_vec(domain, 1, ids.to_vec())?, table.clone())?);
    Ok(map.ids.plane(0).chunks(pixels.max(1)).map(frame))
}

/// Each frame of one clip as a source of its own. Samples keep their numbers: they are numbered frame by frame.
fn by_frames(table: &SourceTable<3>) -> Result<SourceTable<2>, Failure> {
    let frames = table.sources().iter().flat_map(|(_, clip)| {
        let [count, height, width] = clip.shape;
        (0..count).map(move |_| Domain::open([height, width]))
    });
    let source = |(frame, domain)| (Origin { exemplar: frame, transform: Transform::IDENTITY }, domain);
    Ok(SourceTable::new((0..=u16::MAX).zip(frames).map(source).collect())?)
}

/// The clip whose frames are the sources of a map; `None` for sources that are no frames of one. Samples keep their
/// numbers: they are numbered frame by frame.
fn of_clip(table: &SourceTable<2>) -> Option<SourceTable<3>> {
    let first = table.sources().first()?.1;
    let is_frame = |(number, (origin, domain)): (usize, &(Origin, Domain<2>))| {
        usize::from(origin.exemplar) == number && origin.transform == Transform::IDENTITY && *domain == first
    };
    if !table.sources().iter().enumerate().all(is_frame) {
        return None;
    }
    let clip = Domain::open([table.sources().len() as u32, first.shape[0], first.shape[1]]);
    SourceTable::new(vec![(Origin { exemplar: 0, transform: Transform::IDENTITY }, clip)]).ok()
}
