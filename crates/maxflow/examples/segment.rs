//! Cuts an object out of a picture:
//! `cargo run --release -p selvedge-maxflow --example segment -- IN.pgm SEEDS.pgm OUT.pgm`
//!
//! `IN` is a grey picture. `SEEDS` has the same size: white (255) where the object is known to be, black (0) where the
//! background is known to be, any grey elsewhere. `OUT` becomes white for the object. Without arguments a picture is
//! made up, segmented and shown as text.
//!
//! The energy is that of Boykov and Jolly (ICCV 2001): how unlikely a pixel's grey is under the histogram of the
//! object's seeds or of the background's, and between neighbours, also diagonal ones, a price for a border that falls
//! where the picture changes. Seeds are pins. Afterwards the seeds are moved and the cut is found again from its flow.

use std::error::Error;
use std::io::{self, Write};

use selvedge_maxflow::{BinaryEnergy, Diagonal, GridGraph, PairwiseTerm, Side};

/// Weight of the border against the histograms.
const SMOOTHNESS: f64 = 60.0;
/// Grey difference between neighbours at which a border costs half.
const NOISE: f64 = 20.0;

/// A grey picture.
struct Picture {
    size: [usize; 2],
    /// Row by row, 0 to 255.
    grey: Vec<u8>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    match &paths[..] {
        [] => demonstrate(),
        [input, seeds, output] => {
            let (picture, seeds) = (Picture::read(input)?, Picture::read(seeds)?);
            if picture.size != seeds.size {
                return Err(
                    format!("picture is {:?}, seeds are {:?}: sizes must agree", picture.size, seeds.size).into()
                );
            }
            let object = energy(&picture, &seeds)?.minimize()?.cut;
            let grey = (0..picture.grey.len()).map(|v| if object.side(v) == Side::Sink { 255 } else { 0 }).collect();
            Picture { size: picture.size, grey }.write(output)
        }
        _ => Err("usage: segment [IN.pgm SEEDS.pgm OUT.pgm]".into()),
    }
}

/// The energy of calling pixels object (label 1) or background (label 0).
fn energy(picture: &Picture, seeds: &Picture) -> Result<BinaryEnergy<2>, Box<dyn Error>> {
    let mut energy = BinaryEnergy::from(GridGraph::with_diagonals(picture.size, [false, false])?);
    let [object, background] = [255, 0].map(|seed| surprise(picture, seeds, seed));
    let columns = picture.size[1];
    for (v, &grey) in picture.grey.iter().enumerate() {
        energy.unary(v, background[usize::from(grey / 8)], object[usize::from(grey / 8)])?;
        match seeds.grey[v] {
            255 => energy.graph_mut().pin(v, Side::Sink)?,
            0 => energy.graph_mut().pin(v, Side::Source)?,
            _ => {}
        }
        let (below, right, left) = (v + columns < picture.grey.len(), v % columns + 1 < columns, v % columns > 0);
        let border = |w: usize, distance: f64| {
            let change = (f64::from(grey) - f64::from(picture.grey[w])) / NOISE;
            let cost = (SMOOTHNESS / (1.0 + change * change) / distance) as i32 + 1;
            PairwiseTerm { e00: 0, e01: cost, e10: cost, e11: 0 }
        };
        if right {
            energy.pairwise(v, 1, border(v + 1, 1.0))?;
        }
        if below {
            energy.pairwise(v, 0, border(v + columns, 1.0))?;
        }
        if below && right {
            energy.pairwise_diagonal(v, Diagonal::Main, border(v + columns + 1, std::f64::consts::SQRT_2))?;
        }
        if below && left {
            energy.pairwise_diagonal(v, Diagonal::Anti, border(v + columns - 1, std::f64::consts::SQRT_2))?;
        }
    }
    Ok(energy)
}

/// By 8 levels of grey: how rare it is among the pixels with a seed, in tenths of a bit (of whole bits: the leading
/// zeros of the share).
fn surprise(picture: &Picture, seeds: &Picture, seed: u8) -> [i32; 32] {
    let mut count = [1_u32; 32];
    for (&grey, _) in picture.grey.iter().zip(&seeds.grey).filter(|&(_, &s)| s == seed) {
        count[usize::from(grey / 8)] += 4;
    }
    let total: u32 = count.iter().sum();
    count.map(|c| 10 * (total / c).ilog2() as i32)
}

impl Picture {
    /// Reads a PGM file, text (`P2`) or binary (`P5`), of up to 255 levels.
    fn read(path: &str) -> Result<Self, Box<dyn Error>> {
        let bytes = std::fs::read(path)?;
        let broken = || format!("'{path}' is not a PGM file of up to 255 levels");
        let mut at = 0;
        let mut word = || -> Option<String> {
            loop {
                while bytes.get(at)?.is_ascii_whitespace() {
                    at += 1;
                }
                if bytes[at] != b'#' {
                    break;
                }
                at += bytes[at..].iter().position(|&b| b == b'\n')?;
            }
            let end = bytes[at..].iter().position(u8::is_ascii_whitespace).map_or(bytes.len(), |n| at + n);
            let word = String::from_utf8_lossy(&bytes[at..end]).into_owned();
            at = end;
            Some(word)
        };
        let magic = word().ok_or_else(broken)?;
        let [columns, rows, levels] = [word(), word(), word()].map(|w| w.and_then(|w| w.parse::<usize>().ok()));
        let (Some(columns), Some(rows), Some(1..=255)) = (columns, rows, levels) else { return Err(broken().into()) };
        let pixels = rows.checked_mul(columns).filter(|&n| 0 < n && n <= 1 << 28).ok_or_else(broken)?;
        let grey: Vec<u8> = match &magic[..] {
            "P2" => (0..pixels).map_while(|_| word()?.parse().ok()).collect(),
            "P5" => bytes.get(at + 1..).unwrap_or_default().iter().copied().take(pixels).collect(),
            _ => return Err(broken().into()),
        };
        if grey.len() == pixels { Ok(Self { size: [rows, columns], grey }) } else { Err(broken().into()) }
    }

    fn write(&self, path: &str) -> Result<(), Box<dyn Error>> {
        let mut bytes = format!("P5\n{} {}\n255\n", self.size[1], self.size[0]).into_bytes();
        bytes.extend(&self.grey);
        Ok(std::fs::write(path, bytes)?)
    }
}

/// A noisy picture of a ring before a gradient, a few seeds, and the answer in signs.
fn demonstrate() -> Result<(), Box<dyn Error>> {
    let (rows, columns) = (24, 60);
    let mut picture = Picture { size: [rows, columns], grey: vec![0; rows * columns] };
    let mut seeds = Picture { size: [rows, columns], grey: vec![128; rows * columns] };
    let mut noise = 1_u32;
    for v in 0..rows * columns {
        let (y, x) = ((v / columns) as f64 - 11.5, (v % columns) as f64 / 2.0 - 15.0);
        let radius = (y * y + x * x).sqrt();
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let ring = (5.0..10.0).contains(&radius);
        picture.grey[v] = (if ring { 150 } else { 60 + v % columns } + (noise >> 26) as usize) as u8;
        if (7.0..7.5).contains(&radius) && y < 0.0 {
            seeds.grey[v] = 255;
        } else if radius > 13.0 {
            seeds.grey[v] = 0;
        }
    }
    let mut energy = energy(&picture, &seeds)?;
    show(&energy.minimize()?.cut, columns)?;
    // The user strikes the right half out: background there.
    for v in (0..rows * columns).filter(|v| v % columns > 40) {
        energy.graph_mut().pin(v, Side::Source)?;
    }
    show(&energy.minimize()?.cut, columns)
}

fn show(cut: &selvedge_maxflow::MinCut, columns: usize) -> Result<(), Box<dyn Error>> {
    let mut out = io::stdout().lock();
    for row in cut.source_side().chunks(columns) {
        let signs: String = row.iter().map(|&background| if background { '.' } else { '#' }).collect();
        writeln!(out, "{signs}")?;
    }
    Ok(writeln!(out)?)
}
