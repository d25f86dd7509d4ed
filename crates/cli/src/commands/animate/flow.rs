//! Flows as they are typed: built in, a file, or one file a frame.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Direction, Domain, Flow, Limits, Seed};
use selvedge_io::clip::ClipName;
use selvedge_io::{Fingerprint, display_name};
use selvedge_texture_optimization::{Field, Motion};

use crate::failure::Failure;
use crate::flows::DirectionArg;
use crate::used::Used;
use crate::wrong::Wrong;
use crate::{clips, flows};

/// Pixels that a field may go in a frame, or have its middle off: farther than any picture is wide.
const FARTHEST: f64 = 1e6;

/// Options about the flow.
#[derive(Args, Clone, Debug)]
pub(super) struct FlowArgs {
    /// What the texture follows: sink, source, vortex, spiral, shear, uniform or curl-noise; a file of vectors (.flo, a
    /// PNG as KITTI has it, EXR); or one file a frame as 'name.####.flo', a folder or a quoted glob, which begin again
    /// after the last.
    #[arg(long, value_name = "FIELD|FILE", value_parser = flow, value_hint = ValueHint::FilePath)]
    flow: What,
    /// Pixels a frame where a built-in field is fastest. Default: 1.5.
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    speed: Option<f64>,
    /// Column and row of the middle of a built-in field. Default: the output's middle.
    #[arg(long, value_name = "X,Y", value_parser = center, allow_hyphen_values = true)]
    center: Option<Center>,
    /// Degrees from the right, clockwise: where uniform goes. Default: 0.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    angle: Option<f64>,
    /// What the vectors of files say: where samples go in the next frame, or where they come from.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = DirectionArg::Forward)]
    flow_direction: DirectionArg,
    /// Vectors of files are multiplied by this.
    #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true)]
    flow_scale: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum What {
    Field(Field),
    Files(PathBuf),
}

#[derive(Clone, Copy, Debug)]
struct Center([f64; 2]);

/// Fields by the names that they are typed by.
const FIELDS: [(&str, Field); 7] = [
    ("sink", Field::Sink),
    ("source", Field::Source),
    ("vortex", Field::Vortex),
    ("spiral", Field::Spiral),
    ("shear", Field::Shear),
    ("uniform", Field::Uniform),
    ("curl-noise", Field::CurlNoise),
];

fn name_of(field: Field) -> &'static str {
    FIELDS.iter().find(|(_, other)| *other == field).map_or("a field", |(name, _)| name)
}

fn flow(text: &str) -> Result<What, Wrong> {
    if let Some((_, field)) = FIELDS.iter().find(|(name, _)| *name == text) {
        return Ok(What::Field(*field));
    }
    let path = Path::new(text);
    if selvedge_io::flow::is_flow_name(path) || ClipName::parse(path).is_some() {
        return Ok(What::Files(path.to_path_buf()));
    }
    let names: Vec<&str> = FIELDS.iter().map(|(name, _)| *name).collect();
    Err(Wrong::new(
        format!("'{text}' is no flow"),
        format!("write {}, or a file's name (.flo, .png, .exr)", names.join(", ")),
    ))
}

fn center(text: &str) -> Result<Center, Wrong> {
    let wrong = || Wrong::new(format!("'{text}' is no place"), "write a column and a row, such as 128,96");
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    let number = |s: &str| s.trim().parse::<f64>().ok().filter(|v| v.abs() <= FARTHEST).ok_or_else(wrong);
    Ok(Center([number(y)?, number(x)?]))
}

/// What the frames follow, one after the other.
pub(super) struct Flows {
    flows: Vec<Flow>,
    pub(super) direction: Direction,
    /// Of the files.
    pub(super) fingerprint: Option<Fingerprint>,
}

impl Flows {
    /// Whether none of it says where anything goes.
    pub(super) fn is_unknown(&self) -> bool {
        let unknown = |flow: &Flow| flow.known.as_ref().is_some_and(|known| !known.samples().contains(&true));
        self.flows.iter().all(unknown)
    }

    /// The flow after a frame, counted from 0.
    pub(super) fn after(&self, frame: u32) -> &Flow {
        &self.flows[frame as usize % self.flows.len()]
    }

    /// How many there are before they begin again.
    pub(super) fn len(&self) -> u32 {
        self.flows.len() as u32
    }
}

impl FlowArgs {
    /// Refuses what is wrong by itself.
    pub(super) fn validate(&self) -> Result<(), Failure> {
        let numbers = [("speed", self.speed), ("angle", self.angle), ("flow-scale", Some(self.flow_scale))];
        if let Some((name, value)) = numbers.iter().find_map(|(n, v)| v.filter(|v| !v.is_finite()).map(|v| (n, v))) {
            let article = if name.starts_with('a') { "an" } else { "a" };
            return Err(Failure::new(2, format!("{article} {name} of {value} is no number")).remedy("use a finite one"));
        }
        if let Some(speed) = self.speed.filter(|speed| FARTHEST < speed.abs()) {
            let what = format!("a speed of {speed} is out of range");
            return Err(Failure::new(2, what).remedy(format!("use -{FARTHEST} to {FARTHEST}")));
        }
        self.idle().map_or(Ok(()), Err)
    }

    /// Of what was typed the first that does nothing.
    fn idle(&self) -> Option<Failure> {
        let (field, names) = match &self.flow {
            What::Field(field) => (Some(*field), format!("is {}", name_of(*field))),
            What::Files(_) => (None, "names a file".to_owned()),
        };
        let is_placed = field.is_some_and(|field| !matches!(field, Field::Uniform | Field::CurlNoise));
        let of_files = "vectors of files";
        let turned = matches!(self.flow_direction, DirectionArg::Backward);
        let all = [
            ("speed", self.speed.is_some(), field.is_some(), "fields that are built in"),
            ("angle", self.angle.is_some(), field == Some(Field::Uniform), "the uniform field"),
            ("center", self.center.is_some(), is_placed, "fields that have a middle"),
            ("flow-direction", turned, field.is_none(), of_files),
            ("flow-scale", self.flow_scale != 1.0, field.is_none(), of_files),
        ];
        let (name, .., about) = all.into_iter().find(|(_, typed, acts, _)| *typed && !acts)?;
        let instead = if field.is_none() { "use --flow-scale" } else { "give another --flow" };
        let what = format!("--{name} is about {about}, and --flow {names}");
        Some(Failure::new(2, what).remedy(format!("leave it out, or {instead}")))
    }

    /// The files that are read.
    pub(super) fn files(&self) -> Result<Vec<PathBuf>, Failure> {
        match &self.flow {
            What::Field(_) => Ok(Vec::new()),
            What::Files(path) => flows::files(path),
        }
    }

    /// Reads the [`files`](Self::files), which must be of one size.
    pub(super) fn read(&self, files: &[PathBuf], limits: &Limits) -> Result<Option<Flows>, Failure> {
        let What::Files(path) = &self.flow else { return Ok(None) };
        let (mut all, mut each): (Vec<Flow>, Vec<Fingerprint>) = (Vec::new(), Vec::new());
        for file in files {
            let before = all.first().map(|flow| flow.domain().shape);
            let (flow, fingerprint) =
                flows::read(file, before.map(|size| (size, "the first one has")), (self.flow_scale as f32, limits))?;
            all.push(flow);
            each.push(fingerprint);
        }
        let fingerprint = clips::fingerprint(path, &each);
        Ok(Some(Flows { flows: all, direction: self.flow_direction.into(), fingerprint: Some(fingerprint) }))
    }

    /// A field that is built in, over an output.
    pub(super) fn built_in(&self, output: Domain<2>, seed: Seed) -> Result<Option<Flows>, Failure> {
        let What::Field(field) = &self.flow else { return Ok(None) };
        let center = self.center.map(|center| center.0);
        let (speed, angle) = (self.speed.unwrap_or(1.5), self.angle.unwrap_or(0.0));
        let flow = Motion { field: *field, speed, center, angle }.flow(output, seed)?;
        Ok(Some(Flows { flows: vec![flow], direction: Direction::Forward, fingerprint: None }))
    }

    /// Without what does not act.
    pub(super) fn used(&self, used: Used) -> Used {
        match &self.flow {
            What::Field(field) => {
                let used = used.set("speed", self.speed.unwrap_or(1.5)).without("flow-direction").without("flow-scale");
                let used = if self.center.is_none() { used.without("center") } else { used };
                if *field == Field::Uniform {
                    used.set("angle", self.angle.unwrap_or(0.0))
                } else {
                    used.without("angle")
                }
            }
            What::Files(path) => {
                used.set("flow", display_name(path)).without("speed").without("angle").without("center")
            }
        }
    }
}
