//! What commands that go on from an earlier map share: sizes that must agree, and samples by their numbers in this run.

use std::path::Path;

use selvedge_core::{Error, SourceMap, SourceTable, Transform};
use selvedge_io::{Fingerprint, MapFile};

use crate::exemplars::Loaded;
use crate::failure::{Failure, shown};

/// A file has the size that something else asks for, if it does.
pub(crate) fn check_size(
    path: &Path,
    [h, w]: [u32; 2],
    other: Option<[u32; 2]>,
    of: &str,
    remedy: &str,
) -> Result<(), Failure> {
    match other {
        Some([eh, ew]) if [eh, ew] != [h, w] => {
            let what = format!("{w}x{h} px, but {of} {ew}x{eh} px");
            Err(Failure::new(3, what).about(path).remedy(remedy))
        }
        _ => Ok(()),
    }
}

/// A map by the numbers that its samples have in this run; what is masked now is a hole.
pub(crate) fn rebased(file: &MapFile, loaded: &Loaded) -> Result<SourceMap<2>, Failure> {
    let table = loaded.exemplars.table();
    let found: Vec<Option<usize>> = (0..file.map.table.sources().len()).map(|s| find(table, file, s, loaded)).collect();
    file.map.rebased(&loaded.exemplars, &found).map_err(|error| match error {
        Error::MissingSource { number } => missing(file, number, loaded),
        other => other.into(),
    })
}

/// The run's source that is the same as one of a map: of an exemplar with the same content, made in the same way. If an
/// exemplar is given twice, that of the same number.
fn find(table: &SourceTable<2>, file: &MapFile, source: usize, loaded: &Loaded) -> Option<usize> {
    let (origin, domain) = file.map.table.sources()[source];
    let made_of = &file.exemplars[usize::from(origin.exemplar)];
    let same = |s: &usize| {
        let (o, d) = table.sources()[*s];
        let content = &loaded.fingerprints[usize::from(o.exemplar)].blake3;
        (o.transform, d.shape) == (origin.transform, domain.shape) && *content == made_of.blake3
    };
    let of_same_number = |s: &usize| table.sources()[*s].0.exemplar == origin.exemplar;
    let all: Vec<usize> = (0..table.sources().len()).filter(same).collect();
    all.iter().copied().find(of_same_number).or(all.first().copied())
}

/// Says which exemplar, or which way to turn it, a map was made with and this run has not.
fn missing(file: &MapFile, source: usize, loaded: &Loaded) -> Failure {
    let (origin, _) = file.map.table.sources()[source];
    let Fingerprint { name, blake3 } = &file.exemplars[usize::from(origin.exemplar)];
    if loaded.fingerprints.iter().all(|f| f.blake3 != *blake3) {
        let given: Vec<String> = loaded.paths.iter().map(|path| shown(path)).collect();
        let what = format!("was made from '{name}', whose content is none of {}", given.join(", "));
        return Failure::new(3, what).remedy("give the exemplars (and --over) that it was made from");
    }
    let (how, remedy) = match origin.transform {
        Transform::Exact { quarter_turns, mirror } => {
            let how = format!(
                "turned by {} degrees{}",
                90 * u32::from(quarter_turns),
                if mirror { ", mirrored" } else { "" }
            );
            (how, "add --turn or --mirror, as it was made with".to_owned())
        }
        Transform::Resampled { degrees, scale, mirror } => {
            let how =
                format!("turned by {degrees} degrees, scaled by {scale}{}", if mirror { ", mirrored" } else { "" });
            (how, "add --rotate, --scale or --scale-field, as it was made with".to_owned())
        }
        other => (format!("as {other:?}"), "use the options that it was made with".to_owned()),
    };
    Failure::new(3, format!("has samples of '{name}' {how}, and this run has not")).remedy(remedy)
}
