//! `selvedge animate`: a texture that flows. `[Kwatra05 4.1]`

mod flow;

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Event, Observer, Plane, Render as _, Run, SourceMap, Transform};
use selvedge_io::Metadata;
use selvedge_io::clip::{ClipWriteOptions, ClipWriter, Rate};
use selvedge_texture_optimization::{
    Animation, Animator, FrameStats, Optimized, Options, Plan, animation_estimate, estimate,
};
use serde_json::{Value, json};

use self::flow::{FlowArgs, Flows};
use super::optimize::{Init, Levels, init, levels, typed};
use crate::clips;
use crate::exemplars::{ExemplarArgs, Headers};
use crate::failure::{Failure, n, shown};
use crate::loaded::ExemplarSet;
use crate::memory::Resized;
use crate::outputs::{self, Outputs};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::size::{Size, Tile};
use crate::used::Used;
use crate::watch::Watch;
use crate::wrong::Wrong;
use crate::{inputs, made, memory, names};

/// Frames where flows say no number.
const FRAMES: u32 = 60;

/// Options of `animate`.
#[derive(Args, Clone, Debug)]
pub(crate) struct Animate {
    #[command(flatten)]
    input: ExemplarArgs,
    #[command(flatten)]
    flow: FlowArgs,
    /// Frames to make. Default: one more than there are files of vectors, or 60.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Size of the frames: 512, 512x384, or a factor of the first exemplar such as 2x. Default: that of the vectors, or
    /// 2x.
    #[arg(long, value_name = "SIZE")]
    size: Option<Size>,
    /// Make every frame tile without a seam along x, y or both.
    #[arg(long, value_enum, value_name = "AXES")]
    tile: Option<Tile>,
    /// What the first frame is optimised from: auto, quilt, graphcut or random.
    #[arg(long, value_name = "WHAT", default_value = "auto", value_parser = made_init)]
    init: Init,
    /// How much a frame is wished to be the one before, moved, where the texture counts 1: the more, the smoother it
    /// flows; the less, the more it looks like the exemplars.
    #[arg(long, value_name = "L", default_value_t = Animation::default().lambda, allow_negative_numbers = true)]
    lambda: f64,
    /// Resolutions and sizes of neighborhoods in the frames after the first one: 1:16 is 16 px at full resolution.
    #[arg(long, value_name = "SCALE:SIZE,...", default_value = typed(&Animation::default().frame.schedule), value_parser = levels)]
    schedule: Levels,
    /// Iterations at a level of these frames, if it does not settle before.
    #[arg(long, value_name = "N", default_value_t = Animation::default().frame.iterations)]
    iterations: u32,
    /// Frames a second, such as 25 or 30000/1001.
    #[arg(long, value_name = "RATE", value_parser = clips::rate)]
    rate: Option<Rate>,
    /// The clip to write: 'name.####.png' and the like, frame by frame, name.gif, name.png (animated), name.y4m, or '-'
    /// for y4m.
    #[arg(help_heading = "Files that are written", short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    output: PathBuf,
}

/// A map has the size of its own picture alone.
fn made_init(text: &str) -> Result<Init, Wrong> {
    match init(text)? {
        Init::Map(_) => Err(Wrong::new(
            format!("'{text}' is nothing that the program makes"),
            "write auto, quilt, graphcut or random",
        )),
        made => Ok(made),
    }
}

/// Sees each frame as one step.
struct Quiet<'w>(&'w Watch);

impl Observer<2> for Quiet<'_> {
    fn event(&self, _: &Event<'_, 2>) {}

    fn cancelled(&self) -> bool {
        Observer::<2>::cancelled(self.0)
    }
}

impl Animate {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("animate");
        self.flow.validate()?;
        let (first, options) = (Options::default(), self.options()?);
        let files = self.flow.files()?;
        let read: Vec<PathBuf> = self.input.files().into_iter().chain(files.iter().cloned()).collect();
        inputs::check_streams(&read)?;
        let headers = self.input.look(session, None)?;
        let flows = self.flow.read(&files, &session.limits)?;
        let output = self.domain(&headers, flows.as_ref())?;
        let frames =
            self.frames.unwrap_or_else(|| flows.as_ref().filter(|f| 1 < f.len()).map_or(FRAMES, |f| f.len() + 1));
        memory::check_caps(&session.limits, output, Resized::Size)?;
        self.check_outputs(session, &headers, (output, frames), &read)?;
        // A field that is built in is one.
        let known = frames.min(flows.as_ref().map_or(1, Flows::len));
        let need = |output| self.need(&headers, (&first, &options), (output, frames), known);
        let only = (self.input.exemplars.len() == 1).then(|| self.input.exemplars[0].as_path());
        let needed = memory::check(&session.limits, only, output, Resized::Size, &need)?;
        session.detail(&format!("memory: about {needed} of {}", Bytes(session.limits.memory)));
        report.estimate = Some(needed.0);
        let flows = match flows {
            Some(flows) => flows,
            None => self.flow.built_in(output, session.run::<2>().seed)?.expect("what is no file is built in"),
        };
        let options = Animation { direction: flows.direction, ..options };
        let loaded = headers.load(session, &[Transform::IDENTITY], &mut report)?;
        report.stage("read");
        let init = self.init.chosen(&loaded.exemplars)?;
        report.options = self.used(session, &init, (output, frames));
        let [h, w] = output.shape;
        let name = shown(&names::of_plane(&self.output, &self.input.exemplars[0]));
        if session.global.dry_run {
            let line = format!(
                "{name}: would be {} of {w}x{h} px, with about {needed} of memory",
                n("frame", frames as usize)
            );
            return Ok(Done::would(report, line));
        }
        let first = Options { schedule: init.suited(first.schedule), ..first };
        let map = first_frame(session, &loaded, output, (&init, &first))?;
        let outputs = self.frames(session, &loaded, map, (&flows, frames, &options), &mut report)?;
        session.watch.finish();
        let line = format!("{name}: {} of {w}x{h} px, in {:.2} s", n("frame", frames as usize), report.elapsed());
        Ok(Done::made(report, line, outputs))
    }

    fn options(&self) -> Result<Animation, Failure> {
        let default = Animation::default();
        let frame = Options { schedule: self.schedule.0.clone(), iterations: self.iterations, ..default.frame };
        frame.validate()?;
        if !(self.lambda.is_finite() && 0.0 <= self.lambda) {
            let what = format!("a lambda of {} is out of range", self.lambda);
            return Err(Failure::new(2, what).remedy("use 0 (no wish) or more"));
        }
        Ok(Animation { frame, lambda: self.lambda, ..default })
    }

    /// The frames' domain: that of the vectors, with which the size typed must agree.
    fn domain(&self, headers: &Headers, flows: Option<&Flows>) -> Result<Domain<2>, Failure> {
        let first = headers.domains()[0].shape;
        let typed = self.size.map(|size| size.shape(first));
        let of_flow = flows.map(|flows| flows.after(0).domain().shape);
        if let (Some([h, w]), Some([fh, fw])) = (typed, of_flow)
            && [h, w] != [fh, fw]
        {
            let what = format!("the flow has {fw}x{fh} vectors, but --size asks for {w}x{h} px");
            return Err(Failure::new(3, what).remedy("leave --size out, or give a flow of that size"));
        }
        let shape = of_flow.or(typed).unwrap_or_else(|| Size::Factor(2.0).shape(first));
        Ok(Tile::domain(self.tile, shape))
    }

    fn write_options(&self) -> ClipWriteOptions {
        ClipWriteOptions { rate: self.rate, ..ClipWriteOptions::default() }
    }

    /// Refuses what could not be written, before any work.
    fn check_outputs(
        &self,
        session: &Session<'_>,
        headers: &Headers,
        (output, frames): (Domain<2>, u32),
        read: &[PathBuf],
    ) -> Result<(), Failure> {
        let path = names::of_plane(&self.output, &self.input.exemplars[0]);
        let writer = ClipWriter::create(&path, frames, Metadata::default(), self.write_options())?;
        let layout = headers.layout;
        let held = writer.check((layout.channels(), layout.alpha), headers.depth, output.shape);
        held.map_err(|e| Failure::from(e).remedy("write a sequence of png, tiff or exr that holds it"))?;
        clips::tell_left_over(session, &writer);
        outputs::check(session, &writer.files(), read)
    }

    /// An upper bound of the memory of a run with so many fields.
    fn need(
        &self,
        headers: &Headers,
        (first, options): (&Options, &Animation),
        (output, frames): (Domain<2>, u32),
        known: u32,
    ) -> Bytes {
        let sources = headers.sources(&[Transform::IDENTITY]);
        let (channels, depth, features) = (headers.layout.channels(), headers.depth, headers.channels());
        let kept = memory::pictures(&headers.infos, channels, depth) + memory::masks(&headers.mask_infos);
        let reading = memory::reading(headers.infos.iter().chain(&headers.mask_infos));
        let making = memory::making(&sources, features) + headers.light_bytes(&sources);
        let begun = self.init.bytes(&sources, features, output).then(estimate(&sources, features, output, first));
        let flows = Bytes::of_samples(output, 9) * u64::from(known);
        let one = memory::outputs(output, channels, depth, false);
        // A container is held until its last frame.
        let all = memory::picture(output, channels, depth) * u64::from(frames);
        let container = if selvedge_io::clip::ClipName::parse(&self.output).is_some() { Bytes(0) } else { all };
        let each = animation_estimate(&sources, features, output, options) + one + container;
        memory::PROGRAM + kept + flows + reading.then(making).max(memory::sources(&sources, features) + begun.max(each))
    }

    /// The options as used.
    fn used(&self, session: &Session<'_>, init: &Init, (output, frames): (Domain<2>, u32)) -> Used {
        let [h, w] = output.shape;
        let used = session
            .options
            .clone()
            .set("size", format!("{w}x{h}"))
            .set("tile", Tile::of(output).map(crate::args::typed_name))
            .set("frames", frames)
            .set("init", init.typed());
        self.flow.used(self.input.used_if_any(used))
    }

    /// Makes the frames and writes them: those of a sequence one by one, so that what is there stays if the run is
    /// ended.
    fn frames(
        &self,
        session: &Session<'_>,
        loaded: &ExemplarSet,
        first: SourceMap<2>,
        (flows, frames, options): (&Flows, u32, &Animation),
        report: &mut Report,
    ) -> Result<Outputs, Failure> {
        let path = names::of_plane(&self.output, &self.input.exemplars[0]);
        let fingerprints = loaded.all_fingerprints().into_iter().chain(flows.fingerprint.clone()).collect();
        let own = ("animate", session.global.seed());
        let provenance = made::provenance(own, report.options.clone(), loaded.given(), fingerprints);
        let metadata = Metadata { provenance: Some(provenance), ..loaded.metadata.clone() };
        let mut writer = ClipWriter::create(&path, frames, metadata, self.write_options())?;
        let payload: Vec<&Plane<2>> = loaded.payload.iter().collect();
        let quiet = Quiet(&session.watch);
        let run = Run { observer: &quiet, ..session.run() };
        let mut animator = Animator::new(&loaded.exemplars, first, options, &run)?;
        let mut counts = Vec::new();
        for frame in 0..frames {
            if 0 < frame {
                let woven = animator.next(flows.after(frame - 1), &run)?;
                counts.push(count(&woven.stats));
            }
            session.check_signal()?;
            let plane = animator.frame().render(&payload)?;
            if let Some((path, bytes)) = writer.encoded(&plane)? {
                selvedge_io::write_bytes(&path, &bytes, session.global.no_clobber)?;
            }
            Observer::<2>::event(&session.watch, &Event::<2>::step("frames", u64::from(frame) + 1, u64::from(frames)));
        }
        report.stage("synthesis");
        report.stats = json!({ "frames": counts });
        let mut outputs = Outputs::default();
        writer.ended()?.into_iter().for_each(|(path, bytes)| outputs.bytes(&path, bytes));
        report.stage("encode");
        Ok(outputs)
    }
}

/// A full synthesis. `[Kwatra05 4.1]`
fn first_frame(
    session: &Session<'_>,
    loaded: &ExemplarSet,
    output: Domain<2>,
    (init, options): (&Init, &Options),
) -> Result<SourceMap<2>, Failure> {
    let run = session.run();
    let plan = Plan::new(&loaded.exemplars, output, options, &run).map_err(|e| super::optimize::failure(loaded, e))?;
    let begun = init.made(&loaded.exemplars, output, &run)?.map(|woven| woven.result);
    session.check_signal()?;
    let woven = plan.weave(begun.as_ref(), &Default::default(), &run)?;
    session.check_signal()?;
    match woven.result {
        Optimized::Map(map) => Ok(map),
        Optimized::Votes(_) => unreachable!("its finish is a map"),
    }
}

fn count(frame: &FrameStats) -> Value {
    let level = frame.stats.levels.last();
    json!({
        "carried": frame.carried,
        "energy": frame.stats.energy(),
        "robust_energy": level.and_then(|level| level.robust.last()),
        "searched": frame.stats.levels.iter().map(|level| level.searched).sum::<u64>(),
    })
}
