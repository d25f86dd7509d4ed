//! From a source map to samples, in the payload's own depth.

use crate::{Error, Payload, Plane, SourceMap};

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

    /// The same for those who keep it.
    fn into_map(self: Box<Self>) -> Option<SourceMap<D>> {
        None
    }
}

impl<const D: usize> Render<D> for SourceMap<D> {
    /// Copies samples bit for bit; unassigned positions are 0. Normals are turned with their source. Samples of
    /// resampled sources are interpolated.
    fn render(&self, planes: &[&Plane<D>]) -> Result<Plane<D>, Error> {
        Payload::new(&self.table, planes)?.gather(&self.ids)
    }

    fn as_map(&self) -> Option<&SourceMap<D>> {
        Some(self)
    }

    fn into_map(self: Box<Self>) -> Option<SourceMap<D>> {
        Some(*self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Domain, Encoder, Exemplar, Exemplars, Grid, Role, SampleId, Samples, Transform};

    fn map_of(plane: &Plane<2>, transform: Transform) -> SourceMap<2> {
        let planes = [std::slice::from_ref(plane)];
        let encoder = Encoder::fit(&planes).unwrap();
        let exemplars = Exemplars::new(&encoder, &[Exemplar::new(planes[0]).shown(&[transform])]).unwrap();
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
        let plane = Plane::new(Role::Normal, floats(vec![-0.25, 0.5, 0.75], 3));
        let turn = Transform::Exact { quarter_turns: 1, mirror: false };
        let out = map_of(&plane, turn).render(&[&plane]).unwrap();
        assert_eq!(out.samples, floats(vec![0.5, 0.25, 0.75], 3));
    }

    #[test]
    fn normals_with_y_down_turn_as_those_with_y_up() {
        // Upside down before and after is the same as the other role.
        for transform in (0..8).map(|i| Transform::Exact { quarter_turns: i % 4, mirror: 4 <= i }) {
            let shown = |role, y: f32, up: f32| {
                let plane = Plane::new(role, floats(vec![-0.36, y, 0.8], 3));
                let Samples::F32(mut out) = map_of(&plane, transform).render(&[&plane]).unwrap().samples else {
                    panic!()
                };
                out.plane_mut(1).iter_mut().for_each(|v| *v *= up);
                out.samples().iter().map(|v| (v * 1e5).round()).collect::<Vec<f32>>()
            };
            let (up, down) = (shown(Role::Normal, 0.48, 1.0), shown(Role::NormalDown, -0.48, -1.0));
            assert_eq!(up, down, "{transform:?}");
        }
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
