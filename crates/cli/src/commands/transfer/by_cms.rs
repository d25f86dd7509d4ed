//! `selvedge transfer --method cms`: the same guides, followed by labels. `[CMS V-E]`

use selvedge_cms_analogies::{Constraint, Options, Plan, Sizes, estimate};
use selvedge_core::{Bytes, Domain, Transform};
use selvedge_quilting::TransferOptions;

use super::{Pair, Transfer};
use crate::commands::analogies::told::{counts, failure};
use crate::failure::{Failure, n};
use crate::inputs::Input;
use crate::loom::{Loom, Outcome};
use crate::method::{Method, Planned};
use crate::setup::Setup;
use crate::used::Used;

/// Between the paper's for weave, 0.4 and 4, and for rice, 0.2 and 5. `[CMS V-E]`
const WEIGHT: f64 = 0.4;
const NEIGHBORHOOD: u32 = 4;

/// A transfer by labels whose options were understood.
pub(super) struct Labels<'a> {
    pub(super) args: &'a Transfer,
    pub(super) pairs: Vec<Pair>,
    pub(super) first: Input,
    options: Options,
}

impl<'a> Labels<'a> {
    /// Refuses what is of blocks alone.
    pub(super) fn new(args: &'a Transfer, pairs: Vec<Pair>, first: Input) -> Result<Self, Failure> {
        let blocks = TransferOptions::default();
        let of_blocks = [
            ("--block", args.block.0.is_some()),
            ("--passes", args.passes != blocks.passes),
            ("--alpha", args.alpha.is_some()),
            ("--tolerance", args.tolerance != blocks.tolerance),
            ("--spread", args.spread != blocks.spread),
            ("--paper", args.paper),
        ];
        if let Some((option, _)) = of_blocks.iter().find(|(_, typed)| *typed) {
            let what = format!("{option} is of blocks, and --method cms has none");
            return Err(Failure::new(2, what).remedy("leave it out, or use --method quilt"));
        }
        let options = Options {
            constraint_weight: args.constraint_weight.unwrap_or(WEIGHT),
            neighborhood: args.neighborhood.unwrap_or(NEIGHBORHOOD),
            levels: None,
            ..Options::paper()
        };
        options.validate()?;
        Ok(Self { args, pairs, first, options })
    }

    fn planned<'l>(&'l self, loom: &'l Loom<'_>, constraints: &'l [Constraint]) -> Result<Plan<'l>, Failure> {
        let plan = Plan::new(&loom.loaded.exemplars, constraints, &self.options, &loom.session.run());
        plan.map_err(failure)
    }

    fn used(&self, loom: &Loom<'_>) -> Used {
        let used = self
            .args
            .used(loom, &[])
            .set("constraint-weight", self.options.constraint_weight)
            .set("neighborhood", self.options.neighborhood);
        ["block", "passes", "alpha", "tolerance", "spread"].into_iter().fold(used, Used::without)
    }
}

impl Method for Labels<'_> {
    type Read = [Constraint; 1];

    fn setup(&self) -> Result<Setup<'_>, Failure> {
        let turns = (0..4).map(|turn| Transform::new(90.0 * f64::from(turn), 1.0, false));
        Ok(Setup { transforms: turns.collect(), ..self.args.setup(&self.pairs, &self.first) })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let guides = self.args.followed().len() * 2 + self.pairs.len() * 3;
        let sizes = Sizes { sources, channels, constraints: &[(guides, 1)], output };
        let each = 2 * guides as u64 + 12;
        let maps = sources.iter().chain(std::iter::once(&output)).map(|domain| Bytes::of_samples(*domain, each)).sum();
        Bytes(estimate(&sizes, &self.options)) + maps
    }

    fn read(&self, loom: &mut Loom<'_>) -> Result<[Constraint; 1], Failure> {
        Ok([Constraint::new(self.args.guides(loom, &self.first, &self.pairs)?)])
    }

    fn plan<'l>(&'l self, loom: &'l Loom<'_>, constraints: [Constraint; 1]) -> Result<Planned<'l>, Failure> {
        self.planned(loom, &constraints)?;
        Ok(Planned::new(self.used(loom), "by labels", move || {
            let woven = self.planned(loom, &constraints)?.weave(&loom.session.run()).map_err(failure)?;
            let stats = &woven.stats;
            let places = n("place", stats.searches as usize);
            let how = format!("from {} of {} labels for {places}", stats.improvements, stats.expansions);
            Ok(Outcome::new(Box::new(woven.result), woven.complete, counts(stats), how))
        }))
    }
}
