//! What every command that weaves a picture from exemplars goes through: sizes, budget, reading, and writing what came
//! out. A command adds its options, its estimate, and its method.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Depth, Domain, Role, Transform};
use selvedge_io::{Format, ReadOptions};

use crate::args::FormatArg;
use crate::blending::Blending;
use crate::exemplars::{Backdrop, ExemplarArgs, Headers};
use crate::failure::Failure;
use crate::harmonise::Layout;
use crate::inputs;
pub(crate) use crate::loom::{Loom, Outcome};
use crate::memory::{self, Resized};
use crate::planes::{Laying, Looked, is_upright, warn_of_normals};
use crate::report::Report;
use crate::session::Session;
use crate::size::{Size, Tile};
use crate::stdio::STREAM;
use crate::with::With;
use crate::{explain, names, outputs, page};

/// Options of the commands that weave a picture of a chosen size.
#[derive(Args, Clone, Debug)]
pub(crate) struct Weaving {
    #[command(flatten)]
    pub(crate) input: ExemplarArgs,
    #[command(flatten)]
    pub(crate) with: With,
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
    /// How seams are hidden, and whether some samples are kept from it.
    pub(crate) blending: (Blending, bool),
    /// Weights that come before those of planes that decide with the exemplars.
    pub(crate) guides: usize,
    pub(crate) estimate: Estimate<'p>,
}

/// Files that a run writes, by the names that they get.
#[derive(Clone, Debug)]
pub(crate) struct Written {
    pub(crate) output: PathBuf,
    pub(crate) map: Option<PathBuf>,
    pub(crate) explain: Option<PathBuf>,
    pub(crate) report: Option<PathBuf>,
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
        let written = self.written();
        let format =
            outputs::format(&written.output, self.format.map(Format::from), self.input.depth.map(Depth::from))?;
        let read = self.input.files().into_iter().chain(plan.others.iter().chain(self.with.files()).cloned());
        let read: Vec<PathBuf> = read.collect();
        inputs::check_streams(&read)?;
        let exemplars = self.input.exemplars.len() + usize::from(plan.backdrop.is_some());
        self.with.validate(exemplars, plan.guides)?;
        names::check_apart(&self.output, 1 + self.with.with.len() / exemplars)?;
        outputs::check(session, &self.files_written(session, &written, exemplars), &read)?;
        written.map.as_deref().map_or(Ok(()), outputs::check_map_name)?;
        written.report.as_deref().map_or(Ok(()), page::check)?;
        let weights = self.with.weights(plan.guides, self.with.matched.len() / exemplars);
        let headers = self.input.look(session, plan.backdrop)?.matching(session, &self.with.matched, &weights)?;
        let domains = headers.domains();
        let domain = (plan.domain)(&domains)?;
        memory::check_caps(&session.limits, domain, resized).map_err(|refused| {
            // Where another exemplar would have another output, the exemplar is to blame for its size.
            let small: Vec<Domain<2>> = domains.iter().map(|_| Domain::open([1, 1])).collect();
            let follows = (plan.domain)(&small).is_ok_and(|other| other != domain);
            if follows { refused.about(&self.input.exemplars[0]) } else { refused }
        })?;
        headers.check_held((&written.output, format), domain.shape)?;
        if let Some(path) = &written.explain {
            let rgb = (Layout { colors: 3, alpha: false }, Depth::U8);
            outputs::check_held((path, outputs::format(path, None, None)?), domain.shape, rgb, None)?;
        }
        let layers = self.with.look(session, &self.laying(plan), &headers, &self.output, domain)?;
        let only = self.input.exemplars.first().filter(|_| self.input.exemplars.len() == 1).map(PathBuf::as_path);
        let need = |domain| self.need(&headers, &layers, plan, domain);
        let needed = memory::check(&session.limits, only, domain, resized, &need)?;
        session.detail(&format!("memory: about {needed} of {}", Bytes(session.limits.memory)));
        let loaded = headers.load(session, plan.transforms, &mut report)?;
        if !plan.transforms.iter().all(|transform| is_upright(*transform)) {
            for (path, plane) in loaded.given().iter().zip(&loaded.payload) {
                warn_of_normals(session, path, plane, "weave another plane, and lay this one --with it");
            }
        }
        let read = |looked: Looked| {
            let ready = looked.read(session, &mut report, &|_, _, _| {})?;
            ready.warn_of_normals(session, plan.transforms);
            Ok(ready)
        };
        let layers = layers.into_iter().map(read).collect::<Result<Vec<_>, Failure>>()?;
        report.estimate = Some(needed.0);
        report.stage("read");
        let (others, blending) = (Vec::new(), plan.blending.0);
        Ok(Loom {
            session,
            args: self,
            written,
            format,
            report,
            loaded,
            layers,
            domain,
            others,
            blending,
            made_by: None,
            files: None,
        })
    }

    /// The names of what is written: those of the first exemplar are filled in.
    fn written(&self) -> Written {
        let named = |path: &PathBuf| names::of_plane(path, &self.input.exemplars[0]);
        let maybe = |path: &Option<PathBuf>| path.as_ref().map(named);
        let (map, explain, report) = (maybe(&self.map), maybe(&self.explain), maybe(&self.report));
        Written { output: named(&self.output), map, explain, report }
    }

    /// How planes of --with are laid.
    fn laying(&self, plan: &Plan<'_>) -> Laying<'_> {
        Laying {
            roles: &self.with.role,
            depth: self.input.depth.map(Depth::from),
            format: self.format.map(Format::from),
            nonfinite: self.input.nonfinite,
            blending: plan.blending.0,
            copy: self.with.copy,
        }
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
    fn files_written(&self, session: &Session<'_>, written: &Written, exemplars: usize) -> Vec<PathBuf> {
        let layers = self.with.with.chunks(exemplars).map(|planes| names::of_plane(&self.output, &planes[0]));
        let made: Vec<PathBuf> =
            std::iter::once(written.output.clone()).chain(layers).chain(written.map.clone()).collect();
        let keeps = session.global.keep_partial && self.output.as_os_str() != STREAM;
        let partial: Vec<PathBuf> = made.iter().filter(|_| keeps).map(|path| outputs::partial(path)).collect();
        let page = written.report.as_deref().map(page::checked);
        made.into_iter().chain(written.explain.clone()).chain(partial).chain(page).collect()
    }

    fn need(&self, headers: &Headers, layers: &[Looked], plan: &Plan<'_>, domain: Domain<2>) -> Bytes {
        let (sources, resampled) = (headers.sources(plan.transforms), headers.resampled(plan.transforms));
        let (channels, depth, features) = (headers.layout.channels(), headers.depth, headers.channels());
        let matched: Vec<_> = headers.matched_infos().cloned().collect();
        let exemplars = memory::exemplars(&headers.infos, depth)
            + memory::pictures(&matched, depth)
            + memory::sources(&sources, features)
            + memory::shown(&resampled, channels, depth)
            + layers.iter().map(Looked::read_bytes).sum();
        let explained = [self.explain.is_some(), self.report.is_some()].iter().filter(|&&wanted| wanted).count() as u64;
        let explained = memory::explained(explain::shape(domain.shape, sources.iter().map(|s| s.shape))) * explained;
        let (blending, kept) = plan.blending;
        let method = (plan.estimate)(&sources, features, domain);
        let method = Bytes(method.saturating_add(blending.memory(domain, headers.layout.colors + 1, kept)));
        let laid = layers.iter().map(|layer| layer.laid_bytes(domain, &resampled, kept)).max().unwrap_or_default();
        let made = layers.iter().map(|layer| layer.made_bytes(domain)).sum();
        let outputs = memory::outputs(domain, channels, depth, self.map.is_some()) + explained;
        exemplars + method.then(outputs + laid + made)
    }
}
