//! Strokes of a brush replayed over two or more generated pictures, with what each took.
//!
//! `brush [SIDE [STROKES [LABELS]]]`; without arguments two pictures of 256 samples a side, and 24 strokes. Each stroke
//! gives 30 x 5 samples (of 256) to a label that does not show there; every fourth is taken back.

use std::time::Instant;

use selvedge_core::{Domain, Exemplars, Grid, Origin, Run, Seed, Source, Transform};
use selvedge_graphcut_textures::labels::{Label, LabelOptions, Merge, StrokeDelta};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u32>());
    let mut next = |default: u32| arguments.next().unwrap_or(Ok(default));
    let (side, strokes, count) = (next(256)?.max(8), next(24)?, next(2)?.clamp(2, 64) as usize);
    let exemplars = pictures(side, count)?;
    let labels = (0..count).map(|source| Label { source, offset: [0, 0] }).collect();
    let run = Run::seeded(0);

    let begun = Instant::now();
    let mut merge = Merge::new(&exemplars, Domain::open([side; 2]), labels, LabelOptions::default(), &run)?;
    // The first picture at the left, the last one at the right.
    let column = |x: u32| (0..side).map(|y| y * side + x).collect();
    merge.update(&StrokeDelta { places: column(0), label: Some(0) }, &run)?;
    merge.update(&StrokeDelta { places: column(side - 1), label: Some(count - 1) }, &run)?;
    println!("first  {:8.2} ms, {} samples of seam", milliseconds(begun), merge.seam().len());

    let (mut rng, mut updates, mut previews) = (Seed(1).rng(), Vec::new(), Vec::new());
    for number in 0..strokes {
        if number % 4 == 3 {
            let begun = Instant::now();
            merge.undo();
            println!("undo   {:8.2} ms", milliseconds(begun));
            continue;
        }
        let sides = [side * 5 / 256 + 1, side * 30 / 256 + 1];
        let [y, x] = sides.map(|n| rng.below(side - n));
        let places: Vec<u32> = (0..sides[0]).flat_map(|v| (0..sides[1]).map(move |u| (y + v) * side + x + u)).collect();
        let shown = merge.label(places[0] as usize).unwrap_or(0);
        let stroke = StrokeDelta { places, label: Some((shown + 1) % count) };
        let begun = Instant::now();
        merge.preview(&stroke, &run)?;
        let preview = milliseconds(begun);
        let begun = Instant::now();
        merge.update(&stroke, &run)?;
        println!("stroke {:8.2} ms, preview {preview:.2} ms, price {}", milliseconds(begun), merge.price());
        updates.push(milliseconds(begun));
        previews.push(preview);
    }
    for (what, mut all) in [("strokes", updates), ("previews", previews)] {
        all.sort_by(f64::total_cmp);
        if let (Some(median), Some(worst)) = (all.get(all.len() / 2), all.last()) {
            println!("{what}: median {median:.2} ms, worst {worst:.2} ms");
        }
    }
    Ok(())
}

fn milliseconds(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e3
}

/// Pictures of soft blobs, each another sum of waves, so that seams have somewhere to go.
fn pictures(side: u32, count: usize) -> Result<Exemplars<2>, selvedge_core::Error> {
    let domain = Domain::open([side; 2]);
    let source = |number: usize| {
        let mut rng = Seed(number as u64).rng();
        let mut draw = |most: u32| f64::from(rng.below(most));
        let waves: Vec<[f64; 4]> =
            (0..9).map(|_| [draw(40) - 20.0, draw(40) - 20.0, draw(628) / 100.0, draw(20)]).collect();
        let value = |[y, x]: [u32; 2]| {
            let at = |n: u32| f64::from(n) / 256.0;
            let sum: f64 = waves.iter().map(|[v, u, p, h]| h * libm::sin(v * at(y) * 6.3 + u * at(x) * 6.3 + p)).sum();
            (128.0 + sum).clamp(0.0, 255.0) as u8
        };
        let origin = Origin { exemplar: number as u16, transform: Transform::IDENTITY };
        let features = Grid::from_vec(domain, 1, domain.positions().map(value).collect())?;
        Ok(Source { features, valid: None, origin })
    };
    Exemplars::from_sources((0..count).map(source).collect::<Result<_, _>>()?, vec![1])
}
