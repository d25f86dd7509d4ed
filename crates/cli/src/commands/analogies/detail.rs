//! `selvedge detail`: detail synthesis. `[CMS V-B]`

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_cms_analogies::{Constraint, low_resolution};
use selvedge_core::Plane;
use selvedge_guides::encode_together;

use super::job::Job;
use super::{Knobs, Task};
use crate::failure::Failure;
use crate::loom::Loom;
use crate::method::Method as _;
use crate::report::Done;
use crate::session::Session;
use crate::weaving::Weaving;

/// The paper's for carpet and brick is 7 and 7, for curved cloth 7 and 3. `[CMS V-B]`
const TASK: Task = Task { weight: 7.0, neighborhood: 3, spread: 0.0, turn: true };

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
    #[command(flatten)]
    knobs: Knobs,
}

impl Detail {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let options = self.knobs.options(TASK);
        Job {
            name: "detail",
            weaving: &self.weaving,
            knobs: &self.knobs,
            task: TASK,
            options,
            first: &self.low,
            ratio: self.scale,
            channels: 3,
            derived: 0,
            others: vec![self.low.clone()],
            read: &|_, loom| Ok(vec![self.constraint(loom)?]),
            files: None,
        }
        .run(session)
    }

    fn constraint(&self, loom: &mut Loom<'_>) -> Result<Constraint, Failure> {
        let low = loom.open(&self.low)?;
        let planes: Vec<&Plane<2>> = loom.loaded.payload.iter().chain(std::iter::once(&low)).collect();
        let mut maps = encode_together(&planes).map_err(|e| Failure::from(e).about(&self.low))?;
        let low = maps.pop().expect("the picture's").with_periodic(loom.domain.periodic);
        low_resolution(&loom.loaded.exemplars, &maps, &low, self.scale).map_err(super::told::failure)
    }
}
