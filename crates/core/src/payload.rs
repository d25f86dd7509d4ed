//! A plane of each exemplar, looked up by sample numbers.

use half::f16;

use crate::plane::Plane;
use crate::resample;
use crate::source_table::SourceTable;
use crate::{
    Bytes, Depth, Domain, Error, Grid, NormalCoding, Origin, Role, SampleId, Samples, Transform, par, try_vec,
};

/// Samples that one task looks up: enough that starting it costs nothing beside them.
const TOGETHER: usize = 1 << 14;

/// A plane of each exemplar, ready to be looked up by sample numbers: for those who render more than copies.
#[derive(Debug)]
pub struct Payload<'a, const D: usize> {
    table: &'a SourceTable<D>,
    planes: Vec<&'a Plane<D>>,
    /// The plane of each source that is resampled.
    resampled: Vec<Option<Plane<D>>>,
    /// How floats code normals: what is negated of those that span 0 to 1 is taken from 1.
    coding: NormalCoding,
    /// For turned sources the exemplar's index of each sample; `None` where it is the sample's own.
    turned: Vec<Option<Vec<u32>>>,
}

impl<'a, const D: usize> Payload<'a, D> {
    /// Takes a plane of each exemplar, in the exemplars' order, and resamples it for the sources that are.
    ///
    /// # Errors
    /// Those of [`Render::render`](crate::Render::render).
    pub fn new(table: &'a SourceTable<D>, planes: &[&'a Plane<D>]) -> Result<Self, Error> {
        check(table, planes)?;
        let turned = table.sources().iter().map(|&(origin, domain)| origin_indices(origin.transform, domain));
        let turned = turned.collect::<Result<_, _>>()?;
        // Every sample of floats is looked at for it: not of what has no directions.
        let coding = if planes[0].role.is_normal() { NormalCoding::of(planes) } else { NormalCoding::SIGNED };
        Ok(Self { table, planes: planes.to_vec(), resampled: resampled(table, planes, coding)?, coding, turned })
    }

    /// An upper bound of the bytes that it holds beside the planes: for sources of these transforms and shapes, of
    /// planes of so many channels in that depth. Resampled sources have samples of their own, turned ones numbers of
    /// the exemplar's.
    pub fn bytes(sources: &[(Transform, Domain<D>)], channels: usize, depth: Depth) -> Bytes {
        let of = |&(transform, domain): &(Transform, Domain<D>)| match transform {
            Transform::IDENTITY => Bytes(0),
            Transform::Exact { .. } => Bytes::of_samples(domain, size_of::<u32>() as u64),
            Transform::Resampled { .. } => Bytes::of_samples(domain, depth.bytes()) * channels as u64,
        };
        sources.iter().map(of).sum()
    }

    /// The planes, as they were given.
    pub fn planes(&self) -> &[&'a Plane<D>] {
        &self.planes
    }

    /// The samples of these numbers, bit for bit; 0 where none is assigned.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn gather(&self, ids: &Grid<SampleId, D>) -> Result<Plane<D>, Error> {
        let first = self.planes[0];
        macro_rules! copied {
            ($depth:ident, $negate:expr) => {{
                let mut out = Grid::try_filled(ids.domain(), first.samples.channels(), Default::default())?;
                for c in 0..out.channels() {
                    let channel = self.channel(c, |samples| match samples {
                        Samples::$depth(g) => g,
                        _ => unreachable!("layouts were compared"),
                    });
                    par::for_rows(out.plane_mut(c), TOGETHER, |part, to| {
                        let ids = &ids.plane(0)[part * TOGETHER..][..to.len()];
                        self.look_up(ids, &channel, to, |v, negated| if negated { $negate(v) } else { v });
                    });
                }
                Samples::$depth(out)
            }};
        }
        let samples = match &first.samples {
            Samples::U8(_) => copied!(U8, |v| 255 - v),
            Samples::U16(_) => copied!(U16, |v| 65_535 - v),
            Samples::F16(_) => {
                copied!(F16, |v| f16::from_f32(self.coding.negated(f16::from_bits(v).to_f32())).to_bits())
            }
            Samples::F32(_) => copied!(F32, |v| self.coding.negated(v)),
        };
        Ok(Plane { role: first.role, samples, alpha: first.alpha, association: first.association })
    }

    /// One channel of a list of samples as numbers, as [`Samples::value`] has them; 0 where none is assigned.
    ///
    /// # Panics
    /// If the lists differ in length.
    pub fn numbers(&self, channel: usize, ids: &[SampleId], to: &mut [f64]) {
        assert_eq!(ids.len(), to.len(), "a number for each sample");
        macro_rules! read {
            ($depth:ident, $read:expr, $negate:expr) => {{
                let channel = self.channel(channel, |samples| match samples {
                    Samples::$depth(g) => g,
                    _ => unreachable!("layouts were compared"),
                });
                self.look_up(ids, &channel, to, |v, negated| $read(if negated { $negate(v) } else { v }))
            }};
        }
        match &self.planes[0].samples {
            Samples::U8(_) => read!(U8, f64::from, |v| 255 - v),
            Samples::U16(_) => read!(U16, f64::from, |v| 65_535 - v),
            Samples::F16(_) => read!(F16, |v| f16::from_bits(v).to_f64(), |v| f16::from_f32(
                self.coding.negated(f16::from_bits(v).to_f32())
            )
            .to_bits()),
            Samples::F32(_) => read!(F32, f64::from, |v| self.coding.negated(v)),
        }
    }

    fn of_source(&self, source: usize) -> &Plane<D> {
        let exemplar = usize::from(self.table.sources()[source].0.exemplar);
        self.resampled[source].as_ref().unwrap_or(self.planes[exemplar])
    }

    /// By source: the samples that a channel takes, and whether they are negated, as one component of a turned normal
    /// is.
    fn channel<T>(&self, c: usize, of: impl Fn(&Samples<D>) -> &Grid<T, D>) -> Vec<(&[T], bool)> {
        let one = |(source, (origin, _)): (usize, &(Origin, Domain<D>))| {
            // What has one channel has no direction, whatever it is called.
            let role = if self.planes[0].color_channels() < 2 { Role::Scalar } else { self.planes[0].role };
            let (from, negated) = component(role, origin.transform, c);
            (of(&self.of_source(source).samples).plane(from), negated)
        };
        self.table.sources().iter().enumerate().map(one).collect()
    }

    fn look_up<T: Copy, U: Default>(
        &self,
        ids: &[SampleId],
        channel: &[(&[T], bool)],
        to: &mut [U],
        read: impl Fn(T, bool) -> U,
    ) {
        // Neighbours mostly come from one source.
        let mut source = 0;
        for (to, &id) in to.iter_mut().zip(ids) {
            if !self.table.holds(source, id) {
                let Some(found) = self.table.source(id) else {
                    *to = U::default();
                    continue;
                };
                source = found;
            }
            let (samples, negated) = channel[source];
            *to = read(samples[self.index(source, id)], negated);
        }
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
fn resampled<const D: usize>(
    table: &SourceTable<D>,
    planes: &[&Plane<D>],
    normals: NormalCoding,
) -> Result<Vec<Option<Plane<D>>>, Error> {
    let of = |(origin, _): &(Origin, Domain<D>)| {
        let plane = planes[usize::from(origin.exemplar)];
        origin.transform.resampling().map(|r| resample::plane(plane, r, normals)).transpose()
    };
    table.sources().iter().map(of).collect()
}

/// Which component stands in channel `c` of a turned plane, and whether it is negated.
fn component(role: Role, transform: Transform, c: usize) -> (usize, bool) {
    match (role, c) {
        (Role::Normal, 0 | 1) => transform.vector()[c],
        (Role::NormalDown, 0 | 1) => {
            // Upside down, turned, and upside down again: what mixes x and y is negated once.
            let (from, negated) = transform.vector()[c];
            (from, negated != (from != c))
        }
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
    use crate::Seed;

    #[test]
    fn floats_that_span_0_to_1_are_turned_round_within_it() {
        let domain = Domain::open([1, 2]);
        let mirrored = Transform::Exact { quarter_turns: 0, mirror: true };
        let table = SourceTable::new(vec![(Origin { exemplar: 0, transform: mirrored }, domain)]).unwrap();
        let ids = Grid::from_vec(domain, 1, vec![SampleId::new(0), SampleId::new(1)]).unwrap();
        let turned = |x: [f32; 2], depth: Depth| {
            let samples = vec![x[0], x[1], 0.5, 0.5, 1.0, 1.0];
            let samples = match depth {
                Depth::F16 => {
                    let bits = samples.into_iter().map(|v| f16::from_f32(v).to_bits()).collect();
                    Samples::F16(Grid::from_vec(domain, 3, bits).unwrap())
                }
                _ => Samples::F32(Grid::from_vec(domain, 3, samples).unwrap()),
            };
            let plane = Plane::new(Role::Normal, samples);
            let payload = Payload::new(&table, &[&plane]).unwrap();
            let shown = payload.gather(&ids).unwrap();
            let mut listed = [0.0; 2];
            payload.numbers(0, ids.plane(0), &mut listed);
            assert_eq!([0, 1].map(|i| shown.samples.value(0, i)), listed);
            listed
        };
        for depth in [Depth::F16, Depth::F32] {
            assert_eq!(turned([0.25, 0.5], depth), [0.5, 0.75]);
            assert_eq!(turned([-0.5, 0.5], depth), [-0.5, 0.5]);
        }
    }

    #[test]
    fn one_channel_has_no_direction_whatever_it_is_called() {
        let (domain, turned) = (Domain::open([2, 2]), Transform::Exact { quarter_turns: 1, mirror: false });
        let table = SourceTable::new(vec![(Origin { exemplar: 0, transform: turned }, domain)]).unwrap();
        let plane = |role| Plane::new(role, Samples::U8(Grid::from_vec(domain, 1, vec![1, 2, 3, 4]).unwrap()));
        let ids = Grid::from_vec(domain, 1, (0..4).map(SampleId::new).collect()).unwrap();
        let of = |role| Payload::new(&table, &[&plane(role)]).unwrap().gather(&ids).unwrap().samples;
        assert_eq!(of(Role::Normal), of(Role::Scalar));
    }

    #[test]
    fn lists_are_answered_as_grids_are() {
        let exemplar = Domain::open([2, 3, 4]);
        let turned = |quarter_turns, mirror| Transform::Exact { quarter_turns, mirror };
        let transforms = [Transform::IDENTITY, turned(1, false), turned(2, true), Transform::new(30.0, 1.5, true)];
        let source = |t: Transform| (Origin { exemplar: 0, transform: t }, t.domain(exemplar));
        let table = SourceTable::new(transforms.map(source).to_vec()).unwrap();
        let mut rng = Seed(3).rng();
        let ids: Vec<SampleId> = (0..200)
            .map(|i| if i % 9 == 0 { SampleId::UNASSIGNED } else { SampleId::new(rng.below(table.len())) })
            .collect();
        let grid = Grid::from_vec(Domain::open([1, 10, 20]), 1, ids.clone()).unwrap();
        let n = 3 * exemplar.len();
        let bytes: Vec<u8> = (0..n).map(|_| rng.below(256) as u8).collect();
        let all = [
            Samples::U8(Grid::from_vec(exemplar, 3, bytes.clone()).unwrap()),
            Samples::U16(Grid::from_vec(exemplar, 3, bytes.iter().map(|&v| 257 * u16::from(v)).collect()).unwrap()),
            Samples::F16(Grid::from_vec(exemplar, 3, bytes.iter().map(|&v| 0x3000 + u16::from(v)).collect()).unwrap()),
            Samples::F32(Grid::from_vec(exemplar, 3, bytes.iter().map(|&v| f32::from(v) - 99.0).collect()).unwrap()),
        ];
        for samples in all {
            for role in [Role::Color, Role::Normal, Role::NormalDown] {
                let plane = Plane::new(role, samples.clone());
                let payload = Payload::new(&table, &[&plane]).unwrap();
                let gathered = payload.gather(&grid).unwrap();
                for c in 0..3 {
                    let mut numbers = vec![7.0; ids.len()];
                    payload.numbers(c, &ids, &mut numbers);
                    let expected: Vec<f64> = (0..ids.len()).map(|i| gathered.samples.value(c, i)).collect();
                    assert_eq!(numbers, expected, "{role:?} {:?} {c}", plane.samples.depth());
                }
            }
        }
    }
}
