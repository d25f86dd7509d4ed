//! Options of all that is put together from patches: pictures and clips. `[Kwatra03 3.2]` `[Kwatra03 4]`

use clap::Args;
use selvedge_graphcut_textures::{Options, Placement, Stutter};

use crate::used::Used;
use crate::values::{Auto, auto, choices, count, parsed};

choices!(PlacementArg for Placement {
    /// Entire where the exemplar repeats itself, else sub.
    Auto,
    /// Anywhere.
    Random,
    /// Where the whole exemplar agrees with what is there.
    Entire,
    /// Where the exemplar agrees with what is there in the region.
    Sub,
});

choices!(StutterArg for Stutter {
    /// Once where --apart is chosen for outputs of at most six times the exemplar, else never.
    Auto,
    /// None.
    Never,
    /// Those that are moved as none was before.
    Once,
});

/// How patches are drawn.
#[derive(Args, Clone, Debug)]
pub(crate) struct Drawing {
    /// How freely patches are drawn among those that fit worse than the best; the paper uses 0.001 to 1.
    #[arg(long, value_name = "K", default_value_t = Options::<2>::default().randomness)]
    randomness: f64,
    /// How much patches avoid to stand to each other as others do already; auto: 0.5 for entire placement, else 0.25.
    #[arg(long, value_name = "V|auto", default_value = "auto",
        value_parser = auto("variety", "write a number from 0 on, or auto", parsed::<f64>))]
    variety: Auto<f64>,
}

impl Drawing {
    /// In these options.
    pub(crate) fn of<const D: usize>(&self, options: Options<D>) -> Options<D> {
        Options { randomness: self.randomness, variety: self.variety.0, ..options }
    }
}

/// How seams are refined.
#[derive(Args, Clone, Debug)]
pub(crate) struct Refining {
    /// Patches laid over the worst seams at the end, or auto: until seams stop becoming cheaper.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = count())]
    refine: Auto<u32>,
    /// Refinements in a row that bring nothing before the seams count as settled.
    #[arg(long, value_name = "N", default_value_t = Options::<2>::default().patience)]
    patience: u32,
    /// Patches that are tried at each step, of which the best is taken.
    #[arg(long, value_name = "N", default_value_t = Options::<2>::default().tries)]
    tries: u32,
}

impl Refining {
    /// In these options.
    pub(crate) fn of<const D: usize>(&self, options: Options<D>) -> Options<D> {
        Options { refine: self.refine.0, patience: self.patience, tries: self.tries, ..options }
    }

    /// As they are used: where seams decide how many, it is none that was typed.
    pub(crate) fn used(&self, used: Used) -> Used {
        used.set("refine", self.refine.0)
    }
}
