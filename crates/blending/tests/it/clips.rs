//! Clips are blended as pictures are: against the definitions, over any domain, on any number of threads.

use selvedge_blending::{Feathered, Splined};
use selvedge_core::{
    Averaging, Domain, Grid, Origin, Plane, Render, Rng, Role, SampleId, Samples, Seed, SourceMap, SourceTable,
    Transform,
};

/// Sources of one exemplar each, and a map of runs of patches from them.
struct Case<const D: usize> {
    planes: Vec<Plane<D>>,
    map: SourceMap<D>,
}

impl<const D: usize> Case<D> {
    fn new(sources: &[Domain<D>], output: Domain<D>, cell: u32, rng: &mut Rng) -> Self {
        let mut plane = |domain: &Domain<D>| {
            let samples = (0..domain.len()).map(|_| rng.below(1000) as f32 / 8.0).collect();
            Plane::new(Role::Scalar, Samples::F32(Grid::from_vec(*domain, 1, samples).unwrap()))
        };
        let planes = sources.iter().map(&mut plane).collect();
        let origin = |s: usize| Origin { exemplar: s as u16, transform: Transform::IDENTITY };
        let table = SourceTable::new(sources.iter().enumerate().map(|(s, d)| (origin(s), *d)).collect()).unwrap();
        let key = Seed(rng.below(1 << 30).into());
        let ids = output.positions().map(|at| {
            let patch = at.iter().fold(0, |key, p| key * 1000 + u64::from(p / cell));
            let mut rng = key.derive("patch", patch).rng();
            let source = rng.below(sources.len() as u32) as usize;
            let domain = sources[source];
            let from = std::array::from_fn(|a| (rng.below(domain.shape[a]) + at[a]) % domain.shape[a]);
            table.id(source, from)
        });
        let ids = Grid::from_vec(output, 1, ids.collect()).unwrap();
        Self { planes, map: SourceMap::new(ids, table).unwrap() }
    }

    fn refs(&self) -> Vec<&Plane<D>> {
        self.planes.iter().collect()
    }

    fn feathered(&self, sigma: f64) -> Plane<D> {
        Feathered::new(&self.map, Vec::new(), sigma).unwrap().render(&self.refs()).unwrap()
    }

    fn splined(&self, levels: u32) -> Plane<D> {
        Splined::new(&self.map, Vec::new(), levels).unwrap().render(&self.refs()).unwrap()
    }

    fn value(&self, source: usize, at: [u32; D]) -> f64 {
        self.planes[source].samples.value(0, self.planes[source].domain().index(at))
    }

    /// Feathering as it is defined, position by position.
    fn feathered_slowly(&self, sigma: f64) -> Vec<f64> {
        let reach = (2.0 * sigma).ceil() as u32;
        let blended = |at: [u32; D]| {
            let (mut sum, mut weights) = (0.0, 0.0);
            for by in Domain::open([2 * reach + 1; D]).positions() {
                let by = by.map(|b| b as i32 - reach as i32);
                let Some(there) = self.map.domain().step(at, by) else { continue };
                let Some(id) = self.map.table.step(self.map.ids.get(0, there), by.map(|b| -b)) else { continue };
                let (source, from) = self.map.table.locate(id).unwrap();
                let square: i32 = by.iter().map(|b| b * b).sum();
                let weight = libm::exp(-f64::from(square) / (2.0 * sigma * sigma));
                sum += weight * self.value(source, from);
                weights += weight;
            }
            sum / weights
        };
        self.map.domain().positions().map(blended).collect()
    }

    /// Splining as it is defined, over the whole of an open output, with every source as the patch at offset 0.
    fn splined_slowly(&self, levels: u32) -> Vec<f64> {
        let output = self.map.domain();
        let mut sums = vec![0.0; output.len()];
        for source in 0..self.planes.len() {
            let mut fine: Vec<f64> = output.positions().map(|at| self.value(source, at)).collect();
            let shows = |at: [u32; D]| f64::from(u8::from(self.map.locate(at).unwrap().0 == source));
            let mut mask: Vec<f64> = output.positions().map(shows).collect();
            for level in 0..levels {
                let coarse = blurred(&fine, output, 1 << level);
                sums.iter_mut().enumerate().for_each(|(i, s)| *s += mask[i] * (fine[i] - coarse[i]));
                (fine, mask) = (coarse, blurred(&mask, output, 1 << level));
            }
            sums.iter_mut().enumerate().for_each(|(i, s)| *s += mask[i] * fine[i]);
        }
        sums
    }
}

/// Burt and Adelson's kernel with gaps along every axis; the border's sample goes on.
fn blurred<const D: usize>(values: &[f64], domain: Domain<D>, gap: i64) -> Vec<f64> {
    let mut now = values.to_vec();
    for axis in 0..D {
        let at = |mut p: [u32; D], by: i64| {
            p[axis] = (i64::from(p[axis]) + by).clamp(0, i64::from(domain.shape[axis]) - 1) as u32;
            now[domain.index(p)]
        };
        let taps = [1.0, 4.0, 6.0, 4.0, 1.0].into_iter().zip(-2..);
        let blur = |p| taps.clone().map(|(w, t): (f64, i64)| w / 16.0 * at(p, t * gap)).sum();
        now = domain.positions().map(blur).collect();
    }
    now
}

#[track_caller]
fn assert_close<const D: usize>(plane: &Plane<D>, expected: &[f64]) {
    let off = |i: usize| (plane.samples.value(0, i) - expected[i]).abs();
    let worst = (0..expected.len()).map(off).fold(0.0, f64::max);
    assert!(worst < 1e-4, "{worst}");
}

#[test]
fn clips_are_feathered_as_defined() {
    let mut rng = Seed(1).rng();
    for round in 0..8 {
        let periodic = [round % 2 == 0, round % 3 == 0, round % 4 < 2];
        let sources = [Domain::open([6, 9, 14]), Domain { shape: [5, 7, 8], periodic }];
        let output = Domain { shape: [1 + rng.below(12), 1 + rng.below(30), 1 + rng.below(30)], periodic };
        let case = Case::new(&sources, output, 4, &mut rng);
        assert_close(&case.feathered(1.5), &case.feathered_slowly(1.5));
    }
}

#[test]
fn clips_are_splined_as_defined() {
    let mut rng = Seed(2).rng();
    for levels in 1..4 {
        // Several boxes along an axis.
        let output = Domain::open([9, 31, 40]);
        let mut case = Case::new(&[output, output, output], output, 5, &mut rng);
        let mut choice = Seed(3).rng();
        for at in output.positions() {
            let source = choice.below(40).min(2) as usize;
            let id = case.map.table.id(source, at);
            case.map.ids.set(0, at, id);
        }
        let [low, high] = Averaging::of(&case.refs()).ranges()[0];
        let slow: Vec<f64> = case.splined_slowly(levels).iter().map(|v| v.clamp(low, high)).collect();
        assert_close(&case.splined(levels), &slow);
    }
}

#[test]
fn one_frame_is_a_picture() {
    let mut rng = Seed(4).rng();
    let (frame, output) = (Domain::open([40, 50]), Domain { shape: [60, 70], periodic: [true, false] });
    let picture = Case::new(&[frame], output, 13, &mut rng);
    let deep =
        |d: Domain<2>| Domain { shape: [1, d.shape[0], d.shape[1]], periodic: [false, d.periodic[0], d.periodic[1]] };
    let Samples::F32(samples) = &picture.planes[0].samples else { unreachable!() };
    let samples = Samples::F32(Grid::from_vec(deep(frame), 1, samples.samples().to_vec()).unwrap());
    let mut clip = Case::new(&[deep(frame)], deep(output), 13, &mut rng);
    clip.planes = vec![Plane::new(Role::Scalar, samples)];
    clip.map.ids.plane_mut(0).copy_from_slice(picture.map.ids.plane(0));
    let all = |plane: &dyn Fn(usize) -> f64| (0..output.len()).map(plane).collect::<Vec<f64>>();
    let (flat, whole) = (picture.splined(3), clip.splined(3));
    // The axis of one sample blurs to itself.
    assert_close(&whole, &all(&|i| flat.samples.value(0, i)));
    let (flat, whole) = (picture.feathered(2.0), clip.feathered(2.0));
    assert_close(&whole, &all(&|i| flat.samples.value(0, i)));
}

#[test]
fn bytes_are_equal_on_any_number_of_threads() {
    let mut rng = Seed(6).rng();
    let picture = Case::new(&[Domain::open([50, 60])], Domain::periodic([300, 410]), 23, &mut rng);
    let clip = Case::new(&[Domain::open([9, 20, 30])], Domain::open([30, 40, 55]), 9, &mut rng);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let pictures = [picture.feathered(3.0), picture.splined(4)];
            (pictures, [clip.feathered(2.0), clip.splined(2)])
        })
    };
    let one = on(1);
    assert!(one.0[0] != picture.map.render(&picture.refs()).unwrap());
    assert!([2, 3, 5].iter().all(|&n| on(n) == one));
}

#[test]
fn no_blending_changes_nothing() {
    let mut rng = Seed(7).rng();
    let mut case = Case::new(&[Domain::open([20, 20])], Domain::open([30, 30]), 8, &mut rng);
    case.map.ids.set(0, [14, 14], SampleId::UNASSIGNED);
    for plane in [case.feathered(0.0), case.splined(0)] {
        assert_eq!(plane, case.map.render(&case.refs()).unwrap(), "nothing is in reach of nothing");
    }
}
