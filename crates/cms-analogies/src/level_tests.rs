//! Coarse to fine: which levels there are, and what comes of them.

use selvedge_core::{Domain, Exemplars, Grid, Guide, Origin, Source, Transform};

use crate::agreement::{Term, of_sample};
use crate::tests::case;
use crate::{Constraint, Options, levels};

/// The same with as many levels as there may be: nothing but the labelling it begins with is another.
#[test]
fn levels_end_with_whole_outputs_of_no_higher_energy() {
    let (mut lower, mut several) = (0, 0);
    for seed in 0..40 {
        let mut case = case(seed);
        // Small enough for such small cases.
        case.options.neighborhood = 0;
        case.constraints.iter_mut().for_each(|c| c.ratio = 1);
        let (_, one) = case.weave(true);
        case.options.levels = None;
        several += levels::below(&case.exemplars, &case.constraints, &case.options).unwrap().len();
        let (map, stats) = case.weave(true);
        assert_eq!(map.holes(), 0);
        assert!(stats.energy.windows(2).all(|pair| pair[1] < pair[0]), "{seed}: {:?}", stats.energy);
        let terms = Term::list(&case.exemplars, &case.constraints, &case.options);
        let own = |p| i64::from(of_sample(&terms, &case.exemplars, p, map.ids.get(0, p)));
        assert_eq!(stats.model.agreement, map.domain().positions().map(own).sum::<i64>());
        lower += u32::from(stats.model.sum() <= one.model.sum());
        // In the counts as well.
        for threads in [1, 2, 3].into_iter().filter(|_| seed % 2 == 0) {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (same, counts) = pool.install(|| case.weave(true));
            assert_eq!(same, map, "{seed} {threads}");
            assert_eq!(counts, stats, "{seed} {threads}");
        }
    }
    assert!(20 <= several && 20 <= lower, "{several} levels, {lower} of 40 no higher");
}

#[test]
fn levels_divide_every_ratio_or_are_divided_by_it() {
    let domain = Domain::open([96, 96]);
    let flat = |domain| Grid::try_filled(domain, 1, 7).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let source = Source { features: flat(domain), valid: None, origin };
    let exemplars = Exemplars::from_sources(vec![source], vec![1]).unwrap();
    let ratios = |ratios: &[u32], neighborhood, levels| {
        let guide = Guide::new(&exemplars, &[flat(domain)], flat(domain)).unwrap();
        let of = |&ratio: &u32| Constraint { guide: guide.clone(), ratio, weight: 1.0 };
        let constraints: Vec<_> = ratios.iter().map(of).collect();
        let options = Options { neighborhood, levels, ..Options::paper() };
        let below = levels::below(&exemplars, &constraints, &options).unwrap();
        below.iter().map(|l| l.constraints.iter().map(|c| c.ratio).collect()).collect::<Vec<Vec<u32>>>()
    };
    assert_eq!(ratios(&[8, 1], 1, None), [[4, 1], [2, 1]]);
    assert_eq!(ratios(&[2], 1, Some(4)), [[1], [1], [1]]);
    assert_eq!(ratios(&[10], 1, None), [[5]]);
    assert_eq!(ratios(&[3], 1, None), Vec::<Vec<u32>>::new());
    // Two neighborhoods of 17 samples fit into 48, not into 24.
    assert_eq!(ratios(&[1], 8, None), [[1]]);
    assert_eq!(ratios(&[1], 1, Some(1)), Vec::<Vec<u32>>::new());
}
