//! Texture transfer: a target drawn in the texture of the exemplars. `[Efros01 3]`

use std::borrow::Cow;

use selvedge_core::{Bytes, Domain, Exemplars, Guide, Run, SourceMap, Woven, par};

use crate::block_grid::BlockGrid;
use crate::estimate::planned_transfer;
use crate::fit::{check_fit, check_places};
use crate::options::{Continuation, Error, SearchBy, Stage, per_mille};
use crate::pass::{Pass, Progress};
use crate::quilter::{Counts, Quilter};
use crate::search::{BlockSearch, FromAbove, Reduced, Search, halvings_of_whole};
use crate::steering::Steering;
use crate::transfer_options::{PassPlan, TransferOptions, suggest_transfer_block};

/// Counts of one transfer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransferStats {
    /// Each pass, in order; those that a cancelled run never began are left out.
    pub passes: Vec<PassStats>,
}

/// Counts of one pass of a transfer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassStats {
    /// Side of the blocks.
    pub block: u32,
    /// Overlap of the blocks.
    pub overlap: u32,
    /// The texture's share of the error.
    pub alpha: f64,
    /// Blocks laid.
    pub blocks: u64,
    /// Candidates that were drawn from, over all blocks.
    pub candidates: u64,
    /// Sum of the errors along all cuts, in squared feature units.
    pub cut_error: u64,
    /// How far the guide under the output is from the target after this pass: the sum over all samples that are asked
    /// for of the weighted squared differences.
    pub guide_error: u64,
}

/// What [`transfer`] will do: options checked against exemplars, guide and limits, and what they leave open chosen.
#[derive(Clone, Debug)]
pub struct TransferPlan<'e> {
    exemplars: &'e Exemplars<2>,
    guide: Cow<'e, Guide<2>>,
    options: TransferOptions,
    passes: Vec<PassPlan>,
}

impl<'e> TransferPlan<'e> {
    /// Checks the options, then exemplars and guide, which it borrows or owns, then the run's limits; chooses the first
    /// block, if it is left open. Whether memory suffices is checked when the work begins.
    ///
    /// # Errors
    /// Those of [`transfer`].
    pub fn new(
        exemplars: &'e Exemplars<2>,
        guide: Cow<'e, Guide<2>>,
        options: &TransferOptions,
        run: &Run<'_, 2>,
    ) -> Result<Self, Error> {
        options.validate()?;
        guide.check(exemplars)?;
        let output = guide.target().domain();
        check_fit(exemplars, output, options.block)?;
        let block = options.block.unwrap_or_else(|| suggest_transfer_block(exemplars, output));
        check_fit(exemplars, output, Some(block))?;
        let options = TransferOptions { block: Some(block), ..*options };
        let plan = Self { exemplars, guide, options, passes: options.plan(block) };
        run.limits.admit(output, Bytes(0))?;
        check_places(exemplars, &plan.grid(&plan.passes[0]).block(0))?;
        Ok(plan)
    }

    /// Sides of the blocks, pass by pass.
    pub fn blocks(&self) -> impl ExactSizeIterator<Item = u32> {
        self.passes.iter().map(|pass| pass.block)
    }

    /// How many blocks will be laid, in all passes.
    pub fn total(&self) -> u64 {
        self.passes.iter().map(|pass| self.n_blocks(pass)).sum()
    }

    /// Bytes that the work takes at most, beside exemplars and guide, on the threads of this pool.
    pub fn bytes(&self) -> Bytes {
        self.bytes_of(self.output())
    }

    /// The same with blocks of the same sizes for another output.
    pub fn bytes_of(&self, output: Domain<2>) -> Bytes {
        let pass = |pass: &PassPlan| (BlockGrid::new(output, pass.block, pass.overlap), self.halvings_of(pass));
        let passes: Vec<(BlockGrid, u32)> = self.passes.iter().map(pass).collect();
        planned_transfer(self.exemplars, self.guide.weights().len(), output, &passes)
    }

    /// How often exemplars may be halved before blocks of the first pass are looked for in them
    /// ([`SearchBy::Auto`]): 0 if they are small or have masks.
    pub fn halvings(&self) -> u32 {
        self.passes.first().map_or(0, |pass| halvings_of_whole(self.exemplars, pass.block))
    }

    fn halvings_of(&self, pass: &PassPlan) -> u32 {
        if self.options.search == SearchBy::Auto { halvings_of_whole(self.exemplars, pass.block) } else { 0 }
    }

    /// Lays the blocks of all passes.
    ///
    /// # Errors
    /// What only the work can show: masks that leave no place for a cropped block, or no memory.
    pub fn weave(&self, run: &Run<'_, 2>) -> Result<Woven<SourceMap<2>, TransferStats>, Error> {
        run.limits.admit(self.output(), self.bytes())?;
        let exact = BlockSearch::new(self.exemplars, Some(&self.guide), run.simd)?;
        self.lay_passes(|number, last, progress, map| {
            let pass = self.pass(number, last, progress, run);
            let n = self.halvings_of(&self.passes[number]);
            let of = |exemplars: &Exemplars<2>| Reduced::times(exemplars, n);
            let (reduced, guide) = (of(self.exemplars)?, of(self.guide.exemplars())?);
            match FromAbove::new(self.exemplars, &reduced, Some((&self.guide, &guide)), run.simd)? {
                Some(search) => lay(&search, pass, run, map),
                None => lay(&exact, pass, run, map),
            }
        })
    }

    /// All passes, each laid by `lay`: number, what the last one laid, progress, and the map to lay on.
    fn lay_passes(
        &self,
        mut lay: impl FnMut(usize, Option<&SourceMap<2>>, Progress, &mut SourceMap<2>) -> Result<(Counts, bool), Error>,
    ) -> Result<Woven<SourceMap<2>, TransferStats>, Error> {
        let unassigned = || SourceMap::unassigned(self.exemplars, self.output());
        let mut map = unassigned()?;
        // What the last pass laid, while the next one lays over it.
        let mut last = if self.passes.len() == 1 { None } else { Some(unassigned()?) };
        let mut stats = TransferStats::default();
        let mut progress = Progress { name: "transfer", before: 0, of: self.total() };
        let mut complete = true;
        for (number, plan) in self.passes.iter().enumerate() {
            let last = last.as_mut().filter(|_| number != 0).map(|last| {
                last.ids.plane_mut(0).copy_from_slice(map.ids.plane(0));
                &*last
            });
            let counts;
            (counts, complete) = lay(number, last, progress, &mut map)?;
            stats.passes.push(PassStats {
                block: plan.block,
                overlap: plan.overlap,
                alpha: f64::from(plan.alpha) / 1000.0,
                blocks: counts.blocks,
                candidates: counts.candidates,
                cut_error: counts.cut_error,
                guide_error: guide_error(&self.guide, &map),
            });
            progress.before += self.n_blocks(plan);
            if !complete {
                break;
            }
        }
        Ok(Woven { result: map, stats, complete })
    }

    /// What a pass is told.
    fn pass<'p>(
        &'p self,
        number: usize,
        last: Option<&'p SourceMap<2>>,
        progress: Progress,
        run: &Run<'_, 2>,
    ) -> Pass<'p> {
        let plan = &self.passes[number];
        Pass {
            exemplars: self.exemplars,
            grid: self.grid(plan),
            block: plan.block,
            per_mille: per_mille(self.options.tolerance),
            stage: Stage::Cut,
            // Going on where the neighbour left off is the best that can happen to a texture that follows a target.
            continuation: Continuation::Allow,
            spread: self.options.spread,
            steering: Some(Steering::new(&self.guide, last, plan.alpha)),
            seed: run.seed.derive("quilting/pass", number as u64),
            progress,
        }
    }

    fn output(&self) -> Domain<2> {
        self.guide.target().domain()
    }

    fn grid(&self, pass: &PassPlan) -> BlockGrid {
        BlockGrid::new(self.output(), pass.block, pass.overlap)
    }

    fn n_blocks(&self, pass: &PassPlan) -> u64 {
        self.grid(pass).len() as u64
    }
}

/// Lays the blocks of a pass by any search; whether it came to its end.
fn lay(
    search: &impl Search,
    pass: Pass<'_>,
    run: &Run<'_, 2>,
    map: &mut SourceMap<2>,
) -> Result<(Counts, bool), Error> {
    let mut quilter = Quilter::new(search, pass, run, map)?;
    let complete = quilter.lay_all()?;
    Ok((quilter.counts, complete))
}

/// Quilts an output of the target's size that follows the target. `[Efros01 3]`
///
/// Each block is drawn from all those of all sources whose error is within the tolerance of the least, where the error
/// is `alpha` times the texture's plus `1 - alpha` times the guide's, both as means a sample and channel. Several
/// passes refine the output with smaller and smaller blocks; from the second on the texture's error is that to the
/// neighbours on the overlap and to what the last pass laid under the whole block.
///
/// Axes on which the guide's target is periodic close without a seam.
///
/// # Errors
/// Options that are wrong by themselves ([`TransferOptions::validate`]), a guide made for other exemplars, exemplars
/// without a valid block, an empty target, one over the run's limits (its plan's [bytes](TransferPlan::bytes) count
/// against their memory), or no memory for it.
///
/// # Complexity
/// A block takes `O(positions * block samples * channels)` as long as it is small (see the crate's page for figures),
/// so a pass `O(output samples * exemplar samples * channels)` times what its blocks overlap; the last pass, with the
/// smallest blocks, takes most. Large exemplars without masks are searched at a fraction of the size first, unless
/// [all places](SearchBy::Exact) are asked for: that takes a sixteenth for each halving. Space `O(output + exemplars)`.
///
/// # Determinism
/// The map follows from exemplars, guide, options and seed alone: errors are integers (fixed point). Block number `i`
/// of pass `p` draws from `"quilting/pass"`, `p` and `"quilting/block"`, `i`.
pub fn transfer(
    exemplars: &Exemplars<2>,
    guide: &Guide<2>,
    options: &TransferOptions,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, TransferStats>, Error> {
    TransferPlan::new(exemplars, Cow::Borrowed(guide), options, run)?.weave(run)
}

/// How far the guide under the output is from its target.
fn guide_error(guide: &Guide<2>, map: &SourceMap<2>) -> u64 {
    let [height, width] = map.domain().shape;
    let sample = |at: [u32; 2]| {
        let Some((source, from)) = map.locate(at) else { return 0 };
        if guide.asked().is_some_and(|asked| !asked.get(0, at)) {
            return 0;
        }
        let features = &guide.exemplars().sources()[source].features;
        let difference = |c: usize| features.get(c, from).abs_diff(guide.target().get(c, at));
        let weighted = |(c, &w): (usize, &u8)| u64::from(difference(c)).pow(2) * u64::from(w);
        guide.weights().iter().enumerate().map(weighted).sum::<u64>()
    };
    let row = |y: usize| (0..width).map(|x| sample([y as u32, x])).sum::<u64>();
    par::map_indexed(height as usize, row).into_iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::plain::PlainSearch;
    use selvedge_core::{Encoder, Exemplar, Grid, Plane, Role, Samples, Seed, Transform};

    /// Smooth noise.
    fn noise(seed: u64, domain: Domain<2>) -> Grid<u8, 2> {
        let mut rng = Seed(seed).rng();
        let mut value = 128_i32;
        let samples = (0..domain.len() * 3).map(|_| {
            value = (value + rng.below(41) as i32 - 20).clamp(0, 255);
            value as u8
        });
        Grid::from_vec(domain, 3, samples.collect()).unwrap()
    }

    #[test]
    fn the_plain_search_transfers_the_same_picture() {
        let planes = [1, 2].map(|s| {
            let domain = Domain::open([19 + 5 * s as u32, 23]);
            [Plane::new(Role::Color, Samples::U8(noise(s, domain)))]
        });
        let planes = [&planes[0][..], &planes[1][..]];
        let encoder = Encoder::fit(&planes).unwrap();
        let mask = planes[1][0].domain().positions().map(|[y, x]| (y, x) != (14, 11)).collect();
        let mask = Some(Grid::from_vec(planes[1][0].domain(), 1, mask).unwrap());
        let turn = Transform::Exact { quarter_turns: 1, mirror: true };
        for (case, periodic) in [[false, false], [true, false], [true, true]].into_iter().enumerate() {
            let transforms = if case == 0 { vec![Transform::IDENTITY] } else { vec![Transform::IDENTITY, turn] };
            let exemplars = [Exemplar::new(planes[0]), Exemplar::new(planes[1]).masked(mask.as_ref())];
            let exemplars = Exemplars::new(&encoder, &exemplars.map(|e| e.shown(&transforms))).unwrap();
            let maps: Vec<_> = planes.iter().map(|p| encoder.encode(p).unwrap()).collect();
            let target = noise(7, Domain { shape: [31, 26], periodic });
            let guide = Guide::new(&exemplars, &maps, target).unwrap();
            let guide = Guide::join(&[(guide.clone(), 1.0), (guide, 0.25)]).unwrap();
            let alpha = if case == 2 { Some(1.0) } else { None };
            let spread = if case == 1 { 0.0 } else { 0.4 };
            let options = TransferOptions { block: Some(11), passes: 3, alpha, spread, ..TransferOptions::default() };
            let run = Run::seeded(case as u64);
            let fast = transfer(&exemplars, &guide, &options, &run).unwrap();
            let plain = PlainSearch::new(&exemplars, Some(&guide));
            let plan = TransferPlan::new(&exemplars, Cow::Borrowed(&guide), &options, &run).unwrap();
            assert!(plan.blocks().eq(fast.stats.passes.iter().map(|p| p.block)));
            let laid = plan.lay_passes(|number, last, progress, map| {
                lay(&plain, plan.pass(number, last, progress, &run), &run, map)
            });
            let plain = laid.unwrap();
            assert_eq!(fast.stats, plain.stats);
            assert_eq!(fast.result, plain.result);
            assert_eq!(fast.result.holes(), 0);
        }
    }
}
