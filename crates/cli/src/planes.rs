//! Planes that a weave is laid over besides its exemplars, such as the other maps of a material: which go together,
//! what their channels mean, whether they fit, and how they are rendered. `apply` and `--with` are one.

use std::path::{Path, PathBuf};

use selvedge_core::{Bytes, Depth, Domain, Grid, Payload, Plane, Render, Role, Transform};
use selvedge_io::{Fingerprint, Format, Info, Metadata};

use crate::args::{NonFiniteArg, RoleArg, typed_name};
use crate::blending::Blending;
use crate::failure::{Failure, n as count, shown};
use crate::harmonise::{Layout, alike, common_depth, common_layout, converted, widened};
use crate::inputs::{self, Input};
use crate::report::Report;
use crate::roles;
use crate::session::Session;
use crate::{memory, names, outputs};

/// How planes are read and laid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Laying<'a> {
    /// What their channels mean, as typed: one for all, one for each, or none, and names tell.
    pub(crate) roles: &'a [RoleArg],
    pub(crate) depth: Option<Depth>,
    /// Stops by which floats that become integers are brighter.
    pub(crate) exposure: f64,
    pub(crate) format: Option<Format>,
    pub(crate) nonfinite: NonFiniteArg,
    pub(crate) blending: Blending,
    /// Whether heights are copied as all else is.
    pub(crate) copy: bool,
}

/// One output: a plane of every exemplar.
#[derive(Debug)]
pub(crate) struct Layer {
    pub(crate) planes: Vec<PathBuf>,
    /// What the channels of each mean.
    pub(crate) roles: Vec<Role>,
    pub(crate) output: PathBuf,
    pub(crate) format: Format,
    /// How seams are hidden.
    pub(crate) blending: Blending,
}

/// One output whose planes' headers were read.
pub(crate) struct PlaneHeaders {
    pub(crate) layer: Layer,
    inputs: Vec<Input>,
    infos: Vec<Info>,
    depth: Depth,
    layout: Layout,
    exposure: f64,
    nonfinite: NonFiniteArg,
}

/// One output whose planes were read.
pub(crate) struct Ready {
    pub(crate) layer: Layer,
    pub(crate) planes: Vec<Plane<2>>,
    /// By name and content.
    pub(crate) fingerprints: Vec<Fingerprint>,
    /// What the first plane says besides its samples.
    pub(crate) metadata: Metadata,
}

impl Laying<'_> {
    /// Which planes go together: so many for each output, which is named by `pattern`.
    pub(crate) fn layers(
        &self,
        session: &Session<'_>,
        planes: &[PathBuf],
        exemplars: usize,
        pattern: &Path,
    ) -> Result<Vec<Layer>, Failure> {
        let (roles, given) = (self.roles.len(), planes.len());
        if !matches!(roles, 0 | 1) && roles != given {
            let what = format!("{} for {}", count("role", roles), count("plane", given));
            return Err(Failure::new(2, what).remedy("give one --role, or one for each"));
        }
        let mut told = Vec::new();
        let layer = |(i, of_each): (usize, &[PathBuf])| {
            let output = names::of_plane(pattern, &of_each[0]);
            let format = outputs::format(&output, self.format, self.depth)?;
            let by_name = roles::of_names(of_each);
            let role = |e: usize| match self.roles {
                [] => by_name,
                [one] => (*one).into(),
                each => each[i * exemplars + e].into(),
            };
            let roles: Vec<Role> = (0..exemplars).map(role).collect();
            if let Some(other) = roles.iter().find(|role| **role != roles[0]) {
                let what = format!("planes of one output cannot be {} and {}", role_name(roles[0]), role_name(*other));
                return Err(Failure::new(2, what).about(&output).remedy("give them one --role"));
            }
            if self.roles.is_empty() && by_name != Role::Color {
                let names: Vec<String> = of_each.iter().map(|plane| selvedge_io::display_name(plane)).collect();
                told.push(format!("'{}' {}", names.join("', '"), role_name(by_name)));
            }
            // Heights copied side by side are steps, which no light hides.
            let heights = roles.iter().all(|role| *role == Role::Height);
            let fused = self.blending.is_none() && !self.copy && heights;
            let blending = if fused { Blending::FUSED } else { self.blending };
            Ok(Layer { planes: of_each.to_vec(), roles, output, format, blending })
        };
        let layers = planes.chunks(exemplars).enumerate().map(layer).collect::<Result<Vec<_>, Failure>>()?;
        if !told.is_empty() {
            session.say(&format!("by their names: {}; --role says otherwise", told.join(", ")));
        }
        Ok(layers)
    }

    /// Reads the headers of one output's planes, and refuses what does not `fit` its exemplar or the output.
    pub(crate) fn look(
        &self,
        session: &Session<'_>,
        mut layer: Layer,
        shape: [u32; 2],
        fits: &dyn Fn(usize, &Path, &Info) -> Result<(), Failure>,
    ) -> Result<PlaneHeaders, Failure> {
        let inputs = layer.planes.iter().map(|path| Input::new(session, path)).collect::<Result<Vec<_>, Failure>>()?;
        let options = |role: Role| inputs::options(session.limits, role, self.nonfinite);
        let infos = inputs.iter().zip(&layer.roles).map(|(input, role)| input.probe(&options(*role)));
        let infos = infos.collect::<Result<Vec<_>, _>>()?;
        if self.roles.is_empty() && infos.iter().any(|info| Layout::of(info).colors < 3) {
            // One channel is no direction, whatever its name.
            layer.roles.iter_mut().filter(|role| role.is_normal()).for_each(|role| *role = Role::Scalar);
        }
        let of_each = || layer.planes.iter().map(PathBuf::as_path).zip(&infos);
        for (e, (path, info)) in of_each().enumerate() {
            fits(e, path, info)?;
        }
        let depth = match self.depth {
            Some(depth) => depth,
            None => common_depth(of_each().map(|(path, info)| (path, info.depth)))?,
        };
        let layout = common_layout(of_each().map(|(path, info)| (path, Layout::of(info))))?;
        let output = (layer.output.as_path(), layer.format);
        for (path, info) in of_each() {
            outputs::check_held(output, shape, (Layout::of(info), self.depth.unwrap_or(info.depth)), Some(path))?;
        }
        outputs::check_held(output, shape, (layout, depth), None)?;
        let (exposure, nonfinite) = (self.exposure, self.nonfinite);
        Ok(PlaneHeaders { layer, inputs, infos, depth, layout, exposure, nonfinite })
    }
}

impl Layer {
    /// Its roles as they are typed: one for all where they are equal, and none where names say the same colour.
    pub(crate) fn roles_typed(&self) -> Vec<String> {
        roles_typed(&self.planes, &self.roles)
    }
}

/// Roles of planes as they are typed.
pub(crate) fn roles_typed(planes: &[PathBuf], roles: &[Role]) -> Vec<String> {
    let by_name = |plane: &PathBuf| roles::of_name(plane).unwrap_or(Role::Color);
    let plain = planes.iter().zip(roles).all(|(plane, role)| (*role, by_name(plane)) == (Role::Color, Role::Color));
    let mut all: Vec<String> = roles.iter().map(|role| role_name(*role)).collect();
    if all.iter().all(|role| *role == all[0]) {
        all.truncate(1);
    }
    if plain { Vec::new() } else { all }
}

/// A role as it is typed.
fn role_name(role: Role) -> String {
    typed_name(match role {
        Role::Normal => RoleArg::Normal,
        Role::NormalDown => RoleArg::NormalDx,
        Role::Height => RoleArg::Height,
        Role::Scalar => RoleArg::Scalar,
        _ => RoleArg::Color,
    })
}

impl PlaneHeaders {
    /// An upper bound of what its planes take once they are read.
    pub(crate) fn read_bytes(&self) -> Bytes {
        memory::pictures(&self.infos, self.layout.channels(), self.depth)
    }

    /// An upper bound of what reading them takes besides.
    pub(crate) fn reading_bytes(&self) -> Bytes {
        memory::reading(&self.infos)
    }

    /// An upper bound of what laying a weave over them takes: what turned and resampled sources hold, and blending.
    pub(crate) fn laid_bytes(&self, output: Domain<2>, sources: &[(Transform, Domain<2>)], kept: bool) -> Bytes {
        let channels = self.layout.channels();
        Payload::bytes(sources, channels, self.depth) + self.layer.blending.bytes(output, channels, kept)
    }

    /// An upper bound of what its output takes until it is written.
    pub(crate) fn made_bytes(&self, output: Domain<2>) -> Bytes {
        memory::outputs(output, (self.layout.channels(), self.depth), self.layer.format, false)
    }

    /// Reads the planes; tells what each file is.
    pub(crate) fn read(
        self,
        session: &Session<'_>,
        report: &mut Report,
        found: &dyn Fn(usize, &Path, &Fingerprint),
    ) -> Result<Ready, Failure> {
        let (mut planes, mut fingerprints, mut metadata) = (Vec::new(), Vec::new(), None);
        for (exemplar, (input, role)) in self.inputs.iter().zip(&self.layer.roles).enumerate() {
            let options = inputs::options(session.limits, *role, self.nonfinite);
            let picture = input.read(session, &options, report)?;
            let fingerprint = inputs::fingerprint(&input.path, &picture);
            found(exemplar, &input.path, &fingerprint);
            fingerprints.push(fingerprint);
            let from = picture.plane.samples.depth();
            let plane = widened(picture.plane, self.layout)?;
            planes.push(converted(session, &input.path, plane, self.depth, (&picture.metadata, self.exposure))?);
            metadata.get_or_insert_with(|| picture.metadata.converted(from, self.depth));
        }
        let planes = alike(session, &self.layer.planes, planes)?;
        Ok(Ready { layer: self.layer, planes, fingerprints, metadata: metadata.unwrap_or_default() })
    }
}

impl Ready {
    /// Says where a plane that is laid as something else must be normals, which a turned source would have to turn.
    pub(crate) fn warn_of_normals(&self, session: &Session<'_>, sources: &[Transform]) {
        if sources.iter().all(|transform| is_upright(*transform)) {
            return;
        }
        for (path, plane) in self.layer.planes.iter().zip(&self.planes) {
            warn_of_normals(session, path, plane, "use --role normal");
        }
    }

    /// The weave laid over the planes; `valid` says by source what may show where seams are blended, and what is `kept`
    /// stays as it is.
    pub(crate) fn rendered(
        &self,
        woven: &dyn Render<2>,
        valid: Vec<Option<&Grid<bool, 2>>>,
        kept: Option<&Grid<bool, 2>>,
    ) -> Result<Plane<2>, Failure> {
        let planes: Vec<&Plane<2>> = self.planes.iter().collect();
        match woven.as_map().filter(|_| !self.layer.blending.is_none()) {
            Some(map) => self.layer.blending.render(map, valid, kept, &planes),
            None => Ok(woven.render(&planes)?),
        }
    }
}

/// True for sources that are neither turned nor mirrored.
pub(crate) fn is_upright(transform: Transform) -> bool {
    match transform {
        Transform::Exact { quarter_turns, mirror } => quarter_turns == 0 && !mirror,
        Transform::Resampled { degrees, mirror, .. } => degrees == 0.0 && !mirror,
        _ => false,
    }
}

/// Says where a plane must be normals and is turned as something else.
pub(crate) fn warn_of_normals(session: &Session<'_>, path: &Path, plane: &Plane<2>, remedy: &str) {
    if !plane.role.is_normal() && roles::looks_like_normals(plane) {
        let role = role_name(plane.role);
        session
            .warn(path, &format!("looks like normals but is turned as {role}, so that its light is wrong; {remedy}"));
    }
}

/// Refuses a plane that is not the size of its exemplar.
pub(crate) fn check_size(path: &Path, info: &Info, exemplar: &Path, [h, w]: [u32; 2]) -> Result<(), Failure> {
    if [info.height, info.width] == [h, w] {
        return Ok(());
    }
    let what = format!("{}x{} px, but its exemplar '{}' has {w}x{h} px", info.width, info.height, shown(exemplar));
    Err(Failure::new(3, what).about(path).remedy("give a plane of the same size"))
}
