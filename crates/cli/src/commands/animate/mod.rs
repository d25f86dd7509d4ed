//! `selvedge animate`: a texture that flows. `[Kwatra05 4.1]`

mod begun;
mod body;
mod bytes;
mod checks;
mod drift;
mod flow;
mod frames;
mod moving;

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Transform};
use selvedge_io::clip::Rate;
use selvedge_texture_optimization::{Animation, Options};
use serde_json::{Value, json};

use self::begun::Begun;
use self::body::{Body, BodyArgs};
use self::flow::{FlowArgs, Flows};
use self::moving::Moving;
use super::optimize::{Init, Levels, init, levels, typed};
use crate::clips::{self, Encode};
use crate::exemplars::ExemplarArgs;
use crate::failure::{Failure, n, shown};
use crate::kept::KeptArgs;
use crate::loaded::ExemplarSet;
use crate::memory::Resized;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::size::{Size, Tile};
use crate::used::Used;
use crate::wrong::Wrong;
use crate::{inputs, memory, names, outputs};

/// Frames where flows say no number.
const FRAMES: u32 = 60;

/// Options of `animate`.
#[derive(Args, Clone, Debug)]
#[command(mut_arg("exemplars", |arg| arg.help("Pictures of the texture; or one clip of it, as 'name.####.png', a folder, \
    a quoted glob or one file of frames (GIF, APNG, y4m, mp4, ...): each frame is made of its next one, and after its \
    last of its first again; '-' is standard input, 'a.exr[R,G,B]' chooses channels or a layer")))]
#[command(mut_arg("checkpoint", |arg| arg.help("Keep in this folder, after each frame of a sequence, what the next one \
    follows from")))]
#[command(mut_arg("mask", |arg| arg.help("Use an exemplar only where this picture is white. Give one for each \
    exemplar, in order, or 'none'; of a clip one for all of its frames, or one a frame as 'name.####.png'")))]
pub(crate) struct Animate {
    #[command(flatten)]
    input: ExemplarArgs,
    #[command(flatten)]
    flow: FlowArgs,
    #[command(flatten)]
    body: BodyArgs,
    /// Frames to make. Default: one more than there are files of vectors, or as many with --close; else as many as an
    /// exemplar that is a clip has, or 60.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Let the first frame follow the last one: over so many frames at the end, what is there gives way, part by part,
    /// to what would flow into the first frame.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    close: Option<u32>,
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
    /// Those below 8 px serve the first one as well, where the exemplar holds nothing larger.
    #[arg(long, value_name = "SCALE:SIZE,...", default_value = typed(&Animation::default().frame.schedule), value_parser = levels)]
    schedule: Levels,
    /// Iterations at a level of these frames, if it does not settle before.
    #[arg(long, value_name = "N", default_value_t = Animation::default().frame.iterations)]
    iterations: u32,
    /// Frames a second, such as 25 or 30000/1001.
    #[arg(long, value_name = "RATE", value_parser = clips::rate)]
    rate: Option<Rate>,
    /// The clip to write: 'name.####.png' and the like, frame by frame, name.gif, name.png (animated), name.y4m, '-'
    /// for y4m, or name.mp4, .mov, .webm, .mkv, .avi by ffmpeg.
    #[arg(help_heading = "Files that are written", short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    output: PathBuf,
    #[command(flatten)]
    encode: Encode,
    #[command(flatten)]
    kept: KeptArgs,
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

/// Options of the first frame, by those of others: what is smaller there is for exemplars that hold nothing larger.
fn first(init: &Init, frame: &Options, exemplars: &[Domain<2>]) -> Options {
    let mut first = init.suited().unwrap_or_default();
    let least = first.schedule.iter().map(|level| level.size).min().unwrap_or_default();
    if exemplars.iter().all(|exemplar| exemplar.shape.iter().any(|&side| side < least)) {
        first.schedule.extend(frame.schedule.iter().filter(|level| level.scale == 1 && level.size < least));
    }
    first
}

impl Animate {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("animate");
        self.flow.validate()?;
        let (init, options) = (self.init.chosen(), self.options()?);
        let (files, masks) = (self.flow.files()?, self.body.files()?);
        let clip = Moving::found(session, &self.input, &mut report)?;
        let input = clip.as_ref().map_or(&self.input, |clip| &clip.frames);
        let container = clip.iter().filter(|clip| clip.is_packed()).map(|_| self.input.exemplars[0].clone());
        let others = files.iter().chain(&masks).cloned().chain(container);
        let read: Vec<PathBuf> = input.files().into_iter().chain(others).collect();
        inputs::check_streams(&read)?;
        let headers = input.look(session, None)?;
        clip.iter().try_for_each(|clip| moving::check(&clip.frames, &headers))?;
        let period = clip.as_ref().map(|clip| clip.frames.exemplars.len() as u32);
        let flows = self.flow.read(&files, &session.limits)?;
        if flows.as_ref().is_some_and(Flows::is_unknown) {
            session.warn(&files[0], &"no vector of the flow is known: nothing will move");
        }
        let output = self.domain(&headers, flows.as_ref())?;
        let frames = self.count(flows.as_ref(), period)?;
        self.body.check(&masks, frames)?;
        memory::check_caps(&session.limits, output, Resized::Size)?;
        self.check_outputs(session, &headers, (output, frames), &read)?;
        // A field that is built in is one.
        let known = frames.min(flows.as_ref().map_or(1, Flows::len));
        let only = (self.input.exemplars.len() == 1).then(|| self.input.exemplars[0].as_path());
        let masks_held = masks.len().min(frames as usize);
        let masked = headers.layout.alpha || !headers.mask_infos.is_empty();
        let sources = headers.sources(&[Transform::IDENTITY]);
        let first = first(&init, &options.frame, &sources);
        let at_once = if clip.is_some() { &sources[..1] } else { &sources[..] };
        let need = |output| self.need(&headers, (&first, &options), (output, frames), (known, masks_held), at_once);
        let choosing = init.choosing(at_once, headers.channels(), masked);
        memory::check(&session.limits, only, output, Resized::Size, &|output| need(output).with(choosing))?;
        let need = need(output);
        let flows = match flows {
            Some(flows) => flows,
            None => self.flow.built_in(output, session.run::<2>().seed)?.expect("what is no file is built in"),
        };
        let mut loaded = headers.load(session, &[Transform::IDENTITY], &mut report)?;
        let textures = match &clip {
            Some(clip) => clip.each(&self.input, &mut loaded)?,
            None => vec![loaded.exemplars.clone()],
        };
        let body = self.body.read(session, &masks, (output, frames), &mut report)?;
        report.stage("read");
        let beginning = init.planned(&textures[0], output, &session.run())?;
        let needed = need.with(beginning.bytes());
        memory::check_fixed(&session.limits, needed)?;
        session.detail(&format!("memory: about {needed} of {}", Bytes(session.limits.memory)));
        report.estimate = Some(needed.0);
        report.options = self.used(session, &init, (output, frames));
        let [h, w] = output.shape;
        let path = self.path();
        let name = shown(&path);
        let options = Animation { direction: flows.direction, ..options };
        let plan = frames::plan(session, (&loaded, &textures), output, (&first, &options))?;
        if session.global.dry_run {
            let line = format!(
                "{name}: would be {} of {w}x{h} px, with about {needed} of memory",
                n("frame", frames as usize)
            );
            return Ok(Done::would(report, line, vec![outputs::planned_clip(&path, output.shape, Some(frames))]));
        }
        let head = self.head(session, (&loaded, &flows, body.as_ref()), &report.options);
        let begun = match Begun::read(&self.kept, &head)? {
            Some(begun) => begun,
            None => Begun::First(frames::first_frame(session, &loaded, (&beginning, &plan))?),
        };
        let (begun, shown) = ((begun, &self.kept.open(session, head)?), (&loaded, &textures[..]));
        let making = (output, &flows, body.as_ref(), frames, &options);
        let outputs = self.frames(session, shown, begun, making, &mut report)?;
        session.watch.finish();
        let line = format!("{name}: {} of {w}x{h} px, in {:.2} s", n("frame", frames as usize), report.elapsed());
        Ok(Done::made(report, line, outputs))
    }

    /// The clip that is written: a clip that is the exemplar names it as a picture does.
    fn path(&self) -> PathBuf {
        names::of_plane(&self.output, &clips::plane_name(&self.input.exemplars[0]))
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
            .set("init", init.typed())
            .without("checkpoint")
            .without("resume")
            .unless("encode", Value::Null);
        self.flow.used(self.input.used_if_any(used))
    }

    /// What frames follow from.
    fn head(
        &self,
        session: &Session<'_>,
        (loaded, flows, body): (&ExemplarSet, &Flows, Option<&Body>),
        used: &Used,
    ) -> Value {
        let of_exemplars = loaded.all_fingerprints();
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "exemplar": of_exemplars.iter().map(|file| &*file.blake3).collect::<Vec<_>>().join(" "),
            "flow": flows.fingerprint.as_ref().map(|file| &file.blake3),
            "body": body.map(|body| &body.fingerprint.blake3),
            "seed": session.global.seed(),
            "options": used.command("animate", &[]),
        })
    }
}
