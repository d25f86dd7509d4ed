//! Textures that flow.

use selvedge_core::{
    Domain, Event, Exemplars, Flow, Grid, Observer, Origin, Role, Run, SampleId, Seed, SimdLevel, Source, SourceMap,
    Transform,
};
use selvedge_testkit::from_png;
use selvedge_texture_optimization::{Animation, Animator, Checkpoint, Error, Field, Motion};

/// Smooth noise that tiles: no two neighborhoods of it are alike.
fn exemplars(shape: [u32; 2], periodic: bool) -> Exemplars<2> {
    let domain = Domain { shape, periodic: [periodic; 2] };
    let mut rng = Seed(9).rng();
    let samples = (0..domain.len()).map(|_| rng.below(256) as u8).collect();
    let features = Grid::from_vec(domain, 1, samples).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap()
}

/// The exemplar as it is, from a place of it on.
fn copied(exemplars: &Exemplars<2>, output: Domain<2>, from: [u32; 2]) -> SourceMap<2> {
    let mut map = SourceMap::unassigned(exemplars, output).unwrap();
    let shape = exemplars.sources()[0].domain().shape;
    for at in output.positions() {
        map.ids.set(0, at, exemplars.table().id(0, [0, 1].map(|axis| (at[axis] + from[axis]) % shape[axis])));
    }
    map
}

fn uniform(output: Domain<2>, [down, across]: [f32; 2]) -> Flow {
    let by = [vec![down; output.len()], vec![across; output.len()]].concat();
    Flow { by: Grid::from_vec(output, 2, by).unwrap(), known: None }
}

#[test]
fn whole_steps_of_a_copy_are_the_copy_moved_to_the_bit() {
    let output = Domain::periodic([24, 32]);
    let exemplars = exemplars(output.shape, true);
    let run = Run::seeded(1);
    let mut animator =
        Animator::new(&exemplars, copied(&exemplars, output, [0, 0]), &Animation::default(), &run).unwrap();
    for frame in 1..=5_u32 {
        let woven = animator.next(&uniform(output, [2.0, -3.0]), None, &run).unwrap();
        assert_eq!(woven.stats.carried, 1.0);
        let from = [(5 * 24 - 2 * frame) % 24, 3 * frame];
        assert!(*woven.result == copied(&exemplars, output, from), "{frame}");
    }
    // By halves of samples it gets as far.
    for _ in 0..4 {
        animator.next(&uniform(output, [-0.5, 0.25]), None, &run).unwrap();
    }
    assert!(*animator.frame() == copied(&exemplars, output, [24 - 8, 15 - 1]));
}

/// Has enough at once.
struct Cancelled;

impl Observer<2> for Cancelled {
    fn event(&self, _: &Event<'_, 2>) {}

    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn what_comes_counts_also_where_it_is_not_wished_for() {
    let output = Domain::periodic([24, 32]);
    let exemplars = exemplars(output.shape, true);
    let (run, options) = (Run::seeded(1), Animation { lambda: 0.0, ..Animation::default() });
    let mut animator = Animator::new(&exemplars, copied(&exemplars, output, [0, 0]), &options, &run).unwrap();
    assert_eq!(animator.next(&uniform(output, [2.0, -3.0]), None, &run).unwrap().stats.carried, 1.0);
}

#[test]
fn what_stays_at_first_changes_nothing_of_what_moves_then() {
    let output = Domain::periodic([24, 32]);
    let exemplars = exemplars(output.shape, true);
    let run = Run::seeded(1);
    let flow = Motion { field: Field::Vortex, speed: 1.7, center: None, angle: 0.0 }.flow(output, Seed(0)).unwrap();
    let after = |still: usize| {
        let first = copied(&exemplars, output, [0, 0]);
        let mut animator = Animator::new(&exemplars, first, &Animation::default(), &run).unwrap();
        (0..still).for_each(|_| _ = animator.next(&uniform(output, [0.0; 2]), None, &run).unwrap());
        (0..3).for_each(|_| _ = animator.next(&flow, None, &run).unwrap());
        animator.checkpoint()
    };
    assert!(after(2) == after(0));
}

#[test]
fn a_frame_that_is_cancelled_is_none() {
    let output = Domain::periodic([24, 32]);
    let exemplars = exemplars(output.shape, true);
    let (run, flow) = (Run::seeded(1), uniform(output, [0.5, -1.25]));
    let first = copied(&exemplars, output, [0, 0]);
    let mut animator = Animator::new(&exemplars, first, &Animation::default(), &run).unwrap();
    for frame in 0..4 {
        if frame == 2 {
            animator.close([(&flow, None); 3].into_iter(), &run).unwrap();
        }
        let before = animator.checkpoint();
        let woven = animator.next(&flow, None, &Run { observer: &Cancelled, ..run }).unwrap();
        assert!(!woven.complete);
        assert!(animator.checkpoint() == before, "{frame}");
        assert!(animator.next(&flow, None, &run).unwrap().complete && animator.checkpoint() != before);
    }
}

#[test]
fn what_flows_shows_the_frame_of_a_clip_that_is_its_exemplar_now() {
    let output = Domain::periodic([24, 32]);
    // The second frame is the first one, moved by its own: no place looks as it did.
    let still = exemplars(output.shape, true).sources()[0].features.samples().to_vec();
    let source = |frame: u16| {
        let mut samples = still.clone();
        samples.rotate_right(5 * 32 * usize::from(frame));
        let features = Grid::from_vec(output, 1, samples).unwrap();
        Source { features, valid: None, origin: Origin { exemplar: frame, transform: Transform::IDENTITY } }
    };
    let frames = [0, 1, 2].map(|frame| Exemplars::from_sources(vec![source(frame)], vec![1]).unwrap());
    let run = Run::seeded(1);
    let mut animator =
        Animator::new(&frames[0], copied(&frames[0], output, [0, 0]), &Animation::default(), &run).unwrap();
    for (step, frame) in [1, 2, 0, 1].into_iter().enumerate() {
        animator.turn_to(&frames[frame], &run).unwrap();
        animator.next(&uniform(output, [1.0, -3.0]), None, &run).unwrap();
        let by = step as u32 + 1;
        assert!(*animator.frame() == copied(&frames[frame], output, [24 - by, 3 * by]), "{by}");
    }
    let small = exemplars([24, 31], true);
    assert_eq!(animator.turn_to(&small, &run).unwrap_err(), Error::ForeignMap);
}

#[test]
fn an_animation_that_closes_leads_back_to_its_first_frame() {
    let output = Domain::periodic([24, 80]);
    let exemplars = exemplars(output.shape, true);
    let run = Run::seeded(1);
    // Twelve frames, of which the last six close: they do not come around by themselves.
    let flows: Vec<Flow> = (0..12_u32).map(|frame| uniform(output, [0.0, 3.0 - (frame % 2) as f32])).collect();
    let mut animator =
        Animator::new(&exemplars, copied(&exemplars, output, [0, 0]), &Animation::default(), &run).unwrap();
    let (mut gone, mut by) = (Vec::new(), 0);
    for frame in 1..12_u32 {
        if frame == 6 {
            animator.close(flows[6..].iter().map(|flow| (flow, None)), &run).unwrap();
        }
        animator.next(&flows[frame as usize - 1], None, &run).unwrap();
        by += 2 + frame % 2;
        let on = copied(&exemplars, output, [0, 80 - by]);
        let others = animator.frame().ids.plane(0).iter().zip(on.ids.plane(0)).filter(|(a, b)| a != b);
        gone.push(others.count());
    }
    assert!(gone[..5].iter().all(|n| *n == 0) && 0 < gone[5] && gone[5..].is_sorted() && gone[5] < output.len() / 2);
    // One step before what it began with.
    assert!(*animator.frame() == copied(&exemplars, output, [0, 2]), "{gone:?}");
    animator.next(&flows[11], None, &run).unwrap();
    assert!(*animator.frame() == copied(&exemplars, output, [0, 0]));
}

#[test]
fn nothing_flows_into_a_body_from_outside_of_it() {
    let output = Domain::periodic([24, 32]);
    let exemplars = exemplars(output.shape, true);
    let run = Run::seeded(1);
    let body = Grid::from_vec(output, 1, output.positions().map(|[_, x]| x < 20).collect()).unwrap();
    let mut animator =
        Animator::new(&exemplars, copied(&exemplars, output, [0, 0]), &Animation::default(), &run).unwrap();
    let woven = animator.next(&uniform(output, [0.0, 4.0]), Some(&body), &run).unwrap();
    assert_eq!(woven.stats.carried, 20.0 / 32.0);
    let small = Grid::try_filled(Domain::periodic([24, 31]), 1, true).unwrap();
    let refused = animator.next(&uniform(output, [0.0; 2]), Some(&small), &run).unwrap_err();
    assert_eq!(refused.to_string(), "the body that flows is [24, 31, 1], and [24, 32, 1] is needed");
}

#[test]
fn what_stands_outside_of_a_body_is_no_matter() {
    let output = Domain::open([40, 48]);
    let exemplars = exemplars([64, 64], false);
    let run = Run::seeded(1);
    let inside = |[y, x]: [u32; 2]| (6..30).contains(&y) && (9..36).contains(&x);
    let body = Grid::from_vec(output, 1, output.positions().map(inside).collect()).unwrap();
    let first = copied(&exemplars, output, [5, 3]);
    let (mut other, elsewhere) = (first.clone(), copied(&exemplars, output, [20, 11]));
    output.positions().filter(|&at| !inside(at)).for_each(|at| other.ids.set(0, at, elsewhere.ids.get(0, at)));
    let [first, other] = [first, other].map(|map| {
        let mut animator = Animator::new(&exemplars, map, &Animation::default(), &run).unwrap();
        animator.next(&uniform(output, [0.5, 2.0]), Some(&body), &run).unwrap().result.clone()
    });
    assert_eq!(first, other);
}

#[test]
fn a_body_that_closes_still_lets_nothing_in() {
    let output = Domain::periodic([24, 80]);
    let exemplars = exemplars(output.shape, true);
    let (run, flow) = (Run::seeded(1), uniform(output, [0.0, 3.0]));
    let body = Grid::from_vec(output, 1, output.positions().map(|[_, x]| x < 40).collect()).unwrap();
    let mut animator =
        Animator::new(&exemplars, copied(&exemplars, output, [0, 0]), &Animation::default(), &run).unwrap();
    animator.close([(&flow, Some(&body)); 3].into_iter(), &run).unwrap();
    // The last of three: what leads to the first frame from outside of its body is not wished for.
    for _ in 0..2 {
        animator.next(&flow, Some(&body), &run).unwrap();
    }
    let woven = animator.next(&flow, Some(&body), &run).unwrap();
    assert_eq!(woven.stats.carried, 40.0 / 80.0);
}

#[test]
fn what_flows_in_over_an_open_edge_goes_on_as_the_exemplar_does() {
    let exemplars = exemplars([40, 44], false);
    let output = Domain::open([24, 24]);
    let run = Run::seeded(1);
    let mut animator =
        Animator::new(&exemplars, copied(&exemplars, output, [10, 12]), &Animation::default(), &run).unwrap();
    for frame in 1..=4 {
        let woven = animator.next(&uniform(output, [1.0, 2.0]), None, &run).unwrap();
        assert!(woven.stats.carried < 0.9);
        assert!(*woven.result == copied(&exemplars, output, [10 - frame, 12 - 2 * frame]), "{frame}");
    }
}

#[test]
fn threads_and_instructions_change_no_frame() {
    let exemplars = exemplars([30, 34], false);
    let output = Domain { shape: [29, 40], periodic: [false, true] };
    let motion = Motion { field: Field::Vortex, speed: 1.5, center: None, angle: 0.0 };
    let flow = motion.flow(output, Seed(0)).unwrap();
    let body = Grid::from_vec(output, 1, output.positions().map(|[y, x]| y + x < 60).collect()).unwrap();
    let of = |threads: usize, simd| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let run = Run { simd, ..Run::seeded(5) };
        pool.install(|| {
            let first = copied(&exemplars, output, [0, 0]);
            let mut animator = Animator::new(&exemplars, first, &Animation::default(), &run).unwrap();
            let mut frames = Vec::new();
            for frame in 0..4 {
                if frame == 1 {
                    animator.close([(&flow, Some(&body)); 4].into_iter(), &run).unwrap();
                }
                frames.push(animator.next(&flow, Some(&body), &run).unwrap().result.clone());
            }
            frames
        })
    };
    let one = of(1, SimdLevel::Auto);
    assert!(one[0] != one[2]);
    assert!(of(2, SimdLevel::Avx2) == one && of(3, SimdLevel::Scalar) == one);
}

#[test]
fn frames_go_on_from_any_checkpoint_as_if_they_had_not_stopped() {
    let first = exemplars([30, 34], false);
    let darker = first.sources()[0].features.map(|v| v / 2).unwrap();
    // A closure takes animators of one lifetime alone.
    let textures: &'static [_; 2] = Box::leak(Box::new([first.with_features(vec![darker], vec![1]).unwrap(), first]));
    let output = Domain { shape: [29, 40], periodic: [false, true] };
    let motion = Motion { field: Field::Vortex, speed: 1.7, center: None, angle: 0.0 };
    let flow = motion.flow(output, Seed(0)).unwrap();
    let body = Grid::from_vec(output, 1, output.positions().map(|[y, x]| y + x < 60).collect()).unwrap();
    let (options, run) = (Animation::default(), Run::seeded(5));
    // Seven frames after the first one, of a clip of two, of which the last four close.
    let on = |mut animator: Animator<'_>, from: usize| {
        let (mut frames, mut kept) = (Vec::new(), vec![animator.checkpoint().to_bytes()]);
        for frame in from..7 {
            if frame == 3 || (frame == from && 3 < frame) {
                animator.close([(&flow, Some(&body)); 5].into_iter(), &run).unwrap();
            }
            animator.turn_to(&textures[(frame + 1) % 2], &run).unwrap();
            let stats = animator.next(&flow, Some(&body), &run).unwrap().stats;
            frames.push((animator.frame().ids.clone(), stats));
            kept.push(animator.checkpoint().to_bytes());
        }
        (frames, kept)
    };
    let first = copied(&textures[0], output, [0, 0]);
    let (whole, kept) = on(Animator::new(&textures[0], first, &options, &run).unwrap(), 0);
    for (from, bytes) in kept[..7].iter().enumerate() {
        let checkpoint = Checkpoint::of_bytes(bytes).unwrap();
        let animator = Animator::resume(&textures[from % 2], output, &checkpoint, &options, &run).unwrap();
        assert!(animator.checkpoint() == checkpoint);
        assert!(on(animator, from).0 == whole[from..], "from {from}");
    }
    for end in (0..kept[3].len()).step_by(397) {
        let refused = Checkpoint::of_bytes(&kept[3][..end]).unwrap_err();
        assert_eq!(refused, Error::Checkpoint { what: "form differs" }, "{end}");
    }
    let mut damaged = kept[5].clone();
    let closed = b"selvedge animation 1\n".len() + 4 * 8;
    damaged[closed..closed + 8].fill(0xff);
    let damaged = Checkpoint::of_bytes(&damaged).unwrap();
    let mut animator = Animator::resume(&textures[1], output, &damaged, &options, &run).unwrap();
    let refused = animator.close([(&flow, Some(&body)); 5].into_iter(), &run).unwrap_err();
    assert_eq!(refused, Error::Checkpoint { what: "frames that close are fewer" });
    let checkpoint = Checkpoint::of_bytes(&kept[3]).unwrap();
    let refused = |exemplars: &Exemplars<2>, output| {
        Animator::resume(exemplars, output, &checkpoint, &options, &run).unwrap_err().to_string()
    };
    let other = Domain { periodic: [false; 2], ..output };
    assert_eq!(refused(&textures[0], other), "the checkpoint is of another animation: its output differs");
    let small = exemplars([30, 33], false);
    assert_eq!(refused(&small, output), "the checkpoint is of another animation: its exemplars differ");
}

#[test]
fn flows_that_do_not_lie_over_the_output_or_are_no_numbers_are_refused() {
    let exemplars = exemplars([20, 20], true);
    let output = Domain::open([16, 18]);
    let run = Run::seeded(0);
    let mut animator =
        Animator::new(&exemplars, copied(&exemplars, output, [0, 0]), &Animation::default(), &run).unwrap();
    let small = animator.next(&uniform(Domain::open([16, 17]), [0.0; 2]), None, &run).unwrap_err();
    assert_eq!(small, Error::FlowShape { expected: [16, 18], found: [16, 17] });
    assert_eq!(small.to_string(), "the flow is 17x16 vectors, and the output 18x16 px");
    let mut odd = uniform(output, [0.0; 2]);
    odd.by.set(1, [3, 5], f32::NAN);
    assert_eq!(animator.next(&odd, None, &run).unwrap_err(), Error::FlowValue { x: 5, y: 3 });
    let mut known = Grid::try_filled(output, 1, true).unwrap();
    known.set(0, [3, 5], false);
    odd.known = Some(known);
    assert!(animator.next(&odd, None, &run).is_ok());
    let options = Animation { lambda: -1.0, ..Animation::default() };
    let refused = Animator::new(&exemplars, copied(&exemplars, output, [0, 0]), &options, &run);
    assert_eq!(refused.unwrap_err().to_string(), "a lambda of -1 is out of range");
}

#[test]
fn what_is_flat_in_the_exemplar_does_not_grow_where_a_texture_is_made_anew() {
    // Scales, and a part of their mean alone: what is nearest to whatever is not decided yet.
    let scales = from_png(Role::Color, include_bytes!("../../../../fixtures/scales.png")).unwrap();
    let whole = Exemplars::of(&[std::slice::from_ref(&scales)]).unwrap();
    let is_flat = |at: [u32; 2]| at.iter().all(|p| (8..28).contains(p));
    let mut features = whole.sources()[0].features.clone();
    for c in 0..features.channels() {
        let sum: u64 = features.plane(c).iter().map(|&v| u64::from(v)).sum();
        let mean = (sum / features.domain().len() as u64) as u8;
        features.domain().positions().filter(|&at| is_flat(at)).for_each(|at| features.set(c, at, mean));
    }
    let exemplars = whole.with_features(vec![features], whole.weights().to_vec()).unwrap();
    let output = Domain::open([40, 40]);
    let run = Run::seeded(1);
    let first = copied(&exemplars, output, [4, 12]);
    let flat = |map: &SourceMap<2>| {
        let is_flat = |id: &SampleId| is_flat(exemplars.locate(*id).unwrap().1);
        map.ids.plane(0).iter().filter(|id| is_flat(id)).count() as f64 / output.len() as f64
    };
    let before = flat(&first);
    let flow = Motion { field: Field::Source, speed: 1.5, center: None, angle: 0.0 }.flow(output, Seed(0)).unwrap();
    let mut animator = Animator::new(&exemplars, first, &Animation::default(), &run).unwrap();
    for _ in 0..16 {
        animator.next(&flow, None, &run).unwrap();
    }
    let after = flat(animator.frame());
    assert!(after < 1.5 * before, "{after} of the last frame is flat, and {before} of the first");
}
