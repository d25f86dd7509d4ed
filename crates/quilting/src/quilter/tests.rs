//! Which blocks are chosen, one by one.

use super::*;
use crate::options::{Continuation, Options, Stage};
use crate::quilt::Plan;
use crate::search::plain::PlainSearch;
use crate::search::{Space, Term};
use selvedge_core::{Domain, Exemplars, Grid, Look, Plane, Role, Samples, Seed};

/// Smooth noise: patches fit more or less everywhere.
fn noise(seed: u64, shape: [u32; 2]) -> Exemplars<2> {
    let domain = Domain::open(shape);
    let mut rng = Seed(seed).rng();
    let mut value = 128_i32;
    let samples = (0..domain.len()).map(|_| {
        value = (value + rng.below(41) as i32 - 20).clamp(0, 255);
        value as u8
    });
    let plane = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 1, samples.collect()).unwrap()));
    Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap()
}

/// What was laid, block by block: `look(quilter, number)` after each.
fn lay_each(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    mut look: impl FnMut(&Quilter<'_, PlainSearch<'_>>, &Look, usize),
) {
    let run = Run::seeded(4);
    let search = PlainSearch::new(exemplars, None);
    let mut map = SourceMap::unassigned(exemplars, output).unwrap();
    let pass = Plan::new(exemplars, output, options, &run).unwrap().pass(&run);
    let mut quilter = Quilter::new(&search, pass, &run, &mut map).unwrap();
    let mut worker = Worker::default();
    for number in 0..quilter.pass.grid.len() {
        let found = quilter.finder().find(number, &mut worker).unwrap();
        quilter.lay(found).unwrap();
        look(&quilter, &worker.overlap, number);
    }
}

#[test]
fn every_block_is_within_the_tolerance_of_the_least_and_not_all_are_the_least() {
    let exemplars = noise(1, [30, 34]);
    for (tolerance, squared) in [(0.1, 1210), (0.3, 1690), (0.0, 1000)] {
        let options = Options { block: Some(9), overlap: Some(3), tolerance, ..Options::paper() };
        let (mut worse, mut blocks) = (0, 0);
        lay_each(&exemplars, Domain::open([80, 80]), &options, |quilter, overlap, number| {
            if number == 0 {
                return;
            }
            let terms = [Term::new(Space::Texture, quilter.pass.grid.block(number).shape(), overlap)];
            let (search, mut scratch) = (PlainSearch::new(&exemplars, None), Vec::new());
            let least = search.near(&terms, &|_| 0, &|_, _| false, &mut scratch).unwrap()[0].error;
            let chosen = quilter.cloth.laid[number].unwrap().error;
            assert!(least <= chosen && chosen * 1000 <= least * squared, "{tolerance}: {chosen} {least}");
            worse += u32::from(least < chosen);
            blocks += 1;
        });
        assert!(if tolerance == 0.0 { worse == 0 } else { blocks < worse * 3 }, "{tolerance}: {worse} of {blocks}");
    }
}

#[test]
fn no_block_is_within_two_samples_of_a_continuation() {
    // Nothing fits as well as what goes on: each would, or would all but exactly.
    let exemplars = noise(2, [40, 40]);
    let mut close = 0;
    for continuation in [Continuation::Avoid, Continuation::Allow] {
        let options = Options { block: Some(10), continuation, spread: 0.0, ..Options::default() };
        lay_each(&exemplars, Domain::open([60, 60]), &options, |quilter, _, number| {
            let block = quilter.pass.grid.block(number);
            for neighbor in quilter.pass.grid.neighbors(number) {
                let (there, here) = (quilter.cloth.laid[neighbor].unwrap(), quilter.cloth.laid[number].unwrap());
                let way = quilter.pass.grid.block(neighbor).way_to(quilter.cloth.map.domain(), &block);
                let off = (0..2).map(|a| (i64::from(there.at[a]) + way[a] - i64::from(here.at[a])).abs()).max();
                assert!(continuation == Continuation::Allow || Some(2) < off, "{off:?}");
                close += u32::from(off == Some(0));
            }
        });
    }
    assert!(0 < close, "where it is allowed, blocks go on");
}

#[test]
fn random_blocks_are_drawn_from_all_even_where_they_overlap() {
    let exemplars = noise(3, [20, 24]);
    let options = Options { block: Some(8), stage: Stage::Random, ..Options::default() };
    // Three blocks of eight go round 21 samples: some of them overlap.
    let (mut before, mut overlaps) = (0, 0);
    lay_each(&exemplars, Domain::periodic([21, 21]), &options, |quilter, _, number| {
        let block = quilter.pass.grid.block(number);
        overlaps += block.rows.before + block.columns.before;
        let [h, w] = block.shape();
        assert_eq!(quilter.counts.candidates - before, u64::from(21 - h) * u64::from(25 - w));
        before = quilter.counts.candidates;
    });
    assert!(0 < overlaps);
}

#[test]
fn waves_lay_what_raster_order_lays() {
    let exemplars = noise(4, [30, 26]);
    for (shape, periodic) in [([70, 80], [false, false]), ([12, 90], [true, false]), ([50, 40], [false, true])] {
        let output = Domain { shape, periodic };
        // Uses are counted from wave to wave.
        let options = Options { block: Some(9), overlap: Some(4), spread: 0.0, ..Options::default() };
        let mut raster = None;
        lay_each(&exemplars, output, &options, |quilter, _, _| raster = Some(quilter.cloth.map.clone()));
        let waves = crate::quilt(&exemplars, output, &options, &Run::seeded(4)).unwrap().result;
        assert!(raster == Some(waves), "{periodic:?}");
    }
}
