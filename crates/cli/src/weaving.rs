//! What every command that weaves a picture from exemplars goes through: sizes, budget, reading, and writing what came
//! out. A command adds its options, its estimate, and its method.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Depth, Domain, Grid, Plane, Render, Role, Samples, SourceMap, Transform};
use selvedge_io::{Fingerprint, Format, MapFile, Metadata, Provenance, ReadOptions};
use serde_json::Value;

use crate::args::{FormatArg, NonFiniteArg};
use crate::blending::Blending;
use crate::course::Course;
use crate::exemplars::{Backdrop, ExemplarArgs, Headers, Loaded};
use crate::explain::{self, explain};
use crate::failure::{Failure, shown};
use crate::harmonise::{Layout, widened};
use crate::inputs::{self, Input, ReadMap};
use crate::memory::{self, Resized};
use crate::outputs::{self, Outputs};
use crate::page;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::size::{Size, Tile};
use crate::stdio::STREAM;
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
    /// Quality of a JPEG file, 1 to 100.
    #[arg(long, value_name = "Q", value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) quality: Option<u8>,
    /// Make the output tile without a seam along x, y or both.
    #[arg(long, value_enum, value_name = "AXES")]
    pub(crate) tile: Option<Tile>,
    /// Write the source map: which exemplar sample stands at each place. See 'selvedge apply'.
    #[arg(long, value_name = "FILE.exr", value_hint = ValueHint::FilePath)]
    pub(crate) map: Option<PathBuf>,
    /// Write a picture of the seams and of where each part came from, for eyes.
    #[arg(long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    pub(crate) explain: Option<PathBuf>,
    /// Write a page about the run with its pictures inside: DIR/index.html. That of graphcut also shows what seams cost
    /// after refinements that changed something, evenly thinned to at most 25 pictures.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) report: Option<PathBuf>,
}

/// The size of an output that may have any.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Sizing {
    /// Size of the output: 512, 512x384, or a factor of the first exemplar such as 2x. Default: 2x, or the size of what
    /// the output starts from.
    #[arg(long, value_name = "SIZE")]
    size: Option<Size>,
}

impl Sizing {
    /// Height and width for a first exemplar of this shape.
    pub(crate) fn shape(self, exemplar: [u32; 2]) -> [u32; 2] {
        self.typed(exemplar).unwrap_or_else(|| Size::Factor(2.0).shape(exemplar))
    }

    /// The same, if it was asked for.
    pub(crate) fn typed(self, exemplar: [u32; 2]) -> Option<[u32; 2]> {
        Some(self.size?.shape(exemplar))
    }
}

/// What a command tells about itself before anything is read.
pub(crate) struct Plan<'p> {
    pub(crate) command: &'static str,
    /// Files that it reads besides the exemplars and their masks.
    pub(crate) others: Vec<PathBuf>,
    /// Shape and topology of the output for exemplars of these domains, the backdrop last.
    pub(crate) domain: &'p dyn Fn(&[Domain<2>]) -> Result<Domain<2>, Failure>,
    /// The exemplars' orientations.
    pub(crate) transforms: &'p [Transform],
    /// A picture that is one more exemplar, after all others and only as it is.
    pub(crate) backdrop: Option<Backdrop<'p>>,
    pub(crate) estimate: Estimate<'p>,
}

/// A run that was checked and whose exemplars were read.
pub(crate) struct Loom<'a> {
    pub(crate) session: &'a Session<'a>,
    args: &'a Weaving,
    format: Format,
    report: Report,
    pub(crate) loaded: Loaded,
    /// Shape and topology of the output.
    pub(crate) domain: Domain<2>,
    /// What was read besides the exemplars and their masks.
    others: Vec<Fingerprint>,
    /// The command and the seed that make the picture, where they are not this run's own.
    pub(crate) made_by: Option<(&'static str, u64)>,
}

/// What a method made, and how it is laid over the payload.
pub(crate) struct Outcome {
    pub(crate) woven: Box<dyn Render<2>>,
    /// False if it was interrupted.
    pub(crate) complete: bool,
    pub(crate) blending: Blending,
    /// Positions that no blending changes.
    pub(crate) kept: Option<Grid<bool, 2>>,
    /// The options as used.
    pub(crate) options: Used,
    pub(crate) stats: serde_json::Value,
    /// How it was made, for people.
    pub(crate) how: String,
    /// How its seams became cheaper, for the page of `--report`.
    pub(crate) course: Option<Course>,
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
        outputs::check(session, &self.files_written(session), &read)?;
        self.map.as_deref().map_or(Ok(()), outputs::check_map_name)?;
        self.report.as_deref().map_or(Ok(()), page::check)?;
        let headers = self.input.look(session, plan.backdrop)?;
        let domains = headers.domains();
        let domain = (plan.domain)(&domains)?;
        memory::check_caps(&session.limits, domain, resized).map_err(|refused| {
            // Where another exemplar would have another output, the exemplar is to blame for its size.
            let small: Vec<Domain<2>> = domains.iter().map(|_| Domain::open([1, 1])).collect();
            let follows = (plan.domain)(&small).is_ok_and(|other| other != domain);
            if follows { refused.about(&self.input.exemplars[0]) } else { refused }
        })?;
        headers.check_held((&self.output, format), domain.shape)?;
        if let Some(path) = &self.explain {
            let rgb = (Layout { colors: 3, alpha: false }, Depth::U8);
            outputs::check_held((path, outputs::format(path, None, None)?), domain.shape, rgb, None)?;
        }
        let only = self.input.exemplars.first().filter(|_| self.input.exemplars.len() == 1).map(PathBuf::as_path);
        let need = |domain| self.need(&headers, plan, domain);
        let needed = memory::check(&session.limits, only, domain, resized, &need)?;
        session.detail(&format!("memory: about {needed} of {}", Bytes(session.limits.memory)));
        let loaded = headers.load(session, plan.transforms, &mut report)?;
        report.estimate = Some(needed.0);
        report.stage("read");
        Ok(Loom { session, args: self, format, report, loaded, domain, others: Vec::new(), made_by: None })
    }

    /// An output of a shape, with the topology asked for.
    pub(crate) fn tiled(&self, shape: [u32; 2]) -> Domain<2> {
        Tile::domain(self.tile, shape)
    }

    /// How pictures are read.
    pub(crate) fn read_options(&self, session: &Session<'_>) -> ReadOptions {
        inputs::options(session.limits, Role::Color, self.input.nonfinite)
    }

    /// All files that a run may write, were it interrupted.
    fn files_written(&self, session: &Session<'_>) -> Vec<PathBuf> {
        let made = std::iter::once(&self.output).chain(&self.map);
        let kept = made.clone().filter(|_| session.global.keep_partial && self.output.as_os_str() != STREAM);
        let partial: Vec<PathBuf> = kept.map(|path| outputs::partial(path)).collect();
        let page = self.report.as_deref().map(page::checked);
        made.chain(&self.explain).cloned().chain(partial).chain(page).collect()
    }

    fn need(&self, headers: &Headers, plan: &Plan<'_>, domain: Domain<2>) -> Bytes {
        let (sources, resampled) = (headers.sources(plan.transforms), headers.resampled(plan.transforms));
        let (channels, depth) = (headers.layout.channels(), headers.depth);
        let colors = headers.layout.colors;
        let kept = memory::pictures(&headers.infos, channels, depth)
            + memory::masks(&headers.mask_infos)
            + memory::shown(&resampled, channels, depth);
        // Exemplars are read before they become sources, and a method begins when all are made.
        let read = memory::reading(headers.infos.iter().chain(&headers.mask_infos));
        let made = memory::making(&sources, colors);
        let explained = [self.explain.is_some(), self.report.is_some()].iter().filter(|&&wanted| wanted).count() as u64;
        let explained = memory::explained(explain::shape(domain.shape, sources.iter().map(|s| s.shape))) * explained;
        let method = Bytes((plan.estimate)(&sources, colors, domain));
        let written = memory::outputs(domain, channels, depth, self.map.is_some()) + explained;
        let worked = memory::sources(&sources, colors) + method.then(written);
        memory::PROGRAM + kept + read.then(made).max(worked)
    }
}

/// The same picture with alpha where the format has it: nothing shows where nothing stands in the map.
fn transparent_holes(plane: Plane<2>, map: &SourceMap<2>, format: Format) -> Result<Plane<2>, Failure> {
    let (shape, colors, depth) = (plane.domain().shape, plane.color_channels(), plane.samples.depth());
    if format.check(shape, colors, true, depth).is_err() {
        return Ok(plane);
    }
    let mut plane = widened(plane, Layout { colors, alpha: true })?;
    let holes = map.ids.plane(0).iter().map(|id| !id.is_assigned());
    match &mut plane.samples {
        Samples::U8(grid) => clear(grid.plane_mut(colors), holes),
        Samples::U16(grid) | Samples::F16(grid) => clear(grid.plane_mut(colors), holes),
        Samples::F32(grid) => clear(grid.plane_mut(colors), holes),
    }
    Ok(plane)
}

fn clear<T: Default>(alpha: &mut [T], holes: impl Iterator<Item = bool>) {
    alpha.iter_mut().zip(holes).filter(|(_, hole)| *hole).for_each(|(alpha, _)| *alpha = T::default());
}

/// Some methods answer with averages, which no map describes.
fn averaged() -> Failure {
    let what = "samples were averaged, so that there is no source map to write or to explain";
    Failure::new(2, what).remedy("leave --map, --explain and --report out")
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

    /// Notes a source map that was read.
    pub(crate) fn note(&mut self, map: &ReadMap) {
        self.report.inputs.push(map.entry.clone());
        self.others.push(map.fingerprint.clone());
    }

    /// The options as used, but for what a method chooses.
    pub(crate) fn used(&self) -> Used {
        let [h, w] = self.domain.shape;
        let used = self.session.options.clone().set("tile", Tile::of(self.domain).map(crate::args::typed_name));
        let used = if used.has("size") { used.set("size", format!("{w}x{h}")) } else { used };
        let used = if self.args.quality.is_none() { used.without("quality") } else { used };
        // It acts on odd pictures alone.
        if self.args.input.nonfinite == NonFiniteArg::Error { used.set("nonfinite", Value::Null) } else { used }
    }

    /// Ends a dry run: what would be done, in a line that begins with the output's name.
    pub(crate) fn would(mut self, options: Used, how: &str) -> Done {
        let [h, w] = self.domain.shape;
        let needed = Bytes(self.report.estimate.unwrap_or_default());
        let name = shown(&self.args.output);
        let line = format!("{name}: would be {w}x{h} px {how}, with about {needed} of memory");
        self.report.options = options;
        Done::would(self.report, line)
    }

    /// Renders what was woven, to be written; a run that was interrupted ends here.
    pub(crate) fn finish(mut self, outcome: Outcome) -> Result<Done, Failure> {
        self.session.watch.finish();
        self.report.stage("synthesis");
        self.report.options = outcome.options.clone();
        self.report.stats = outcome.stats.clone();
        let (output, map_file) = (self.args.output.clone(), self.args.map.clone());
        if !outcome.complete {
            return Err(self.interrupted(outcome, &output, map_file.as_deref()));
        }
        self.session.check_signal()?;
        let ([h, w], name, how) = (self.domain.shape, shown(&output), outcome.how.clone());
        let outputs = self.make(outcome, &output, map_file.as_deref(), Some(self.provenance()))?;
        let line = format!("{name}: {w}x{h} px {how}, in {:.2} s", self.report.elapsed());
        Ok(Done::made(self.report, line, outputs))
    }

    fn make(
        &mut self,
        outcome: Outcome,
        output: &Path,
        map_file: Option<&Path>,
        provenance: Option<Provenance>,
    ) -> Result<Outputs, Failure> {
        let payload: Vec<&Plane<2>> = self.loaded.payload.iter().collect();
        let Outcome { woven, blending, kept, complete, course, .. } = outcome;
        // What is not whole is not blended: holes would darken what is around them.
        let blending = if complete { blending } else { Blending::default() };
        let mut plane = match woven.as_map() {
            Some(map) => blending.render(map, self.loaded.exemplars.validity(), kept.as_ref(), &payload)?,
            None => woven.render(&payload)?,
        };
        // Beside the partial result black would be as good as any colour of it.
        if let (false, Some(map)) = (complete, woven.as_map()) {
            plane = transparent_holes(plane, map, self.format)?;
        }
        self.report.stage("render");
        let metadata = Metadata { provenance: provenance.clone(), ..self.loaded.metadata.clone() };
        let mut outputs = Outputs::with_quality(self.args.quality);
        outputs.picture(output, self.format, &plane, &metadata)?;
        // Of a partial result there is nothing to explain: it says not how it was made.
        let shown = provenance.as_ref().filter(|_| self.args.explain.is_some() || self.args.report.is_some());
        let shown = shown
            .map(|made| {
                Ok::<_, Failure>((made.command.clone(), explain(woven.as_map().ok_or_else(averaged)?, &plane)?))
            })
            .transpose()?;
        if let (Some(path), Some((_, explained))) = (&self.args.explain, &shown) {
            let metadata = Metadata { provenance: provenance.clone(), ..Metadata::default() };
            outputs.picture(path, outputs::format(path, None, None)?, explained, &metadata)?;
        }
        if let Some(path) = map_file {
            let metadata = Metadata { provenance, ..Metadata::default() };
            let map = woven.into_map().ok_or_else(averaged)?;
            outputs.map(path, &MapFile::new(map, self.loaded.fingerprints.clone(), metadata))?;
        }
        self.report.stage("encode");
        if let (Some(folder), Some((command, explained))) = (&self.args.report, &shown) {
            let page = self.page(command, &outputs, &[&plane, explained], course.as_ref())?;
            outputs.bytes(&page::file(folder), page.into_bytes());
        }
        Ok(outputs)
    }

    /// The page of `--report`.
    fn page(
        &self,
        command: &str,
        outputs: &Outputs,
        [picture, explained]: &[&Plane<2>; 2],
        course: Option<&Course>,
    ) -> Result<String, Failure> {
        let threads = rayon::current_num_threads();
        let mut run = self.report.json(self.session.global.seed, threads, false);
        run["outputs"] = outputs.noted().into();
        run["made"] = ["version", "seed", "threads", "peak_memory_bytes"]
            .into_iter()
            .map(|key| (key.to_owned(), run[key].clone()))
            .collect::<serde_json::Map<_, _>>()
            .into();
        let what = "Seams; the places that each part came from; the exemplars in the colours of those places";
        if let (Some(_), Some(stats)) = (course, run["stats"].as_object_mut()) {
            // Drawn, not listed.
            stats.remove("energy");
        }
        let course = course.map_or(Ok(String::new()), Course::html)?;
        page::page(&run, command, &[("The output", picture), (what, explained)], &course)
    }

    /// How the picture was made: nothing that differs between equal runs.
    fn provenance(&self) -> Provenance {
        let own = (self.report.command(), self.session.global.seed);
        let ((command, seed), options) = (self.made_by.unwrap_or(own), &self.report.options);
        Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            seed,
            inputs: self.loaded.all_fingerprints().into_iter().chain(self.others.iter().cloned()).collect(),
            command: options.clone().with("seed", seed).command(command, self.loaded.given()),
        }
    }

    /// Keeps the best so far if that is wanted. It says nothing of how it was made: no command makes it again.
    fn interrupted(&mut self, outcome: Outcome, output: &Path, map_file: Option<&Path>) -> Failure {
        let signal = self.session.watch.signal().unwrap_or(2);
        let failure = Failure::interrupted(signal);
        if !self.session.global.keep_partial || output.as_os_str() == STREAM {
            return failure;
        }
        let (output, map_file) = (outputs::partial(output), map_file.map(outputs::partial));
        let made = self.make(outcome, &output, map_file.as_deref(), None);
        match made.and_then(|outputs| outputs.write(self.session)) {
            Ok(()) => Failure::kept(signal, &output),
            Err(e) => e,
        }
    }
}
