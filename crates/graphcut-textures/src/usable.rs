//! Which sources are worth a patch where a field says which may show.

use selvedge_core::{Domain, Window};

use crate::canvas::Canvas;

/// A patch has to show in at least one of so many positions that it is laid for. One that shows in a sliver alone,
/// because its scale ends there, costs a search and a cut, and the next one has to begin where it did.
const SHARE: u32 = 4;

/// A set of sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Usable(Option<u64>);

impl Usable {
    /// All sources, however many there are.
    pub(crate) fn all() -> Self {
        Self(None)
    }

    pub(crate) fn has(self, source: usize) -> bool {
        self.0.is_none_or(|bits| bits >> source & 1 == 1)
    }

    /// The sources that may show at a position of a region and in a fair share of what a patch is laid there for: the
    /// region's holes, or, where it has none, all of it. If no source has that share, those that may show most.
    pub(crate) fn of<const D: usize>(canvas: &Canvas<'_, D>, region: &Window<D>, at: [i32; D]) -> Self {
        let Some(allowed) = &canvas.allowed else { return Self::all() };
        let (allowed, ids, output) = (allowed.plane(0), canvas.map.ids.plane(0), canvas.domain());
        let places: Vec<usize> = region.places(output).flatten().collect();
        let holes: Vec<usize> = places.iter().filter(|&&place| !ids[place].is_assigned()).copied().collect();
        let wanted = if holes.is_empty() { places } else { holes };
        let mut shown = [0_u32; u64::BITS as usize];
        for &place in &wanted {
            sources(allowed[place]).for_each(|s| shown[s] += 1);
        }
        let here = place(output, at).map_or(0, |place| allowed[place]);
        let most = sources(here).map(|s| shown[s]).max().unwrap_or(0);
        let least = most.min((wanted.len() as u32).div_ceil(SHARE));
        Self(Some(sources(here).filter(|&s| least <= shown[s]).fold(0, |bits, s| bits | 1 << s)))
    }
}

/// The numbers of the bits that are set.
fn sources(bits: u64) -> impl Iterator<Item = usize> {
    (0..u64::BITS as usize).filter(move |s| bits >> s & 1 == 1)
}

/// Place in the output's buffer of a position that is not wrapped.
fn place<const D: usize>(output: Domain<D>, at: [i32; D]) -> Option<usize> {
    Some(output.index(output.step([0; D], at)?))
}
