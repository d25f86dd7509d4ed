//! What an output goes on from: an earlier map, a picture, and what of them must stay.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Error, Grid, Role, SampleId, SourceMap, SourceTable, Start, Transform};
use selvedge_io::{Fingerprint, MapFile};

use crate::args::NonFiniteArg;
use crate::backdrop::{Backdrop, eroded};
use crate::failure::{Failure, shown};
use crate::inputs::{self, Input, ReadMap, white};
use crate::loaded::ExemplarSet;
use crate::loom::{Before, Loom};
use crate::report::Report;
use crate::session::Session;
use crate::weaving::{Sizing, Weaving};

/// Options about what is there before the first patch.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct StartArgs {
    /// Go on from a source map of the same exemplars: its holes are filled, its seams made better.
    #[arg(help_heading = "What is there before", long, value_name = "MAP.exr", value_hint = ValueHint::FilePath)]
    start: Option<PathBuf>,
    /// Go on from a picture: its samples stay to the bit where they are, and patches are woven in where it is
    /// transparent, or where --fixed is black. An exemplar that is the same picture without holes gives nothing from
    /// their places.
    #[arg(help_heading = "What is there before", long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    over: Option<PathBuf>,
    /// Where this picture is white, what --start or --over has there stays to the bit. Where it is black, the
    /// samples of --start may become better ones, and those of --over are holes to fill.
    #[arg(help_heading = "What is there before", long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    fixed: Option<PathBuf>,
    /// Let patches cut into a band of so many pixels around the holes of --over, for seams that show less.
    #[arg(help_heading = "What is there before", long, value_name = "N", default_value_t = 0)]
    blend_in: u32,
}

/// What an output goes on from, its map read.
pub(crate) struct Ground {
    args: StartArgs,
    map: Option<ReadMap>,
}

impl StartArgs {
    /// Nothing but a map, if there is one.
    pub(crate) fn of_map(start: Option<PathBuf>) -> Self {
        Self { start, ..Self::default() }
    }

    /// Reads the map.
    pub(crate) fn ground(&self, session: &Session<'_>) -> Result<Ground, Failure> {
        if self.fixed.is_some() && self.start.is_none() && self.over.is_none() {
            return Err(Failure::new(2, "--fixed has nothing to fix").remedy("give --start or --over as well"));
        }
        if self.blend_in != 0 && self.over.is_none() {
            let failure = Failure::new(2, "--blend-in widens the holes of --over, and there is no --over");
            return Err(failure.remedy("leave it out, or give --over"));
        }
        let read = |path: &PathBuf| Input::new(session, path)?.read_map(session);
        Ok(Ground { args: self.clone(), map: self.start.as_ref().map(read).transpose()? })
    }

    /// The picture as an exemplar: only what stays of it is seen.
    pub(crate) fn backdrop(&self) -> Option<Backdrop<'_>> {
        Some(Backdrop { picture: self.over.as_deref()?, mask: self.fixed.as_deref() })
    }

    /// Bytes of what says where the picture may be copied from.
    pub(crate) fn bytes(&self, output: Domain<2>) -> Bytes {
        if self.over.is_some() { Bytes::of_samples(output, 8) } else { Bytes(0) }
    }

    /// Files that are read.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        [&self.start, &self.over, &self.fixed].into_iter().flatten().cloned().collect()
    }
}

impl Ground {
    /// True if nothing is there before.
    pub(crate) fn is_bare(&self) -> bool {
        self.map.is_none() && self.args.over.is_none()
    }

    /// The map with its file's name.
    fn file(&self) -> Option<(&Path, &ReadMap)> {
        self.args.start.as_deref().zip(self.map.as_ref())
    }

    /// The output's topology: what is asked for, and that of the map.
    pub(crate) fn topology(&self, weaving: &Weaving) -> [bool; 2] {
        let asked = weaving.tiled([1, 1]).periodic;
        let of_map = self.map.as_ref().map_or([false; 2], |map| map.file.map.domain().periodic);
        [0, 1].map(|axis| asked[axis] || of_map[axis])
    }

    /// The output's domain where a picture that is followed decides its shape; map and picture must agree. Domains of
    /// the exemplars, the picture last.
    pub(crate) fn under(
        &self,
        exemplars: &[Domain<2>],
        followed: (&Path, [u32; 2]),
        weaving: &Weaving,
    ) -> Result<Domain<2>, Failure> {
        let of = format!("the output, as {} has it, is of", shown(followed.0));
        if let Some((path, map)) = self.file() {
            check_size(path, map.file.map.domain().shape, Some(followed.1), &of, "give a map of that size")?;
        }
        if let Some((path, domain)) = self.args.over.as_ref().zip(exemplars.last()) {
            check_size(path, domain.shape, Some(followed.1), &of, "give a picture of that size")?;
        }
        Ok(Domain { shape: followed.1, periodic: self.topology(weaving) })
    }

    /// The output's domain: that of the map or the picture, if the size that was typed agrees. Domains of the
    /// exemplars, the picture last.
    pub(crate) fn domain(
        &self,
        exemplars: &[Domain<2>],
        sizing: Sizing,
        weaving: &Weaving,
    ) -> Result<Domain<2>, Failure> {
        let first = exemplars[0].shape;
        let (typed, mut shape) = (sizing.typed(first), sizing.shape(first));
        if let Some((path, map)) = self.file() {
            shape = map.file.map.domain().shape;
            check_size(path, shape, typed, "--size asks for", "leave --size out")?;
        }
        if let Some((path, domain)) = self.args.over.as_ref().zip(exemplars.last()) {
            let started = self.map.is_some().then_some(shape);
            check_size(path, domain.shape, started, "the map of --start has", "give a picture of that size")?;
            check_size(path, domain.shape, typed, "--size asks for", "leave --size out")?;
            shape = domain.shape;
        }
        Ok(Domain { shape, periodic: self.topology(weaving) })
    }
}

impl Before for Ground {
    /// By the numbers that its samples have in this run.
    fn map(self: Box<Self>, loom: &mut Loom<'_>) -> Result<Option<SourceMap<2>>, Failure> {
        let Some((path, read)) = self.file() else { return Ok(None) };
        loom.note(read);
        let mut map = rebased(&read.file, &loom.loaded).map_err(|e| e.about(path))?;
        map.ids = map.ids.with_periodic(loom.domain.periodic);
        Ok(Some(map))
    }

    /// A picture stands where it is, and is copied from nowhere.
    fn start(self: Box<Self>, loom: &mut Loom<'_>) -> Result<Start<2>, Failure> {
        let args = self.args.clone();
        let map = self.map(loom)?;
        let exemplars = &loom.loaded.exemplars;
        let mut map = map.map_or_else(|| SourceMap::unassigned(exemplars, loom.domain), Ok)?;
        if args.over.is_none() {
            let fixed = args.fixed.as_ref().map(|path| mask(loom, path)).transpose()?;
            return Ok(Start { map, fixed, sources: None });
        }
        let picture = exemplars.sources().len() - 1;
        map.lay_under(exemplars, picture)?;
        // What is white in --fixed stays whichever of the two it shows, and of the picture all that stands.
        let white = loom.loaded.masks.last().and_then(Option::as_ref);
        let stays = |(i, id): (usize, &SampleId)| {
            exemplars.table().source(*id).is_some_and(|s| s == picture || white.is_some_and(|white| white.samples()[i]))
        };
        let stays = map.ids.samples().iter().enumerate().map(stays).collect();
        let stays = Grid::from_vec(map.domain(), 1, stays)?;
        let fixed = Some(eroded(&stays, args.blend_in)?);
        Ok(Start { map, fixed, sources: Some(Grid::try_filled(loom.domain, 1, (1 << picture) - 1)?) })
    }
}

/// What is white in a picture of the output's size.
pub(crate) fn mask(loom: &mut Loom<'_>, path: &Path) -> Result<Grid<bool, 2>, Failure> {
    let plane = loom.read(&Input::new(loom.session, path)?)?;
    check_size(path, plane.domain().shape, Some(loom.domain.shape), "the output has", "give a mask of that size")?;
    white(&plane, path)
}

/// What is white in a picture of the size that frames have, which another size is told by its header alone to miss.
pub(crate) fn frame_mask(
    session: &Session<'_>,
    path: &Path,
    (shape, of): ([u32; 2], &str),
    report: &mut Report,
) -> Result<(Grid<bool, 2>, Fingerprint), Failure> {
    let options = inputs::options(session.limits, Role::Scalar, NonFiniteArg::Error);
    let input = Input::new(session, path)?;
    let info = input.probe(&options)?;
    check_size(path, [info.height, info.width], Some(shape), of, "give a mask of that size")?;
    let picture = input.read(session, &options, report)?;
    Ok((white(&picture.plane, path)?, inputs::fingerprint(path, &picture)))
}

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
pub(crate) fn rebased(file: &MapFile, loaded: &ExemplarSet) -> Result<SourceMap<2>, Failure> {
    let table = loaded.exemplars.table();
    let found: Vec<Option<usize>> = (0..file.map.table.sources().len()).map(|s| find(table, file, s, loaded)).collect();
    file.map.rebased(&loaded.exemplars, &found).map_err(|error| match error {
        Error::MissingSource { number } => missing(file, number, loaded),
        other => other.into(),
    })
}

/// The run's source that is the same as one of a map: of an exemplar with the same content, made in the same way. If an
/// exemplar is given twice, that of the same number.
fn find(table: &SourceTable<2>, file: &MapFile, source: usize, loaded: &ExemplarSet) -> Option<usize> {
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

/// Says that a map has an exemplar whose content none of those that were given has.
pub(crate) fn made_of_another(name: &str, given: &[PathBuf]) -> Failure {
    let given: Vec<String> = given.iter().map(|path| shown(path)).collect();
    let what = format!("was made from '{name}', whose content is none of {}", given.join(", "));
    Failure::new(3, what).remedy("give the exemplars (and --over) that it was made from")
}

/// Says which exemplar, or which way to turn it, a map was made with and this run has not.
fn missing(file: &MapFile, source: usize, loaded: &ExemplarSet) -> Failure {
    let (origin, _) = file.map.table.sources()[source];
    let Fingerprint { name, blake3 } = &file.exemplars[usize::from(origin.exemplar)];
    if loaded.fingerprints.iter().all(|f| f.blake3 != *blake3) {
        return made_of_another(name, &loaded.paths);
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
