//! Options of several commands.

use clap::{Arg, Args, Command};
use selvedge_core::{Depth, SeamMeasure, Transform};
use selvedge_io::Format;

use crate::args::{DepthArg, FormatArg, NonFiniteArg, typed_name};
use crate::harmonise::stops;
use crate::values::SeamArg;

/// Changes one option of those that a command shares with others, which stays where it is: one that clap changes alone
/// becomes the last.
pub(crate) fn option(id: &'static str, mut change: impl FnMut(Arg) -> Arg) -> impl FnMut(Arg) -> Arg {
    move |arg| if arg.get_id() == id { change(arg) } else { arg }
}

/// The exemplars of a command that takes one picture.
pub(crate) fn one_picture(arg: Arg) -> Arg {
    arg.value_names(["PICTURE"])
        .num_args(1)
        .help("The picture; '-' is standard input, 'a.exr[R,G,B]' chooses channels or a layer")
}

/// Long names of a group of options.
pub(crate) fn names_of<A: Args>() -> Vec<String> {
    A::augment_args(Command::new("")).get_arguments().filter_map(|arg| arg.get_long().map(str::to_owned)).collect()
}

/// Whether exemplars are turned and mirrored.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Turning {
    /// Turn exemplars by quarter turns as well.
    #[arg(long)]
    pub(crate) turn: bool,
    /// Mirror exemplars as well.
    #[arg(long)]
    pub(crate) mirror: bool,
}

impl Turning {
    /// As they are first, and whatever else is asked for.
    pub(crate) fn transforms(self) -> Vec<Transform> {
        let exact =
            |quarter_turns| self.mirrors().iter().map(move |&mirror| Transform::Exact { quarter_turns, mirror });
        self.quarter_turns().flat_map(exact).collect()
    }

    pub(crate) fn quarter_turns(self) -> std::ops::Range<u8> {
        if self.turn { 0..4 } else { 0..1 }
    }

    pub(crate) fn mirrors(self) -> &'static [bool] {
        if self.mirror { &[false, true] } else { &[false] }
    }
}

/// The price of seams.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Seams {
    /// How seams are priced: by their difference, or by difference over gradient.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = SeamArg::Gradient)]
    seam: SeamArg,
}

impl Seams {
    pub(crate) fn measure(self) -> SeamMeasure {
        self.seam.into()
    }
}

/// How evenly exemplars are used.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Spread {
    /// How evenly the exemplar is used: 0 takes whatever fits best.
    #[arg(long, value_name = "S", default_value_t = selvedge_quilting::Options::default().spread)]
    pub(crate) spread: f64,
}

/// How pictures are written.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Encoding {
    /// Format of the output, whatever its extension.
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<FormatArg>,
    /// Quality of a JPEG file, 1 to 100.
    #[arg(long, value_name = "Q", value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) quality: Option<u8>,
}

impl Encoding {
    pub(crate) fn format(self) -> Option<Format> {
        self.format.map(Format::from)
    }
}

/// The depth that samples get.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Conversion {
    /// Depth of the output; by default that of what is read.
    #[arg(long, value_enum, value_name = "DEPTH")]
    depth: Option<DepthArg>,
    /// Stops by which light of floats becomes brighter, or darker below 0, where --depth makes integers of it.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, value_parser = stops, allow_negative_numbers = true)]
    pub(crate) exposure: f64,
}

impl Conversion {
    pub(crate) fn depth(self) -> Option<Depth> {
        self.depth.map(Depth::from)
    }
}

/// How closely constraints are followed; what is not given is the task's own.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Following {
    /// How much the constraints count against seams: large values follow them, small ones keep the texture whole.
    #[arg(short = 'K', long, value_name = "K")]
    pub(crate) constraint_weight: Option<f64>,
    /// Half the side of the neighborhoods that are compared, in pixels of the constraint: large ones keep structures,
    /// small ones follow curves.
    #[arg(short = 'N', long, value_name = "N")]
    pub(crate) neighborhood: Option<u32>,
}

/// What is read of floats.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct NonFinite {
    /// What becomes of float samples that are infinite or no numbers.
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = NonFiniteArg::Error)]
    nonfinite: NonFiniteArg,
}

impl NonFinite {
    /// As it is typed, where it is not what it is by default.
    pub(crate) fn typed(self) -> Option<String> {
        (self.nonfinite != NonFiniteArg::Error).then(|| typed_name(self.nonfinite))
    }
}

impl From<NonFinite> for NonFiniteArg {
    fn from(option: NonFinite) -> Self {
        option.nonfinite
    }
}
