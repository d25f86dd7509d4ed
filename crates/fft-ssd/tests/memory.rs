//! Searching a picture of 4096^2 stays within the estimate. Alone in its process, so that nothing else counts.

use selvedge_core::{Domain, Exemplars, Grid, Origin, Seed, Source, Transform};
use selvedge_fft_ssd::{Costs, Options, Placement, Scratch, Sizes, SsdSearcher, Template, estimate};

/// A line of the process's status in bytes, where the system tells it.
fn status(field: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|l| l.starts_with(field))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? << 10)
}

/// Black and white: the largest differences, and the largest norms.
fn extremes(seed: u64, n: usize) -> Vec<u8> {
    let mut rng = Seed(seed).rng();
    (0..n.div_ceil(64))
        .flat_map(|_| rng.next_u64().to_le_bytes().map(|b| b & 1).repeat(8))
        .map(|b| b * 255)
        .take(n)
        .collect()
}

#[test]
fn the_largest_picture_stays_within_the_estimate() {
    let domain = Domain::open([4096, 4096]);
    let mut samples = extremes(1, 3 * domain.len());
    samples.shrink_to_fit();
    let features = Grid::from_vec(domain, 3, samples).unwrap();
    let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
    let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1; 3]).unwrap();
    let template = extremes(2, 3 * 64 * 64);

    let before = status("VmRSS");
    let searcher = SsdSearcher::new(&exemplars).unwrap();
    let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
    searcher.search(&Template::new([64, 64], &template), Placement::INSIDE, &mut scratch, &mut costs).unwrap();
    let peak = status("VmHWM");
    assert_eq!(scratch.repeated(), 0);

    // Some positions against the definition.
    for i in 0..40 {
        let mut rng = Seed(3).derive("position", i).rng();
        let at = [rng.below(4033), rng.below(4033)];
        let mut error = 0;
        for x in Domain::open([64, 64]).positions() {
            for c in 0..3 {
                let value = template[c * 4096 + (x[0] * 64 + x[1]) as usize];
                let under = exemplars.sources()[0].features.get(c, [at[0] + x[0], at[1] + x[1]]);
                error += u64::from(value.abs_diff(under)).pow(2);
            }
        }
        assert_eq!(costs.get(0, at.map(|p| p as i32)).unwrap().error, error, "{at:?}");
    }

    let sizes = Sizes { sources: &[domain], weights: &[1; 3], template: [64; 2], noisy_masks: false };
    let estimate = estimate(&sizes, Placement::INSIDE, &Options::default()).unwrap();
    let (Some(before), Some(peak)) = (before, peak) else {
        eprintln!("skipped: this system does not tell how much memory a process had at its peak");
        return;
    };
    let held = peak - before;
    assert!(held <= estimate && estimate <= held + held / 2, "held {held} bytes, estimated {estimate}");
}
