//! Renderers stay within what they say that they take, and do not say absurdly more. Each case in a process of its own:
//! what a case held would count in the next.

use selvedge_blending::{Feathered, Fused, Splined};
use selvedge_core::{
    Domain, Grid, Origin, Plane, Render, Role, SampleId, Samples, Seed, SourceMap, SourceTable, Transform,
};
use selvedge_testkit::memory;

/// What is rendered.
#[derive(Clone, Copy)]
enum How {
    Feathered(f64),
    Splined(u32),
    /// Wholly, or as near to seams.
    Fused(Option<u32>),
}

/// Patches of a clip (or, of one frame, a picture) of bytes.
fn render<const D: usize>(output: Domain<D>, channels: usize, how: How) -> u64 {
    let source = Domain::open([40; D]);
    let table = SourceTable::new(vec![(Origin { exemplar: 0, transform: Transform::IDENTITY }, source)]).unwrap();
    let ids = output.positions().map(|at| {
        let patch = at.iter().fold(0, |key, p| key * 1000 + u64::from(p / 17));
        let mut rng = Seed(1).derive("patch", patch).rng();
        table.id(0, std::array::from_fn(|a| rng.below(23) + at[a] % 17))
    });
    let ids: Vec<SampleId> = ids.collect();
    let map = SourceMap::new(Grid::from_vec(output, 1, ids).unwrap(), table).unwrap();
    let samples =
        Grid::from_vec(source, channels, (0..source.len() * channels).map(|i| (i * i % 251) as u8).collect()).unwrap();
    let plane = Plane::new(Role::Color, Samples::U8(samples));
    let before = memory::held();
    let out = match how {
        How::Feathered(sigma) => Feathered::new(&map, Vec::new(), sigma).unwrap().render(&[&plane]).unwrap(),
        How::Splined(levels) => Splined::new(&map, Vec::new(), levels).unwrap().render(&[&plane]).unwrap(),
        How::Fused(reach) => {
            let fused = Fused::new(&map, Vec::new()).unwrap();
            reach.map_or(fused.clone(), |reach| fused.within(reach)).render(&[&plane]).unwrap()
        }
    };
    if let (Some(before), Some(peak)) = (before, memory::peak()) {
        // The output is the caller's.
        println!("held {}", peak.saturating_sub(before + (out.domain().len() * channels) as u64));
    }
    match how {
        How::Feathered(sigma) => Feathered::bytes(output, channels, sigma),
        How::Splined(levels) => Splined::bytes(output, channels, levels),
        How::Fused(reach) => Fused::bytes(output, channels, reach.is_some()),
    }
    .0
}

fn case(number: usize) -> Option<u64> {
    let (picture, clip) = (Domain::open([500, 700]), Domain::open([30, 60, 80]));
    Some(match number {
        0 => render(picture, 3, How::Feathered(8.0)),
        1 => render(picture, 1, How::Splined(5)),
        2 => render(picture, 4, How::Splined(2)),
        3 => render(clip, 3, How::Feathered(2.0)),
        4 => render(clip, 3, How::Splined(3)),
        5 => render(Domain { periodic: [true; 3], ..clip }, 1, How::Splined(2)),
        6 => render(picture, 3, How::Fused(None)),
        7 => render(picture, 1, How::Fused(Some(6))),
        8 => render(clip, 1, How::Fused(None)),
        _ => return None,
    })
}

#[test]
fn renderers_stay_within_what_they_say() {
    let test = "memory::renderers_stay_within_what_they_say";
    if let Some(number) = memory::case(test) {
        println!("estimated {}", case(number.parse().unwrap()).unwrap());
        return;
    }
    for number in 0..9 {
        let said = memory::alone(test, &number.to_string());
        let after = |word: &str| said.split_once(word).map(|(_, rest)| rest.lines().next().unwrap().parse::<u64>());
        let Some(Ok(held)) = after("held ") else {
            eprintln!("skipped: this system does not tell how much memory a process had at its peak");
            return;
        };
        let estimated = after("estimated ").unwrap().unwrap();
        let most = 4 * held + (2 << 20);
        assert!(
            held <= estimated + (1 << 20) && estimated <= most,
            "case {number}: held {held}, estimated {estimated}"
        );
    }
}
