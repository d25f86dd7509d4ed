//! Strokes of a brush from bytes, against merges made anew: what the fuzzer feeds, and what its corpus replays.
//!
//! Any bytes are a case: shape, labels and pictures come first, then strokes, some of them taken back, as far as the
//! bytes go; missing bytes are zeros. Sizes are bounded, so every run ends soon.

use selvedge_core::{Domain, Exemplars, Grid, Origin, Run, SeamMeasure, Source, Transform};
use selvedge_graphcut_textures::labels::{Label, LabelOptions, Merge, StrokeDelta};

struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn next(&mut self) -> u32 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        u32::from(first)
    }

    fn below(&mut self, bound: u32) -> u32 {
        self.next() % bound.max(1)
    }
}

/// Pictures whose samples repeat a few bytes.
fn pictures(bytes: &mut Bytes<'_>, domain: Domain<2>, count: usize) -> Exemplars<2> {
    let mut source = |number: usize| {
        let some: Vec<u32> = (0..1 + bytes.below(20)).map(|_| bytes.next()).collect();
        let features = (0..domain.len()).map(|i| some[(i + i / 7) % some.len()] as u8).collect();
        let masked = bytes.below(40) as usize;
        // The first shows everywhere.
        let valid = (0..domain.len()).map(|i| number == 0 || masked < 20 || i % masked != 0).collect();
        Source {
            features: Grid::from_vec(domain, 1, features).expect("one channel"),
            valid: Some(Grid::from_vec(domain, 1, valid).expect("one channel").into()),
            origin: Origin { exemplar: number as u16, transform: Transform::IDENTITY },
        }
    };
    Exemplars::from_sources((0..count).map(&mut source).collect(), vec![1]).expect("equal pictures")
}

/// A box of places, and a label that shows in all of them, or any.
fn stroke(bytes: &mut Bytes<'_>, domain: Domain<2>, exemplars: &Exemplars<2>, labels: usize) -> StrokeDelta {
    let label = (bytes.below(4) != 0).then(|| bytes.below(labels as u32) as usize);
    let start = domain.shape.map(|n| bytes.below(n));
    let sides = [1 + bytes.below(4), 1 + bytes.below(4)];
    let inside = |at: [u32; 2]| (0..2).all(|a| start[a] <= at[a] && at[a] < start[a] + sides[a]);
    let shows = |at: [u32; 2]| {
        let valid = label.and_then(|label| exemplars.sources()[label].valid.as_deref());
        valid.is_none_or(|valid| valid.get(0, at))
    };
    let places = domain.positions().filter(|at| inside(*at) && shows(*at)).map(|at| domain.index(at) as u32);
    StrokeDelta { places: places.collect(), label }
}

/// Lays and takes back strokes, and checks each time that what must show shows, and with two labels that the answer is
/// that of a merge made anew with the strokes that are left.
pub(crate) fn run(data: &[u8]) {
    let mut bytes = Bytes(data);
    let domain = Domain::open([1 + bytes.below(12), 1 + bytes.below(12)]);
    let count = 2 + bytes.below(3) as usize;
    let seam = if bytes.below(2) == 0 { SeamMeasure::Difference } else { SeamMeasure::Gradient };
    let exemplars = pictures(&mut bytes, domain, count);
    let labels: Vec<Label<2>> = (0..count).map(|source| Label { source, offset: [0, 0] }).collect();
    let (options, run) = (LabelOptions { seam, ..LabelOptions::default() }, Run::seeded(0));
    let fresh = || Merge::new(&exemplars, domain, labels.clone(), options.clone(), &run).expect("labels that fit");
    let mut merge = fresh();
    assert!(merge.solve(&run).expect("small"));
    let mut wanted = vec![vec![None; domain.len()]];
    for _ in 0..8 {
        if bytes.below(4) == 3 {
            assert_eq!(merge.undo(), 1 < wanted.len());
            wanted.truncate(1.max(wanted.len() - 1));
        } else {
            let stroke = stroke(&mut bytes, domain, &exemplars, count);
            let shown = merge.preview(&stroke, &run).expect("it may show");
            assert_eq!(shown.holes(), 0);
            assert!(merge.update(&stroke, &run).expect("it may show"));
            let mut next = wanted.last().expect("the beginning").clone();
            stroke.places.iter().for_each(|&place| next[place as usize] = stroke.label);
            wanted.push(next);
        }
        let now = wanted.last().expect("the beginning");
        assert_eq!(merge.map().holes(), 0);
        for (place, label) in now.iter().enumerate().filter(|(_, label)| label.is_some()) {
            assert_eq!(merge.label(place), *label, "place {place}");
        }
        if count == 2 {
            let mut anew = fresh();
            for label in 0..count {
                let places = (0..domain.len()).filter(|&place| now[place] == Some(label)).map(|place| place as u32);
                anew.update(&StrokeDelta { places: places.collect(), label: Some(label) }, &run).expect("it shows");
            }
            assert!(anew.solve(&run).expect("small"));
            assert_eq!((merge.map(), merge.price()), (anew.map(), anew.price()));
        }
    }
}

#[cfg(test)]
mod tests {
    use selvedge_core::Seed;
    use std::time::{Duration, Instant};

    /// The corpus, and byte strings of our own: some, or for as many seconds as `SELVEDGE_FUZZ_SECONDS` says.
    #[test]
    fn byte_strings_of_strokes() {
        let folder = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/strokes");
        let files = std::fs::read_dir(folder).expect("the corpus").map(|file| file.expect("a file").path());
        let files: Vec<Vec<u8>> = files.map(|file| std::fs::read(file).expect("a file of the corpus")).collect();
        assert!(3 <= files.len());
        files.iter().for_each(|data| super::run(data));
        let seconds = std::env::var("SELVEDGE_FUZZ_SECONDS").ok().and_then(|s| s.parse().ok());
        let (begun, limit) = (Instant::now(), Duration::from_secs(seconds.unwrap_or(0)));
        let (mut rng, mut runs) = (Seed(1).rng(), 0);
        while runs < 400 || begun.elapsed() < limit {
            let data: Vec<u8> = (0..rng.below(200)).map(|_| rng.below(256) as u8).collect();
            super::run(&data);
            runs += 1;
        }
    }
}
