//! What masks leave open, without a search: gaps of patches that were laid, and all where no patch is left.
//!
//! A mask of noise leaves gaps all over a patch, and a search fills a share of them alone: half of the samples masked
//! by chance took eleven times as many patches as none, and 9.2 s where none took 1.

use selvedge_core::{Domain, Patch, Window};

use crate::error::Error;
use crate::usable::Usable;
use crate::weaver::Weaver;

/// Of what is missing in a region one in so many lies next to what stands, if they are gaps: the gaps of a patch of
/// which one in twenty samples is valid do, a piece that is missing whole does not, unless it is a strip.
const BESIDE: usize = 3;
/// What is moved has to show one in so many gaps: of less a search finds more.
const SHOWN: usize = 16;

impl<const D: usize> Weaver<'_, D> {
    /// Where masks leave crumbs alone, each hole shows one of them, by chance.
    pub(crate) fn strew(&mut self) {
        let crumbs = self.matcher.few.crumbs().filter(|c| !c.is_empty() && self.canvas.allowed.is_none());
        let Some(crumbs) = crumbs else { return };
        let table = self.canvas.exemplars.table();
        let ids: Vec<_> = crumbs.into_iter().map(|(source, at)| table.id(source, at)).collect();
        let mut rng = self.run.seed.derive("graphcut/crumbs", 0).rng();
        self.stats.patches += self.canvas.holes as u64;
        self.canvas.fill_each(|| ids[rng.below(ids.len() as u32) as usize]);
    }

    /// Cuts a patch from around a hole, moved by a sample, into a region; false where none shows enough of its gaps.
    ///
    /// # Errors
    /// [`Error::Cut`]
    pub(crate) fn fill_gaps(&mut self, region: &Window<D>, hole: [u32; D]) -> Result<bool, Error> {
        let hole = region.unwrapped(self.canvas.domain(), hole);
        let Some(patch) = self.moved(region, hole) else { return Ok(false) };
        let mut worker = std::mem::take(&mut self.workers[0]);
        let cut = self.cut_in(&patch, region, &mut worker.cut);
        self.workers[0] = worker;
        cut.map(|()| true)
    }

    /// Of the patches around a hole, moved by a sample, the one that shows most gaps of a region; `None` where some
    /// source holds whole regions: patches have few gaps then.
    fn moved(&self, region: &Window<D>, hole: [i32; D]) -> Option<Patch<D>> {
        if self.matcher.holds(self.region, Usable::all()) {
            return None;
        }
        let local = region.local();
        let unwrapped = |at: [u32; D]| std::array::from_fn(|a| region.start[a] + at[a] as i32);
        let holes: Vec<[i32; D]> =
            local.positions().map(unwrapped).filter(|&at| self.stands(at) == Some(false)).collect();
        let is_gap = |at: &&[i32; D]| steps([true; D]).any(|by| self.stands(moved(**at, by)) == Some(true));
        if holes.iter().filter(is_gap).count() * BESIDE < holes.len() {
            return None;
        }
        let around = Window { start: hole.map(|n| n - 1), shape: [3; D] }.inside(self.canvas.domain());
        let shows = |patch: &Patch<D>, at: [i32; D]| self.canvas.offered(patch, at).is_some();
        let neighbours = self.canvas.map.patches(&around);
        let by_one = |patch: &Patch<D>| {
            let Patch { source, offset } = *patch;
            steps(self.options.free).map(move |by| Patch { source, offset: moved(offset, by) })
        };
        let showing = neighbours.iter().flat_map(by_one).filter(|patch| shows(patch, hole));
        let counted = showing.map(|patch| (holes.iter().filter(|&&at| shows(&patch, at)).count(), patch));
        let best = counted.reduce(|best, next| if best.0 < next.0 { next } else { best });
        best.filter(|(shown, _)| holes.len() <= shown * SHOWN).map(|(_, patch)| patch)
    }

    /// Whether anything is at a position, given unwrapped; `None` outside of the output.
    fn stands(&self, at: [i32; D]) -> Option<bool> {
        let at = self.canvas.domain().step([0; D], at)?;
        Some(self.canvas.map.ids.get(0, at).is_assigned())
    }
}

fn moved<const D: usize>(at: [i32; D], by: [i32; D]) -> [i32; D] {
    std::array::from_fn(|a| at[a] + by[a])
}

/// A sample along the free axes, in every direction.
fn steps<const D: usize>(free: [bool; D]) -> impl Iterator<Item = [i32; D]> {
    let all = Domain::open(free.map(|free| if free { 3 } else { 1 })).positions();
    let by = move |at: [u32; D]| std::array::from_fn(|a| at[a] as i32 - i32::from(free[a]));
    all.map(by).filter(|by| *by != [0; D])
}
