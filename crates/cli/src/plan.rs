//! What every command that weaves a picture from exemplars goes through before its method begins: sizes, budget, reading.
//! A command adds its options, its estimate, and its method.

use std::path::PathBuf;

use selvedge_core::{Bytes, Depth, Domain, Transform};
use selvedge_io::Format;

use crate::backdrop::Backdrop;
use crate::blending::Blending;
use crate::exemplars::Headers;
use crate::failure::Failure;
use crate::harmonise::Layout;
use crate::loom::Loom;
use crate::memory::{self, Resized};
use crate::planes::{Laying, Looked, is_upright, warn_of_normals};
use crate::report::Report;
use crate::session::Session;
use crate::weaving::Weaving;
use crate::{explain, inputs, names, outputs, page};

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

    fn need(&self, headers: &Headers, layers: &[Looked], plan: &Plan<'_>, domain: Domain<2>) -> Bytes {
        let (sources, resampled) = (headers.sources(plan.transforms), headers.resampled(plan.transforms));
        let (channels, depth, features) = (headers.layout.channels(), headers.depth, headers.channels());
        let matched: Vec<_> = headers.matched_infos().cloned().collect();
        // Planes that decide may have four channels, and depths of their own.
        let matched_held: Bytes =
            matched.iter().map(|info| memory::pictures(std::slice::from_ref(info), 4, info.depth)).sum();
        let kept = memory::pictures(&headers.infos, channels, depth)
            + memory::masks(&headers.mask_infos)
            + memory::shown(&resampled, channels, depth)
            + layers.iter().map(Looked::read_bytes).sum();
        // Exemplars are read before they become sources, and a method begins when all are made.
        let read = memory::reading(headers.infos.iter().chain(&headers.mask_infos).chain(&matched))
            .max(layers.iter().map(Looked::reading_bytes).max().unwrap_or_default());
        let making = memory::making(&sources, features) + matched_held;
        let explained = [self.explain.is_some(), self.report.is_some()].iter().filter(|&&wanted| wanted).count() as u64;
        let explained = memory::explained(explain::shape(domain.shape, sources.iter().map(|s| s.shape))) * explained;
        let (blending, keeps) = plan.blending;
        let method = (plan.estimate)(&sources, features, domain);
        let method = Bytes(method.saturating_add(blending.memory(domain, headers.layout.colors + 1, keeps)));
        let laid = layers.iter().map(|layer| layer.laid_bytes(domain, &resampled, keeps)).max().unwrap_or_default();
        let made = layers.iter().map(|layer| layer.made_bytes(domain)).sum();
        let written = memory::outputs(domain, channels, depth, self.map.is_some()) + explained + laid + made;
        let worked = memory::sources(&sources, features) + method.then(written);
        memory::PROGRAM + kept + read.then(making).max(worked)
    }
}
