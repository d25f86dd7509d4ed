//! What fits one block: a draw from all places that do, and the cut against what lies there. `[Efros01 2]`

use selvedge_core::{Domain, Exemplars, SourceMap, reserve, try_vec};

use crate::block_grid::Block;
use crate::boundary_cut::{Cut, Overlaps, boundary_cut};
use crate::options::{Error, Stage};
use crate::quilter::{Pass, Quilter};
use crate::search::{Candidate, Search, Space, Template, Term};
use crate::transfer::Followed;

/// What is kept from one block to the next.
pub(crate) struct Worker<S: Search> {
    search: S::Scratch,
    /// The output under the block, where blocks of this pass lie.
    pub(crate) overlap: Template,
    followed: Followed,
}

/// What is to be laid at a block.
pub(crate) struct Found {
    pub(crate) number: usize,
    /// The chosen place, and how many it was drawn from; none if the block agrees with nothing, so that any place does.
    pub(crate) chosen: Option<(Candidate, u32)>,
    /// Where it shows; everywhere if none.
    pub(crate) cut: Option<Cut>,
}

impl<S: Search> Worker<S> {
    pub(crate) fn new(pass: &Pass<'_>) -> Result<Self, Error> {
        let overlap = Template::for_blocks(pass.block, pass.exemplars)?;
        Ok(Self { search: S::Scratch::default(), overlap, followed: Followed::default() })
    }
}

impl<S: Search> Quilter<'_, S> {
    /// What fits a block by all that was laid so far.
    pub(crate) fn find(&self, number: usize, worker: &mut Worker<S>) -> Result<Found, Error> {
        let block = self.pass.grid.block(number);
        // Random blocks agree with nothing.
        let compared = |p| self.pass.stage != Stage::Random && block.is_overlap(p);
        worker.overlap.read(self.pass.exemplars, self.map, &block, compared)?;
        if self.pass.steering.is_none() && self.usage.is_even() && worker.overlap.samples() == 0 {
            return Ok(Found { number, chosen: None, cut: None });
        }
        let (chosen, candidates) = self.choose(number, &block, worker)?;
        let cut = match self.pass.stage {
            Stage::Random | Stage::Overlap => None,
            Stage::Cut => Some(self.cut(&block, chosen, &worker.overlap)?),
        };
        Ok(Found { number, chosen: Some((chosen, candidates)), cut })
    }

    /// A uniform draw from the candidates within the tolerance, and how many they are.
    fn choose(&self, number: usize, block: &Block, worker: &mut Worker<S>) -> Result<(Candidate, u32), Error> {
        let Worker { search, overlap, followed } = worker;
        let continued = self.continuations(number, block);
        let avoid = |source: usize, at: [u32; 2]| continued.iter().any(|&(s, p)| s == source && near(at, p));
        let agree = [Term { space: Space::Texture, template: overlap, weight: 1 }];
        let steering = self.pass.steering.as_ref();
        let terms = steering.map(|s| s.terms(self.pass.exemplars, block, overlap, followed)).transpose()?;
        let terms = terms.as_deref().unwrap_or(&agree);
        let per_mille = self.pass.per_mille;
        let within = |best: &Candidate| self.usage.widened(per_mille, best);
        let near = self.search.near(terms, &within, &avoid, search)?;
        self.usage.draw(near, per_mille, &mut self.rng(number)).ok_or(masked(block))
    }

    /// Where the chosen block shows. `[Efros01 2.1]`
    fn cut(&self, block: &Block, chosen: Candidate, under: &Template) -> Result<Cut, Error> {
        let [h, w] = under.shape.map(|v| v as usize);
        let features = &self.pass.exemplars.sources()[chosen.source].features;
        let stride = features.domain().shape[1] as usize;
        let corner = features.domain().index(chosen.at);
        let mut error = try_vec(h * w, 0_u64)?;
        for (c, &weight) in self.pass.exemplars.weights().iter().enumerate() {
            let (old, new) = (under.features[c * h * w..].chunks(w), features.plane(c)[corner..].chunks(stride));
            let rows = error.chunks_mut(w).zip(under.mask.chunks(w)).zip(old.zip(new));
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
        Ok(boundary_cut([h, w], overlaps, &error)?)
    }
}

/// How far from a continuation a block is one itself, in samples on each axis.
const NEAR: i64 = 2;

/// True for places about a continuation: those of [`around`].
pub(crate) fn near(at: [u32; 2], to: [i64; 2]) -> bool {
    at.iter().zip(to).all(|(&a, b)| (i64::from(a) - b).abs() <= NEAR)
}

/// All places near a continuation.
pub(crate) fn around(&(source, [y, x]): &(usize, [i64; 2])) -> impl Iterator<Item = (usize, [i64; 2])> {
    (y - NEAR..=y + NEAR).flat_map(move |y| (x - NEAR..=x + NEAR).map(move |x| (source, [y, x])))
}

/// No place is free of masked samples.
pub(crate) fn masked(block: &Block) -> Error {
    let [height, width] = block.shape();
    Error::Masked { height, width }
}

impl Template {
    /// One that takes no more memory for blocks up to this side.
    fn for_blocks(side: u32, exemplars: &Exemplars<2>) -> Result<Self, Error> {
        let samples = side as usize * side as usize;
        let mut template = Self { shape: [0; 2], mask: Vec::new(), features: Vec::new() };
        reserve(&mut template.mask, samples)?;
        reserve(&mut template.features, samples * exemplars.channels())?;
        Ok(template)
    }

    /// Takes the features of a map's samples under a block where they are compared.
    pub(crate) fn read(
        &mut self,
        exemplars: &Exemplars<2>,
        map: &SourceMap<2>,
        block: &Block,
        compared: impl Fn([u32; 2]) -> bool,
    ) -> Result<(), Error> {
        let (output, table) = (map.domain(), exemplars.table());
        self.shape = block.shape();
        let n = (self.shape[0] * self.shape[1]) as usize;
        self.clear(n, exemplars.channels())?;
        self.features.resize(n * exemplars.channels(), 0);
        for (i, p) in Domain::open(self.shape).positions().enumerate() {
            let id = compared(p).then(|| map.ids.get(0, block.position(output, p)));
            let source = id.and_then(|id| table.source(id));
            self.mask.push(source.is_some());
            if let (Some(source), Some(id)) = (source, id) {
                let from = (id.get() - table.first(source)) as usize;
                let features = &exemplars.sources()[source].features;
                for c in 0..features.channels() {
                    self.features[c * n + i] = features.plane(c)[from];
                }
            }
        }
        Ok(())
    }

    /// Empties the buffers and makes room for so many samples and channels.
    pub(crate) fn clear(&mut self, samples: usize, channels: usize) -> Result<(), Error> {
        self.mask.clear();
        self.features.clear();
        reserve(&mut self.mask, samples)?;
        Ok(reserve(&mut self.features, samples * channels)?)
    }

    /// Compared samples.
    pub(crate) fn samples(&self) -> u64 {
        self.mask.iter().filter(|&&on| on).count() as u64
    }
}
