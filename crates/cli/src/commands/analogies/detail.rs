//! `selvedge detail`: detail synthesis. `[CMS V-B]`

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_cms_analogies::{Constraint, Kernel, low_resolution, match_low};
use selvedge_core::{Grid, Plane};
use selvedge_guides::encode_together;

use super::job::{Job, Request};
use super::{Knobs, Task, told};
use crate::failure::Failure;
use crate::followed::Followed;
use crate::harmonise::is_integer;
use crate::loom::Loom;
use crate::method::Method as _;
use crate::outcome::After;
use crate::report::Done;
use crate::session::Session;
use crate::values::choices;
use crate::weaving::Weaving;

/// The paper's `K`. `[CMS V-B]`
const TASK: Task = Task { weight: 7.0, neighborhood: 0, spread: 0.0, turn: true };

/// As many taps, a scale apart, as reach about as far as the paper's 15 samples a side. Of bricks, dirt and chickpeas,
/// each a half that was reduced and made from the other, at 4 and 8 times, the reduction is nearer to what was given
/// than with 3 everywhere, by 1.2 to 2.4 dB, peas are whole instead of crumbs, and the run takes half as long.
fn neighborhood(scale: u32) -> u32 {
    (15 / scale).saturating_sub(1).div_ceil(2).max(1)
}

/// Options of `detail`.
#[derive(Args, Debug)]
pub(crate) struct Detail {
    #[command(flatten)]
    weaving: Weaving,
    /// The picture that lacks detail.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    low: PathBuf,
    /// How many times larger the output is; the exemplar has the output's resolution.
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(1..=64))]
    scale: u32,
    /// How --low was made smaller: of a photograph by box or lanczos, of a blurred one by gauss.
    #[arg(long, value_enum, value_name = "KERNEL", default_value_t = KernelArg::Box)]
    kernel: KernelArg,
    /// Add what the picture still lacks of --low at the end: the light and colours of its large parts are exactly those
    /// then. --map and other planes stay as they are.
    #[arg(long)]
    match_low: bool,
    #[command(flatten)]
    knobs: Knobs,
}

choices!(KernelArg for Kernel {
    /// Means over squares.
    Box,
    /// Means by a Gaussian of half the scale.
    Gauss,
    /// Three lobes, as programs for pictures do.
    Lanczos,
});

impl Detail {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let task = Task { neighborhood: neighborhood(self.scale), ..TASK };
        let options = self.knobs.options(task);
        Job {
            name: "detail",
            weaving: &self.weaving,
            knobs: &self.knobs,
            task,
            options,
            first: &self.low,
            ratio: self.scale,
            channels: 3,
            derived: 0,
            others: vec![self.low.clone()],
            read: &|_, loom| self.asked(loom),
            files: None,
            frame: None,
        }
        .run(session)
    }

    fn asked(&self, loom: &mut Loom<'_>) -> Result<Request, Failure> {
        let (low, scale, kernel) = (Followed::read(loom, &self.low)?, self.scale, self.kernel.into());
        self.check_match(loom, &low)?;
        let (own, low) = (self.constraint(loom, &low)?, low.plane);
        let after = move |plane: &mut Plane<2>| match_low(plane, &low, scale, kernel).map_err(told::failure);
        Ok(Request { after: self.match_low.then(|| Box::new(after) as After), ..Request::one(own) })
    }

    /// Refuses to match what cannot be compared, or would change what stays to the bit.
    fn check_match(&self, loom: &Loom<'_>, low: &Followed) -> Result<(), Failure> {
        let picture = &loom.loaded.payload[0];
        let refused = |what: &str, remedy: &str| Err(Failure::new(2, what.to_owned()).about(&self.low).remedy(remedy));
        if !self.match_low {
            return Ok(());
        }
        if !self.knobs.start.files().is_empty() {
            let what = "--match-low changes the whole picture, and --over, --start and --fixed keep some of it";
            return refused(what, "leave one of them out");
        }
        if low.seen.is_some() {
            return refused("it is transparent in places, which have no light to match", "leave --match-low out");
        }
        let low = &low.plane;
        if is_integer(low.samples.depth()) != is_integer(picture.samples.depth()) {
            let what = "--match-low adds values of one kind, and one of both is light and the other is not";
            return refused(what, "give --low in the exemplar's kind, or --depth");
        }
        if picture.color_channels() < low.color_channels() {
            return refused("it has colours that --match-low cannot add to grey", "give a grey one");
        }
        Ok(())
    }

    fn constraint(&self, loom: &Loom<'_>, picture: &Followed) -> Result<Constraint, Failure> {
        let planes: Vec<&Plane<2>> = loom.loaded.payload.iter().chain(std::iter::once(&picture.plane)).collect();
        let mut maps = encode_together(&planes).map_err(|e| Failure::from(e).about(&self.low))?;
        let low = maps.pop().expect("the picture's").with_periodic(loom.domain.periodic);
        let exemplars = &loom.loaded.exemplars;
        let own = low_resolution(exemplars, &maps, &low, self.scale, self.kernel.into()).map_err(told::failure)?;
        let Some(seen) = &picture.seen else { return Ok(own) };
        let places = loom.domain.positions().map(|at| seen.get(0, at.map(|n| n / self.scale)));
        let asked = Grid::from_vec(loom.domain, 1, places.collect())?;
        Ok(Constraint { guide: own.guide.asking(asked)?, ..own })
    }
}
