//! Source maps of clips: one a frame, of which the sources are the frames of the clip.

use std::path::{Path, PathBuf};

use selvedge_core::{Domain, Grid, Origin, SourceMap, SourceTable, Transform};
use selvedge_io::clip::ClipName;
use selvedge_io::{Fingerprint, Format, MapFile, Metadata};

use crate::failure::Failure;
use crate::outputs::Outputs;

/// The names of so many maps.
pub(super) fn files(name: &Path, frames: u32) -> Result<Vec<PathBuf>, Failure> {
    let sequence = ClipName::parse(name).filter(|_| Format::of_name(name) == Some(Format::Exr));
    let files = sequence.and_then(|sequence| (1..=frames).map(|number| sequence.file(number)).collect());
    let no_maps = || Failure::new(2, "is no name of EXR files, one a frame").about(name).remedy("write maps.####.exr");
    files.ok_or_else(no_maps)
}

/// Adds the maps of a clip, whose frames come from these files.
pub(super) fn add(
    outputs: &mut Outputs,
    name: &Path,
    map: &SourceMap<3>,
    (frames, metadata): (&[Fingerprint], &Metadata),
) -> Result<(), Failure> {
    let table = by_frames(&map.table)?;
    let Domain { shape: [count, height, width], periodic: [_, y, x] } = map.domain();
    let (domain, pixels) = (Domain { shape: [height, width], periodic: [y, x] }, height as usize * width as usize);
    for (path, ids) in files(name, count)?.iter().zip(map.ids.plane(0).chunks(pixels.max(1))) {
        let map = SourceMap::new(Grid::from_vec(domain, 1, ids.to_vec())?, table.clone())?;
        let file = MapFile::new(map, frames.to_vec(), metadata.clone());
        outputs.map(path, &file)?;
    }
    Ok(())
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
