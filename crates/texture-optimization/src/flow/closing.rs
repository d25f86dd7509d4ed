//! Frames that lead back to the first one, so that it may follow the last.
//!
//! What the first frame shows is carried back, against the flow: what it would have been a frame before it began, and
//! so on. Over the last frames the wish to be the frame before, moved, passes to the wish to be that, cell by cell: a
//! mean of both would be a wish for mush. What has passed once agrees with both from then on.

use selvedge_core::{CameFrom, Domain, Error, Seed, try_vec};

use super::carry::Carried;

/// Samples a side of what passes at once: neighborhoods of 16 and 32 samples lay texture over its borders.
const CELL: u32 = 16;

/// What is to be shown, frame after frame, and how soon.
#[derive(Clone, Debug)]
pub(crate) struct Closing {
    /// Those ahead, the next one last.
    ahead: Vec<Target>,
    /// How many there were.
    of: usize,
    /// By cell, row-major, which of them pass first.
    ranks: Vec<u32>,
    cells: [u32; 2],
}

/// A frame as it would lead to the first one.
#[derive(Clone, Debug)]
struct Target {
    carried: Carried,
    is_sure: Vec<bool>,
}

impl Closing {
    /// Goes back from the first frame, by where samples of each frame before come from in the one after it, the last
    /// one first.
    pub(crate) fn new(
        first: &Carried,
        output: Domain<2>,
        back: impl ExactSizeIterator<Item = Result<Vec<CameFrom>, Error>>,
        seed: Seed,
    ) -> Result<Self, Error> {
        let of = back.len();
        let mut ahead: Vec<Target> = Vec::new();
        selvedge_core::reserve(&mut ahead, of)?;
        for origins in back {
            let origins = origins?;
            let (carried, known) = ahead.last().map_or((first, None), |t| (&t.carried, Some(&t.is_sure)));
            let mut is_sure = try_vec(origins.len(), false)?;
            for (sure, origin) in is_sure.iter_mut().zip(&origins) {
                let there = output.index(origin.nearest(output).0);
                *sure = origin.is_sure && known.is_none_or(|known| known[there]);
            }
            ahead.push(Target { carried: carried.moved(&origins)?, is_sure });
        }
        let cells = output.shape.map(|side| side.div_ceil(CELL));
        let mut ranks = try_vec((cells[0] * cells[1]) as usize, 0)?;
        ranks.iter_mut().zip(0..).for_each(|(rank, number)| *rank = number);
        let mut rng = seed.derive("animate/close", 0).rng();
        for i in (1..ranks.len()).rev() {
            ranks.swap(i, rng.below(i as u32 + 1) as usize);
        }
        Ok(Self { ahead, of, ranks, cells })
    }

    /// The next frame is there; false if none was ahead.
    pub(crate) fn go_on(&mut self) -> bool {
        self.ahead.pop().is_some()
    }

    /// Lets cells of the next frame pass: so many of all as frames of all are gone with it.
    pub(crate) fn pass(&self, output: Domain<2>, moved: &mut Carried, origins: &mut [CameFrom]) {
        let Some(target) = self.ahead.last() else { return };
        let gone = self.of + 1 - self.ahead.len();
        let passed = |at: [u32; 2]| {
            let [y, x] = at.map(|p| p / CELL);
            let rank = self.ranks[(y * self.cells[1] + x) as usize];
            (rank as usize * self.of) < gone * self.ranks.len()
        };
        for (i, _) in output.positions().enumerate().filter(|(_, at)| passed(*at)) {
            moved.take(i, &target.carried);
            origins[i].is_sure = target.is_sure[i];
        }
    }
}
