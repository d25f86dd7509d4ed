//! Feathered and splined maps: against their definitions, and what they promise for every kind of samples.

use selvedge_blending::{Error, Feathered, Splined};
use selvedge_core::{
    Domain, Encoder, Exemplar, Exemplars, Grid, Plane, Render, Role, SampleId, Samples, Seed, SourceMap, Transform,
};

fn of(planes: &[&Plane<2>]) -> Exemplars<2> {
    let planes: Vec<&[Plane<2>]> = planes.iter().map(|p| std::slice::from_ref(*p)).collect();
    Exemplars::of(&planes).unwrap()
}

fn floats(role: Role, domain: Domain<2>, channels: usize, value: impl Fn(usize, [u32; 2]) -> f32) -> Plane<2> {
    let samples = (0..channels).flat_map(|c| domain.positions().map(move |p| (c, p))).map(|(c, p)| value(c, p));
    Plane::new(role, Samples::F32(Grid::from_vec(domain, channels, samples.collect()).unwrap()))
}

fn noise(role: Role, domain: Domain<2>, channels: usize, seed: u64) -> Plane<2> {
    let key = |c: usize, [y, x]: [u32; 2]| (c as u64) << 40 | u64::from(y) << 20 | u64::from(x);
    floats(role, domain, channels, |c, p| (Seed(seed).derive("noise", key(c, p)).0 % 1000) as f32 / 10.0)
}

/// A map that shows each exemplar at its own place, where a number is its own.
fn map_of(e: &Exemplars<2>, output: Domain<2>, which: impl Fn([u32; 2]) -> usize) -> SourceMap<2> {
    let mut map = SourceMap::unassigned(e, output).unwrap();
    for at in output.positions() {
        map.ids.set(0, at, e.table().id(which(at), at));
    }
    map
}

fn values(plane: &Plane<2>, channel: usize) -> Vec<f64> {
    (0..plane.domain().len()).map(|i| plane.samples.value(channel, i)).collect()
}

/// Feathering as it is defined, position by position.
fn feathered_slowly(e: &Exemplars<2>, map: &SourceMap<2>, plane: &Plane<2>, sigma: f64) -> Vec<f64> {
    let reach = (2.0 * sigma).ceil() as i32;
    let blended = |at: [u32; 2]| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for y in -reach..=reach {
            for x in -reach..=reach {
                let Some(there) = map.domain().step(at, [y, x]) else { continue };
                let Some(id) = map.table.step(map.ids.get(0, there), [-y, -x]) else { continue };
                let (source, from) = map.table.locate(id).unwrap();
                if e.sources()[source].valid.as_deref().is_some_and(|v| !v.get(0, from)) {
                    continue;
                }
                let weight = libm::exp(-f64::from(y * y + x * x) / (2.0 * sigma * sigma));
                sum += weight * plane.samples.value(0, plane.domain().index(from));
                weights += weight;
            }
        }
        sum / weights
    };
    map.domain().positions().map(blended).collect()
}

#[test]
fn feathering_is_what_it_is_defined_as() {
    for round in 0..20 {
        let mut rng = Seed(round).rng();
        let domain = Domain::open([9 + rng.below(60), 9 + rng.below(80)]);
        let plane = noise(Role::Scalar, domain, 1, round);
        let valid = (0..domain.len()).map(|_| rng.below(7) != 0).collect();
        let mask = Some(Grid::from_vec(domain, 1, valid).unwrap());
        let planes = [std::slice::from_ref(&plane)];
        let encoder = Encoder::fit(&planes).unwrap();
        let e = Exemplars::new(&encoder, &[Exemplar::new(planes[0]).masked(mask.as_ref())]).unwrap();
        let periodic = [round % 2 == 0, round % 3 == 0];
        let output = Domain { shape: [1 + rng.below(70), 1 + rng.below(90)], periodic };
        // Patches of four by six; each position shows a valid sample.
        let mut map = SourceMap::unassigned(&e, output).unwrap();
        for at in output.positions() {
            let key = Seed(round).derive("patch", u64::from(at[0] / 4) << 20 | u64::from(at[1] / 6)).0;
            let mut from =
                [(key as u32 % 97 + at[0]) % domain.shape[0], ((key >> 32) as u32 + at[1]) % domain.shape[1]];
            while !e.sources()[0].valid.as_deref().is_none_or(|v| v.get(0, from)) {
                from[1] = (from[1] + 1) % domain.shape[1];
            }
            map.ids.set(0, at, e.table().id(0, from));
        }
        let sigma = [0.5, 1.0, 1.7, 3.0][round as usize % 4];
        let fast = Feathered::new(&map, e.validity(), sigma).unwrap().render(&[&plane]).unwrap();
        let slow = feathered_slowly(&e, &map, &plane, sigma);
        let off = values(&fast, 0).iter().zip(&slow).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-4, "{round}: {off} on {output:?}");
    }
}

/// Burt and Adelson's kernel over a whole picture, with gaps; the border's sample goes on.
fn blurred(values: &[f64], [h, w]: [i64; 2], gap: i64) -> Vec<f64> {
    let at = |v: &[f64], y: i64, x: i64| v[(y.clamp(0, h - 1) * w + x.clamp(0, w - 1)) as usize];
    let taps = [1.0, 4.0, 6.0, 4.0, 1.0];
    let along = |v: &[f64], [dy, dx]: [i64; 2]| -> Vec<f64> {
        let tap =
            |i: i64, t: i64| taps[t as usize] / 16.0 * at(v, i / w + (t - 2) * gap * dy, i % w + (t - 2) * gap * dx);
        (0..h * w).map(|i| (0..5).map(|t| tap(i, t)).sum()).collect()
    };
    along(&along(values, [1, 0]), [0, 1])
}

#[test]
fn splines_are_what_they_are_defined_as() {
    for (levels, shape) in [(1, [70_u32, 150]), (2, [33, 65]), (3, [140, 90]), (5, [100, 200])] {
        let output = Domain::open(shape);
        let planes = [1, 2, 3].map(|seed| noise(Role::Scalar, output, 1, seed));
        let refs: Vec<&Plane<2>> = planes.iter().collect();
        let e = of(&refs);
        let which = |[y, x]: [u32; 2]| (Seed(9).derive("which", u64::from(y / 17 * 100 + x / 23)).0 % 3) as usize;
        let map = map_of(&e, output, which);
        let size = shape.map(i64::from);
        let mut slow = vec![0.0; output.len()];
        for (p, plane) in planes.iter().enumerate() {
            let mut fine = values(plane, 0);
            let mut mask: Vec<f64> = output.positions().map(|at| f64::from(u8::from(which(at) == p))).collect();
            for level in 0..levels {
                let coarse = blurred(&fine, size, 1 << level);
                slow.iter_mut().enumerate().for_each(|(i, s)| *s += mask[i] * (fine[i] - coarse[i]));
                (fine, mask) = (coarse, blurred(&mask, size, 1 << level));
            }
            slow.iter_mut().enumerate().for_each(|(i, s)| *s += mask[i] * fine[i]);
        }
        let fast = Splined::new(&map, e.validity(), levels).unwrap().render(&refs).unwrap();
        let clamped = slow.iter().map(|v| v.clamp(0.0, 99.9));
        let off = values(&fast, 0).iter().zip(clamped).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-4, "{levels} levels: {off}");
    }
}

/// A map of two patches side by side, with a straight seam, over a ramp.
fn two_halves() -> (Exemplars<2>, SourceMap<2>, Plane<2>) {
    let plane = floats(Role::Scalar, Domain::open([12, 40]), 1, |_, [_, x]| x as f32);
    let e = of(&[&plane]);
    let mut map = SourceMap::unassigned(&e, Domain::open([12, 24])).unwrap();
    for [y, x] in map.domain().positions() {
        map.ids.set(0, [y, x], e.table().id(0, [y, if x < 12 { x } else { x + 8 }]));
    }
    (e, map, plane)
}

#[test]
fn blending_goes_monotonely_from_one_patch_to_the_other() {
    let (e, map, plane) = two_halves();
    let feathered = Feathered::new(&map, e.validity(), 2.0).unwrap().render(&[&plane]).unwrap();
    let splined = Splined::new(&map, e.validity(), 3).unwrap().render(&[&plane]).unwrap();
    let plain = map.render(&[&plane]).unwrap();
    for (name, out) in [("feathered", feathered), ("splined", splined)] {
        let row: Vec<f64> = (0..24).map(|x| out.samples.value(0, 5 * 24 + x)).collect();
        assert!(row.is_sorted(), "{name} {row:?}");
        let step = row.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        assert!(step < 4.0, "{name}: the step of 9 is spread out, {row:?}");
        // In the middle both patches weigh the same: x and x + 8.
        assert!((row[11] + row[12] - (11.0 + 12.0 + 8.0)).abs() < 1e-3, "{name} {row:?}");
        if name == "feathered" {
            assert!((0..7).chain(17..24).all(|x| row[x] == plain.samples.value(0, 5 * 24 + x)));
        }
    }
}

#[test]
fn what_no_seam_is_near_and_what_is_kept_is_copied_bit_for_bit() {
    let plane = noise(Role::Color, Domain::open([80, 300]), 3, 11);
    let e = of(&[&plane]);
    let mut map = SourceMap::unassigned(&e, Domain::open([70, 240])).unwrap();
    for [y, x] in map.domain().positions() {
        map.ids.set(0, [y, x], e.table().id(0, [y + 3, if x < 100 { x + 5 } else { x + 40 }]));
    }
    let plain = map.render(&[&plane]).unwrap();
    let kept = Grid::from_vec(map.domain(), 1, map.domain().positions().map(|[y, _]| y < 30).collect()).unwrap();
    let feathered = Feathered::new(&map, e.validity(), 3.0).unwrap();
    let splined = Splined::new(&map, e.validity(), 4).unwrap();
    let kept_both = [
        feathered.clone().keeping(&kept).unwrap().render(&[&plane]).unwrap(),
        splined.clone().keeping(&kept).unwrap().render(&[&plane]).unwrap(),
    ];
    let both = [(feathered.render(&[&plane]).unwrap(), 6), (splined.render(&[&plane]).unwrap(), 30)];
    for ((all, reach), some) in both.into_iter().zip(kept_both) {
        let changed = |out: &Plane<2>, keep: bool| {
            let is_changed = |at: &[u32; 2]| {
                let i = map.domain().index(*at);
                (0..3).any(|c| out.samples.value(c, i) != plain.samples.value(c, i))
            };
            let part = map.domain().positions().filter(|[y, _]| (*y < 30) == keep);
            part.filter(is_changed).map(|[_, x]| x).collect::<Vec<u32>>()
        };
        let near = changed(&all, true);
        assert!(!near.is_empty() && near.iter().all(|x| (100 - reach..100 + reach).contains(x)), "{reach}");
        assert!(changed(&some, true).is_empty(), "kept");
        assert_eq!(changed(&some, false), changed(&all, false), "the others are blended as ever");
    }
    assert!(Feathered::new(&map, e.validity(), f64::NAN).is_err());
    assert!(Splined::new(&map, e.validity(), 6).is_err());
    let other = Grid::try_filled(Domain::open([2, 2]), 1, true).unwrap();
    assert!(matches!(Feathered::new(&map, e.validity(), 1.0).unwrap().keeping(&other), Err(Error::Shape { .. })));
    assert!(matches!(Splined::new(&map, vec![Some(&other)], 1), Err(Error::Shape { .. })));
    map.ids.set(0, [0, 0], SampleId::new(1 << 30));
    assert!(matches!(
        Feathered::new(&map, e.validity(), 1.0),
        Err(Error::Core(selvedge_core::Error::UnknownSample { .. }))
    ));
}

#[test]
fn splines_of_equal_patches_are_the_patch() {
    // Two exemplars with the same samples: any blend of them is the same picture.
    let domain = Domain::open([40, 40]);
    let samples = noise(Role::Color, domain, 3, 12);
    let bytes = (0..3).flat_map(|c| values(&samples, c)).map(|v| v as u8).collect();
    let plane = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 3, bytes).unwrap()));
    let e = of(&[&plane, &plane]);
    let map = map_of(&e, Domain::periodic([40, 40]), |[y, x]| usize::from((y / 7 + x / 9) % 2 == 1));
    let plain = map.render(&[&plane, &plane]).unwrap();
    assert_eq!(Splined::new(&map, e.validity(), 4).unwrap().render(&[&plane, &plane]).unwrap(), plain);
    assert_eq!(Feathered::new(&map, e.validity(), 2.0).unwrap().render(&[&plane, &plane]).unwrap(), plain);
}

/// Both blends of a map of two exemplars, left and right.
fn halves(planes: [&Plane<2>; 2]) -> [Plane<2>; 2] {
    let e = of(&planes);
    let map = map_of(&e, planes[0].domain(), |[_, x]| usize::from(x >= planes[0].domain().shape[1] / 2));
    [
        Feathered::new(&map, e.validity(), 2.0).unwrap().render(&planes).unwrap(),
        Splined::new(&map, e.validity(), 3).unwrap().render(&planes).unwrap(),
    ]
}

#[test]
fn normals_keep_their_length() {
    let domain = Domain::open([20, 24]);
    let [left, right] = [[-0.8, 0.0, 0.6], [0.6, 0.0, 0.8]];
    let signed = |n: [f32; 3]| floats(Role::Normal, domain, 3, move |c, _| n[c]);
    let unsigned = |n: [f32; 3]| floats(Role::Normal, domain, 3, move |c, _| n[c] / 2.0 + 0.5);
    let bytes = |n: [f32; 3]| {
        let samples = (0..3).flat_map(|c| vec![(n[c] * 127.5 + 127.5).round() as u8; domain.len()]).collect();
        Plane::new(Role::Normal, Samples::U8(Grid::from_vec(domain, 3, samples).unwrap()))
    };
    let codings = [
        (signed(left), signed(right), 0.0, 1.0),
        (unsigned(left), unsigned(right), 0.5, 0.5),
        (bytes(left), bytes(right), 127.5, 127.5),
    ];
    for (left, right, zero, unit) in codings {
        for out in halves([&left, &right]) {
            let normal = |i: usize| [0, 1, 2].map(|c| (out.samples.value(c, i) - zero) / unit);
            for i in 0..domain.len() {
                let length = normal(i).iter().map(|v| v * v).sum::<f64>().sqrt();
                assert!((length - 1.0).abs() < 0.01, "{length} at {i}");
            }
            let x = |i: usize| normal(10 * 24 + i)[0];
            assert!(x(0) < -0.7 && (-0.4..0.2).contains(&x(12)) && 0.5 < x(23), "it turns from one to the other");
        }
    }
}

#[test]
fn colour_of_what_is_transparent_does_not_show() {
    // Right of the seam nearly transparent black: the white on the left stays white.
    let domain = Domain::open([20, 24]);
    let plane = |color: u8, alpha: u8| {
        let samples = [vec![color; domain.len()], vec![alpha; domain.len()]].concat();
        Plane::with_alpha(Role::Color, Samples::U8(Grid::from_vec(domain, 2, samples).unwrap()))
    };
    for out in halves([&plane(255, 255), &plane(0, 1)]) {
        let row = |c: usize| (0..24).map(|x| out.samples.value(c, 10 * 24 + x)).collect::<Vec<f64>>();
        let (color, alpha) = (row(0), row(1));
        assert!((20.0..235.0).contains(&alpha[12]) && alpha.is_sorted_by(|a, b| a >= b), "{alpha:?}");
        assert!((0..24).filter(|&x| 20.0 < alpha[x]).all(|x| 240.0 < color[x]), "{color:?} {alpha:?}");
    }
}

#[test]
fn light_stays_within_the_exemplars_range() {
    let domain = Domain::open([40, 48]);
    // A highlight on black beside mid-grey: bands of it ring below 0.
    let spot = |_: usize, [y, x]: [u32; 2]| if y.abs_diff(20) < 3 && x.abs_diff(20) < 3 { 1000.0 } else { 0.0 };
    let (dark, grey) = (floats(Role::Color, domain, 3, spot), floats(Role::Color, domain, 3, |_, _| 0.5));
    for out in halves([&dark, &grey]) {
        let all: Vec<f64> = (0..3).flat_map(|c| values(&out, c)).collect();
        assert!(all.iter().all(|v| (0.0..=1000.0).contains(v)));
    }
}

#[test]
fn sources_that_are_turned_and_scaled_are_blended_alike() {
    let plane = noise(Role::Color, Domain::open([40, 40]), 3, 5);
    let planes = [std::slice::from_ref(&plane)];
    let transforms =
        [Transform::new(30.0, 1.5, true), Transform::new(90.0, 1.0, true), Transform::new(0.0, 0.6, false)];
    let e = Exemplars::new(&Encoder::fit(&planes).unwrap(), &[Exemplar::new(planes[0]).shown(&transforms)]).unwrap();
    let mut map = SourceMap::unassigned(&e, Domain::open([20, 20])).unwrap();
    for [y, x] in map.domain().positions() {
        let source = (x / 7) as usize;
        let corner = if source == 0 { 30 } else { 2 };
        map.ids.set(0, [y, x], e.table().id(source, [y + corner, x + corner]));
    }
    let validity = map.table.validity(&[&plane], &[None]).unwrap();
    assert_eq!(validity.iter().map(Option::as_ref).collect::<Vec<_>>(), e.validity());
    for out in [
        Feathered::new(&map, e.validity(), 1.0).unwrap().render(&[&plane]).unwrap(),
        Splined::new(&map, e.validity(), 1).unwrap().render(&[&plane]).unwrap(),
    ] {
        let plain = map.render(&[&plane]).unwrap();
        let same = |x: usize| {
            (0..20).all(|y| (0..3).all(|c| out.samples.value(c, y * 20 + x) == plain.samples.value(c, y * 20 + x)))
        };
        assert_eq!([3, 10, 17, 6, 7, 13].map(same), [true, true, true, false, false, false]);
    }
}

#[test]
fn bands_are_as_wide_as_patches_allow() {
    let plane = noise(Role::Height, Domain::open([16, 256]), 1, 3);
    let e = of(&[&plane, &plane]);
    let levels = |side: u32| {
        let map = map_of(&e, Domain { shape: [16, 256], periodic: [false, true] }, |[_, x]| (x / side % 2) as usize);
        Splined::levels_for(&map)
    };
    assert_eq!([1, 4, 7, 8, 15, 16, 31, 32, 63, 64, 128].map(levels), [1, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5]);
}
