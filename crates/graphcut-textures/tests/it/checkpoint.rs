//! Runs that go on from where others were.

use std::sync::atomic::{AtomicU64, Ordering};

use selvedge_core::{Domain, Observer, Run};
use selvedge_graphcut_textures::{Checkpoint, Error, Options, Placement, Start, graphcut, plan};

use crate::common::{blobs, of};

/// Asks to stop after so many questions.
struct Until(AtomicU64);

impl<const D: usize> Observer<D> for Until {
    fn cancelled(&self) -> bool {
        let left = self.0.load(Ordering::Relaxed);
        self.0.store(left.saturating_sub(1), Ordering::Relaxed);
        left == 0
    }
}

#[test]
fn runs_go_on_from_any_checkpoint_as_if_they_had_not_stopped() {
    let e = of(&blobs([10, 18, 16], 2));
    let output = Domain { shape: [14, 30, 24], periodic: [true, false, false] };
    let time = Options { free: [true, false, false], ..Options::default() };
    let sub = Options { placement: Placement::Sub, region: Some([5, 8, 8]), reach: Some([3; 3]), ..Options::default() };
    let (mut kept, mut ended) = (0, 0);
    for (options, shape) in
        [(sub, output.shape), (Options { variety: Some(1.0), ..sub }, output.shape), (time, [26, 18, 16])]
    {
        let options = Options { refine: Some(24), levels: Some(1), ..options };
        let output = Domain { shape, ..output };
        let run = Run::seeded(5);
        let whole = graphcut(&e, output, &options, &run).unwrap();
        let plan = plan(&e, output, None, &options, &run.limits).unwrap();
        let start = || Start::empty(&e, output).unwrap();
        let go_on = |bytes: &[u8]| {
            let from = Checkpoint::of_bytes(bytes).unwrap();
            let woven = plan.weave_on(start(), Some(&from), &run, &mut |_| ()).unwrap();
            assert!(woven.complete && woven.result == whole.result, "from {:?}", from.done());
            assert_eq!(woven.stats, whole.stats);
        };
        let mut all = Vec::new();
        plan.weave_on(start(), None, &run, &mut |made| all.push(made().to_bytes())).unwrap();
        all.iter().step_by(5).for_each(|bytes| go_on(bytes));
        kept += all.len();
        // Ended wherever it is: in the middle of a search, a cut, or of regions that are refined at once.
        for asked in (1..400).step_by(37) {
            let observer = &Until(AtomicU64::new(asked));
            let mut last = None;
            let run = Run { observer, ..run };
            let woven = plan.weave_on(start(), None, &run, &mut |made| last = Some(made().to_bytes())).unwrap();
            ended += usize::from(!woven.complete);
            go_on(&last.unwrap());
        }
        for end in (0..all[0].len()).step_by(97) {
            assert!(Checkpoint::<3>::of_bytes(&all[0][..end]).is_err(), "{end}");
        }
        assert!(Checkpoint::<2>::of_bytes(&all[0]).is_err(), "of another number of axes");
        let from = Checkpoint::of_bytes(&all[0]).unwrap();
        let other = Domain { shape: [14, 30, 25], ..output };
        let of_other = selvedge_graphcut_textures::plan(&e, other, None, &sub, &run.limits).unwrap();
        let refused = of_other.weave_on(Start::empty(&e, other).unwrap(), Some(&from), &run, &mut |_| ());
        assert_eq!(refused.unwrap_err(), Error::Checkpoint { what: "output" });
    }
    assert!(20 < kept && 10 < ended, "{kept} were kept, {ended} were ended");
}
