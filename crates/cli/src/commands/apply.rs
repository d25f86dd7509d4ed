//! `selvedge apply`: a source map laid over other planes of the same exemplars.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Depth, Domain, Grid, Plane, Render, Role, Transform};
use selvedge_io::{Fingerprint, Format, Info, MapFile, MaskChannel, Metadata, Provenance, ReadOptions};

use crate::args::{DepthArg, FormatArg, NonFiniteArg, RoleArg, typed_name};
use crate::blending::Blending;
use crate::exemplars::{NO_MASK, alike, converted};
use crate::failure::{Failure, n as count, shown};
use crate::harmonise::{Layout, common_depth, common_layout, widened};
use crate::inputs::{self, Input, ReadMap};
use crate::memory;
use crate::outputs::{self, Outputs};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::Used;

/// Options of `apply`.
#[derive(Args, Debug)]
pub(crate) struct Apply {
    /// A source map that was written with --map.
    #[arg(value_name = "MAP", value_hint = ValueHint::FilePath)]
    map: PathBuf,
    /// A plane for each exemplar of the map, in order; more of them make more outputs.
    #[arg(required = true, value_name = "PLANE", value_hint = ValueHint::FilePath)]
    planes: Vec<PathBuf>,
    /// The picture to write, '-' for standard output. For several, '{name}' and '{stem}' stand for the plane's name
    /// with and without its extension: 'out/{name}'.
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    output: PathBuf,
    /// What the channels mean: one for all planes, or one for each. Normals are turned with their samples, and only
    /// colour is encoded when depths change.
    #[arg(long, value_enum, value_name = "ROLE", value_delimiter = ',', default_value = "color")]
    role: Vec<RoleArg>,
    #[command(flatten)]
    blending: Blending,
    /// Copy heights sample by sample as well: by default they are fused, or every seam would be a step.
    #[arg(long, conflicts_with_all = ["feather", "spline", "fuse"])]
    copy: bool,
    /// The masks that the exemplars were woven with: what is black does not show where seams are blended. Give one for each
    /// exemplar of the map, in order, or 'none'.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    mask: Vec<PathBuf>,
    /// Where this picture is white, nothing is blended.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    fixed: Option<PathBuf>,
    /// Format of the output, whatever its extension.
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<FormatArg>,
    /// Depth of the output; by default that of the planes.
    #[arg(long, value_enum, value_name = "DEPTH")]
    depth: Option<DepthArg>,
    /// Quality of a JPEG file, 1 to 100.
    #[arg(long, value_name = "Q", value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: Option<u8>,
    /// What becomes of float samples that are infinite or no numbers.
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = NonFiniteArg::Error)]
    nonfinite: NonFiniteArg,
}

/// One output: a plane of every exemplar.
struct Layer<'a> {
    planes: &'a [PathBuf],
    roles: Vec<Role>,
    output: PathBuf,
    format: Format,
}

impl Apply {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("apply");
        self.blending.validate()?;
        let masks = self.mask.iter().filter(|mask| mask.as_os_str() != NO_MASK).chain(&self.fixed);
        let files: Vec<PathBuf> = std::iter::once(&self.map).chain(&self.planes).chain(masks).cloned().collect();
        inputs::check_streams(&files)?;
        let (roles, planes) = (self.role.len(), self.planes.len());
        if roles != 1 && roles != planes {
            let what = format!("{} for {}", count("role", roles), count("plane", planes));
            return Err(Failure::new(2, what).remedy("give one --role, or one for each"));
        }
        let ReadMap { file, fingerprint, entry } = Input::new(session, &self.map)?.read_map(session)?;
        report.inputs.push(entry);
        let masks = self.masks(session, &file, &mut report)?;
        let layers = self.layers(&file)?;
        let written: Vec<&Path> = layers.iter().map(|layer| layer.output.as_path()).collect();
        outputs::check(session, &written, &files)?;
        report.options = self.used(session);
        report.stage("read");
        let mut run = Run { args: self, session, file, map: fingerprint, masks, report };
        // Whatever can be refused is, before the first picture is made, and nothing is written before the last one is.
        let looked = layers.iter().map(|layer| run.look(layer)).collect::<Result<Vec<_>, Failure>>()?;
        let needed = run.need(&looked);
        memory::check_fixed(&session.limits, needed)?;
        run.report.estimate = Some(needed.0);
        let mut outputs = Outputs::with_quality(self.quality);
        looked.into_iter().try_for_each(|one| run.lay(one, &mut outputs))?;
        session.check_signal()?;
        Ok(run.done(&written, outputs))
    }

    /// How the planes of an output are laid: heights copied side by side are steps, which no light hides.
    fn blending(&self, layer: &Layer<'_>) -> Blending {
        let by_default = self.blending.is_none() && !self.copy && layer.roles.iter().all(|role| *role == Role::Height);
        if by_default { Blending::FUSED } else { self.blending }
    }

    /// Which planes go together, and what becomes of them.
    fn layers(&self, file: &MapFile) -> Result<Vec<Layer<'_>>, Failure> {
        let (n, given) = (file.exemplars.len(), self.planes.len());
        if n == 0 || !given.is_multiple_of(n) {
            let names: Vec<&str> = file.exemplars.iter().map(|e| e.name.as_str()).collect();
            let what = format!(
                "was made from {} ({}), and {} given",
                count("exemplar", n),
                names.join(", "),
                if given == 1 { "1 plane is".into() } else { format!("{given} planes are") }
            );
            return Err(Failure::new(3, what).about(&self.map).remedy("give one plane for each, in order"));
        }
        let role = |plane: usize| Role::from(self.role[plane.min(self.role.len() - 1)]);
        let layer = |i: usize, planes| {
            let output = named(&self.output, &self.planes[i * n]);
            if n < given && output == self.output {
                let what = format!("{} outputs would have this name", given / n);
                return Err(Failure::new(2, what).about(&output).remedy("use '{name}' or '{stem}' in it"));
            }
            let format = outputs::format(&output, self.format.map(Format::from), self.depth.map(Depth::from))?;
            Ok(Layer { planes, roles: (0..n).map(|e| role(i * n + e)).collect(), output, format })
        };
        self.planes.chunks(n).enumerate().map(|(i, planes)| layer(i, planes)).collect()
    }

    /// The masks of the exemplars, and what is not blended.
    fn masks(&self, session: &Session<'_>, file: &MapFile, report: &mut Report) -> Result<Masks, Failure> {
        let (n, given) = (file.exemplars.len(), self.mask.len());
        if given != 0 && given != n {
            let what = format!("was made from {n} exemplar(s), and {given} mask(s) are given");
            return Err(Failure::new(3, what).about(&self.map).remedy("give one --mask for each, or '--mask none'"));
        }
        let (mut fingerprints, mut held) = (Vec::new(), Bytes(0));
        let mut read = |path: &PathBuf, shape: Option<[u32; 2]>| -> Result<Option<Grid<bool, 2>>, Failure> {
            if path.as_os_str() == NO_MASK {
                return Ok(None);
            }
            let options = inputs::options(session.limits, Role::Scalar, self.nonfinite);
            let input = Input::new(session, path)?;
            let info = input.probe(&options)?;
            if let Some([eh, ew]) = shape.filter(|shape| *shape != [info.height, info.width]) {
                let what = format!("{}x{} px, but the map has {ew}x{eh} px", info.width, info.height);
                return Err(Failure::new(3, what).about(path).remedy("give a mask of that size"));
            }
            held = held + memory::masks([&info]);
            let picture = input.read(session, &options, report)?;
            fingerprints.push(inputs::fingerprint(path, &picture));
            let mask = selvedge_io::mask(&picture.plane, MaskChannel::Light);
            mask.map(Some).map_err(|p| Failure::from_problem(path, p))
        };
        let of_exemplars = self.mask.iter().map(|path| read(path, None));
        let of_exemplars = of_exemplars.collect::<Result<Vec<_>, _>>()?;
        let shape = Some(file.map.domain().shape);
        let fixed = self.fixed.as_ref().map(|path| read(path, shape)).transpose()?.flatten();
        Ok(Masks { of_exemplars, fixed, fingerprints, held })
    }

    /// The options as used.
    fn used(&self, session: &Session<'_>) -> Used {
        let roles: Vec<String> = self.role.iter().map(|role| typed_name(*role)).collect();
        let used = self.blending.used(session.options.clone().without("role"));
        let used = if self.copy { used } else { used.without("copy") };
        let used = if self.quality.is_none() { used.without("quality") } else { used };
        let odd = (self.nonfinite != NonFiniteArg::Error).then(|| typed_name(self.nonfinite));
        used.set("nonfinite", odd).with("role", if roles == ["color"] { Vec::new() } else { roles })
    }
}

/// The output's name for a plane.
fn named(output: &Path, plane: &Path) -> PathBuf {
    let Some(pattern) = output.to_str() else { return output.to_path_buf() };
    let mut name = OsString::new();
    for (i, part) in pattern.split("{name}").enumerate() {
        if i != 0 {
            name.push(plane.file_name().unwrap_or_default());
        }
        for (i, part) in part.split("{stem}").enumerate() {
            if i != 0 {
                name.push(plane.file_stem().unwrap_or_default());
            }
            name.push(part);
        }
    }
    name.into()
}

/// One output whose planes' headers were read.
struct Looked<'a> {
    layer: &'a Layer<'a>,
    inputs: Vec<Input>,
    infos: Vec<Info>,
    depth: Depth,
    layout: Layout,
}

/// Masks that were read.
struct Masks {
    of_exemplars: Vec<Option<Grid<bool, 2>>>,
    /// What is not blended.
    fixed: Option<Grid<bool, 2>>,
    fingerprints: Vec<Fingerprint>,
    held: Bytes,
}

/// A map that was read, and what became of it so far.
struct Run<'a> {
    args: &'a Apply,
    session: &'a Session<'a>,
    file: MapFile,
    map: Fingerprint,
    masks: Masks,
    report: Report,
}

impl Run<'_> {
    /// How a plane is read.
    fn read_options(&self, role: Role) -> ReadOptions {
        inputs::options(self.session.limits, role, self.args.nonfinite)
    }

    /// Reads the headers of one output's planes.
    fn look<'l>(&self, layer: &'l Layer<'l>) -> Result<Looked<'l>, Failure> {
        let inputs =
            layer.planes.iter().map(|path| Input::new(self.session, path)).collect::<Result<Vec<_>, Failure>>()?;
        let infos = inputs.iter().zip(&layer.roles).map(|(input, role)| input.probe(&self.read_options(*role)));
        let infos = infos.collect::<Result<Vec<_>, _>>()?;
        let (depth, layout) = self.check(layer, &infos)?;
        Ok(Looked { layer, inputs, infos, depth, layout })
    }

    /// An upper bound of what it takes: the planes of one output at a time, and all outputs until they are written.
    fn need(&self, looked: &[Looked<'_>]) -> Bytes {
        let domain = self.file.map.domain();
        let sources = self.file.map.table.sources().iter();
        let resampled = sources.filter(|(o, _)| matches!(o.transform, Transform::Resampled { .. })).map(|(_, d)| *d);
        let resampled: Vec<Domain<2>> = resampled.collect();
        let made = |l: &Looked<'_>| memory::outputs(domain, l.layout.channels(), l.depth, false);
        let copied = self.masks.fixed.is_some() || 0 < self.file.map.holes();
        let laid = |l: &Looked<'_>| {
            memory::pictures(&l.infos, l.layout.channels(), l.depth)
                + memory::reading(&l.infos)
                + memory::shown(&resampled, l.layout.channels(), l.depth)
                + Bytes(self.args.blending(l.layer).memory(domain, l.layout.channels(), copied))
        };
        let read = looked.iter().map(laid).max().unwrap_or_default();
        memory::PROGRAM + self.masks.held + memory::places(domain) + read + looked.iter().map(made).sum()
    }

    /// Says where a plane has the name of the map's exemplar but is another file: then the weave may not fit it.
    fn check_content(&self, exemplar: usize, path: &Path, found: &Fingerprint) {
        let made_from = &self.file.exemplars[exemplar];
        if made_from.blake3 == found.blake3 {
            self.session.detail(&format!("'{}' is the exemplar that the map was made from", shown(path)));
        } else if made_from.name == found.name && !made_from.blake3.is_empty() {
            self.session.warn(path, &"the map was made from a file of this name, but with other contents");
        }
    }

    /// Reads the planes of one output and renders it.
    fn lay(
        &mut self,
        Looked { layer, inputs, depth, layout, .. }: Looked<'_>,
        to: &mut Outputs,
    ) -> Result<(), Failure> {
        let (mut planes, mut read_files, mut metadata) = (Vec::new(), vec![self.map.clone()], None);
        for (exemplar, (input, role)) in inputs.iter().zip(&layer.roles).enumerate() {
            let picture = input.read(self.session, &self.read_options(*role), &mut self.report)?;
            let found = inputs::fingerprint(&input.path, &picture);
            self.check_content(exemplar, &input.path, &found);
            read_files.push(found);
            let from = picture.plane.samples.depth();
            let plane = widened(picture.plane, layout)?;
            planes.push(converted(self.session, &input.path, plane, depth, &picture.metadata)?);
            metadata.get_or_insert_with(|| picture.metadata.converted(from, depth));
        }
        let paths: Vec<PathBuf> = inputs.iter().map(|input| input.path.clone()).collect();
        let planes = alike(self.session, &paths, planes)?;
        self.report.stage("read");
        if self.session.global.dry_run {
            return Ok(());
        }
        let rendered = self.rendered(layer, &planes.iter().collect::<Vec<_>>())?;
        drop(planes);
        self.report.stage("render");
        let provenance = Some(self.provenance(layer, read_files));
        let metadata = Metadata { provenance, ..metadata.unwrap_or_default() };
        to.picture(&layer.output, layer.format, &rendered, &metadata)?;
        self.report.stage("encode");
        self.session.check_signal()
    }

    /// The map laid over the planes.
    fn rendered(&self, layer: &Layer<'_>, planes: &[&Plane<2>]) -> Result<Plane<2>, Failure> {
        let map = &self.file.map;
        let blending = self.args.blending(layer);
        if blending.is_none() {
            return Ok(map.render(planes)?);
        }
        let valid = map.table.validity(planes, &self.masks.of_exemplars);
        let valid =
            valid.map_err(|e| Failure::from(e).about(&layer.planes[0]).remedy("give masks of the planes' size"))?;
        let valid = valid.iter().map(Option::as_ref).collect();
        blending.render(map, valid, self.masks.fixed.as_ref(), planes)
    }

    /// Refuses planes that are not the size of their exemplars, and outputs that cannot hold them.
    fn check(&self, layer: &Layer<'_>, infos: &[Info]) -> Result<(Depth, Layout), Failure> {
        let of_each = || layer.planes.iter().map(PathBuf::as_path).zip(infos);
        for (e, (path, info)) in of_each().enumerate() {
            self.check_size(e, path, info)?;
        }
        let depth = match self.args.depth {
            Some(depth) => depth.into(),
            None => common_depth(of_each().map(|(path, info)| (path, info.depth)))?,
        };
        let layout = common_layout(of_each().map(|(path, info)| (path, Layout::of(info))))?;
        let (output, shape) = ((layer.output.as_path(), layer.format), self.file.map.domain().shape);
        for (path, info) in of_each() {
            let depth = self.args.depth.map_or(info.depth, Depth::from);
            outputs::check_held(output, shape, (Layout::of(info), depth), Some(path))?;
        }
        outputs::check_held(output, shape, (layout, depth), None)?;
        Ok((depth, layout))
    }

    fn check_size(&self, exemplar: usize, path: &Path, info: &Info) -> Result<(), Failure> {
        let found = Domain::open([info.height, info.width]);
        let sources = self.file.map.table.sources().iter().filter(|(o, _)| usize::from(o.exemplar) == exemplar);
        for (origin, domain) in sources {
            if origin.transform.domain(found).shape != domain.shape {
                let name = &self.file.exemplars[exemplar].name;
                let ([h, w], how) = match origin.transform {
                    Transform::Resampled { degrees, scale, .. } => {
                        (domain.shape, format!("turned by {degrees} degrees and scaled by {scale} to"))
                    }
                    // A transform that turned the exemplar turns it back as far as its sides go.
                    turned => (turned.domain(*domain).shape, "of".to_owned()),
                };
                let what =
                    format!("{}x{} px, but the map was made from '{name}' {how} {w}x{h} px", info.width, info.height);
                return Err(Failure::new(3, what).about(path).remedy("give a plane of the same size"));
            }
        }
        Ok(())
    }

    fn provenance(&self, layer: &Layer<'_>, inputs: Vec<Fingerprint>) -> Provenance {
        let seed = self.file.metadata.provenance.as_ref().map_or(0, |p| p.seed);
        let files: Vec<PathBuf> = std::iter::once(&self.args.map).chain(layer.planes).cloned().collect();
        let inputs = inputs.into_iter().chain(self.masks.fingerprints.iter().cloned()).collect();
        let command = self.report.options.command("apply", &files);
        Provenance { version: env!("CARGO_PKG_VERSION").into(), seed, inputs, command }
    }

    fn done(self, written: &[&Path], outputs: Outputs) -> Done {
        let [h, w] = self.file.map.domain().shape;
        let names: Vec<String> = written.iter().map(|path| shown(path)).collect();
        let (names, map) = (names.join(", "), shown(&self.args.map));
        if self.session.global.dry_run {
            let needed = Bytes(self.report.estimate.unwrap_or_default());
            let line = format!("{names}: would be {w}x{h} px through {map}, with about {needed} of memory");
            return Done::would(self.report, line);
        }
        let line = format!("{names}: {w}x{h} px through {map}, in {:.2} s", self.report.elapsed());
        Done::made(self.report, line, outputs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_filled_in() {
        let name = |pattern: &str| named(Path::new(pattern), Path::new("in/a.b.png"));
        assert_eq!(name("out/{name}"), Path::new("out/a.b.png"));
        assert_eq!(name("{stem}-{stem}.exr"), Path::new("a.b-a.b.exr"));
        assert_eq!(name("out.png"), Path::new("out.png"));
    }
}
