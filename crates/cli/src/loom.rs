//! A run whose exemplars were read: what a method makes of them is rendered, laid over other planes, and written.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use selvedge_core::{Bytes, Domain, Grid, Plane, Role, SourceMap, Start};
use selvedge_io::{Fingerprint, Format, MapFile, Metadata, Provenance};
use serde_json::Value;

use crate::blending::Blending;
use crate::course::Course;
use crate::explain::{LEGEND, explain};
use crate::eyes;
use crate::failure::{Failure, n, shown};
use crate::harmonise::{Layout, hidden, widened};
use crate::inputs::{self, Input, ReadMap};
use crate::loaded::ExemplarSet;
use crate::made;
use crate::memory;
use crate::needs::Needs;
use crate::outcome::{MadeBy, Outcome};
use crate::outputs::{self, Outputs};
use crate::page;
use crate::planes::{Ready, roles_typed};
use crate::repairing::Repairing;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::sheet;
use crate::size::Tile;
use crate::stdio::STREAM;
use crate::used::Used;
use crate::weaving::{Weaving, Written};
use crate::with::without_planes;

/// A run that was checked and whose exemplars were read.
pub(crate) struct Loom<'a> {
    pub(crate) session: &'a Session<'a>,
    pub(crate) args: Cow<'a, Weaving>,
    pub(crate) written: Written,
    pub(crate) format: Format,
    pub(crate) report: Report,
    pub(crate) loaded: ExemplarSet,
    /// Planes of --with.
    pub(crate) layers: Vec<Ready>,
    /// Shape and topology of the output.
    pub(crate) domain: Domain<2>,
    /// What was read besides the exemplars and their masks.
    pub(crate) others: Vec<Fingerprint>,
    /// What the output goes on from, until it is asked for.
    pub(crate) before: Option<Box<dyn Before>>,
    /// The picture that the output has the size of, until it is read.
    pub(crate) picture: Option<Input>,
    /// How seams are hidden.
    pub(crate) blending: Blending,
    /// Where they are not, though they are fused elsewhere.
    pub(crate) unfused: Option<Grid<bool, 2>>,
    /// How they are repaired before.
    pub(crate) repairing: Repairing,
    /// What makes the picture, where it is not this run's own command.
    pub(crate) made_by: Option<MadeBy>,
    /// Files that the command was given where others are given their exemplars, if it was given more.
    pub(crate) files: Option<Vec<PathBuf>>,
    /// What the run takes beside the method.
    pub(crate) needs: Needs,
}

/// What an output goes on from, whichever kind of thing it is.
pub(crate) trait Before {
    /// What stands, and what of it stays.
    fn start(self: Box<Self>, loom: &mut Loom<'_>) -> Result<Start<2>, Failure>;

    /// The map alone, if there is one.
    fn map(self: Box<Self>, loom: &mut Loom<'_>) -> Result<Option<SourceMap<2>>, Failure>;
}

/// The same picture with alpha where the format has it: nothing shows where nothing stands in the map.
fn transparent_holes(plane: Plane<2>, map: &SourceMap<2>, format: Format) -> Result<Plane<2>, Failure> {
    let (shape, colors, depth) = (plane.domain().shape, plane.color_channels(), plane.samples.depth());
    if format.check(shape, colors, true, depth).is_err() {
        return Ok(plane);
    }
    hidden(plane, |i| !map.ids.plane(0)[i].is_assigned())
}

/// Some methods answer with averages, which no map describes.
fn averaged() -> Failure {
    let what = "samples were averaged, so that there is no source map to write or to explain";
    Failure::new(2, what).remedy("leave --map and --explain out")
}

impl Loom<'_> {
    /// The picture to write.
    pub(crate) fn output(&self) -> &Path {
        &self.written.output
    }

    /// What the output goes on from, and what of it stays.
    pub(crate) fn start(&mut self) -> Result<Start<2>, Failure> {
        if let Some(before) = self.before.take() {
            return before.start(self);
        }
        Ok(Start::empty(&self.loaded.exemplars, self.domain)?)
    }

    /// The map that the output goes on from, if there is one.
    pub(crate) fn start_map(&mut self) -> Result<Option<SourceMap<2>>, Failure> {
        self.before.take().map_or(Ok(None), |before| before.map(self))
    }

    /// Reads a file besides the exemplars, which may be the picture that the output has the size of.
    pub(crate) fn open(&mut self, path: &Path) -> Result<Plane<2>, Failure> {
        let known = self.picture.take_if(|picture| picture.path == path);
        self.read(&known.map_or_else(|| Input::new(self.session, path), Ok)?)
    }

    /// Reads a picture besides the exemplars.
    pub(crate) fn read(&mut self, input: &Input) -> Result<Plane<2>, Failure> {
        let picture = input.read(self.session, &self.args.read_options(self.session), &mut self.report)?;
        self.others.push(inputs::fingerprint(&input.path, &picture));
        Ok(picture.plane)
    }

    /// Domains of all sources, and their feature channels.
    pub(crate) fn sources(&self) -> (Vec<Domain<2>>, usize) {
        let exemplars = &self.loaded.exemplars;
        (exemplars.domains(), exemplars.channels())
    }

    /// Refuses a run that takes too much with what was chosen for it: the method's `bytes` for an output.
    pub(crate) fn admit(&self, bytes: &dyn Fn(Domain<2>) -> Bytes) -> Result<Bytes, Failure> {
        let needed = self.needs.check(&self.session.limits, self.domain, bytes)?;
        self.session.detail(&format!("memory: about {needed} of {}", Bytes(self.session.limits.memory)));
        Ok(needed)
    }

    /// Refuses a run that takes so many bytes more than was known before anything was read, where there is no room.
    pub(crate) fn admit_more(&mut self, more: Bytes) -> Result<(), Failure> {
        let needed = self.report.estimate.unwrap_or_default().saturating_add(more.0);
        memory::check_fixed(&self.session.limits, Bytes(needed))?;
        self.report.estimate = Some(needed);
        Ok(())
    }

    /// The output has another shape than was known before the exemplars were read. It is admitted again, with the
    /// method's `bytes` for it.
    pub(crate) fn lay(&mut self, shape: [u32; 2], bytes: impl Fn(Domain<2>) -> Bytes) -> Result<(), Failure> {
        let (domain, plane) = (Domain { shape, ..self.domain }, &self.loaded.payload[0]);
        let depth = plane.samples.depth();
        let layout = Layout { colors: plane.color_channels(), alpha: plane.alpha };
        outputs::check_held((&self.written.output, self.format), shape, (layout, depth), None)?;
        let needed = |domain: Domain<2>| {
            let made = memory::outputs(domain, (layout.channels(), depth), self.format, self.written.map.is_some());
            bytes(domain) + made + self.blending.bytes(domain, layout.channels(), false)
        };
        let more = needed(domain).0.saturating_sub(needed(self.domain).0);
        let all = Bytes(self.report.estimate.unwrap_or_default().saturating_add(more));
        self.session.limits.admit(domain, all)?;
        self.report.estimate = Some(all.0);
        self.domain = domain;
        Ok(())
    }

    /// Notes a source map that was read.
    pub(crate) fn note(&mut self, map: &ReadMap) {
        self.report.inputs.push(map.entry.clone());
        self.others.push(map.fingerprint.clone());
    }

    /// The options as used, but for what a method chooses; of most of those that do nothing in this run, none.
    pub(crate) fn used(&self) -> Used {
        let [h, w] = self.domain.shape;
        let used = self.session.options.clone().set("tile", Tile::of(self.domain).map(crate::args::typed_name));
        let used = if used.has("size") { used.set("size", format!("{w}x{h}")) } else { used };
        let used = self.args.input.used_if_any(used.unless("quality", Value::Null).unless("blend-in", 0));
        let used = if used.has("repair") { self.repairing.used_if_any(used) } else { used };
        let used = if used.has("fuse") { self.blending.used_if_any(used) } else { used };
        let planes: Vec<PathBuf> = self.layers.iter().flat_map(|ready| ready.layer.planes.clone()).collect();
        let roles: Vec<Role> = self.layers.iter().flat_map(|ready| ready.layer.roles.clone()).collect();
        self.args.with.used(used, roles_typed(&planes, &roles))
    }

    /// Ends a dry run: what would be done, in a line that begins with the output's name.
    pub(crate) fn would(mut self, options: Used, how: &str) -> Done {
        let [h, w] = self.domain.shape;
        let needed = Bytes(self.report.estimate.unwrap_or_default());
        let name = self.names();
        let line = format!("{name}: would be {w}x{h} px {how}, with about {needed} of memory");
        self.report.options = options;
        let layers = self.layers.iter().map(|ready| &ready.layer.output);
        let pictures = std::iter::once(&self.written.output).chain(layers).chain(&self.written.map);
        let planned = pictures.map(|path| outputs::planned(path, [h, w])).collect();
        Done::would(self.report, line, planned)
    }

    /// Renders what was woven, to be written; a run that was interrupted ends here.
    pub(crate) fn finish(mut self, used: Used, mut outcome: Outcome) -> Result<Done, Failure> {
        self.session.watch.busy(self.blending.name());
        self.report.stage("synthesis");
        self.made_by = outcome.made_by.take();
        self.report.options = self.made_by.as_ref().map_or(used, |made| made.options.clone());
        self.report.stats = outcome.stats.clone();
        if !outcome.complete {
            return Err(self.interrupted(outcome));
        }
        self.session.check_signal()?;
        let ([h, w], name, how) = (self.domain.shape, self.names(), outcome.how.clone());
        let outputs = self.make(outcome)?;
        self.session.watch.finish();
        let line = format!("{name}: {w}x{h} px {how}, in {:.2} s", self.report.elapsed());
        Ok(Done::made(self.report, line, outputs))
    }

    /// Names of the pictures, for people.
    fn names(&self) -> String {
        let layers = self.layers.iter().map(|ready| &ready.layer.output);
        let all: Vec<String> = std::iter::once(&self.written.output).chain(layers).map(|path| shown(path)).collect();
        all.join(", ")
    }

    /// Refuses outputs that cannot tell so many pixels that show nothing from black ones.
    pub(crate) fn check_holes(&self, holes: usize) -> Result<(), Failure> {
        let plane = &self.loaded.payload[0];
        let own = (&self.written.output, self.format, plane);
        let layers = self.layers.iter().map(|ready| (&ready.layer.output, ready.layer.format, &ready.planes[0]));
        for (path, format, plane) in std::iter::once(own).chain(layers).filter(|_| 0 < holes) {
            let (colors, depth) = (plane.color_channels(), plane.samples.depth());
            if format.check(self.domain.shape, colors, true, depth).is_err() {
                let what =
                    format!("{} are in none of the pictures, and {format} holds no transparency", n("pixel", holes));
                return Err(Failure::new(3, what).about(path).remedy("write a PNG file, or lay more pictures"));
            }
        }
        Ok(())
    }

    /// True if somebody will see what else a method has to show.
    pub(crate) fn is_explained(&self) -> bool {
        self.written.explain.is_some() || self.written.report.is_some()
    }

    fn make(&mut self, mut outcome: Outcome) -> Result<Outputs, Failure> {
        outcome.keep(self.unfused.take());
        let plane = self.picture(&outcome)?;
        let Outcome { woven, kept, holes, complete, course, how, others, after, beside, .. } = outcome;
        // What is not whole does not say how it was made: no command makes it again.
        let provenance = complete.then(|| self.provenance());
        let told = || Metadata { provenance: provenance.clone(), ..Metadata::default() };
        // Black would be as good as any colour of the picture.
        let bare = woven.as_map().filter(|_| holes || !complete);
        let transparent = |plane, format| match bare {
            Some(map) => transparent_holes(plane, map, format),
            None => Ok(plane),
        };
        let mut plane = self.held(transparent(plane, self.format)?)?;
        after.map_or(Ok(()), |after| after(&mut plane))?;
        self.report.stage("render");
        self.session.watch.busy("encode");
        let metadata = Metadata { provenance: provenance.clone(), ..self.loaded.metadata.clone() };
        let mut outputs = Outputs::with_quality(self.args.encoding.quality);
        let name = |path: &PathBuf| if complete { path.clone() } else { outputs::partial(path) };
        outputs.picture(&name(&self.written.output), self.format, &plane, &metadata)?;
        for mut ready in std::mem::take(&mut self.layers) {
            ready.layer.blending = ready.layer.blending.of_whole(complete);
            self.session.watch.busy(ready.layer.blending.name());
            let laid = ready.rendered(&*woven, self.loaded.exemplars.validity(), kept.as_ref())?;
            let laid = transparent(laid, ready.layer.format)?;
            let provenance = complete.then(|| self.provenance_of(&ready));
            let metadata = Metadata { provenance, ..ready.metadata };
            outputs.picture(&name(&ready.layer.output), ready.layer.format, &laid, &metadata)?;
        }
        // Of a partial result there is nothing to explain.
        let explains = complete && self.is_explained();
        let explained = woven.as_map().filter(|_| explains).map(|map| explain(map, &plane)).transpose()?;
        if let Some(path) = self.written.explain.as_ref().filter(|_| complete) {
            let explained = explained.as_ref().ok_or_else(averaged)?;
            let pictures = &beside.pictures;
            let all = if pictures.is_empty() { None } else { Some(sheet::below(explained, pictures)?) };
            outputs.view(path, all.as_ref().unwrap_or(explained), &told())?;
        }
        if let (Some(path), true) = (&self.written.preview, complete) {
            outputs.view(path, &eyes::tiled(&plane, self.domain)?, &told())?;
        }
        for (path, plane) in others.iter().filter(|_| complete) {
            outputs.view(path, plane, &told())?;
        }
        if let Some(path) = &self.written.map {
            let map = woven.into_map().ok_or_else(averaged)?;
            outputs.map(&name(path), &MapFile::new(map, self.loaded.fingerprints.clone(), told()))?;
        }
        self.report.stage("encode");
        if let (Some(folder), Some(made)) = (&self.written.report, &provenance) {
            let course = course.as_ref().map_or(Ok(String::new()), Course::html)?;
            let course = course + &page::gallery(beside.heading, &beside.pictures)?;
            let page = self.page((&made.command, &how), &outputs, (&plane, explained.as_ref()), &course)?;
            outputs.bytes(&page::file(folder), page.into_bytes());
        }
        Ok(outputs)
    }

    /// The picture without its alpha, where its format has none: it is opaque then.
    fn held(&self, plane: Plane<2>) -> Result<Plane<2>, Failure> {
        let (shape, colors, depth) = (plane.domain().shape, plane.color_channels(), plane.samples.depth());
        let is_held = !plane.alpha || self.format.check(shape, colors, true, depth).is_ok();
        if is_held { Ok(plane) } else { widened(plane, Layout { colors, alpha: false }) }
    }

    /// The exemplars' own picture of what was woven.
    fn picture(&self, outcome: &Outcome) -> Result<Plane<2>, Failure> {
        let blending = self.blending.of_whole(outcome.complete);
        let payload: Vec<&Plane<2>> = self.loaded.payload.iter().collect();
        let Some(map) = outcome.woven.as_map() else { return Ok(outcome.woven.render(&payload)?) };
        let (valid, kept) = (self.loaded.exemplars.validity(), outcome.kept.as_ref());
        blending.render_around_holes(map, valid, kept, (&payload, outcome.holes))
    }

    /// The page of `--report`.
    fn page(
        &self,
        (command, how): (&str, &str),
        outputs: &Outputs,
        (picture, explained): (&Plane<2>, Option<&Plane<2>>),
        course: &str,
    ) -> Result<String, Failure> {
        let threads = rayon::current_num_threads();
        let mut run = self.report.json(&[self.session.global.seed()], threads, false);
        run["outputs"] = outputs.noted().into();
        let [height, width] = self.domain.shape;
        run["summary"] = format!("{width}x{height} px {how}").into();
        run["made"] = ["version", "seed", "threads", "peak_memory_bytes"]
            .into_iter()
            .map(|key| (key.to_owned(), run[key].clone()))
            .collect::<serde_json::Map<_, _>>()
            .into();
        let what = "Seams; the places that each part came from; the exemplars in the colours of those places";
        if let (false, Some(stats)) = (course.is_empty(), run["stats"].as_object_mut()) {
            // Drawn, not listed.
            stats.retain(|name, _| !matches!(name.as_str(), "energy" | "candidates"));
        }
        let names: Vec<String> = self.loaded.paths.iter().map(|path| format!("Exemplar {}", shown(path))).collect();
        let exemplars = names.iter().map(String::as_str).zip(&self.loaded.payload);
        let made = [("The output", picture)].into_iter().chain(explained.map(|explained| (what, explained)));
        let pictures: Vec<_> = made.chain(exemplars).collect();
        let legend = explained.map_or_else(String::new, |_| page::swatches(&LEGEND));
        page::page(&run, command, &pictures, &(legend + course))
    }

    /// How the picture was made: nothing that differs between equal runs.
    fn provenance(&self) -> Provenance {
        self.made(without_planes(self.report.options.clone()), &[])
    }

    /// How the output of a plane of --with was made.
    fn provenance_of(&self, ready: &Ready) -> Provenance {
        let planes: Vec<String> = ready.layer.planes.iter().map(|path| selvedge_io::display_name(path)).collect();
        let own = self.report.options.clone().set("with", planes).set("role", ready.layer.roles_typed());
        self.made(own, &ready.fingerprints)
    }

    fn made(&self, options: Used, planes: &[Fingerprint]) -> Provenance {
        let own = (self.report.command(), self.session.global.seed());
        let (command, seed) = self.made_by.as_ref().map_or(own, |made| (made.command, made.seed));
        let inputs = self.loaded.all_fingerprints().into_iter().chain(self.others.iter().chain(planes).cloned());
        let files = self.files.as_deref().unwrap_or(self.loaded.given());
        made::provenance((command, seed), options, files, inputs.collect())
    }

    /// Keeps the best so far if that is wanted.
    fn interrupted(&mut self, outcome: Outcome) -> Failure {
        let signal = self.session.watch.signal().unwrap_or(2);
        let failure = self.session.interrupted(signal);
        if !self.session.global.keep_partial || self.written.output.as_os_str() == STREAM {
            return failure;
        }
        let partial = outputs::partial(&self.written.output);
        match self.make(outcome).and_then(|outputs| outputs.write(self.session)) {
            Ok(()) => Failure::kept(signal, &partial),
            Err(e) => e,
        }
    }
}
