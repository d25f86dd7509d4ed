//! What every command that weaves a picture from exemplars goes through before its method begins: sizes, budget,
//! reading. A command adds its options, its estimate, and its method.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use selvedge_analysis::Texture;
use selvedge_core::{Bytes, Depth, Domain, Payload, Transform};
use selvedge_io::Format;

use crate::backdrop::Backdrop;
use crate::blending::Blending;
use crate::exemplars::Headers;
use crate::failure::Failure;
use crate::ground::StartArgs;
use crate::harmonise::Layout;
use crate::loaded::ExemplarSet;
use crate::loom::{Before, Loom};
use crate::needs::{Needs, Share};
use crate::output_size::OutputSize;
use crate::planes::{Laying, PlaneHeaders, Ready, is_upright, warn_of_normals};
use crate::repairing::Repairing;
use crate::report::Report;
use crate::session::Session;
use crate::weaving::{Sizing, Weaving, Written};
use crate::{explain, eyes, inputs, memory, names, outputs, page};

/// What a command tells about itself before anything is read.
pub(crate) struct Setup<'a> {
    pub(crate) command: &'static str,
    /// The options of all commands that weave.
    pub(crate) weaving: Cow<'a, Weaving>,
    pub(crate) size: OutputSize<'a>,
    /// Files that it reads besides the exemplars and their masks.
    pub(crate) others: Vec<PathBuf>,
    /// Files that it writes besides those of all commands.
    pub(crate) writes: Vec<PathBuf>,
    /// The exemplars' orientations.
    pub(crate) transforms: Vec<Transform>,
    /// A picture that is one more exemplar, after all others and only as it is.
    pub(crate) backdrop: Option<Backdrop<'a>>,
    /// How seams are hidden.
    pub(crate) blending: Blending,
    /// How they are hidden in planes of --with, if not as in the picture.
    pub(crate) of_planes: Option<Blending>,
    /// How they are repaired before.
    pub(crate) repairing: Repairing,
    /// Whether some samples may be kept from blending.
    pub(crate) keeps: bool,
    /// Whether what is transparent is filled, so that a format without transparency may hold it: the plan
    /// refuses what is left.
    pub(crate) fills: bool,
    /// Pairs of guides that have weights, which come before those of planes that decide with the exemplars.
    pub(crate) guides: usize,
    /// Side of a square that an exemplar has to hold.
    pub(crate) block: Option<u32>,
    /// Files that the command was given where others are given their exemplars, if it was given more.
    pub(crate) files: Option<Vec<PathBuf>>,
}

/// The method's share of the memory: domains of the sources, feature channels, output domain.
pub(crate) type Estimate<'e> = &'e dyn Fn(&[Domain<2>], usize, Domain<2>, bool) -> Bytes;

impl<'a> Setup<'a> {
    /// Of a command that reads exemplars alone, as they are.
    pub(crate) fn new(command: &'static str, weaving: &'a Weaving, size: OutputSize<'a>) -> Self {
        Self {
            command,
            weaving: Cow::Borrowed(weaving),
            size,
            others: Vec::new(),
            writes: Vec::new(),
            transforms: vec![Transform::IDENTITY],
            backdrop: None,
            blending: Blending::default(),
            of_planes: None,
            repairing: Repairing::default(),
            keeps: false,
            fills: false,
            guides: 0,
            block: None,
            files: None,
        }
    }

    /// Of a command that may go on from what was there before.
    pub(crate) fn on(
        command: &'static str,
        weaving: &'a Weaving,
        sizing: Sizing,
        start: &'a StartArgs,
        session: &Session<'_>,
    ) -> Result<Self, Failure> {
        let size = OutputSize::Ground(start.ground(session)?.into(), sizing);
        let (others, backdrop) = (start.files(), start.backdrop());
        Ok(Self { others, backdrop, keeps: true, ..Self::new(command, weaving, size) })
    }

    /// Refuses what cannot be done, in the order in which it is cheap to see, and reads the exemplars.
    pub(crate) fn begin(self, session: &'a Session<'a>, estimate: Estimate<'_>) -> Result<Loom<'a>, Failure> {
        self.blending.validate()?;
        self.repairing.validate()?;
        let mut report = Report::new(self.command);
        let args = &self.weaving;
        let written = args.written();
        let format = outputs::format(&written.output, args.encoding.format(), args.input.conversion.depth())?;
        let exemplars = args.input.exemplars.len() + usize::from(self.backdrop.is_some());
        self.check_names(session, &written, exemplars)?;
        let weights = args.with.weights(self.guides, args.with.matched.len() / exemplars);
        let headers = args.input.look(session, self.backdrop)?.matching(session, &args.with.matched, &weights)?;
        let domain = self.sized(session, &headers.domains())?;
        headers.check_held((&written.output, format), domain.shape, self.fills)?;
        self.check_views(&written, &headers, domain)?;
        let layers = args.with.look(session, &self.laying(), &headers, &args.output, domain)?;
        let sources = headers.sources(&self.transforms);
        let needs = self.needs(&headers, &layers, domain, format);
        // What is turned freely has corners that show nothing.
        let free = self.transforms.iter().any(|transform| matches!(transform, Transform::Resampled { .. }));
        let masked = free || headers.layout.alpha || !headers.mask_infos.is_empty();
        let own = |domain| estimate(&sources, headers.channels(), domain, masked);
        let needed = needs.check(&session.limits, domain, &own)?;
        session.detail(&format!("memory: about {needed} of {}", Bytes(session.limits.memory)));
        session.watch.prepare(if self.transforms.len() == 1 { "read" } else { "read, turn" });
        let (loaded, layers) = self.read(session, headers, layers, &mut report)?;
        session.watch.prepare("measure");
        let domain = self.closed(session, &loaded, domain)?;
        report.estimate = Some(needed.0);
        report.stage("read");
        let (before, picture) = match self.size {
            OutputSize::Ground(ground, _) => (Some(ground as Box<dyn Before>), None),
            OutputSize::Picture(picture, _) => (None, Some(picture)),
            OutputSize::Upon(ground, picture, _) => (Some(ground as Box<dyn Before>), Some(picture)),
            OutputSize::Exemplar(_) | OutputSize::First(_) | OutputSize::Arranged(_) => (None, None),
        };
        Ok(Loom {
            session,
            args: self.weaving,
            written,
            format,
            report,
            loaded,
            layers,
            domain,
            others: Vec::new(),
            before,
            picture,
            blending: self.blending,
            unfused: None,
            repairing: self.repairing,
            made_by: None,
            files: self.files,
            needs,
        })
    }

    /// Refuses names and numbers of files that do not go together, before any is opened.
    fn check_names(&self, session: &Session<'_>, written: &Written, exemplars: usize) -> Result<(), Failure> {
        let args = &self.weaving;
        let read = args.input.files().into_iter().chain(self.others.iter().chain(args.with.files()).cloned());
        let read: Vec<PathBuf> = read.collect();
        inputs::check_streams(&read)?;
        self.check_number()?;
        args.with.validate(exemplars, self.guides)?;
        names::check_apart(&args.output, 1 + args.with.with.len() / exemplars)?;
        let writes = args.files_written(session, written, exemplars).into_iter().chain(self.writes.iter().cloned());
        outputs::check(session, &writes.collect::<Vec<_>>(), &read)?;
        written.map.as_deref().map_or(Ok(()), outputs::check_map_name)?;
        written.report.as_deref().map_or(Ok(()), page::check)
    }

    /// The output that follows from exemplars of these domains, within the caps.
    fn sized(&self, session: &Session<'_>, exemplars: &[Domain<2>]) -> Result<Domain<2>, Failure> {
        let args = &self.weaving;
        // Before the budget, which such a block would exceed as well.
        self.block.map_or(Ok(()), |block| check_block(block, exemplars)).map_err(|e| match self.only() {
            Some(path) => e.about(path),
            None => e,
        })?;
        let (domain, resized) = (self.size.domain(session, args, exemplars)?, self.size.resized());
        memory::check_caps(&session.limits, domain, resized).map_err(|refused| {
            if self.size.follows_exemplar() { refused.about(&args.input.exemplars[0]) } else { refused }
        })?;
        Ok(domain)
    }

    /// The exemplar, where there is one alone.
    fn only(&self) -> Option<&Path> {
        match &self.weaving.input.exemplars[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    /// Refuses pictures for eyes that their formats do not hold.
    fn check_views(&self, written: &Written, headers: &Headers, domain: Domain<2>) -> Result<(), Failure> {
        if let Some(path) = &written.explain {
            let rgb = (Layout { colors: 3, alpha: false }, Depth::U8);
            let sources = headers.sources(&self.transforms);
            let shape = explain::shape(domain.shape, sources.iter().map(|source| source.shape));
            let shape = shape.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
            outputs::check_held((path, outputs::format(path, None, None)?), shape, rgb, None)?;
        }
        let Some(path) = &written.preview else { return Ok(()) };
        if domain.periodic == [false; 2] {
            let failure = Failure::new(2, "would show how the output tiles, and it does not").about(path);
            return Err(failure.remedy("add --tile xy, or leave --preview out"));
        }
        let format = outputs::format(path, None, Some(Depth::U8))?;
        let (shape, layout) = (eyes::shape_tiled(domain), (headers.layout, Depth::U8));
        let first = self.weaving.input.exemplars.first().map(PathBuf::as_path);
        outputs::check_held((path, format), shape, layout, first)
    }

    /// Reads the exemplars, and the planes that are laid with them.
    fn read(
        &self,
        session: &Session<'_>,
        headers: Headers,
        layers: Vec<PlaneHeaders>,
        report: &mut Report,
    ) -> Result<(ExemplarSet, Vec<Ready>), Failure> {
        let loaded = headers.load(session, &self.transforms, report)?;
        if !self.transforms.iter().all(|transform| is_upright(*transform)) {
            for (path, plane) in loaded.given().iter().zip(&loaded.payload) {
                warn_of_normals(session, path, plane, "weave another plane, and lay this one --with it");
            }
        }
        let read = |looked: PlaneHeaders| {
            let ready = looked.read(session, report, &|_, _, _| {})?;
            ready.warn_of_normals(session, &self.transforms);
            Ok(ready)
        };
        Ok((loaded, layers.into_iter().map(read).collect::<Result<_, Failure>>()?))
    }

    /// Where a picture is gone on from, a bit a source says what may be copied where.
    fn check_number(&self) -> Result<(), Failure> {
        let sources = self.weaving.input.exemplars.len() * self.transforms.len();
        if self.backdrop.is_none() || sources < u64::BITS as usize {
            return Ok(());
        }
        let what = format!("{sources} exemplars and orientations are more than --over tells apart");
        Err(Failure::new(2, what).remedy(format!("use at most {}", u64::BITS - 1)))
    }

    /// True if the output's size may follow from the first exemplar's lattice.
    fn may_close(&self, domain: Domain<2>) -> bool {
        let as_it_is = self.transforms.iter().all(|&transform| transform == Transform::IDENTITY);
        domain.periodic != [false; 2] && as_it_is && self.size.is_free()
    }

    /// What tiles has to close the first exemplar's lattice, or it is torn where it wraps. A size that was typed in
    /// pixels stays, and the nearest that closes is named; any other becomes the next smaller one that does, which is
    /// told.
    fn closed(&self, session: &Session<'_>, loaded: &ExemplarSet, domain: Domain<2>) -> Result<Domain<2>, Failure> {
        if !self.may_close(domain) {
            return Ok(domain);
        }
        let source = &loaded.exemplars.sources()[0];
        let texture = Texture::of(&source.features, source.valid.as_deref(), loaded.exemplars.weights())?;
        let Some(lattice) = texture.order() else { return Ok(domain) };
        let follows = self.size.follows_exemplar();
        let side = |axis: usize| match domain.shape[axis] {
            side if domain.periodic[axis] && follows => lattice.closing_within(axis, side),
            side if domain.periodic[axis] => lattice.closing(axis, side),
            side => side,
        };
        let ([height, width], closed) = (domain.shape, [side(0), side(1)]);
        if closed == domain.shape {
            return Ok(domain);
        }
        let closing = format!("{}x{}", closed[1], closed[0]);
        if follows {
            session.say(&format!("size: {closing} px, which closes the exemplar's lattice, not {width}x{height}"));
            return Ok(Domain { shape: closed, ..domain });
        }
        let what = format!("its lattice may be torn where {width}x{height} px wrap; {closing} px close it");
        session.warn(&self.weaving.input.exemplars[0], &what);
        Ok(domain)
    }

    /// How planes of --with are laid.
    fn laying(&self) -> Laying<'_> {
        let args = &self.weaving;
        Laying {
            roles: &args.with.role,
            depth: args.input.conversion.depth(),
            format: args.encoding.format(),
            exposure: args.input.conversion.exposure,
            nonfinite: args.input.nonfinite.into(),
            blending: self.of_planes.unwrap_or(self.blending),
            copy: args.with.copy,
        }
    }

    fn needs(&self, headers: &Headers, layers: &[PlaneHeaders], output: Domain<2>, format: Format) -> Needs {
        let (sources, shown) = (headers.sources(&self.transforms), headers.shown(&self.transforms));
        let (channels, depth, features) = (headers.layout.channels(), headers.depth, headers.channels());
        let matched: Vec<_> = headers.matched_infos().cloned().collect();
        // Planes that decide may have four channels, and depths of their own.
        let matched_held: Bytes =
            matched.iter().map(|info| memory::pictures(std::slice::from_ref(info), 4, info.depth)).sum();
        let kept = memory::pictures(&headers.infos, channels, depth)
            + memory::masks(&headers.mask_infos)
            + Payload::bytes(&shown, channels, depth)
            + layers.iter().map(PlaneHeaders::read_bytes).sum();
        // Exemplars are read before they become sources, and a method begins when all are made.
        let read = memory::reading(headers.infos.iter().chain(&headers.mask_infos).chain(&matched))
            .max(layers.iter().map(PlaneHeaders::reading_bytes).max().unwrap_or_default());
        let making = memory::making(&sources, features) + matched_held + headers.light_bytes(&sources);
        let args = &self.weaving;
        let explained = [args.explain.is_some(), args.report.is_some()].iter().filter(|&&wanted| wanted).count() as u64;
        let shape = |domain: Domain<2>| explain::shape(domain.shape, sources.iter().map(|s| s.shape));
        let explained = |domain| memory::explained(shape(domain)) * explained;
        let twice = |domain| if args.preview.is_some() { eyes::tiled_bytes(domain, channels) } else { Bytes(0) };
        let laid = |layer: &PlaneHeaders, domain| layer.laid_bytes(domain, &shown, self.keeps);
        let written = |domain| {
            let laid = layers.iter().map(|layer| laid(layer, domain)).max().unwrap_or_default();
            let made = layers.iter().map(|layer| layer.made_bytes(domain)).sum();
            memory::outputs(domain, (channels, depth), format, args.map.is_some())
                + explained(domain)
                + laid
                + made
                + twice(domain)
        };
        // Where it closes, the lattice of the first is looked for before anything is planned.
        let masked = headers.layout.alpha || !headers.mask_infos.is_empty();
        let looked = sources.first().filter(|_| self.may_close(output));
        let looked =
            looked.map(|first| selvedge_analysis::estimate_texture(*first, features, masked)).unwrap_or_default();
        let held = memory::sources(&sources, features);
        Needs {
            kept,
            reading: read.then(making).then(held + looked),
            sources: held,
            blended: Share::of(output, |domain| self.blending.bytes(domain, headers.layout.colors + 1, self.keeps)),
            written: Share::of(output, written),
            exemplar: args.input.exemplars.first().filter(|_| args.input.exemplars.len() == 1).cloned(),
            resized: self.size.resized(),
        }
    }
}

/// Refuses a block that no exemplar holds.
fn check_block(block: u32, exemplars: &[Domain<2>]) -> Result<(), Failure> {
    let side = |domain: &&Domain<2>| domain.shape[0].min(domain.shape[1]);
    let Some(largest) = exemplars.iter().max_by_key(side) else { return Ok(()) };
    let (limit, [height, width]) = (side(&largest), largest.shape);
    if block <= limit {
        return Ok(());
    }
    let error = selvedge_quilting::Error::BlockExceedsExemplar { block, width, height, limit };
    Err(Failure::from(error).remedy(format!("use --block {limit} or a larger exemplar")))
}
