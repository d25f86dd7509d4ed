//! What the output starts from: an earlier map, a picture, and what of them must stay.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Domain, Error, Grid, SourceMap, SourceTable, Transform};
use selvedge_io::{Fingerprint, MapFile, MaskChannel};

use crate::exemplars::{Backdrop, Loaded};
use crate::failure::{Failure, shown};
use crate::inputs::{Input, ReadMap};
use crate::loom::Loom;
use crate::session::Session;

/// Options about what is there before the first patch.
#[derive(Args, Clone, Debug)]
pub(super) struct StartArgs {
    /// Go on from a source map of the same exemplars: its holes are filled, its seams made better.
    #[arg(long, value_name = "MAP.exr", value_hint = ValueHint::FilePath)]
    start: Option<PathBuf>,
    /// Go on from a picture: its samples stand where they are, and patches are woven in where it is transparent, or where
    /// --fixed is black.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    over: Option<PathBuf>,
    /// Where this picture is white, what --start or --over has there stays to the bit. Where it is black, the samples of
    /// --start may become better ones, and those of --over are holes to fill.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    fixed: Option<PathBuf>,
}

/// The same, with the map read.
pub(super) struct Begun<'a> {
    args: &'a StartArgs,
    map: Option<ReadMap>,
}

impl StartArgs {
    /// Reads the map.
    pub(super) fn begin(&self, session: &Session<'_>) -> Result<Begun<'_>, Failure> {
        if self.fixed.is_some() && self.start.is_none() && self.over.is_none() {
            return Err(Failure::new(2, "--fixed has nothing to fix").remedy("give --start or --over as well"));
        }
        let read = |path: &PathBuf| Input::new(session, path)?.read_map(session);
        Ok(Begun { args: self, map: self.start.as_ref().map(read).transpose()? })
    }

    /// The picture as an exemplar: only what stays of it is seen.
    pub(super) fn backdrop(&self) -> Option<Backdrop<'_>> {
        Some(Backdrop { picture: self.over.as_deref()?, mask: self.fixed.as_deref() })
    }

    /// Files that are read.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        [&self.start, &self.over, &self.fixed].into_iter().flatten().cloned().collect()
    }
}

impl Begun<'_> {
    /// The output's domain: that of the map or the picture, if the size `typed` agrees. `wanted` is what would be made
    /// without either.
    pub(super) fn domain(
        &self,
        exemplars: &[Domain<2>],
        typed: Option<[u32; 2]>,
        wanted: Domain<2>,
    ) -> Result<Domain<2>, Failure> {
        let mut output = wanted;
        if let Some((path, map)) = self.args.start.as_ref().zip(self.map.as_ref()) {
            let of_map = map.file.map.domain();
            output = Domain { shape: of_map.shape, ..output };
            (0..2).for_each(|axis| output.periodic[axis] |= of_map.periodic[axis]);
            check_size(path, of_map.shape, typed, "--size asks for", "leave --size out")?;
        }
        if let Some((path, domain)) = self.args.over.as_ref().zip(exemplars.last()) {
            let started = self.map.is_some().then_some(output.shape);
            check_size(path, domain.shape, started, "the map of --start has", "give a picture of that size")?;
            check_size(path, domain.shape, typed, "--size asks for", "leave --size out")?;
            output.shape = domain.shape;
        }
        Ok(output)
    }

    /// What stands, and what of it stays.
    pub(super) fn stand(&self, loom: &mut Loom<'_>) -> Result<(SourceMap<2>, Option<Grid<bool, 2>>), Failure> {
        let mut map = match self.args.start.as_ref().zip(self.map.as_ref()) {
            Some((path, read)) => {
                loom.note(read);
                rebased(&read.file, &loom.loaded).map_err(|e| e.about(path))?
            }
            None => SourceMap::unassigned(&loom.loaded.exemplars, loom.domain)?,
        };
        map.ids = map.ids.with_periodic(loom.domain.periodic);
        if self.args.over.is_some() {
            map.lay_under(&loom.loaded.exemplars, loom.loaded.exemplars.sources().len() - 1)?;
        }
        let Some(path) = &self.args.fixed else { return Ok((map, None)) };
        let fixed = match loom.loaded.masks.last_mut().filter(|_| self.args.over.is_some()) {
            Some(mask) => mask.take(),
            None => Some(mask(loom, path)?),
        };
        Ok((map, fixed))
    }
}

fn check_size(path: &Path, [h, w]: [u32; 2], other: Option<[u32; 2]>, of: &str, remedy: &str) -> Result<(), Failure> {
    match other {
        Some([eh, ew]) if [eh, ew] != [h, w] => {
            let what = format!("{w}x{h} px, but {of} {ew}x{eh} px");
            Err(Failure::new(3, what).about(path).remedy(remedy))
        }
        _ => Ok(()),
    }
}

fn mask(loom: &mut Loom<'_>, path: &Path) -> Result<Grid<bool, 2>, Failure> {
    let plane = loom.read(&Input::new(loom.session, path)?)?;
    check_size(path, plane.domain().shape, Some(loom.domain.shape), "the output has", "give a mask of that size")?;
    selvedge_io::mask(&plane, MaskChannel::Light).map_err(|p| Failure::from_problem(path, p))
}

/// A map by the numbers that its samples have in this run; what is masked now is a hole.
fn rebased(file: &MapFile, loaded: &Loaded) -> Result<SourceMap<2>, Failure> {
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
