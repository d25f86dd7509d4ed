//! What lies under a window: features, as searches want them.

use crate::window::emptied;
use crate::{Domain, Error, Exemplars, Grid, SourceMap, Window};

/// Features under a window, planar, and where they are known. Its memory serves look after look.
///
/// ```
/// use selvedge_core::{Domain, Grid, Look, Window};
/// # fn main() -> Result<(), selvedge_core::Error> {
/// let guide = Grid::from_vec(Domain { shape: [1, 4], periodic: [false, true] }, 1, vec![10, 20, 30, 40])?;
/// let mut look = Look::new();
/// look.at_grid(&guide, None, &Window { start: [-1, 3], shape: [2, 2] })?;
/// assert_eq!((look.features(), look.known()), (&[0, 0, 40, 10][..], &[false, false, true, true][..]));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Look {
    features: Vec<u8>,
    known: Vec<bool>,
}

impl Look {
    /// One that has not seen anything.
    pub fn new() -> Self {
        Self::default()
    }

    /// Channel by channel, each row-major over the window; 0 where nothing is known.
    pub fn features(&self) -> &[u8] {
        &self.features
    }

    /// By position, row-major: false outside of open axes, in holes, and where nobody wanted to look.
    pub fn known(&self) -> &[bool] {
        &self.known
    }

    /// Positions that are known.
    pub fn samples(&self) -> usize {
        self.known.iter().filter(|known| **known).count()
    }

    /// Looks at an output in the making where it is `wanted`, a question to each of the window's own positions.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn at_map<const D: usize>(
        &mut self,
        exemplars: &Exemplars<D>,
        map: &SourceMap<D>,
        window: &Window<D>,
        wanted: impl Fn([u32; D]) -> bool,
    ) -> Result<(), Error> {
        let channels = exemplars.channels();
        self.reset(window, channels)?;
        let (len, ids, table) = (self.known.len(), map.ids.plane(0), exemplars.table());
        let local = window.local();
        for (i, place) in window.places(map.domain()).enumerate() {
            let Some(id) = place.map(|p| ids[p]).filter(|_| wanted(local.position(i))) else { continue };
            let Some(source) = table.source(id) else { continue };
            let (features, index) = (&exemplars.sources()[source].features, (id.get() - table.first(source)) as usize);
            self.known[i] = true;
            for c in 0..channels {
                self.features[c * len + i] = features.plane(c)[index];
            }
        }
        Ok(())
    }

    /// Looks at features over a domain, such as a guide's target; where `valid` is false, nothing is known.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    ///
    /// # Panics
    /// If both have different shapes.
    pub fn at_grid<const D: usize>(
        &mut self,
        grid: &Grid<u8, D>,
        valid: Option<&Grid<bool, D>>,
        window: &Window<D>,
    ) -> Result<(), Error> {
        let shape = |domain: Domain<D>| domain.shape;
        assert!(valid.is_none_or(|v| shape(v.domain()) == shape(grid.domain())), "a mask has its grid's shape");
        self.reset(window, grid.channels())?;
        let len = self.known.len();
        for (i, place) in window.places(grid.domain()).enumerate() {
            let Some(place) = place.filter(|&p| valid.is_none_or(|v| v.samples()[p])) else { continue };
            self.known[i] = true;
            for c in 0..grid.channels() {
                self.features[c * len + i] = grid.plane(c)[place];
            }
        }
        Ok(())
    }

    /// Nothing known over a window.
    fn reset<const D: usize>(&mut self, window: &Window<D>, channels: usize) -> Result<(), Error> {
        let len = window.local().checked_len();
        emptied(&mut self.known, len)?;
        emptied(&mut self.features, len.and_then(|n| n.checked_mul(channels)))?;
        self.known.resize(window.len(), false);
        self.features.resize(window.len() * channels, 0);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Origin, SampleId, Source, Transform};

    #[test]
    fn a_look_at_a_map_sees_features_where_they_stand_and_are_wanted() {
        let features = Grid::from_vec(Domain::open([1, 3]), 2, vec![1, 2, 3, 11, 12, 13]).unwrap();
        let source = Source { features, valid: None, origin: Origin { exemplar: 0, transform: Transform::IDENTITY } };
        let exemplars = Exemplars::from_sources(vec![source.clone(), source], vec![1, 1]).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, Domain { shape: [3, 1], periodic: [true, false] }).unwrap();
        map.ids.plane_mut(0)[..2].copy_from_slice(&[SampleId::new(5), SampleId::new(1)]);
        let (mut look, window) = (Look::new(), Window { start: [-1, -1], shape: [3, 2] });
        // What was seen before does not shine through.
        look.at_grid(&Grid::try_filled(Domain::open([9, 9]), 3, 7).unwrap(), None, &window).unwrap();
        look.at_map(&exemplars, &map, &window, |_| true).unwrap();
        assert_eq!(look.known(), [false, false, false, true, false, true]);
        assert_eq!(look.features(), [0, 0, 0, 3, 0, 2, 0, 0, 0, 13, 0, 12]);
        look.at_map(&exemplars, &map, &window, |[y, _]| y == 2).unwrap();
        assert_eq!((look.samples(), look.features()[3], look.features()[5]), (1, 0, 2));
    }

    #[test]
    fn a_look_at_a_guide_knows_what_its_mask_leaves() {
        let guide = Grid::from_vec(Domain::open([2, 2]), 1, vec![1, 2, 3, 4]).unwrap();
        let valid = Grid::from_vec(Domain::open([2, 2]), 1, vec![true, true, false, true]).unwrap();
        let mut look = Look::new();
        look.at_grid(&guide, Some(&valid), &Window { start: [0, 0], shape: [2, 3] }).unwrap();
        assert_eq!(look.known(), [true, true, false, false, true, false]);
        assert_eq!(look.features(), [1, 2, 0, 0, 4, 0]);
        let huge = Window { start: [0; 2], shape: [u32::MAX; 2] };
        assert!(matches!(look.at_grid(&guide, None, &huge), Err(Error::Allocation { .. })));
    }
}
