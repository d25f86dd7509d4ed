//! From a source map to samples, in the payload's own depth.

use crate::plane::Plane;
use crate::resample;
use crate::source_map::SourceTable;
use crate::{Domain, Error, Grid, NormalCoding, Role, SampleId, Samples, SourceMap, Transform, par, try_vec};

/// Samples that one task looks up.
const TOGETHER: usize = 1 << 14;

/// What can be laid over registered planes.
pub trait Render<const D: usize> {
    /// The output's plane, from the same plane of each exemplar, in the exemplars' order.
    ///
    /// # Errors
    /// If planes are missing, differ in layout, or have another shape than their exemplar.
    fn render(&self, plane_of_each_exemplar: &[&Plane<D>]) -> Result<Plane<D>, Error>;

    /// The source map, where this is one: for those who look at more than its samples.
    fn as_map(&self) -> Option<&SourceMap<D>> {
        None
    }
}

impl<const D: usize> Render<D> for SourceMap<D> {
    /// Copies samples bit for bit; unassigned positions are 0. Normals are turned with their source. Samples of resampled
    /// sources are interpolated.
    fn render(&self, planes: &[&Plane<D>]) -> Result<Plane<D>, Error> {
        Payload::new(&self.table, planes)?.gather(&self.ids)
    }

    fn as_map(&self) -> Option<&SourceMap<D>> {
        Some(self)
    }
}

/// A plane of each exemplar, ready to be looked up by sample numbers: for those who render more than copies.
#[derive(Debug)]
pub struct Payload<'a, const D: usize> {
    table: &'a SourceTable<D>,
    planes: Vec<&'a Plane<D>>,
    /// The plane of each source that is resampled.
    resampled: Vec<Option<Plane<D>>>,
    /// For turned sources the exemplar's index of each sample; `None` where it is the sample's own.
    turned: Vec<Option<Vec<u32>>>,
}

impl<'a, const D: usize> Payload<'a, D> {
    /// Takes a plane of each exemplar, in the exemplars' order, and resamples it for the sources that are.
    ///
    /// # Errors
    /// Those of [`Render::render`].
    pub fn new(table: &'a SourceTable<D>, planes: &[&'a Plane<D>]) -> Result<Self, Error> {
        check(table, planes)?;
        let turned = table.sources().iter().map(|&(origin, domain)| origin_indices(origin.transform, domain));
        let turned = turned.collect::<Result<_, _>>()?;
        Ok(Self { table, planes: planes.to_vec(), resampled: resampled(table, planes)?, turned })
    }

    /// The planes, as they were given.
    pub fn planes(&self) -> &[&'a Plane<D>] {
        &self.planes
    }

    /// The samples of these numbers; 0 where none is assigned.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn gather(&self, ids: &Grid<SampleId, D>) -> Result<Plane<D>, Error> {
        let first = self.planes[0];
        macro_rules! copy {
            ($depth:ident, $negate:expr) => {{
                let grids = (0..self.table.sources().len()).map(|s| match &self.of_source(s).samples {
                    Samples::$depth(g) => g,
                    _ => unreachable!("layouts were compared"),
                });
                Samples::$depth(self.copy(ids, &grids.collect::<Vec<_>>(), first.role, $negate)?)
            }};
        }
        let samples = match &first.samples {
            Samples::U8(_) => copy!(U8, |v| 255 - v),
            Samples::U16(_) => copy!(U16, |v| 65_535 - v),
            Samples::F16(_) => copy!(F16, |v| v ^ 0x8000),
            Samples::F32(_) => copy!(F32, |v: f32| -v),
        };
        Ok(Plane { role: first.role, samples, alpha: first.alpha })
    }

    fn of_source(&self, source: usize) -> &Plane<D> {
        let exemplar = usize::from(self.table.sources()[source].0.exemplar);
        self.resampled[source].as_ref().unwrap_or(self.planes[exemplar])
    }

    /// Copies each sample of each channel from the grid of its source; `negate` mirrors one component of a normal.
    fn copy<T: Copy + Default + Send + Sync>(
        &self,
        ids: &Grid<SampleId, D>,
        grids: &[&Grid<T, D>],
        role: Role,
        negate: impl Fn(T) -> T + Send + Sync,
    ) -> Result<Grid<T, D>, Error> {
        let channels = grids[0].channels();
        let mut out = Grid::try_filled(ids.domain(), channels, T::default())?;
        for c in 0..channels {
            let payload: Vec<(&[T], bool)> = self
                .table
                .sources()
                .iter()
                .zip(grids)
                .map(|((origin, _), grid)| {
                    let (from, negated) = component(role, origin.transform, c);
                    (grid.plane(from), negated)
                })
                .collect();
            let ids = ids.plane(0);
            par::for_rows(out.plane_mut(c), TOGETHER, |part, to| {
                // Neighbours mostly come from one source.
                let mut source = 0;
                for (to, &id) in to.iter_mut().zip(&ids[part * TOGETHER..]) {
                    if !self.table.holds(source, id) {
                        let Some(found) = self.table.source(id) else { continue };
                        source = found;
                    }
                    let (plane, negated) = payload[source];
                    let value = plane[self.index(source, id)];
                    *to = if negated { negate(value) } else { value };
                }
            });
        }
        Ok(out)
    }

    #[inline]
    fn index(&self, source: usize, id: SampleId) -> usize {
        let own = (id.get() - self.table.first(source)) as usize;
        self.turned[source].as_ref().map_or(own, |t| t[own] as usize)
    }
}

/// A plane for each exemplar, of one layout, each of its exemplar's shape.
fn check<const D: usize>(table: &SourceTable<D>, planes: &[&Plane<D>]) -> Result<(), Error> {
    let expected = table.sources().iter().map(|(o, _)| usize::from(o.exemplar) + 1).max().unwrap_or(0);
    if planes.len() != expected || planes.is_empty() {
        return Err(Error::PlaneCount { expected, found: planes.len() });
    }
    let first = planes[0];
    for (e, plane) in planes.iter().enumerate() {
        if (plane.role, plane.layout()) != (first.role, first.layout()) {
            return Err(Error::Layout { exemplar: e, expected: first.layout(), found: plane.layout() });
        }
    }
    for (origin, domain) in table.sources() {
        let plane = planes[usize::from(origin.exemplar)];
        let found = origin.transform.domain(plane.domain()).shape;
        if found != domain.shape {
            let (expected, found) = (domain.shape.to_vec(), found.to_vec());
            return Err(Error::Shape { exemplar: origin.exemplar.into(), plane: 0, expected, found });
        }
    }
    Ok(())
}

/// The plane of each source that is resampled.
fn resampled<const D: usize>(table: &SourceTable<D>, planes: &[&Plane<D>]) -> Result<Vec<Option<Plane<D>>>, Error> {
    let normals = NormalCoding::of(planes);
    let of = |(origin, _): &(crate::Origin, Domain<D>)| {
        let plane = planes[usize::from(origin.exemplar)];
        origin.transform.resampling().map(|r| resample::plane(plane, r, normals)).transpose()
    };
    table.sources().iter().map(of).collect()
}

/// Which component stands in channel `c` of a turned plane, and whether it is negated.
fn component(role: Role, transform: Transform, c: usize) -> (usize, bool) {
    match (role, c) {
        (Role::Normal, 0 | 1) => transform.vector()[c],
        _ => (c, false),
    }
}

fn origin_indices<const D: usize>(transform: Transform, source: Domain<D>) -> Result<Option<Vec<u32>>, Error> {
    if transform == Transform::IDENTITY || transform.resampling().is_some() {
        return Ok(None);
    }
    // Undoing an exact transform swaps the sides exactly as doing it does.
    let exemplar = transform.domain(source);
    let mut indices = try_vec(source.len(), 0_u32)?;
    for (to, at) in indices.iter_mut().zip(source.positions()) {
        *to = exemplar.index(transform.origin(source, at)) as u32;
    }
    Ok(Some(indices))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Encoder, Exemplars};

    fn map_of(plane: &Plane<2>, transform: Transform) -> SourceMap<2> {
        let planes = [std::slice::from_ref(plane)];
        let encoder = Encoder::fit(&planes).unwrap();
        let exemplars = Exemplars::new(&encoder, &planes, &[transform]).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, exemplars.sources()[0].domain()).unwrap();
        for (i, id) in map.ids.plane_mut(0).iter_mut().enumerate() {
            *id = SampleId::new(i as u32);
        }
        map
    }

    fn floats(values: Vec<f32>, channels: usize) -> Samples<2> {
        let width = (values.len() / channels) as u32;
        Samples::F32(Grid::from_vec(Domain::open([1, width]), channels, values).unwrap())
    }

    #[test]
    fn floats_are_copied_bit_for_bit() {
        let plane = Plane::new(Role::Color, floats(vec![-0.0, 1.0e-40, -7.5, 60_000.0], 1));
        let mut map = map_of(&plane, Transform::IDENTITY);
        map.ids.plane_mut(0).reverse();
        let Samples::F32(out) = map.render(&[&plane]).unwrap().samples else { panic!("the depth is kept") };
        let bits: Vec<u32> = out.plane(0).iter().map(|v| v.to_bits()).collect();
        assert_eq!(bits, [60_000.0_f32, -7.5, 1.0e-40, -0.0].map(f32::to_bits));
    }

    #[test]
    fn normals_turn_with_their_source() {
        let plane = Plane::new(Role::Normal, floats(vec![0.25, 0.5, 0.75], 3));
        let turn = Transform::Exact { quarter_turns: 1, mirror: false };
        let out = map_of(&plane, turn).render(&[&plane]).unwrap();
        assert_eq!(out.samples, floats(vec![0.5, -0.25, 0.75], 3));
    }

    #[test]
    fn unassigned_positions_are_zero() {
        let plane = Plane::new(Role::Color, floats(vec![1.0, 2.0], 1));
        let mut map = map_of(&plane, Transform::IDENTITY);
        map.ids.plane_mut(0)[0] = SampleId::UNASSIGNED;
        assert_eq!(map.render(&[&plane]).unwrap().samples, floats(vec![0.0, 2.0], 1));
    }

    #[test]
    fn wrong_planes_are_refused() {
        let plane = Plane::new(Role::Color, floats(vec![1.0, 2.0], 1));
        let map = map_of(&plane, Transform::IDENTITY);
        let wide = Plane::new(Role::Color, floats(vec![1.0, 2.0, 3.0], 1));
        assert!(matches!(map.render(&[&wide]), Err(Error::Shape { .. })));
        assert_eq!(map.render(&[]), Err(Error::PlaneCount { expected: 1, found: 0 }));
    }
}
