//! A command that weaves, as a page of options: what it tells of itself, in the order in which it is asked. All else is
//! one way for all of them: files, masks, budget, maps, reports, provenance.

use std::path::PathBuf;

use selvedge_core::{Domain, Transform};

use crate::backdrop::Backdrop;
use crate::blending::Blending;
use crate::failure::Failure;
use crate::inputs::Input;
use crate::loom::{Loom, Outcome};
use crate::plan::Plan;
use crate::report::Done;
use crate::session::Session;
use crate::used::Used;
use crate::weaving::{Sizing, Weaving};

/// What the size of an output follows from.
pub(crate) enum OutputSize<'a> {
    /// What is typed, or a multiple of the first exemplar.
    Exemplar(Sizing),
    /// A picture, of which the header is read, so many times larger.
    Picture(&'a Input, u32),
    /// What was there before, with which the size typed must agree: domains of the exemplars, the backdrop last.
    Start(&'a dyn Fn(&[Domain<2>]) -> Result<Domain<2>, Failure>),
}

/// A method of the program.
pub(crate) trait Method {
    /// What it reads besides the exemplars, and makes of it.
    type Read;

    /// The command's name.
    fn name(&self) -> &'static str;

    /// The options of all commands that weave.
    fn weaving(&self) -> &Weaving;

    /// Refuses options that are wrong by themselves, before anything is read.
    fn validate(&self) -> Result<(), Failure>;

    /// What the size of the output follows from.
    fn size(&self) -> OutputSize<'_>;

    /// Files that it reads besides the exemplars and their masks.
    fn others(&self) -> Vec<PathBuf> {
        Vec::new()
    }

    /// The exemplars' orientations.
    fn transforms(&self) -> Vec<Transform> {
        vec![Transform::IDENTITY]
    }

    /// A picture that is one more exemplar.
    fn backdrop(&self) -> Option<Backdrop<'_>> {
        None
    }

    /// How seams are hidden.
    fn blending(&self) -> Blending {
        Blending::default()
    }

    /// Whether some samples may be kept from blending.
    fn keeps(&self) -> bool {
        false
    }

    /// Pairs of guides that have weights.
    fn guides(&self) -> usize {
        0
    }

    /// An upper bound of its own memory: domains of the sources, feature channels, output.
    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> u64;

    /// Reads what it needs besides the exemplars.
    fn read(&self, loom: &mut Loom<'_>) -> Result<Self::Read, Failure>;

    /// What a dry run tells: the options as used, and how it would be made, for people.
    fn plan(&self, loom: &Loom<'_>, read: Self::Read) -> Result<(Used, String), Failure>;

    /// Does it.
    fn weave(&self, loom: &Loom<'_>, read: Self::Read) -> Result<Outcome, Failure>;

    /// Runs the command.
    fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        self.validate()?;
        self.blending().validate()?;
        let (weaving, size) = (self.weaving(), self.size());
        let plan = Plan {
            command: self.name(),
            others: self.others(),
            domain: &|exemplars| match &size {
                OutputSize::Exemplar(sizing) => Ok(weaving.tiled(sizing.shape(exemplars[0].shape))),
                OutputSize::Start(domain) => domain(exemplars),
                OutputSize::Picture(picture, times) => {
                    let info = picture.probe(&weaving.read_options(session))?;
                    Ok(weaving.tiled([info.height, info.width].map(|side| side.saturating_mul(*times))))
                }
            },
            transforms: &self.transforms(),
            backdrop: self.backdrop(),
            blending: (self.blending(), self.keeps()),
            guides: self.guides(),
            estimate: &|sources, channels, output| self.bytes(sources, channels, output),
        };
        let mut loom = match size {
            OutputSize::Picture(..) => weaving.begin_of_fixed_size(session, &plan),
            _ => weaving.begin(session, &plan),
        }?;
        let read = self.read(&mut loom)?;
        if loom.is_dry() {
            let (used, how) = self.plan(&loom, read)?;
            return Ok(loom.would(used, &how));
        }
        let outcome = self.weave(&loom, read)?;
        loom.finish(outcome)
    }
}
