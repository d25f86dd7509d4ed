//! Fused maps: against a dense solution of the least squares, and what they promise.

use selvedge_blending::Fused;
use selvedge_core::{
    Domain, Grid, Origin, Plane, Render, Rng, Role, SampleId, Samples, Seed, SourceMap, SourceTable, Transform,
};

/// A map of cells from two exemplars, what may show of them, and heights over them.
struct Case<const D: usize> {
    planes: [Plane<D>; 2],
    valid: Grid<bool, D>,
    map: SourceMap<D>,
}

fn heights<const D: usize>(domain: Domain<D>, rng: &mut Rng) -> Plane<D> {
    let samples = (0..domain.len()).map(|_| 400.0 + rng.below(100) as f32 / 8.0).collect();
    Plane::new(Role::Height, Samples::F32(Grid::from_vec(domain, 1, samples).unwrap()))
}

impl<const D: usize> Case<D> {
    fn new(source: Domain<D>, output: Domain<D>, cell: u32, seed: u64) -> Self {
        let mut rng = Seed(seed).rng();
        let mut planes = [heights(source, &mut rng), heights(source, &mut rng)];
        // Room for what is raised.
        for plane in &mut planes {
            let Samples::F32(grid) = &mut plane.samples else { unreachable!() };
            (grid.plane_mut(0)[0], grid.plane_mut(0)[1]) = (0.0, 800.0);
        }
        let valid = (0..source.len()).map(|i| i == 0 || rng.below(8) != 0).collect();
        let origin = |exemplar| Origin { exemplar, transform: Transform::IDENTITY };
        let table = SourceTable::new(vec![(origin(0), source), (origin(1), source)]).unwrap();
        let ids = output.positions().map(|at| {
            let patch = at.iter().fold(0, |key, p| key * 1000 + u64::from(p / cell));
            let mut rng = Seed(seed).derive("patch", patch).rng();
            let source_number = rng.below(2) as usize;
            let from = std::array::from_fn(|a| (rng.below(source.shape[a]) + at[a]) % source.shape[a]);
            table.id(source_number, from)
        });
        let ids = Grid::from_vec(output, 1, ids.collect()).unwrap();
        Self { planes, valid: Grid::from_vec(source, 1, valid).unwrap(), map: SourceMap::new(ids, table).unwrap() }
    }

    fn fused(&self) -> Fused<'_, D> {
        Fused::new(&self.map, vec![Some(&self.valid), None]).unwrap()
    }

    fn render(&self, fused: &Fused<'_, D>) -> Vec<f64> {
        let plane = fused.render(&self.planes.each_ref()).unwrap();
        (0..plane.domain().len()).map(|i| plane.samples.value(0, i)).collect()
    }

    fn value(&self, id: SampleId) -> f64 {
        let (source, at) = self.map.table.locate(id).unwrap();
        self.planes[source].samples.value(0, self.valid.domain().index(at))
    }

    /// The height of the second sample of an edge above the first, as the patches have it.
    fn asked(&self, at: [u32; D], next: [u32; D], axis: usize, stronger: bool) -> f64 {
        let step = |at: [u32; D], by: i32| {
            let by = std::array::from_fn(|a| if a == axis { by } else { 0 });
            let id = self.map.table.step(self.map.ids.get(0, at), by)?;
            let (source, from) = self.map.table.locate(id).unwrap();
            (source == 1 || self.valid.get(0, from)).then(|| self.value(id))
        };
        let [here, there] = [at, next].map(|p| self.value(self.map.ids.get(0, p)));
        if !self.map.is_seam(at, axis) {
            return there - here;
        }
        match (step(at, 1).map(|v| v - here), step(next, -1).map(|v| there - v)) {
            (Some(a), Some(b)) if stronger => {
                if b.abs() <= a.abs() {
                    a
                } else {
                    b
                }
            }
            (Some(a), Some(b)) => (a + b) / 2.0,
            (Some(d), None) | (None, Some(d)) => d,
            (None, None) => 0.0,
        }
    }

    /// The least squares, densely: the mean stays, unless some samples do.
    fn solved(&self, kept: &dyn Fn(usize) -> bool, stronger: bool) -> Vec<f64> {
        let domain = self.map.domain();
        let n = domain.len();
        let shown: Vec<f64> = self.map.ids.plane(0).iter().map(|id| self.value(*id)).collect();
        let mut matrix = vec![vec![0.0; n + 1]; n];
        for at in domain.positions() {
            for axis in 0..D {
                let Some(next) = domain.next(at, axis).filter(|next| *next != at) else { continue };
                let (p, q, d) = (domain.index(at), domain.index(next), self.asked(at, next, axis, stronger));
                for (i, j, d) in [(p, q, -d), (q, p, d)] {
                    matrix[i][i] += 1.0;
                    matrix[i][j] -= 1.0;
                    matrix[i][n] += d;
                }
            }
        }
        let any_kept = (0..n).any(kept);
        for (i, row) in matrix.iter_mut().enumerate() {
            if kept(i) {
                row.fill(0.0);
                (row[i], row[n]) = (1.0, shown[i]);
            } else if !any_kept {
                // One that has no say in differences, but makes the mean what it was.
                row[..n].iter_mut().for_each(|v| *v += 1.0);
                row[n] += shown.iter().sum::<f64>();
            }
        }
        for i in 0..n {
            let pivot = (i..n).max_by(|&a, &b| matrix[a][i].abs().total_cmp(&matrix[b][i].abs())).unwrap();
            matrix.swap(i, pivot);
            for below in i + 1..n {
                let factor = matrix[below][i] / matrix[i][i];
                let (upper, lower) = matrix.split_at_mut(below);
                lower[0].iter_mut().zip(&upper[i]).for_each(|(v, u)| *v -= factor * u);
            }
        }
        let mut solved = vec![0.0; n];
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|j| matrix[i][j] * solved[j]).sum();
            solved[i] = (matrix[i][n] - known) / matrix[i][i];
        }
        // What leaves the exemplars' range is held in it.
        solved.into_iter().map(|v| v.clamp(0.0, 800.0)).collect()
    }
}

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < tolerance, "{off}");
}

#[test]
fn whole_outputs_are_the_least_squares() {
    for seed in 0..8 {
        let periodic = [seed % 2 == 0, seed % 4 < 2];
        let case = Case::new(Domain::open([9, 11]), Domain { shape: [12, 15], periodic }, 4, seed);
        // Floats hold about 3e-5 of 400.
        assert_close(&case.render(&case.fused()), &case.solved(&|_| false, false), 1e-4);
        assert_close(&case.render(&case.fused().stronger()), &case.solved(&|_| false, true), 1e-4);
    }
    let open = Domain { shape: [4, 5, 6], periodic: [false, true, false] };
    let clip = Case::new(Domain::open([3, 4, 5]), open, 2, 9);
    assert_close(&clip.render(&clip.fused()), &clip.solved(&|_| false, false), 1e-4);
}

#[test]
fn kept_samples_stay_and_the_others_follow() {
    for seed in 0..6 {
        let periodic = [seed % 2 == 0, seed % 4 < 2];
        let case = Case::new(Domain::open([9, 11]), Domain { shape: [12, 15], periodic }, 4, seed);
        let mut rng = Seed(seed).derive("kept", 0).rng();
        let is_kept: Vec<bool> = (0..180).map(|i| i == 7 || rng.below(4) == 0).collect();
        let kept = Grid::from_vec(case.map.domain(), 1, is_kept.clone()).unwrap();
        let found = case.render(&case.fused().keeping(&kept).unwrap());
        // 1e-4 of a grey level of the range of 800.
        assert_close(&found, &case.solved(&|i| is_kept[i], false), 800.0 * 1e-4 / 255.0 + 1e-4);
        let shown = case.map.render(&case.planes.each_ref()).unwrap();
        assert!((0..180).filter(|&i| is_kept[i]).all(|i| shown.samples.value(0, i) == found[i]));
    }
}

#[test]
fn holes_are_solved_by_themselves_as_in_the_whole() {
    type Holes = fn([u32; 2]) -> bool;
    let inner: Holes = |[y, x]| (3..8).contains(&y) && (4..9).contains(&x);
    let beside: Holes = |[y, x]| y < 4 && (9..13).contains(&x) || (6..11).contains(&y) && x < 3;
    let corners: Holes = |[y, x]| !(3..10).contains(&y) && !(2..12).contains(&x);
    let around: Holes = |[y, x]| (2..4).contains(&y) || 6 <= y && (x + y) % 5 < 3;
    let ring: Holes = |[y, x]| (2..4).contains(&y.abs_diff(5).max(x.abs_diff(7)));
    for (number, hole) in [inner, beside, corners, around, ring].into_iter().enumerate() {
        for periodic in [[false, false], [true, false], [false, true], [true, true]] {
            let case = Case::new(Domain::open([9, 11]), Domain { shape: [12, 15], periodic }, 4, number as u64);
            let is_kept: Vec<bool> = case.map.domain().positions().map(|at| !hole(at)).collect();
            let kept = Grid::from_vec(case.map.domain(), 1, is_kept.clone()).unwrap();
            let found = case.render(&case.fused().keeping(&kept).unwrap());
            assert_close(&found, &case.solved(&|i| is_kept[i], false), 800.0 * 1e-4 / 255.0 + 1e-4);
        }
    }
}

#[test]
fn samples_far_from_seams_keep_their_bytes() {
    let case = Case::new(Domain::open([60, 70]), Domain::open([50, 50]), 25, 3);
    let found = case.render(&case.fused().within(3));
    let shown = case.map.render(&case.planes.each_ref()).unwrap();
    let changed: Vec<[u32; 2]> = case
        .map
        .domain()
        .positions()
        .filter(|at| shown.samples.value(0, case.map.domain().index(*at)) != found[case.map.domain().index(*at)])
        .collect();
    let near = |at: [u32; 2]| {
        let around = Domain::open([8, 8]).positions().map(|by| [0, 1].map(|a| by[a] as i32 - 4));
        around.filter_map(|by| case.map.domain().step(at, by)).any(|p| (0..2).any(|a| case.map.is_seam(p, a)))
    };
    assert!(200 < changed.len() && changed.iter().all(|at| near(*at)), "{}", changed.len());
}

#[test]
fn what_fits_is_not_changed_and_what_is_raised_is_lowered() {
    let mut rng = Seed(5).rng();
    let source = Domain::open([20, 30]);
    let plane = heights(source, &mut rng);
    let Samples::F32(grid) = &plane.samples else { unreachable!() };
    let raised = Plane::new(Role::Height, Samples::F32(grid.map(|v| v + 50.0).unwrap()));
    let origin = |exemplar| Origin { exemplar, transform: Transform::IDENTITY };
    let table = SourceTable::new(vec![(origin(0), source), (origin(1), source)]).unwrap();
    let ids = source.positions().map(|[y, x]| table.id(usize::from(x / 10 == 1 && y < 13), [y, x])).collect();
    let map = SourceMap::new(Grid::from_vec(source, 1, ids).unwrap(), table).unwrap();
    let fused = Fused::new(&map, Vec::new()).unwrap();
    assert_eq!(fused.render(&[&plane, &plane]).unwrap(), plane, "bit for bit");
    let out = fused.render(&[&plane, &raised]).unwrap();
    let differences: Vec<f64> =
        (0..source.len()).map(|i| out.samples.value(0, i) - plane.samples.value(0, i)).collect();
    let mean = 50.0 * 130.0 / 600.0;
    assert!(differences.iter().all(|d| (d - mean).abs() < 1e-3), "{differences:?}");
}

#[test]
fn one_frame_is_a_picture_on_any_number_of_threads() {
    let picture = Case::new(Domain::open([30, 41]), Domain { shape: [150, 170], periodic: [false, true] }, 13, 6);
    let deep =
        |d: Domain<2>| Domain { shape: [d.shape[0], 1, d.shape[1]], periodic: [d.periodic[0], false, d.periodic[1]] };
    let plane = |p: &Plane<2>| {
        let Samples::F32(grid) = &p.samples else { unreachable!() };
        Plane::new(p.role, Samples::F32(Grid::from_vec(deep(p.domain()), 1, grid.samples().to_vec()).unwrap()))
    };
    let mut clip = Case::new(deep(picture.planes[0].domain()), deep(picture.map.domain()), 13, 6);
    clip.planes = picture.planes.each_ref().map(plane);
    clip.valid = Grid::from_vec(clip.valid.domain(), 1, picture.valid.samples().to_vec()).unwrap();
    clip.map.ids.plane_mut(0).copy_from_slice(picture.map.ids.plane(0));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| [picture.render(&picture.fused()), picture.render(&picture.fused().within(5))])
    };
    let one = on(1);
    assert!([2, 3].iter().all(|&n| on(n) == one));
    assert_close(&clip.render(&clip.fused()), &one[0], 1e-4);
}

#[test]
fn light_of_another_exposure_becomes_that_around_it() {
    let mut rng = Seed(7).rng();
    let source = Domain::open([20, 30]);
    let light: Vec<f32> = (0..source.len()).map(|_| 500.0 + rng.below(500) as f32).collect();
    let of = |factor: f32| {
        let samples = light.iter().map(|v| v * factor).collect();
        Plane::new(Role::Color, Samples::F32(Grid::from_vec(source, 1, samples).unwrap()))
    };
    let [plane, brighter] = [1.0, 2.0].map(of);
    let origin = |exemplar| Origin { exemplar, transform: Transform::IDENTITY };
    let table = SourceTable::new(vec![(origin(0), source), (origin(1), source)]).unwrap();
    let inside = |[y, x]: [u32; 2]| x / 10 == 1 && (3..13).contains(&y);
    let ids = source.positions().map(|at| table.id(usize::from(inside(at)), at)).collect();
    let map = SourceMap::new(Grid::from_vec(source, 1, ids).unwrap(), table).unwrap();
    let kept = Grid::from_vec(source, 1, source.positions().map(|at| !inside(at)).collect()).unwrap();
    let out = Fused::new(&map, Vec::new()).unwrap().keeping(&kept).unwrap().render(&[&plane, &brighter]).unwrap();
    let ratios: Vec<f64> = (0..source.len()).map(|i| out.samples.value(0, i) / plane.samples.value(0, i)).collect();
    let bounds = ratios.iter().fold([f64::MAX, 0.0], |[low, high], r| [r.min(low), r.max(high)]);
    assert!(0.9 < bounds[0] && bounds[1] < 1.1, "{bounds:?}");
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!((mean - 1.0).abs() < 0.02, "{mean}");
}
