//! What every command that weaves a picture from exemplars goes through: sizes, budget, reading, and writing what came
//! out. A command adds its options, its estimate, and its method.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Depth, Domain, Plane, Render, Role, SourceMap, Transform};
use selvedge_io::{Fingerprint, Format, MapFile, Metadata, Provenance, ReadOptions};

use crate::args::FormatArg;
use crate::exemplars::{ExemplarArgs, Headers, Loaded};
use crate::explain::{self, explain};
use crate::failure::{Failure, shown};
use crate::inputs::{self, Input, STREAM};
use crate::memory::{self, Resized};
use crate::outputs::{self, Outputs};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::size::{Size, Tile};
use crate::used::Used;

/// Options of the commands that weave a picture of a chosen size.
#[derive(Args, Clone, Debug)]
pub(crate) struct Weaving {
    #[command(flatten)]
    pub(crate) input: ExemplarArgs,
    /// The picture to write, '-' for standard output; the format follows the extension.
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,
    /// Format of the output, whatever its extension.
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(crate) format: Option<FormatArg>,
    /// Make the output tile without a seam along x, y or both.
    #[arg(long, value_enum, value_name = "AXES")]
    pub(crate) tile: Option<Tile>,
    /// Write the source map: which exemplar sample stands at each place. See 'selvedge apply'.
    #[arg(long, value_name = "FILE.exr", value_hint = ValueHint::FilePath)]
    pub(crate) map: Option<PathBuf>,
    /// Write a picture of the seams and of where each part came from, for eyes.
    #[arg(long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    pub(crate) explain: Option<PathBuf>,
}

/// The size of an output that may have any.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Sizing {
    /// Size of the output: 512, 512x384, or a factor of the first exemplar such as 2x.
    #[arg(long, value_name = "SIZE", default_value = "2x")]
    size: Size,
}

impl Sizing {
    /// Height and width for a first exemplar of this shape.
    pub(crate) fn shape(self, exemplar: [u32; 2]) -> Result<[u32; 2], Failure> {
        Ok(self.size.shape(exemplar))
    }
}

/// What a command tells about itself before anything is read.
pub(crate) struct Plan<'p> {
    pub(crate) command: &'static str,
    /// Files that it reads besides the exemplars and their masks.
    pub(crate) others: Vec<PathBuf>,
    /// Height and width of the output for a first exemplar of some shape.
    pub(crate) shape: &'p dyn Fn([u32; 2]) -> Result<[u32; 2], Failure>,
    /// The exemplars' orientations.
    pub(crate) transforms: &'p [Transform],
    pub(crate) estimate: Estimate<'p>,
}

/// A run that was checked and whose exemplars were read.
pub(crate) struct Loom<'a> {
    session: &'a Session<'a>,
    args: &'a Weaving,
    format: Format,
    report: Report,
    pub(crate) loaded: Loaded,
    /// Shape and topology of the output.
    pub(crate) domain: Domain<2>,
    /// What was read besides the exemplars and their masks.
    others: Vec<Fingerprint>,
}

/// The method's share of the memory: domains of the sources, feature channels, output domain.
pub(crate) type Estimate<'e> = &'e dyn Fn(&[Domain<2>], usize, Domain<2>) -> u64;

impl Weaving {
    /// Refuses what cannot be done, in the order in which it is cheap to see, and reads the exemplars.
    pub(crate) fn begin<'a>(&'a self, session: &'a Session<'a>, plan: &Plan<'_>) -> Result<Loom<'a>, Failure> {
        self.begin_by(session, plan, Resized::Size)
    }

    /// The same for a command whose output has the size of a picture that it is given.
    pub(crate) fn begin_of_fixed_size<'a>(
        &'a self,
        session: &'a Session<'a>,
        plan: &Plan<'_>,
    ) -> Result<Loom<'a>, Failure> {
        self.begin_by(session, plan, Resized::Target)
    }

    fn begin_by<'a>(
        &'a self,
        session: &'a Session<'a>,
        plan: &Plan<'_>,
        resized: Resized,
    ) -> Result<Loom<'a>, Failure> {
        let mut report = Report::new(plan.command);
        let format = outputs::format(&self.output, self.format.map(Format::from), self.input.depth.map(Depth::from))?;
        let read: Vec<PathBuf> = self.input.files().into_iter().chain(plan.others.iter().cloned()).collect();
        inputs::check_streams(&read)?;
        outputs::check(session, &self.files_written(), &read)?;
        let headers = self.input.look(session)?;
        outputs::check_depth(&self.output, format, headers.depth)?;
        if let Some(path) = &self.explain {
            outputs::check_depth(path, outputs::format(path, None, None)?, Depth::U8)?;
        }
        let domain = Tile::domain(self.tile, (plan.shape)(headers.domains()[0].shape)?);
        check_size(session, domain, resized)?;
        let only = self.input.exemplars.first().filter(|_| self.input.exemplars.len() == 1).map(PathBuf::as_path);
        let need = |domain| self.need(&headers, plan, domain);
        let needed = memory::check(session.limits.memory, only, domain, resized, &need)?;
        let human = memory::human;
        session.detail(&format!("memory: about {} of {}", human(needed), human(session.limits.memory)));
        let loaded = headers.load(session, plan.transforms, &mut report)?;
        report.estimate = Some(needed);
        report.stage("read");
        Ok(Loom { session, args: self, format, report, loaded, domain, others: Vec::new() })
    }

    /// How pictures are read.
    pub(crate) fn read_options(&self, session: &Session<'_>) -> ReadOptions {
        inputs::options(session.limits, Role::Color, self.input.nonfinite)
    }

    fn files_written(&self) -> Vec<&Path> {
        std::iter::once(self.output.as_path()).chain(self.map.as_deref()).chain(self.explain.as_deref()).collect()
    }

    fn need(&self, headers: &Headers, plan: &Plan<'_>, domain: Domain<2>) -> u64 {
        let sources: Vec<Domain<2>> =
            headers.domains().iter().flat_map(|d| plan.transforms.iter().map(|t| t.domain(*d))).collect();
        let exemplars = memory::exemplars(&headers.infos, headers.depth)
            .saturating_add(memory::sources(&sources, headers.layout.colors));
        let output = memory::outputs(domain, headers.layout.channels(), headers.depth, self.map.is_some());
        let explained = if self.explain.is_some() {
            memory::explained(explain::shape(domain.shape, sources.iter().map(|s| s.shape)))
        } else {
            0
        };
        let method = (plan.estimate)(&sources, headers.layout.colors, domain);
        [exemplars, output, explained, method].into_iter().fold(0, u64::saturating_add)
    }
}

/// Refuses outputs over the caps.
fn check_size(session: &Session<'_>, domain: Domain<2>, resized: Resized) -> Result<(), Failure> {
    let [h, w] = domain.shape;
    let (side, samples) = (session.limits.side, session.limits.samples);
    if side < h.max(w) || samples < u64::from(h) * u64::from(w) {
        let caps = format!("the output of {w}x{h} px is over the caps of {side} px a side and {samples} px in all");
        return Err(Failure::new(3, format!("{caps}; use a smaller {}", resized.flag())));
    }
    Ok(())
}

impl Loom<'_> {
    /// True if nothing is to be woven.
    pub(crate) fn is_dry(&self) -> bool {
        self.session.global.dry_run
    }

    /// Reads a picture besides the exemplars.
    pub(crate) fn read(&mut self, input: &Input) -> Result<Plane<2>, Failure> {
        let picture = input.read(self.session, &self.args.read_options(self.session), &mut self.report)?;
        self.others.push(inputs::fingerprint(&input.path, &picture));
        Ok(picture.plane)
    }

    /// The size of the output, for commands that take one.
    pub(crate) fn sized(&self) -> Used {
        let [h, w] = self.domain.shape;
        Used::default().with("size", format!("{w}x{h}"))
    }

    /// Adds the options that all weaving commands have, as used, before a method's own.
    pub(crate) fn used(&self, before: Used) -> Used {
        self.args.input.used(before.with("tile", self.args.tile.map(crate::args::typed_name)))
    }

    /// Ends a dry run: what would be done, in a line that begins with the output's name.
    pub(crate) fn would(mut self, options: Used, how: &str) -> Done {
        let [h, w] = self.domain.shape;
        let needed = self.report.estimate.unwrap_or_default();
        let name = shown(&self.args.output);
        let line = format!("{name}: would be {w}x{h} px {how}, with about {} of memory", memory::human(needed));
        self.report.options = options;
        Done::made(self.report, line)
    }

    /// Renders and writes what was woven; a run that was interrupted ends here.
    pub(crate) fn finish(
        mut self,
        map: SourceMap<2>,
        complete: bool,
        options: Used,
        stats: serde_json::Value,
        how: &str,
    ) -> Result<Done, Failure> {
        self.session.watch.finish();
        self.report.stage("synthesis");
        self.report.options = options;
        self.report.stats = stats;
        let (output, map_file) = (self.args.output.clone(), self.args.map.clone());
        if !complete {
            return Err(self.interrupted(map, &output, map_file.as_deref()));
        }
        self.session.check_signal()?;
        self.write(map, &output, map_file.as_deref(), Some(self.provenance()))?;
        let ([h, w], name) = (self.domain.shape, shown(&output));
        let line = format!("{name}: {w}x{h} px {how}, in {:.2} s", self.report.elapsed());
        Ok(Done::made(self.report, line))
    }

    fn write(
        &mut self,
        map: SourceMap<2>,
        output: &Path,
        map_file: Option<&Path>,
        provenance: Option<Provenance>,
    ) -> Result<(), Failure> {
        let payload: Vec<&Plane<2>> = self.loaded.payload.iter().collect();
        let plane = map.render(&payload)?;
        self.report.stage("render");
        let metadata = Metadata { provenance: provenance.clone(), ..self.loaded.metadata.clone() };
        let mut outputs = Outputs::default();
        outputs.picture(output, self.format, &plane, &metadata)?;
        if let Some(path) = self.args.explain.as_deref().filter(|_| provenance.is_some()) {
            let metadata = Metadata { provenance: provenance.clone(), ..Metadata::default() };
            outputs.picture(path, outputs::format(path, None, None)?, &explain(&map, &plane)?, &metadata)?;
        }
        drop(plane);
        if let Some(path) = map_file {
            let metadata = Metadata { provenance, ..Metadata::default() };
            outputs.map(path, &MapFile::new(map, self.loaded.fingerprints.clone(), metadata))?;
        }
        outputs.write(self.session, &mut self.report)?;
        self.report.stage("write");
        Ok(())
    }

    /// How the picture was made: nothing that differs between equal runs.
    fn provenance(&self) -> Provenance {
        let (seed, options) = (self.session.global.seed, &self.report.options);
        Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            seed,
            inputs: self.loaded.all_fingerprints().into_iter().chain(self.others.iter().cloned()).collect(),
            command: options.clone().with("seed", seed).command(self.report.command(), &self.loaded.paths),
        }
    }

    /// Keeps the best so far if that is wanted. It says nothing of how it was made: no command makes it again.
    fn interrupted(&mut self, map: SourceMap<2>, output: &Path, map_file: Option<&Path>) -> Failure {
        let failure = Failure::interrupted(self.session.watch.signal().unwrap_or(2));
        if !self.session.global.keep_partial || output.as_os_str() == STREAM {
            return failure;
        }
        let (output, map_file) = (outputs::partial(output), map_file.map(outputs::partial));
        match self.write(map, &output, map_file.as_deref(), None) {
            Ok(()) => failure.remedy(format!("the best so far is in '{}'", shown(&output))),
            Err(e) => e,
        }
    }
}
