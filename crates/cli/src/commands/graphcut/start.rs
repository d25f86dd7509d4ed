//! What the output starts from: an earlier map, a picture, and what of them must stay.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Domain, Grid, SampleId, SourceMap};
use selvedge_io::MaskChannel;

use crate::backdrop::{Backdrop, eroded};
use crate::failure::Failure;
use crate::inputs::{Input, ReadMap};
use crate::loom::Loom;
use crate::session::Session;
use crate::starting::{check_size, rebased};

/// Options about what is there before the first patch.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "What is there before")]
pub(crate) struct StartArgs {
    /// Go on from a source map of the same exemplars: its holes are filled, its seams made better.
    #[arg(long, value_name = "MAP.exr", value_hint = ValueHint::FilePath)]
    start: Option<PathBuf>,
    /// Go on from a picture: its samples stay to the bit where they are, and patches are woven in where it is transparent,
    /// or where --fixed is black. An exemplar that is the same picture without holes gives nothing from their places.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    over: Option<PathBuf>,
    /// Where this picture is white, what --start or --over has there stays to the bit. Where it is black, the samples of
    /// --start may become better ones, and those of --over are holes to fill.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    fixed: Option<PathBuf>,
    /// Let patches cut into a band of so many pixels around the holes of --over, for seams that show less.
    #[arg(long, value_name = "N", default_value_t = 0)]
    blend_in: u32,
}

/// The same, with the map read.
pub(crate) struct Begun<'a> {
    args: &'a StartArgs,
    map: Option<ReadMap>,
}

impl StartArgs {
    /// Reads the map.
    pub(crate) fn begin(&self, session: &Session<'_>) -> Result<Begun<'_>, Failure> {
        if self.fixed.is_some() && self.start.is_none() && self.over.is_none() {
            return Err(Failure::new(2, "--fixed has nothing to fix").remedy("give --start or --over as well"));
        }
        if self.blend_in != 0 && self.over.is_none() {
            let failure = Failure::new(2, "--blend-in widens the holes of --over, and there is no --over");
            return Err(failure.remedy("leave it out, or give --over"));
        }
        let read = |path: &PathBuf| Input::new(session, path)?.read_map(session);
        Ok(Begun { args: self, map: self.start.as_ref().map(read).transpose()? })
    }

    /// The picture as an exemplar: only what stays of it is seen.
    pub(crate) fn backdrop(&self) -> Option<Backdrop<'_>> {
        Some(Backdrop { picture: self.over.as_deref()?, mask: self.fixed.as_deref() })
    }

    /// True if a band around holes may be cut again.
    pub(crate) fn is_blended_in(&self) -> bool {
        self.blend_in != 0
    }

    /// Files that are read.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        [&self.start, &self.over, &self.fixed].into_iter().flatten().cloned().collect()
    }
}

impl Begun<'_> {
    /// The output's domain: that of the map or the picture, if the size `typed` agrees. `wanted` is what would be made
    /// without either.
    pub(crate) fn domain(
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
    pub(crate) fn stand(&self, loom: &mut Loom<'_>) -> Result<(SourceMap<2>, Option<Grid<bool, 2>>), Failure> {
        let mut map = match self.args.start.as_ref().zip(self.map.as_ref()) {
            Some((path, read)) => {
                loom.note(read);
                rebased(&read.file, &loom.loaded).map_err(|e| e.about(path))?
            }
            None => SourceMap::unassigned(&loom.loaded.exemplars, loom.domain)?,
        };
        map.ids = map.ids.with_periodic(loom.domain.periodic);
        if self.args.over.is_none() {
            let fixed = self.args.fixed.as_ref().map(|path| mask(loom, path)).transpose()?;
            return Ok((map, fixed));
        }
        let exemplars = &loom.loaded.exemplars;
        let picture = exemplars.sources().len() - 1;
        map.lay_under(exemplars, picture)?;
        // What is white in --fixed stays whichever of the two it shows, and of the picture all that stands.
        let white = loom.loaded.masks.last().and_then(Option::as_ref);
        let stays = |(i, id): (usize, &SampleId)| {
            exemplars.table().source(*id).is_some_and(|s| s == picture || white.is_some_and(|white| white.samples()[i]))
        };
        let stays = map.ids.samples().iter().enumerate().map(stays).collect();
        let stays = Grid::from_vec(map.domain(), 1, stays)?;
        Ok((map, Some(eroded(&stays, self.args.blend_in)?)))
    }
}

fn mask(loom: &mut Loom<'_>, path: &Path) -> Result<Grid<bool, 2>, Failure> {
    let plane = loom.read(&Input::new(loom.session, path)?)?;
    check_size(path, plane.domain().shape, Some(loom.domain.shape), "the output has", "give a mask of that size")?;
    selvedge_io::mask(&plane, MaskChannel::Light).map_err(|p| Failure::from_problem(path, p))
}
