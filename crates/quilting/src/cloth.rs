//! What was laid so far.

use selvedge_core::{Error, SampleId, SourceMap, Usage, try_vec};

use crate::block_grid::Block;
use crate::options::{Continuation, Stage};
use crate::pass::Pass;
use crate::search::{Candidate, Successor};

/// The output in the making, and where its blocks came from.
pub(crate) struct Cloth<'a> {
    pub(crate) map: &'a mut SourceMap<2>,
    /// What was laid at each block so far.
    pub(crate) laid: Vec<Option<Candidate>>,
    /// How often the parts of the exemplars were laid.
    pub(crate) usage: Usage<2>,
}

impl<'a> Cloth<'a> {
    /// Nothing is laid yet by this pass.
    pub(crate) fn new(pass: &Pass<'_>, map: &'a mut SourceMap<2>) -> Result<Self, Error> {
        let usage = Usage::new(pass.exemplars, [pass.block; 2], pass.spread)?;
        Ok(Self { map, laid: try_vec(pass.grid.len(), None)?, usage })
    }

    /// Where the blocks next to this one would go on in their sources.
    pub(crate) fn continuations(&self, pass: &Pass<'_>, number: usize, block: &Block) -> Vec<Successor> {
        if pass.stage == Stage::Random || pass.continuation == Continuation::Allow {
            return Vec::new();
        }
        let output = self.map.domain();
        let go_on = |neighbor: usize| {
            let laid = self.laid[neighbor]?;
            let [dy, dx] = pass.grid.block(neighbor).way_to(output, block);
            Some(Successor { source: laid.source, at: [i64::from(laid.at[0]) + dy, i64::from(laid.at[1]) + dx] })
        };
        pass.grid.neighbors(number).filter_map(go_on).collect()
    }

    /// Lays a block where `new` is true; everywhere if there is no such list.
    pub(crate) fn lay(&mut self, number: usize, block: &Block, chosen: Candidate, new: Option<&[bool]>) {
        self.paste(block, chosen, new);
        self.usage.note(chosen.source, chosen.at);
        self.laid[number] = Some(chosen);
    }

    /// Writes the samples of the chosen block.
    fn paste(&mut self, block: &Block, chosen: Candidate, new: Option<&[bool]>) {
        let (window, [height, width]) = (block.window(), block.shape());
        let mut places = window.places(self.map.domain());
        let SourceMap { ids, table } = &mut *self.map;
        let ids = ids.plane_mut(0);
        for y in 0..height {
            let first = table.id(chosen.source, [chosen.at[0] + y, chosen.at[1]]).get();
            let row = new.map(|new| &new[(y * width) as usize..][..width as usize]);
            for (x, place) in (0..width).zip(&mut places) {
                if let Some(place) = place.filter(|_| row.is_none_or(|row| row[x as usize])) {
                    ids[place] = SampleId::new(first + x);
                }
            }
        }
    }
}
