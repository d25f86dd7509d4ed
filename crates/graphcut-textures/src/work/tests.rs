//! Steps of runs as they were timed, played again: what is left follows from what was done.

use super::*;
use selvedge_core::Exemplars;

/// A stage, steps of it that are done and all of them, and when.
type Step = (char, u64, u64, u64);

/// Samples of the smallest output, of larger ones, and at which hundredth of a second of processor time which step of
/// which stage was done: by development on two loaded cores. Photographs of 1024^2 to 2048^2, the others to 512^2 from
/// 192^2.
const RUNS: [(u64, u64, &[Step]); 6] = [
    (
        262144,
        5242880,
        &[
            ('c', 36261, 262144, 0),
            ('c', 250773, 262144, 13),
            ('c', 262144, 262144, 15),
            ('r', 3, 22, 29),
            ('r', 6, 22, 46),
            ('r', 8, 22, 60),
            ('r', 11, 22, 76),
            ('r', 13, 22, 89),
            ('r', 16, 22, 108),
            ('r', 19, 22, 123),
            ('r', 21, 22, 137),
            ('r', 22, 22, 142),
            ('s', 1048576, 5242880, 156),
            ('s', 5242880, 5242880, 200),
        ],
    ),
    (
        262144,
        5242880,
        &[
            ('c', 36261, 262144, 0),
            ('c', 207774, 262144, 13),
            ('c', 262144, 262144, 21),
            ('r', 4, 24, 36),
            ('r', 8, 24, 52),
            ('r', 13, 24, 66),
            ('r', 17, 24, 81),
            ('r', 21, 24, 95),
            ('r', 24, 24, 105),
            ('s', 1048576, 5242880, 132),
            ('s', 5242880, 5242880, 200),
        ],
    ),
    (
        262144,
        5242880,
        &[
            ('c', 14690, 262144, 0),
            ('c', 132096, 262144, 23),
            ('c', 262144, 262144, 43),
            ('r', 4, 36, 71),
            ('r', 8, 36, 97),
            ('r', 12, 36, 119),
            ('r', 16, 36, 146),
            ('r', 20, 36, 174),
            ('r', 24, 36, 197),
            ('r', 28, 36, 221),
            ('r', 32, 36, 246),
            ('r', 36, 36, 270),
            ('s', 5242880, 5242880, 331),
        ],
    ),
    (
        262144,
        0,
        &[
            ('c', 14490, 262144, 0),
            ('c', 108743, 262144, 8),
            ('c', 198726, 262144, 16),
            ('c', 257329, 262144, 24),
            ('c', 262144, 262144, 26),
            ('r', 1, 48, 34),
            ('r', 7, 48, 44),
            ('r', 11, 48, 55),
            ('r', 16, 48, 63),
            ('r', 20, 48, 73),
            ('r', 25, 48, 83),
            ('r', 30, 48, 94),
            ('r', 36, 48, 107),
            ('r', 41, 48, 115),
            ('r', 47, 48, 126),
            ('r', 48, 48, 126),
        ],
    ),
    (
        262144,
        0,
        &[
            ('c', 14490, 262144, 0),
            ('c', 153683, 262144, 10),
            ('c', 262144, 262144, 22),
            ('r', 3, 42, 33),
            ('r', 6, 42, 44),
            ('r', 9, 42, 57),
            ('r', 12, 42, 68),
            ('r', 15, 42, 79),
            ('r', 18, 42, 91),
            ('r', 21, 42, 102),
            ('r', 24, 42, 113),
            ('r', 26, 42, 123),
            ('r', 31, 42, 138),
            ('r', 38, 42, 152),
            ('r', 42, 42, 160),
        ],
    ),
    (
        262144,
        0,
        &[
            ('c', 3773, 262144, 0),
            ('c', 122433, 262144, 11),
            ('c', 205704, 262144, 22),
            ('c', 257546, 262144, 33),
            ('c', 262144, 262144, 36),
            ('r', 9, 134, 51),
            ('r', 22, 134, 64),
            ('r', 37, 134, 77),
            ('r', 51, 134, 91),
            ('r', 63, 134, 105),
            ('r', 75, 134, 118),
            ('r', 87, 134, 131),
            ('r', 102, 134, 145),
            ('r', 116, 134, 157),
            ('r', 129, 134, 172),
            ('r', 134, 134, 173),
        ],
    ),
];

#[test]
fn what_is_left_follows_from_what_was_done() {
    for (smallest, larger, steps) in RUNS {
        let side = (smallest as f64).sqrt() as u32;
        let plane = selvedge_testkit::simple::noise(8, 8, 1);
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let (output, options) = (Domain::open([side; 2]), Options { region: Some([8; 2]), ..Options::default() });
        let plan = crate::plan(&exemplars, output, None, &options, &Default::default()).unwrap();
        let work = Work::of(&plan.settings, output, larger, &options);
        let all = steps.last().unwrap().3 as f64;
        for &(stage, done, of, at) in steps {
            let [done, of] = match stage {
                'c' => work.at("cover", done, of),
                'r' => work.at("refine", done, of),
                _ => work.settled(done),
            };
            // After a tenth of the run, and while a tenth is left.
            if (0.1 * all..0.9 * all).contains(&(at as f64)) {
                let told = at as f64 * of as f64 / done as f64 / all;
                assert!((1.0 / 1.5..1.5).contains(&told), "{stage} at {at} of {all}: {told:.2} of what it took");
            }
        }
    }
}

#[test]
fn work_grows_to_all_of_it_over_several_levels() {
    #[derive(Default)]
    struct Notes(std::sync::Mutex<Vec<[u64; 2]>>);
    impl Observer<2> for Notes {
        fn event(&self, event: &Event<'_, 2>) {
            self.0.lock().unwrap().push(event.work.unwrap());
        }
    }
    let plane = selvedge_testkit::simple::noise(120, 120, 1);
    let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
    for levels in [1, 3] {
        let (notes, options) = (Notes::default(), Options { levels: Some(levels), ..Options::default() });
        let run = selvedge_core::Run { observer: &notes, ..selvedge_core::Run::seeded(1) };
        crate::graphcut(&exemplars, Domain::open([260, 300]), &options, &run).unwrap();
        let told = notes.0.into_inner().unwrap();
        assert!(told.is_sorted() && told.iter().all(|&[_, of]| of == told[0][1]), "{told:?}");
        assert_eq!(told.last().map(|&[done, of]| of - done), Some(0), "{levels}");
    }
}
