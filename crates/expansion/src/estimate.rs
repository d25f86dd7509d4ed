//! How much memory a move needs.

use selvedge_core::{Bytes, Domain};
use selvedge_maxflow::GridGraph;

/// Bytes of a sample of the frame: its place, what is there and what is offered; its choice, before and after pruning;
/// whether it takes the offer; its node, and how much the offer differs.
const A_SAMPLE: u64 = 3 * 4 + 2 + 1 + 2 * 4;
/// Bytes of such a sample while it is pruned: its margin, and the list of those to look at, which doubles. All of that
/// is given back before the cut.
const PRUNED: u64 = 8 + 16;

/// An upper bound of the bytes that a move over a window of this shape holds: its [`Frame`](crate::Frame), choices,
/// [`Scratch`](crate::Scratch) and [`Proposal`](crate::Proposal). The map and the prices are the caller's.
pub fn estimate<const D: usize>(window: [u32; D]) -> Bytes {
    let frame = window.map(|side| side.saturating_add(2));
    let cut = Bytes(GridGraph::estimate(frame.map(|side| side as usize)));
    Bytes::of_samples(Domain::open(frame), A_SAMPLE) + cut.max(Bytes::of_samples(Domain::open(frame), PRUNED))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frame, Holes, Prices, Scratch, expand};
    use selvedge_core::{
        Exemplars, Grid, Origin, Patch, SampleId, SeamCosts, SeamMeasure, Seed, Source, SourceMap, Transform, Window,
    };
    use selvedge_testkit::memory;

    const TEST: &str = "estimate::tests::moves_stay_within_their_estimate";

    /// Prices of seams, and for each sample one of its own.
    struct Own<'a, const D: usize>(&'a SeamCosts<D>);

    impl<const D: usize> Prices<D> for Own<'_, D> {
        fn pair(&self, axis: usize, here: SampleId, there: SampleId) -> i32 {
            self.0.pair(axis, here, there)
        }

        fn unary(&self, place: usize, id: SampleId) -> i32 {
            if id == SampleId::new(place as u32) {
                0
            } else {
                (place as i32).wrapping_mul(0x9E37_79B1_u32 as i32) >> 16 & 0xfff
            }
        }

        fn difference(&self, a: SampleId, b: SampleId) -> u32 {
            self.0.difference(a, b)
        }
    }

    fn measure<const D: usize>(shape: [u32; D]) {
        let domain = Domain::open(shape);
        let mut rng = Seed(7).rng();
        let samples = (0..domain.len()).map(|_| rng.below(256) as u8).collect();
        let features = Grid::from_vec(domain, 1, samples).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        let costs = SeamCosts::new(&exemplars, SeamMeasure::Difference).unwrap();
        let mut map = SourceMap::unassigned(&exemplars, domain).unwrap();
        let ids = map.ids.samples_mut();
        (0..).zip(ids).for_each(|(i, id)| *id = SampleId::new(i));
        let before = memory::held();
        let mut offset = [0; D];
        offset[0] = 1;
        let (patch, window) = (Patch { source: 0, offset }, Window::all(domain));
        let frame = Frame::of_patch(&exemplars, &map, &patch, &window).unwrap();
        let choices = frame.choices(Holes::Fill, |_| None).unwrap();
        let mut scratch = Scratch::default();
        let proposal = expand(&frame, &choices, &Own(&costs), &mut scratch, &|| false).unwrap();
        memory::tell(before);
        assert!(proposal.free * 2 > domain.len(), "{} had a choice", proposal.free);
    }

    #[test]
    fn moves_stay_within_their_estimate() {
        let run = |number: usize| match number {
            0 => measure([700, 900]),
            1 => measure([256, 256]),
            _ => measure([40, 90, 100]),
        };
        let estimates = [estimate([700, 900]), estimate([256, 256]), estimate([40, 90, 100])];
        // What a process holds is counted in pages, and a small one keeps some that it gave back.
        let check = |number: usize, held: u64| {
            let told = estimates[number].0;
            assert!(held <= told + (1 << 18) && told <= 2 * held + (1 << 20), "{number}: held {held}, told {told}");
        };
        memory::of_each(TEST, estimates.len(), run, check);
    }
}
