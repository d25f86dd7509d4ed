//! `selvedge apply`: a source map laid over other planes of the same exemplars.

mod clip;

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Grid, Plane, Role, Transform};
use selvedge_io::{Fingerprint, Info, MapFile, Metadata, Provenance};
use serde_json::Value;

use crate::args::RoleArg;
use crate::blending::Blending;
use crate::exemplars::NO_MASK;
use crate::failure::{Failure, n as count, shown};
use crate::inputs::{self, Input, ReadMap};
use crate::options::{Conversion, Encoding, NonFinite};
use crate::outputs::{self, Outputs};
use crate::planes::{Layer, Laying, PlaneHeaders, roles_typed};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::Used;
use crate::{memory, names};

/// Options of `apply`.
#[derive(Args, Debug)]
pub(crate) struct Apply {
    /// A source map that was written with --map; 'maps.####.exr', one a frame, for clips.
    #[arg(value_name = "MAP", value_hint = ValueHint::FilePath)]
    map: PathBuf,
    /// A plane for each exemplar of the map, in order; more of them make more outputs. Of a clip's maps: passes of its
    /// frames, of each clip that was merged.
    #[arg(required = true, value_name = "PLANE", value_hint = ValueHint::FilePath)]
    planes: Vec<PathBuf>,
    /// The picture to write, '-' for standard output. For several, '{name}' and '{stem}' stand for the plane's name
    /// with and without its extension: 'out/{name}'.
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    output: PathBuf,
    /// What the channels mean: one for all planes, or one for each. By default names tell, as in wood_normal.png.
    /// Normals are turned with their samples, and only colour is encoded when depths change.
    #[arg(long, value_enum, value_name = "ROLE", value_delimiter = ',')]
    role: Vec<RoleArg>,
    #[command(flatten)]
    blending: Blending,
    /// Copy heights sample by sample as well: by default they are fused, or every seam would be a step.
    #[arg(long, conflicts_with_all = ["feather", "spline", "fuse"])]
    copy: bool,
    /// The masks that the exemplars were woven with: what is black does not show where seams are blended. Give one for
    /// each exemplar of the map, in order, or 'none'.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    mask: Vec<PathBuf>,
    /// Where this picture is white, nothing is blended.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    fixed: Option<PathBuf>,
    #[command(flatten)]
    encoding: Encoding,
    #[command(flatten)]
    conversion: Conversion,
    #[command(flatten)]
    nonfinite: NonFinite,
}

impl Apply {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        if self.is_of_clip() {
            return self.over_clips(session);
        }
        let mut report = Report::new("apply");
        self.blending.validate()?;
        let masks = self.mask.iter().filter(|mask| mask.as_os_str() != NO_MASK).chain(&self.fixed);
        let files: Vec<PathBuf> = std::iter::once(&self.map).chain(&self.planes).chain(masks).cloned().collect();
        inputs::check_streams(&files)?;
        let ReadMap { file, fingerprint, entry } = Input::new(session, &self.map)?.read_map(session)?;
        report.inputs.push(entry);
        let masks = self.masks(session, &file, &mut report)?;
        let layers = self.layers(session, &file)?;
        let written: Vec<PathBuf> = layers.iter().map(|layer| layer.output.clone()).collect();
        outputs::check(session, &written, &files)?;
        report.stage("read");
        let mut run = Run { args: self, session, file, map: fingerprint, masks, report };
        // Whatever can be refused is, before the first picture is made, and nothing is written before the last one is.
        let looked = layers.into_iter().map(|layer| run.look(layer)).collect::<Result<Vec<_>, Failure>>()?;
        let needed = run.need(&looked);
        memory::check_fixed(&session.limits, needed)?;
        run.report.estimate = Some(needed.0);
        let roles: Vec<Role> = looked.iter().flat_map(|one| one.layer.roles.clone()).collect();
        run.report.options = self.used(session, roles_typed(&self.planes, &roles));
        let mut outputs = Outputs::with_quality(self.encoding.quality);
        looked.into_iter().try_for_each(|one| run.lay(one, &mut outputs))?;
        session.check_signal()?;
        Ok(run.done(&written, outputs))
    }

    fn laying(&self) -> Laying<'_> {
        Laying {
            roles: &self.role,
            depth: self.conversion.depth(),
            exposure: self.conversion.exposure,
            format: self.encoding.format(),
            nonfinite: self.nonfinite.into(),
            blending: self.blending,
            copy: self.copy,
        }
    }

    /// Which planes go together, and what becomes of them.
    fn layers(&self, session: &Session<'_>, file: &MapFile) -> Result<Vec<Layer>, Failure> {
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
        names::check_apart(&self.output, given / n)?;
        self.laying().layers(session, &self.planes, n, &self.output)
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
            held += memory::masks([&info]);
            let picture = input.read(session, &options, report)?;
            fingerprints.push(inputs::fingerprint(path, &picture));
            inputs::white(&picture.plane, path).map(Some)
        };
        let of_exemplars = self.mask.iter().map(|path| read(path, None));
        let of_exemplars = of_exemplars.collect::<Result<Vec<_>, _>>()?;
        let shape = Some(file.map.domain().shape);
        let fixed = self.fixed.as_ref().map(|path| read(path, shape)).transpose()?.flatten();
        Ok(Masks { of_exemplars, fixed, fingerprints, held })
    }

    /// The options as used, with roles as they are typed.
    fn used(&self, session: &Session<'_>, roles: Vec<String>) -> Used {
        let used = self.blending.used(session.options.clone().without("role"));
        let used = if self.copy { used } else { used.without("copy") };
        used.unless("quality", Value::Null)
            .unless("exposure", 0.0)
            .set("nonfinite", self.nonfinite.typed())
            .with("role", roles)
    }
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
    /// Reads the headers of one output's planes.
    fn look(&self, layer: Layer) -> Result<PlaneHeaders, Failure> {
        let fits = |exemplar: usize, path: &Path, info: &Info| self.check_size(exemplar, path, info);
        self.args.laying().look(self.session, layer, self.file.map.domain().shape, &fits)
    }

    /// An upper bound of what it takes: the planes of one output at a time, and all outputs until they are written.
    fn need(&self, looked: &[PlaneHeaders]) -> Bytes {
        let domain = self.file.map.domain();
        let sources = self.file.map.table.sources().iter();
        let shown: Vec<_> = sources.map(|(origin, domain)| (origin.transform, *domain)).collect();
        let kept = self.masks.fixed.is_some() || 0 < self.file.map.holes();
        let laid =
            |one: &PlaneHeaders| one.read_bytes() + one.reading_bytes().then(one.laid_bytes(domain, &shown, kept));
        let read = looked.iter().map(laid).max().unwrap_or_default();
        let made = looked.iter().map(|one| one.made_bytes(domain)).sum();
        memory::PROGRAM + self.masks.held + memory::places(domain) + read + made
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
    fn lay(&mut self, looked: PlaneHeaders, to: &mut Outputs) -> Result<(), Failure> {
        let mut report = std::mem::replace(&mut self.report, Report::new("apply"));
        let ready = looked.read(self.session, &mut report, &|e, path, found| self.check_content(e, path, found));
        self.report = report;
        let ready = ready?;
        let map = &self.file.map;
        let turned: Vec<Transform> = map.table.sources().iter().map(|(origin, _)| origin.transform).collect();
        ready.warn_of_normals(self.session, &turned);
        self.report.stage("read");
        if self.session.global.dry_run {
            return Ok(());
        }
        self.session.watch.busy(ready.layer.blending.name());
        let valid = if ready.layer.blending.is_none() {
            Vec::new()
        } else {
            let planes: Vec<&Plane<2>> = ready.planes.iter().collect();
            let about = |e| Failure::from(e).about(&ready.layer.planes[0]).remedy("give masks of the planes' size");
            map.table.validity(&planes, &self.masks.of_exemplars).map_err(about)?
        };
        let rendered = ready.rendered(map, valid.iter().map(Option::as_ref).collect(), self.masks.fixed.as_ref())?;
        self.report.stage("render");
        let provenance = Some(self.provenance(&ready.layer, ready.fingerprints));
        to.picture(&ready.layer.output, ready.layer.format, &rendered, &Metadata { provenance, ..ready.metadata })?;
        self.report.stage("encode");
        self.session.check_signal()
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

    fn provenance(&self, layer: &Layer, inputs: Vec<Fingerprint>) -> Provenance {
        let seed = self.file.metadata.provenance.as_ref().map_or(0, |p| p.seed);
        let files: Vec<PathBuf> = std::iter::once(&self.args.map).chain(&layer.planes).cloned().collect();
        let inputs = std::iter::once(self.map.clone()).chain(inputs).chain(self.masks.fingerprints.iter().cloned());
        // Of each picture only what made it: the other outputs of the run had roles of their own.
        let own = self.args.used(self.session, layer.roles_typed());
        let command = own.command("apply", &files);
        Provenance { version: env!("CARGO_PKG_VERSION").into(), seed, inputs: inputs.collect(), command }
    }

    fn done(self, written: &[PathBuf], outputs: Outputs) -> Done {
        let [h, w] = self.file.map.domain().shape;
        let names: Vec<String> = written.iter().map(|path| shown(path)).collect();
        let (names, map) = (names.join(", "), shown(&self.args.map));
        if self.session.global.dry_run {
            let needed = Bytes(self.report.estimate.unwrap_or_default());
            let line = format!("{names}: would be {w}x{h} px through {map}, with about {needed} of memory");
            let planned = written.iter().map(|path| outputs::planned(path, [h, w])).collect();
            return Done::would(self.report, line, planned);
        }
        let line = format!("{names}: {w}x{h} px through {map}, in {:.2} s", self.report.elapsed());
        Done::made(self.report, line, outputs)
    }
}
