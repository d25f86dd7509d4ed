//! What is remembered of searches, and for how long.

use super::*;
use selvedge_core::{Domain, Grid, Origin, Seed, Source, Transform};

/// The samples of a window are within so many steps of one of another, along both axes.
fn is_near(output: Domain<2>, window: &Window<2>, at: [u32; 2], steps: u32) -> bool {
    window.places(output).flatten().map(|place| output.position(place)).any(|other| {
        (0..2).all(|a| {
            let d = at[a].abs_diff(other[a]);
            (if output.periodic[a] { d.min(output.shape[a] - d) } else { d }) <= steps
        })
    })
}

#[test]
fn a_change_is_forgotten_as_far_as_it_could_matter() {
    for case in 0..60 {
        let mut rng = Seed(case).rng();
        let output = Domain { shape: [12, 14], periodic: [case % 2 == 0, case % 3 == 0] };
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let features = Grid::try_filled(Domain::open([5, 4]), 1, 0).unwrap();
        let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        let options = Options { neighborhood: 2, ..Options::paper() };
        let map = SourceMap::unassigned(&exemplars, output).unwrap();
        let run = Run::seeded(0);
        let (of, start) = ((&exemplars, Vec::new()), (map, None));
        let mut weaver = Weaver::new(of, start, &[true], &options, &run, true).unwrap();
        let label = |y: u32, x: u32| Patch { source: 0, offset: [y as i32, x as i32] };
        let labels: Vec<Patch<2>> = (0..6).map(|_| label(rng.below(8), rng.below(11))).collect();
        let known: Vec<usize> = (0..12).map(|_| rng.below(output.len() as u32) as usize).collect();
        for &place in &known {
            let labels = labels.iter().map(|label| (*label, false)).collect();
            weaver.tried.insert(place, Tried { labels, is_idle: false });
        }
        let changed =
            Window { start: [rng.below(10) as i32, rng.below(12) as i32], shape: [1 + rng.below(2), 1 + rng.below(2)] };
        weaver.forget(&changed);
        for place in known {
            let at = output.position(place);
            let was_seen = is_near(output, &changed, at, options.neighborhood);
            assert_eq!(weaver.tried.contains_key(&place), !was_seen, "{output:?}, {changed:?}: {at:?}");
            for (label, again) in weaver.tried.get(&place).into_iter().flat_map(|tried| &tried.labels) {
                let mut shown = label.footprint(&exemplars, &Window::all(output)).places(output).flatten();
                let beside = shown.any(|p| is_near(output, &changed, output.position(p), 1));
                assert_eq!(*again, beside, "{output:?}, {changed:?}: {label:?}");
            }
        }
    }
}
