//! Clips of which only some frames are held.

use std::borrow::Cow;
use std::ops::Range;

use selvedge_core::{Domain, Exemplars, Grid, Run, Source, SourceTable};
use selvedge_graphcut_textures::Error;
use selvedge_graphcut_textures::video::{DistanceOptions, Footage, FrameDistances, JumpOptions, LoopOptions, looped};

use crate::video::{changing, jump, of};

/// Hands over copies, so many frames at once at most.
struct Read<'a> {
    clip: &'a Exemplars<3>,
    most: u32,
    missing: Option<u32>,
}

impl<'a> Read<'a> {
    fn new(clip: &'a Exemplars<3>, most: u32) -> Self {
        Self { clip, most, missing: None }
    }
}

impl Footage for Read<'_> {
    fn table(&self) -> &SourceTable<3> {
        self.clip.table()
    }

    fn weights(&self) -> &[u8] {
        self.clip.weights()
    }

    fn stretch(&self, frames: Range<u32>) -> Result<Cow<'_, Source<3>>, Error> {
        assert!(frames.len() as u32 <= self.most, "{frames:?}");
        match self.missing.filter(|missing| frames.contains(missing)) {
            Some(frame) => Err(Error::Unread { frame }),
            None => self.clip.stretch(frames),
        }
    }
}

#[test]
fn clips_that_are_read_again_loop_as_those_that_are_held() {
    let mut masked = of(&changing([31, 37, 40], 5, 3)).sources()[0].as_ref().clone();
    let domain = masked.domain();
    let valid = domain.positions().map(|[t, y, x]| (t + y * x) % 5 != 0 && y != 7).collect();
    masked.valid = Some(Grid::from_vec(domain, 1, valid).unwrap().into());
    let masked = Exemplars::from_sources(vec![masked], vec![2, 1]).unwrap();
    let run = Run::seeded(0);
    for clip in [of(&changing([40, 70, 66], 8, 2)), of(&selvedge_testkit::exemplars::beach([50, 40, 40])), masked] {
        let whole = FrameDistances::new(&clip, &DistanceOptions::default(), &run).unwrap();
        for (levels, held) in [(1, 7), (2, 20), (1, 1)] {
            // A window and two frames on either side.
            let read = Read::new(&clip, 20.max(held));
            let options = DistanceOptions { held };
            let distances = FrameDistances::new(&read, &options, &run).unwrap();
            let frames = distances.frames();
            let pairs = (0..frames).flat_map(|a| (0..frames).map(move |b| (a, b)));
            assert!(pairs.into_iter().all(|(a, b)| distances.between(a, b) == whole.between(a, b)));
            assert_eq!(distances.closes(), whole.closes());
            let jumps = distances.best(&JumpOptions::default(), &Run::seeded(0)).unwrap();
            let options = LoopOptions { window: 16, levels, jumps: 2, ..LoopOptions::default() };
            let again = looped(&read, &jumps, &options, &run).unwrap();
            let once = looped(&clip, &jumps, &options, &run).unwrap();
            assert_eq!((again.result, again.stats), (once.result.clone(), once.stats.clone()));
            assert_eq!(once.result.closure(&read).unwrap(), once.stats.tried[once.stats.chosen].closure);
        }
    }
}

#[test]
fn frames_of_a_loop_are_those_of_its_map() {
    for (frames, of_jump, window) in [(40, jump(31, 10), 12), (24, jump(15, 8), 60), (9, jump(8, 0), 60)] {
        let clip = of(&changing([frames, 9, 8], 4, 2));
        let woven = looped(&clip, &[of_jump], &LoopOptions { window, ..LoopOptions::default() }, &Run::seeded(0));
        let result = woven.unwrap().result;
        let map = result.map().unwrap();
        for t in 0..of_jump.period() {
            let (shown, frame) = result.frame(t).unwrap();
            assert!(shown.len() <= 2 && shown.is_sorted());
            for [y, x] in Domain::open([9, 8]).positions() {
                let (source, at) = frame.locate([y, x]).unwrap();
                assert_eq!((at, map.locate([t, y, x])), ([y, x], Some((0, [shown[source], y, x]))));
            }
        }
    }
}

#[test]
fn a_frame_that_cannot_be_read_is_an_error() {
    let clip = of(&changing([30, 6, 5], 1, 2));
    let run = Run::seeded(0);
    for frame in [0, 13, 29] {
        let read = Read { missing: Some(frame), ..Read::new(&clip, 30) };
        let wrong = FrameDistances::new(&read, &DistanceOptions::default(), &run).map(drop);
        assert_eq!(wrong, Err(Error::Unread { frame }));
        assert_eq!(
            looped(&read, &[jump(20, 4)], &LoopOptions::default(), &run).map(drop),
            Err(Error::Unread { frame })
        );
    }
}
