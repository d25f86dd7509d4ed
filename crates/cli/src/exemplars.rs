//! Exemplars from files: looked at, read, masked, and made alike.

use std::path::{Path, PathBuf};

use clap::Args;
use selvedge_core::{Bytes, Depth, Domain, Encoder, Exemplar, Exemplars, Grid, Plane, Role, Transform};
use selvedge_io::{Fingerprint, Format, Info, Metadata, ReadOptions};
use serde_json::Value;

use crate::backdrop::{Backdrop, spare_holes};
use crate::failure::{Failure, n};
use crate::harmonise::{
    Layout, alike, associated, common_association, common_depth, common_layout, converted, is_integer, widened,
};
use crate::inputs::{self, Input};
use crate::light::LightArgs;
use crate::loaded::ExemplarSet;
use crate::options::{Conversion, NonFinite};
use crate::outputs;
use crate::planes::check_size;
use crate::report::Report;
use crate::roles;
use crate::session::Session;
use crate::used::Used;

/// The mask of an exemplar that has none.
pub(crate) const NO_MASK: &str = "none";

/// Options of the commands that take exemplars.
#[derive(Args, Clone, Debug)]
pub(crate) struct ExemplarArgs {
    /// Pictures of the texture.
    #[arg(help = "Pictures of the texture; '-' is standard input, 'a.exr[R,G,B]' chooses channels or a layer")]
    #[arg(required = true, value_name = "EXEMPLAR", value_hint = clap::ValueHint::FilePath)]
    pub(crate) exemplars: Vec<PathBuf>,
    /// Use an exemplar only where this picture is white. Give one for each exemplar, in order, or 'none'.
    #[arg(long, value_name = "MASK", value_hint = clap::ValueHint::FilePath)]
    pub(crate) mask: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) conversion: Conversion,
    #[command(flatten)]
    pub(crate) nonfinite: NonFinite,
    #[command(flatten)]
    pub(crate) light: LightArgs,
    /// The mask of the first exemplar is white where it has holes.
    #[arg(skip)]
    pub(crate) holes: bool,
}

/// Exemplars of which the headers were read.
pub(crate) struct Headers {
    pub(crate) inputs: Vec<Input>,
    /// One each.
    masks: Vec<Option<Input>>,
    matched: Vec<Matched>,
    /// How many were given as exemplars.
    given: usize,
    /// Whether the first mask is white where its exemplar has holes.
    holes: bool,
    options: ReadOptions,
    light: LightArgs,
    pub(crate) infos: Vec<Info>,
    /// Of the masks that there are.
    pub(crate) mask_infos: Vec<Info>,
    /// Whether the depth was typed.
    converts: bool,
    /// Stops by which floats that become integers are brighter.
    exposure: f64,
    /// Depth of what is rendered from them.
    pub(crate) depth: Depth,
    /// Channels of what is rendered from them.
    pub(crate) layout: Layout,
}

/// A plane of every exemplar that decides with it.
struct Matched {
    inputs: Vec<Input>,
    infos: Vec<Info>,
    role: Role,
    layout: Layout,
    weight: f64,
}

impl ExemplarArgs {
    /// Options as used, without those of these that do nothing in this run.
    pub(crate) fn used_if_any(&self, used: Used) -> Used {
        let used = used.unless("exposure", 0.0).unless("ignore-light", Value::Null).unless("flatten", Value::Null);
        // It acts on odd pictures alone.
        used.set("nonfinite", self.nonfinite.typed())
    }

    /// Of the commands that take one picture.
    pub(crate) fn check_one_mask(&self) -> Result<(), Failure> {
        match self.mask.len() {
            0 | 1 => Ok(()),
            masks => Err(Failure::new(2, format!("{masks} masks for one picture")).remedy("give one --mask")),
        }
    }

    /// All files that are read.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        self.exemplars.iter().chain(self.mask.iter().filter(|mask| mask.as_os_str() != NO_MASK)).cloned().collect()
    }

    /// Checks what can be checked without a file.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        let (masks, exemplars) = (self.mask.len(), self.exemplars.len());
        if masks == 0 || masks == exemplars {
            return Ok(());
        }
        let what = format!("{} for {}", n("mask", masks), n("exemplar", exemplars));
        Err(Failure::new(2, what).remedy("give one --mask for each exemplar, or '--mask none'"))
    }

    /// Reads headers: how large the exemplars are, and what their samples become.
    pub(crate) fn look(&self, session: &Session<'_>, backdrop: Option<Backdrop<'_>>) -> Result<Headers, Failure> {
        self.validate()?;
        let options = inputs::options(session.limits, Role::Color, self.nonfinite);
        let open = |path: &Path| Input::new(session, path);
        let paths = self.exemplars.iter().map(PathBuf::as_path).chain(backdrop.map(|b| b.picture));
        let inputs = paths.map(open).collect::<Result<Vec<_>, _>>()?;
        let masks = self.mask.iter().map(|path| Some(path.as_path()).filter(|path| path.as_os_str() != NO_MASK));
        let given = self.exemplars.len();
        let masks = masks.chain(std::iter::repeat(None)).take(given).chain(backdrop.map(|b| b.mask));
        let masks = masks.map(|mask| mask.map(open).transpose()).collect::<Result<Vec<_>, _>>()?;
        let infos = inputs.iter().map(|input| input.probe(&options)).collect::<Result<Vec<_>, _>>()?;
        let of_each = || inputs.iter().map(|input| input.path.as_path()).zip(&infos);
        let mut mask_infos = Vec::new();
        for (mask, (path, info)) in masks.iter().zip(of_each()) {
            let Some(mask) = mask else { continue };
            let found = mask.probe(&options)?;
            check_mask(&mask.path, [found.width, found.height], path, [info.width, info.height])?;
            mask_infos.push(found);
        }
        let depth = match self.conversion.depth() {
            Some(depth) => depth,
            None => common_depth(of_each().map(|(path, info)| (path, info.depth)))?,
        };
        let layout = common_layout(of_each().map(|(path, info)| (path, Layout::of(info))))?;
        let (converts, exposure) = (self.conversion.depth().is_some(), self.conversion.exposure);
        if exposure != 0.0 && (!is_integer(depth) || infos.iter().all(|info| is_integer(info.depth))) {
            let what = "--exposure is for floats that become integers, and none do";
            return Err(
                Failure::new(2, what).remedy("give --depth u8 or u16 and an exemplar of floats, or leave it out")
            );
        }
        let (light, matched, holes) = (self.light, Vec::new(), self.holes);
        Ok(Headers {
            given,
            holes,
            options,
            light,
            converts,
            exposure,
            depth,
            layout,
            infos,
            mask_infos,
            masks,
            matched,
            inputs,
        })
    }
}

impl Headers {
    /// With planes that decide beside the exemplars, one for each of them, and their weights.
    pub(crate) fn matching(
        mut self,
        session: &Session<'_>,
        planes: &[PathBuf],
        weights: &[f64],
    ) -> Result<Self, Failure> {
        let exemplars = self.inputs.len();
        if !planes.len().is_multiple_of(exemplars) {
            let what = format!("{} of --match for {}", n("plane", planes.len()), n("exemplar", exemplars));
            return Err(Failure::new(2, what).remedy("give one for each, and for the picture of --over"));
        }
        for (paths, &weight) in planes.chunks(exemplars).zip(weights).filter(|(_, weight)| **weight != 0.0) {
            let inputs = paths.iter().map(|path| Input::new(session, path)).collect::<Result<Vec<_>, _>>()?;
            let infos = inputs.iter().map(|input| input.probe(&self.options)).collect::<Result<Vec<_>, _>>()?;
            for ((path, info), (exemplar, of)) in paths.iter().zip(&infos).zip(self.inputs.iter().zip(&self.infos)) {
                check_size(path, info, &exemplar.path, [of.height, of.width])?;
            }
            let layout = common_layout(paths.iter().map(PathBuf::as_path).zip(infos.iter().map(Layout::of)))?;
            let role = roles::of_names(paths);
            let role = if role.is_normal() && layout.colors < 3 { Role::Scalar } else { role };
            self.matched.push(Matched { inputs, infos, role, layout, weight });
        }
        Ok(self)
    }

    /// Channels of the features.
    pub(crate) fn channels(&self) -> usize {
        self.layout.colors + self.matched.iter().map(|matched| matched.layout.colors).sum::<usize>()
    }

    /// Headers of planes that decide beside the exemplars.
    pub(crate) fn matched_infos(&self) -> impl Iterator<Item = &Info> {
        self.matched.iter().flat_map(|matched| &matched.infos)
    }

    /// What making them even takes beside them.
    pub(crate) fn light_bytes(&self, sources: &[Domain<2>]) -> Bytes {
        self.light.memory(&self.infos, sources, self.channels())
    }

    /// Names of the exemplars.
    pub(crate) fn paths(&self) -> Vec<&Path> {
        self.inputs.iter().map(|input| input.path.as_path()).collect()
    }

    /// Domain of each exemplar.
    pub(crate) fn domains(&self) -> Vec<Domain<2>> {
        self.infos.iter().map(|info| Domain::open([info.height, info.width])).collect()
    }

    /// Refuses, before any work, an output (`opaque`: without transparency) that its format does not hold, by exemplar.
    pub(crate) fn check_held(&self, output: (&Path, Format), shape: [u32; 2], opaque: bool) -> Result<(), Failure> {
        let of = |layout: Layout| Layout { alpha: layout.alpha && !opaque, ..layout };
        for (Input { path, .. }, info) in self.inputs.iter().zip(&self.infos) {
            let depth = if self.converts { self.depth } else { info.depth };
            outputs::check_held(output, shape, (of(Layout::of(info)), depth), Some(path))?;
        }
        outputs::check_held(output, shape, (of(self.layout), self.depth), None)
    }

    /// The domain of each source.
    pub(crate) fn sources(&self, transforms: &[Transform]) -> Vec<Domain<2>> {
        self.each_source(transforms).map(|(transform, domain)| transform.domain(domain)).collect()
    }

    /// How each source is shown, and its domain.
    pub(crate) fn shown(&self, transforms: &[Transform]) -> Vec<(Transform, Domain<2>)> {
        self.each_source(transforms).map(|(transform, domain)| (transform, transform.domain(domain))).collect()
    }

    /// How each source is made, and of what.
    fn each_source(&self, transforms: &[Transform]) -> impl Iterator<Item = (Transform, Domain<2>)> {
        let of = |(i, domain): (usize, Domain<2>)| {
            self.transforms(i, transforms).iter().map(|t| (*t, domain)).collect::<Vec<_>>()
        };
        self.domains().into_iter().enumerate().flat_map(of)
    }

    /// The backdrop is not turned.
    fn transforms<'t>(&self, exemplar: usize, transforms: &'t [Transform]) -> &'t [Transform] {
        if exemplar < self.given { transforms } else { &[Transform::IDENTITY] }
    }

    /// Reads the pictures, and turns each of them in every way that is asked for.
    pub(crate) fn load(
        self,
        session: &Session<'_>,
        transforms: &[Transform],
        report: &mut Report,
    ) -> Result<ExemplarSet, Failure> {
        let (mut planes, mut fingerprints, mut metadata) = (Vec::new(), Vec::new(), Vec::<Metadata>::new());
        let association = common_association(self.infos.iter().map(|info| (info.alpha, info.association)));
        for input in &self.inputs {
            let picture = input.read(session, &self.options, report)?;
            fingerprints.push(inputs::fingerprint(&input.path, &picture));
            metadata.push(picture.metadata);
            let plane = widened(picture.plane, self.layout)?;
            planes.push(associated(session, &input.path, plane, association)?);
        }
        inputs::tell_tags(session, &self.inputs[0].path, &metadata, "exemplar");
        let (mut masks, mut other_fingerprints) = self.read_masks(session, report)?;
        let paths: Vec<PathBuf> = self.inputs.iter().map(|input| input.path.clone()).collect();
        if self.given < planes.len() {
            spare_holes(session, &paths, &planes, &mut masks)?;
        }
        self.light.flatten(&mut planes[..self.given])?;
        let transforms: Vec<&[Transform]> = (0..planes.len()).map(|i| self.transforms(i, transforms)).collect();
        let matched = self.read_matched(session, report, &mut other_fingerprints)?;
        let weights: Vec<f64> = std::iter::once(1.0).chain(self.matched.iter().map(|matched| matched.weight)).collect();
        let encoded = encoded(&planes, matched, &weights, &masks, &transforms);
        let (encoder, exemplars) = encoded.map_err(|e| named(&paths, e, self.holes))?;
        let exemplars = self.light.ignore(exemplars)?;
        let depths: Vec<Depth> = planes.iter().map(|plane| plane.samples.depth()).collect();
        let payload = paths.iter().zip(planes).zip(&metadata);
        let payload =
            payload.map(|((path, plane), tags)| converted(session, path, plane, self.depth, (tags, self.exposure)));
        let payload = alike(session, &paths, payload.collect::<Result<_, _>>()?)?;
        let first = metadata.swap_remove(0).converted(depths[0], self.depth);
        Ok(ExemplarSet {
            exemplars,
            encoder,
            payload,
            paths,
            fingerprints,
            masks,
            other_fingerprints,
            given: self.given,
            metadata: first,
        })
    }

    /// By exemplar, the planes that decide with it.
    fn read_matched(
        &self,
        session: &Session<'_>,
        report: &mut Report,
        fingerprints: &mut Vec<Fingerprint>,
    ) -> Result<Vec<Vec<Plane<2>>>, Failure> {
        let mut planes: Vec<Vec<Plane<2>>> = self.inputs.iter().map(|_| Vec::new()).collect();
        for matched in &self.matched {
            let options = ReadOptions { role: matched.role, ..self.options.clone() };
            for (input, planes) in matched.inputs.iter().zip(&mut planes) {
                let picture = input.read(session, &options, report)?;
                fingerprints.push(inputs::fingerprint(&input.path, &picture));
                planes.push(widened(picture.plane, matched.layout)?);
            }
        }
        Ok(planes)
    }

    #[expect(clippy::type_complexity, reason = "one mask an exemplar, and what they are")]
    fn read_masks(
        &self,
        session: &Session<'_>,
        report: &mut Report,
    ) -> Result<(Vec<Option<Grid<bool, 2>>>, Vec<Fingerprint>), Failure> {
        let (mut masks, mut fingerprints) = (Vec::new(), Vec::new());
        for input in &self.masks {
            let Some(input) = input else {
                masks.push(None);
                continue;
            };
            let picture = input.read(session, &self.options, report)?;
            let mut mask = inputs::white(&picture.plane, &input.path)?;
            if self.holes && masks.is_empty() {
                mask.samples_mut().iter_mut().for_each(|white| *white = !*white);
            }
            masks.push(Some(mask));
            fingerprints.push(inputs::fingerprint(&input.path, &picture));
        }
        Ok((masks, fingerprints))
    }
}

/// Refuses a mask of another size, by width and height.
fn check_mask(path: &Path, [w, h]: [u32; 2], exemplar: &Path, [ew, eh]: [u32; 2]) -> Result<(), Failure> {
    if [h, w] == [eh, ew] {
        return Ok(());
    }
    let what = format!("{w}x{h} px, but its exemplar '{}' has {ew}x{eh} px", crate::failure::shown(exemplar));
    Err(Failure::new(3, what).about(path).remedy("give a mask of the same size"))
}

/// Features of exemplars and of the planes that decide with them, which have their `weights`, that of the exemplar
/// first.
fn encoded(
    planes: &[Plane<2>],
    matched: Vec<Vec<Plane<2>>>,
    weights: &[f64],
    masks: &[Option<Grid<bool, 2>>],
    transforms: &[&[Transform]],
) -> Result<(Encoder, Exemplars<2>), selvedge_core::Error> {
    let alone = matched.iter().all(Vec::is_empty);
    let both = |(plane, matched): (&Plane<2>, Vec<Plane<2>>)| std::iter::once(plane.clone()).chain(matched).collect();
    let joined: Vec<Vec<Plane<2>>> = if alone { Vec::new() } else { planes.iter().zip(matched).map(both).collect() };
    let each: Vec<&[Plane<2>]> = if alone {
        planes.iter().map(std::slice::from_ref).collect()
    } else {
        joined.iter().map(Vec::as_slice).collect()
    };
    let exemplar = |i: usize| Exemplar::new(each[i]).masked(masks[i].as_ref()).shown(transforms[i]);
    let exemplars: Vec<Exemplar<'_, 2>> = (0..each.len()).map(exemplar).collect();
    let encoder = Encoder::fit(&each)?.with_plane_weights(weights)?;
    let exemplars = Exemplars::new(&encoder, &exemplars)?;
    Ok((encoder, exemplars))
}

/// An error of the core about an exemplar, with the name of its file.
fn named(paths: &[PathBuf], error: selvedge_core::Error, holes: bool) -> Failure {
    use selvedge_core::Error;
    let exemplar = match &error {
        Error::NotFinite { exemplar, .. }
        | Error::Shape { exemplar, .. }
        | Error::MaskShape { exemplar, .. }
        | Error::Layout { exemplar, .. } => Some(*exemplar),
        _ if paths.len() == 1 => Some(0),
        _ => None,
    };
    let failure = match error {
        Error::NothingValid if holes => Failure::new(3, "all of it is to be filled: nothing is left to fill it from")
            .remedy("make less of the mask white, or give other pictures with --from"),
        Error::NothingValid => Failure::new(3, "no sample can be used: all are masked or transparent")
            .remedy("give a picture, or a mask, with something in it"),
        other => Failure::from(other),
    };
    match exemplar.and_then(|e| paths.get(e)) {
        Some(path) => failure.about(path),
        None => failure,
    }
}
