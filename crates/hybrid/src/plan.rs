//! What a run will do: options checked, and what they leave open chosen.

use selvedge_core::{Bytes, Domain, Exemplars, Grid, Guidance, Run, Source, SourceMap, Start, Woven};
use selvedge_quilting::suggest_block;

use crate::error::Error;
use crate::estimate::{measuring, woven};
use crate::followed::Followed;
use crate::layout::{Blocks, overlap_of, power_of_two};
use crate::options::Options;
use crate::stats::Stats;
use crate::usable::Usable;
use crate::weave::Weaver;

/// What [`hybrid`](crate::hybrid()) will do: options checked against exemplars, output and limits, and what they leave
/// open chosen.
#[derive(Clone, Debug)]
pub struct Plan {
    /// As they are searched: around their borders, if that was asked for.
    pub(crate) exemplars: Exemplars<2>,
    /// As they are.
    given: Exemplars<2>,
    pub(crate) output: Domain<2>,
    pub(crate) options: Options,
    pub(crate) block: [u32; 2],
    /// What is followed, under the exemplars as they are searched.
    followed: Option<Followed>,
}

impl Plan {
    /// Checks the options, then exemplars and output, then whether the run's limits allow for measuring; then chooses
    /// the block, if it is left open. Whether they allow for the work is checked when it begins.
    ///
    /// # Errors
    /// Those of [`hybrid`](crate::hybrid()).
    pub fn new(
        exemplars: &Exemplars<2>,
        output: Domain<2>,
        options: &Options,
        run: &Run<'_, 2>,
    ) -> Result<Self, Error> {
        options.validate()?;
        check_fit(exemplars, output, options)?;
        let (sources, masked) = (exemplars.domains(), exemplars.is_masked());
        run.limits.admit(output, measuring(&sources, exemplars.channels(), masked, options))?;
        let block = options.block.map_or_else(|| suggested(exemplars), Ok)?;
        let given = exemplars.clone();
        let exemplars = if options.circular { around(exemplars)? } else { exemplars.clone() };
        Ok(Self { exemplars, given, output, options: *options, block, followed: None })
    }

    /// The same plan, whose blocks and samples follow a guide as well: its error is one more mean beside that of what
    /// stands, in the search, in what splits a block (down to a side of eight samples), and in the choice of samples.
    ///
    /// # Errors
    /// A weight that is negative or no number, a guide of other exemplars or another output (the core's), one of which
    /// less is valid than of the exemplars ([`Error::GuideMask`]), and no memory.
    pub fn following(self, guidance: Guidance<2>) -> Result<Self, Error> {
        guidance.check_weight()?;
        let Guidance { guide, weight } = guidance;
        guide.check(&self.given)?;
        let (expected, found) = (self.output.shape.to_vec(), guide.target().domain().shape.to_vec());
        if expected != found {
            return Err(selvedge_core::Error::GuideTarget { expected, found }.into());
        }
        if guide.exemplars().validity() != self.given.validity() {
            return Err(Error::GuideMask);
        }
        if weight == 0.0 {
            return Ok(self);
        }
        let followed = Followed { guide, weight };
        let followed =
            if self.options.circular { followed.under(&around(followed.guide.exemplars())?)? } else { followed };
        Ok(Self { followed: Some(followed), ..self })
    }

    /// Bytes that choosing the block and the work take at most, beside the exemplars.
    pub fn bytes(&self) -> Bytes {
        self.bytes_of(self.output)
    }

    /// The same with blocks of the same size for another output.
    pub fn bytes_of(&self, output: Domain<2>) -> Bytes {
        let (sources, channels, masked) = (self.given.domains(), self.given.channels(), self.given.is_masked());
        let followed = self.followed.as_ref().map_or(0, |followed| followed.guide.weights().len());
        let work = woven(&sources, (channels, followed), masked, output, (self.block, &self.options));
        measuring(&sources, channels, masked, &self.options).then(work)
    }

    /// Height and width of the start blocks in samples.
    pub fn block(&self) -> [u32; 2] {
        self.block
    }

    /// How many start blocks the output has.
    pub fn len(&self) -> u64 {
        self.blocks().len()
    }

    /// False: an output has at least one.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn blocks(&self) -> Blocks {
        Blocks::new(self.output, self.block, (self.options.layout, self.options.overlap))
    }

    /// Lays the blocks, from nothing.
    ///
    /// # Errors
    /// What only the work can show: no memory, of the run's limits or at all.
    pub fn weave(&self, run: &Run<'_, 2>) -> Result<Woven<SourceMap<2>, Stats>, Error> {
        let map = SourceMap::unassigned(&self.given, self.output)?;
        self.weave_from(Start { map, fixed: None, sources: None }, run)
    }

    /// Lays the blocks where something is missing.
    ///
    /// # Errors
    /// Those of [`Start::check`], [`Error::MixedSources`], and no memory.
    pub fn weave_from(&self, mut start: Start<2>, run: &Run<'_, 2>) -> Result<Woven<SourceMap<2>, Stats>, Error> {
        start.check(&self.given)?;
        run.limits.admit(self.output, self.bytes())?;
        let sources = start.sources.take();
        let usable = Usable::new(&self.exemplars, &start.map, sources.as_ref(), self.followed.as_ref())?;
        let weaver = Weaver::new(&usable, self.followed.as_ref(), self.block, &self.options, start, run)?;
        weaver.weave(self.blocks())
    }
}

/// A start block that an exemplar holds, with an overlap along axes on which there is a second one: without, the first
/// block alone would be laid whole.
fn check_fit(exemplars: &Exemplars<2>, output: Domain<2>, options: &Options) -> Result<(), Error> {
    let shapes = || exemplars.sources().iter().map(|s| s.domain().shape);
    let Some(block) = options.block else { return Ok(()) };
    let overlap_of = |side| overlap_of(side, options.overlap);
    let needed = [0, 1].map(|a| block[a] + if block[a] < output.shape[a] { overlap_of(block[a]) } else { 0 });
    if shapes().any(|shape| (0..2).all(|a| needed[a] <= shape[a])) {
        return Ok(());
    }
    let [height, width] = shapes().max_by_key(|s| s[0].min(s[1])).unwrap_or([0, 0]);
    let most = power_of_two(height.min(width));
    let limit = if height.min(width) < most + overlap_of(most) { (most / 2).max(1) } else { most };
    let [block_height, block_width] = block;
    Err(Error::BlockExceedsExemplar { block_height, block_width, height, width, limit })
}

/// Of quilting's block, what it steps by: its overlap, a quarter, lies inside.
const QUILTED: f64 = 0.75;

/// The block of an automatic size: the power of two that is nearest, by its ratio, to the step of quilting's blocks.
fn suggested(exemplars: &Exemplars<2>) -> Result<[u32; 2], Error> {
    let step = f64::from(suggest_block(exemplars)?) * QUILTED;
    Ok([power_of_two((step * std::f64::consts::SQRT_2) as u32); 2])
}

/// The same exemplars, each going on around its borders.
pub(crate) fn around(exemplars: &Exemplars<2>) -> Result<Exemplars<2>, Error> {
    let periodic = |s: &Source<2>| -> Result<Source<2>, selvedge_core::Error> {
        let valid =
            s.valid.as_deref().map(|v| Ok::<_, selvedge_core::Error>(Grid::map(v, |v| v)?.with_periodic([true; 2])));
        Ok(Source {
            features: s.features.map(|v| v)?.with_periodic([true; 2]),
            valid: valid.transpose()?.map(Into::into),
            origin: s.origin,
        })
    };
    let sources = exemplars.sources().iter().map(|s| periodic(s)).collect::<Result<_, _>>()?;
    Ok(Exemplars::from_sources(sources, exemplars.weights().to_vec())?)
}
