//! Where a map was changed last, so that what was tried in vain is tried again only where something is new.

use selvedge_core::{Domain, Error, try_vec};

use crate::site::AROUND;

/// Changes are noted by tiles of so many samples a side: what becomes of a region follows from samples no further away
/// than that, so from the next tiles at most.
const TILE: u32 = AROUND;

/// By tile of a map, the number of the last change.
pub(crate) struct Changes {
    domain: Domain<2>,
    /// Along an axis.
    tiles: [u32; 2],
    last: Vec<u32>,
    now: u32,
}

impl Changes {
    pub(crate) fn new(domain: Domain<2>) -> Result<Self, Error> {
        // Of an axis that is around, the last tile may be as small as a sample: it belongs to the one before.
        let tiles = domain.shape.map(|n| (n / TILE).max(1));
        Ok(Self { domain, tiles, last: try_vec(tiles[0] as usize * tiles[1] as usize, 0)?, now: 0 })
    }

    /// The number of the last change of all.
    pub(crate) fn now(&self) -> u32 {
        self.now
    }

    /// Notes that these places may have been changed.
    pub(crate) fn note(&mut self, places: &[usize]) {
        self.now += 1;
        for &place in places {
            let [y, x] = self.tile(place);
            self.last[(y * self.tiles[1] + x) as usize] = self.now;
        }
    }

    /// True if nothing near these places was changed after the change of this number.
    pub(crate) fn none_near(&self, places: &[usize], since: u32) -> bool {
        let mut seen = None;
        places.iter().all(|&place| {
            let tile = self.tile(place);
            seen.replace(tile) == Some(tile) || self.around(tile).all(|i| self.last[i] <= since)
        })
    }

    fn tile(&self, place: usize) -> [u32; 2] {
        let at = self.domain.position(place);
        [0, 1].map(|a| (at[a] / TILE).min(self.tiles[a] - 1))
    }

    /// A tile and those beside it.
    fn around(&self, tile: [u32; 2]) -> impl Iterator<Item = usize> + '_ {
        let tiles = Domain { shape: self.tiles, periodic: self.domain.periodic };
        let step = move |i: i32| tiles.step(tile, [i / 3 - 1, i % 3 - 1]);
        (0..9).filter_map(step).map(move |at| tiles.index(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Seed;

    #[test]
    fn what_changed_near_by_is_known_and_what_changed_far_away_does_not_matter() {
        let mut rng = Seed(1).rng();
        let (mut near, mut none) = (0, 0);
        for periodic in [false, true] {
            let domain = Domain { shape: [75, 130], periodic: [periodic; 2] };
            let mut changes = Changes::new(domain).unwrap();
            for _ in 0..300 {
                let [a, b] = [0; 2].map(|_: u8| rng.below(domain.len() as u32) as usize);
                let since = changes.now();
                changes.note(&[a]);
                let (at, other) = (domain.position(a), domain.position(b));
                let apart = (0..2).map(|axis| {
                    let d = at[axis].abs_diff(other[axis]);
                    if periodic { d.min(domain.shape[axis] - d) } else { d }
                });
                let apart = apart.max().unwrap();
                let is_none = changes.none_near(&[b], since);
                assert!(changes.none_near(&[b], changes.now()));
                assert!(!is_none || AROUND < apart, "{at:?} {other:?}");
                assert!(is_none || apart < 3 * TILE, "{at:?} {other:?}");
                (near, none) = (near + u32::from(!is_none), none + u32::from(is_none));
            }
        }
        assert!(20 < near && 100 < none, "{near} {none}");
    }
}
