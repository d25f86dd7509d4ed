//! Options of several commands.

use clap::{Arg, Args, Command};
use selvedge_core::{SeamMeasure, Transform};

use crate::args::{NonFiniteArg, typed_name};
use crate::values::SeamArg;

/// Changes one option of those that a command shares with others, which stays where it is: one that clap changes alone
/// becomes the last.
pub(crate) fn option(id: &'static str, mut change: impl FnMut(Arg) -> Arg) -> impl FnMut(Arg) -> Arg {
    move |arg| if arg.get_id() == id { change(arg) } else { arg }
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
