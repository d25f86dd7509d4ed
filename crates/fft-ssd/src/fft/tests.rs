//! The engine by transforms against the direct one, where blocks and tiles are many.

use crate::{Costs, Cover, Engine, Options, Placement, Positions, Scratch, SsdSearcher, Template};
use selvedge_core::{Domain, Grid, Rng, Seed};

fn bytes(rng: &mut Rng, n: usize) -> Vec<u8> {
    (0..n).map(|_| rng.below(256) as u8).collect()
}

/// A random search by the direct engine, and by transforms with blocks of at most `block` samples.
fn both(index: u64, block: usize, limit: f64, shape: [u32; 2], template: [u32; 2]) -> [Costs<2>; 2] {
    let mut rng = Seed(8).derive("blocks", index).rng();
    let domain = Domain { shape, periodic: [rng.below(4) == 0, false] };
    let features = Grid::from_vec(domain, 2, bytes(&mut rng, 2 * domain.len())).unwrap();
    let holes = bytes(&mut rng, domain.len()).iter().map(|&b| 9 < b).collect();
    let valid = Grid::from_vec(domain, 1, holes).unwrap();
    let query = bytes(&mut rng, 2 * Domain::open(template).len());
    let mask: Vec<bool> = query.iter().take(query.len() / 2).map(|&q| q % 4 != 0).collect();
    let positions = [Positions::Inside, Positions::Circular, Positions::Overlapping][index as usize % 3];
    let cover = [Cover::AtLeast(1), Cover::Mask][index as usize / 3 % 2];
    [Engine::Direct, Engine::Fft].map(|engine| {
        let valid = Some(&valid).filter(|_| index.is_multiple_of(5));
        let searcher =
            SsdSearcher::of_grid(&features, valid, &[3, 200], Options { engine, ..Options::default() }).unwrap();
        let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
        (scratch.fft.block, scratch.fft.limit) = (block, limit);
        let template = Template::new(template, &query).masked(&mask);
        searcher.search(&template, Placement { positions, cover }, &mut scratch, &mut costs).unwrap();
        assert_eq!(scratch.repeated(), 0);
        costs
    })
}

fn assert_same([a, b]: [Costs<2>; 2]) {
    assert!(!a.is_empty() && a.iter().eq(b.iter()));
}

#[test]
fn templates_in_blocks_have_the_same_costs() {
    for index in 0..30 {
        assert_same(both(index, 60, super::bound::LIMIT, [40, 33], [23, 31]));
        assert_same(both(index, 300, super::bound::LIMIT, [36, 90], [30, 33]));
    }
}

#[test]
fn what_wraps_around_a_transform_meets_zeros_alone() {
    // Moved over itself by `reach` one way and as far as it goes the other: of 9 samples and 4 of them 17 do, not 21.
    for (side, reach) in (9..=18).flat_map(|side| (1..side).map(move |reach| (side, reach))) {
        let domain = Domain::open([side, side + 2]);
        let mut rng = Seed(9).derive("wrapped", (side * 32 + reach).into()).rng();
        let features = Grid::from_vec(domain, 1, bytes(&mut rng, domain.len())).unwrap();
        let costs = [Engine::Direct, Engine::Fft].map(|engine| {
            let options = Options { engine, ..Options::default() };
            let searcher = SsdSearcher::of_grid(&features, None, &[3], options).unwrap();
            let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
            let (first, count) = ([-(reach as i32); 2], [reach + side; 2]);
            searcher.search_box(&Template::of(&features), first, count, 1, &mut scratch, &mut costs).unwrap();
            assert_eq!(scratch.repeated(), 0, "{side} by {reach}");
            costs
        });
        assert_same(costs);
    }
}

#[test]
fn blocks_shrink_until_rounding_is_safe() {
    for index in 0..12 {
        assert_same(both(index, usize::MAX, 2.0e-4, [60, 50], [24, 31]));
    }
}

/// White over black by transforms: every error is known, the bound holds and is of use.
fn flat<const D: usize>(shape: [u32; D], template: [u32; D], weights: &[u8]) {
    let (n, samples) = (weights.len(), Domain::open(template).len());
    let features = Grid::try_filled(Domain::open(shape), n, 0_u8).unwrap();
    let query = vec![255; n * samples];
    let options = Options { engine: Engine::Fft, ..Options::default() };
    let searcher = SsdSearcher::of_grid(&features, None, weights, options).unwrap();
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    searcher.search(&Template::new(template, &query), Placement::INSIDE, &mut scratch, &mut costs).unwrap();
    assert_eq!(scratch.repeated(), 0);
    let error = samples as u64 * 255 * 255 * weights.iter().map(|&w| u64::from(w)).sum::<u64>();
    assert!(costs.iter().all(|c| c.error == error) && !costs.is_empty());
    let worst = scratch.fft.workers.iter().fold(0.0_f64, |m, w| m.max(w.residual));
    assert!(worst <= scratch.fft.bound && scratch.fft.bound < super::bound::LIMIT, "{worst} {}", scratch.fft.bound);
}

/// One frequency holds all of a flat picture: nothing is farther from noise, of which rounding errors average out.
#[test]
fn flat_extremes_stay_within_the_bound() {
    flat([200, 200], [100, 100], &[255; 3]);
    flat([700, 700], [512, 512], &[255; 3]);
}

#[test]
fn the_largest_picture_and_clip_stay_within_the_bound() {
    flat([4096, 4096], [300, 300], &[1]);
    // A million voxels.
    flat([64, 128, 128], [30, 60, 70], &[77, 150, 29]);
}

/// A searcher over one flat picture, and the sets of spectra and the bytes it holds after searches by squares.
fn held(side: u32, cache: u64, templates: impl Iterator<Item = u32>) -> Vec<(usize, u64)> {
    let features = Grid::try_filled(Domain::open([side, side]), 3, 7_u8).unwrap();
    let options = Options { engine: Engine::Fft, cache, ..Options::default() };
    let searcher = SsdSearcher::of_grid(&features, None, &[1; 3], options).unwrap();
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    let search = |part: u32| {
        let query = vec![9; 3 * (part * part) as usize];
        searcher.search(&Template::new([part, part], &query), Placement::INSIDE, &mut scratch, &mut costs).unwrap();
        assert!(costs.iter().all(|c| c.error == u64::from(part * part) * 12));
        searcher.held()
    };
    templates.map(search).collect()
}

#[test]
fn templates_of_nearly_one_size_share_spectra() {
    // Small pictures are transformed whole or in a few ways of tiles, large ones in tiles.
    assert!(held(64, 1 << 30, 5..=40).last().unwrap().0 <= 9);
    assert_eq!(held(1000, 1 << 30, (57..=64).step_by(3)).last().unwrap().0, 1);
}

#[test]
fn what_is_kept_fits_the_budget() {
    let sizes = || [9, 17, 25, 33, 41, 57].into_iter();
    let all = held(500, u64::MAX, sizes()).last().copied().unwrap();
    assert!(3 <= all.0, "these sizes were to have different spectra: {all:?}");
    let budget = all.1 / 2;
    let within = held(500, budget, sizes());
    assert!(within.iter().all(|&(_, bytes)| bytes <= budget), "{within:?} of {budget}");
    assert!(within.iter().any(|&(spectra, _)| 1 < spectra), "{within:?}");
}

#[test]
fn a_bound_that_no_block_meets_is_never_trusted() {
    let features = Grid::try_filled(Domain::open([40, 40]), 1, 7_u8).unwrap();
    let options = Options { engine: Engine::Fft, ..Options::default() };
    let searcher = SsdSearcher::of_grid(&features, None, &[1], options).unwrap();
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    scratch.fft.limit = 0.0;
    searcher.search(&Template::new([3, 3], &[9; 9]), Placement::INSIDE, &mut scratch, &mut costs).unwrap();
    assert_eq!(scratch.repeated(), 1);
    assert!(costs.iter().all(|c| c.error == 36));
}

#[test]
fn many_tiles_have_the_same_costs() {
    for index in 0..12 {
        assert_same(both(index, usize::MAX, super::bound::LIMIT, [333, 419], [9, 14]));
    }
}
