//! What fits one block: a draw from all places that do, and the cut against what lies there. `[Efros01 2]`

use selvedge_core::{Look, Rng, try_vec};

use crate::block_grid::Block;
use crate::boundary_cut::{Cut, Overlaps, boundary_cut};
use crate::cloth::Cloth;
use crate::options::{Error, Stage};
use crate::pass::Pass;
use crate::search::{self, Candidate, Preference, Search, Space, Term};
use crate::steering::Followed;

/// Who finds blocks: by what the pass is told, and by all that was laid so far.
pub(crate) struct Finder<'f, 'a, S> {
    pub(crate) search: &'f S,
    pub(crate) pass: &'f Pass<'a>,
    pub(crate) cloth: &'f Cloth<'a>,
}

/// What is kept from one block to the next.
pub(crate) struct Worker<S: Search> {
    search: S::Scratch,
    /// The output under the block, where blocks of this pass lie.
    pub(crate) overlap: Look,
    followed: Followed,
}

/// What is to be laid at a block.
pub(crate) struct Find {
    pub(crate) number: usize,
    /// The chosen place, and how many it was drawn from; none if the block agrees with nothing, so that any place does.
    pub(crate) chosen: Option<(Candidate, u32)>,
    /// Where it shows; everywhere if none.
    pub(crate) cut: Option<Cut>,
}

impl<S: Search> Default for Worker<S> {
    fn default() -> Self {
        Self { search: S::Scratch::default(), overlap: Look::new(), followed: Followed::default() }
    }
}

impl<S: Search> Finder<'_, '_, S> {
    /// What fits a block.
    pub(crate) fn find(&self, number: usize, worker: &mut Worker<S>) -> Result<Find, Error> {
        let block = self.pass.grid.block(number);
        // Random blocks agree with nothing.
        let compared = |p| self.pass.stage != Stage::Random && block.is_overlap(p);
        worker.overlap.at_map(self.pass.exemplars, self.cloth.map, &block.window(), compared)?;
        if self.pass.steering.is_none() && self.cloth.usage.is_even() && worker.overlap.samples() == 0 {
            return Ok(Find { number, chosen: None, cut: None });
        }
        let (chosen, candidates) = self.choose(number, &block, worker)?;
        let cut = match self.pass.stage {
            Stage::Random | Stage::Overlap => None,
            Stage::Cut => Some(self.cut(&block, chosen, &worker.overlap)?),
        };
        Ok(Find { number, chosen: Some((chosen, candidates)), cut })
    }

    /// A uniform draw from the candidates within the tolerance, and how many they are.
    fn choose(&self, number: usize, block: &Block, worker: &mut Worker<S>) -> Result<(Candidate, u32), Error> {
        let Worker { search, overlap, followed } = worker;
        let agree = [Term::new(Space::Texture, block.shape(), overlap)];
        let steering = self.pass.steering.as_ref();
        let terms = steering.map(|s| s.terms(self.pass.exemplars, block, overlap, followed)).transpose()?;
        let preference = Preference {
            per_mille: self.pass.per_mille,
            usage: &self.cloth.usage,
            continued: &self.cloth.continuations(self.pass, number, block),
        };
        let terms = terms.as_deref().unwrap_or(&agree);
        let drawn = search::draw(self.search, terms, &preference, &mut rng(self.pass, number), search)?;
        drawn.ok_or_else(|| masked(block))
    }

    /// Where the chosen block shows. `[Efros01 2.1]`
    fn cut(&self, block: &Block, chosen: Candidate, under: &Look) -> Result<Cut, Error> {
        let [h, w] = block.shape().map(|v| v as usize);
        let features = &self.pass.exemplars.sources()[chosen.source].features;
        let stride = features.domain().shape[1] as usize;
        let corner = features.domain().index(chosen.at);
        let mut error = try_vec(h * w, 0_u64)?;
        for (c, &weight) in self.pass.exemplars.weights().iter().enumerate() {
            let (old, new) = (under.features()[c * h * w..].chunks(w), features.plane(c)[corner..].chunks(stride));
            let rows = error.chunks_mut(w).zip(under.known().chunks(w)).zip(old.zip(new));
            for ((error, mask), (old, new)) in rows {
                for (((e, &on), &old), &new) in error.iter_mut().zip(mask).zip(old).zip(new) {
                    let d = u32::from(new.abs_diff(old));
                    *e += u64::from(on) * u64::from(d * d) * u64::from(weight);
                }
            }
        }
        let overlaps = Overlaps {
            left: block.columns.before as usize,
            top: block.rows.before as usize,
            right: block.columns.after as usize,
            bottom: block.rows.after as usize,
        };
        Ok(boundary_cut([h, w], overlaps, &error, None)?)
    }
}

/// The random numbers of a block.
pub(crate) fn rng(pass: &Pass<'_>, number: usize) -> Rng {
    pass.seed.derive("quilting/block", number as u64).rng()
}

/// No place is free of masked samples.
pub(crate) fn masked(block: &Block) -> Error {
    let [height, width] = block.shape();
    Error::Masked { height, width }
}
