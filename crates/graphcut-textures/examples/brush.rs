//! Strokes of a brush replayed over two or more generated pictures, with what each took.
//!
//! `brush [SIDE [STROKES [LABELS]]]`; without arguments two pictures of 256 samples a side, and 24 strokes. Each stroke
//! gives 30 x 5 samples (of 256) to a label that does not show there; every fourth is taken back. STROKES may be a file
//! that was recorded: a line `X Y WIDTH HEIGHT LABEL` for each stroke, `undo` for one that is taken back.

use std::error::Error;
use std::time::Instant;

use selvedge_core::{Domain, Exemplars, Grid, Origin, Run, Seed, Source, Transform};
use selvedge_graphcut_textures::labels::{Label, LabelOptions, Merge, StrokeDelta};

/// What is done with the brush: a box of samples, and its label, or any that does not show there.
enum Step {
    Stroke { at: [u32; 2], shape: [u32; 2], label: Option<usize> },
    Undo,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: u32| arguments.get(i).map_or(Ok(default), |argument| argument.parse());
    let (side, count) = (number(0, 256)?.max(8), number(2, 2)?.clamp(2, 64) as usize);
    let steps = match arguments.get(1).filter(|argument| argument.parse::<u32>().is_err()) {
        Some(file) => recorded(&std::fs::read_to_string(file)?, side, count)?,
        None => drawn(side, number(1, 24)?),
    };
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

    let (mut updates, mut previews) = (Vec::new(), Vec::new());
    for step in steps {
        let Step::Stroke { at: [y, x], shape: [height, width], label } = step else {
            let begun = Instant::now();
            merge.undo();
            println!("undo   {:8.2} ms", milliseconds(begun));
            continue;
        };
        let places: Vec<u32> = (0..height).flat_map(|v| (0..width).map(move |u| (y + v) * side + x + u)).collect();
        let shown = merge.label(places[0] as usize).unwrap_or(0);
        let stroke = StrokeDelta { places, label: label.or(Some((shown + 1) % count)) };
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

/// Strokes anywhere, every fourth of which is taken back.
fn drawn(side: u32, strokes: u32) -> Vec<Step> {
    let mut rng = Seed(1).rng();
    let shape = [side * 5 / 256 + 1, side * 30 / 256 + 1];
    let mut step = |number: u32| match number % 4 {
        3 => Step::Undo,
        _ => Step::Stroke { at: shape.map(|n| rng.below(side - n)), shape, label: None },
    };
    (0..strokes).map(&mut step).collect()
}

/// The steps of a file, all of which lie in the picture.
fn recorded(text: &str, side: u32, count: usize) -> Result<Vec<Step>, Box<dyn Error>> {
    let step = |line: &str| -> Result<Step, Box<dyn Error>> {
        if line == "undo" {
            return Ok(Step::Undo);
        }
        let numbers = line.split_whitespace().map(str::parse).collect::<Result<Vec<u32>, _>>();
        let wrong = || format!("'{line}': write X Y WIDTH HEIGHT LABEL or undo");
        let [x, y, width, height, label] = numbers.map_err(|_| wrong())?[..] else { return Err(wrong().into()) };
        let fits = |at: u32, n: u32| 0 < n && at.checked_add(n).is_some_and(|end| end <= side);
        if !fits(x, width) || !fits(y, height) || count <= label as usize {
            return Err(format!("'{line}': outside of {side}x{side} samples and {count} labels").into());
        }
        Ok(Step::Stroke { at: [y, x], shape: [height, width], label: Some(label as usize) })
    };
    text.lines().map(str::trim).filter(|line| !line.is_empty()).map(step).collect()
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
