//! What is checked before any work: whether there is a block at all.

use selvedge_core::{Domain, Error as CoreError, Exemplars, Seed};

use crate::block_grid::Block;
use crate::finding::masked;
use crate::free::FreePlaces;
use crate::options::Error;

/// There is something to fill, and at least one source holds a block.
pub(crate) fn check_fit(exemplars: &Exemplars<2>, output: Domain<2>, block: Option<u32>) -> Result<(), Error> {
    if output.is_empty() {
        return Err(CoreError::EmptyOutput { shape: output.shape.to_vec() }.into());
    }
    let shapes = exemplars.sources().iter().map(|s| s.domain().shape);
    let [height, width] = shapes.max_by_key(|s| s[0].min(s[1])).unwrap_or([0, 0]);
    let limit = height.min(width);
    match block {
        Some(block) if limit < block => Err(Error::BlockExceedsExemplar { block, width, height, limit }),
        _ => Ok(()),
    }
}

/// Masks leave at least one place for the first block.
pub(crate) fn check_places(exemplars: &Exemplars<2>, block: &Block) -> Result<(), Error> {
    if !exemplars.is_masked() {
        return Ok(());
    }
    let any = FreePlaces::new(exemplars).draw(block.shape(), std::iter::empty(), &mut Seed(0).rng())?;
    any.map(|_| ()).ok_or_else(|| masked(block))
}
