//! How solve time and memory grow: `cargo run --release -p selvedge-maxflow --example growth -- [2d SIDE | 3d SIDE]`
//!
//! Each problem lays one noise texture over another (2-D: the border is the old texture's, the middle quarter of each
//! side the new one's; 3-D: from the first frame to the last) and asks for the cheapest seam. Without arguments: 64^2
//! to 2048^2. Prints nodes, seconds to build and to solve, nanoseconds a node, and the process's peak memory in bytes a
//! node (Linux), and fails if that is more than `GridGraph::estimate` states.

use std::time::Instant;

use selvedge_maxflow::{GridGraph, MaxflowError, Side};

fn main() -> Result<(), MaxflowError> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let sizes: Vec<(bool, usize)> = match words.len() {
        0 => (6..12).map(|k| (false, 1 << k)).collect(),
        _ => words.chunks(2).map(|w| (w[0] == "3d", w.get(1).and_then(|s| s.parse().ok()).unwrap_or(64))).collect(),
    };
    println!("{:>6} {:>10} {:>9} {:>9} {:>8} {:>10}", "shape", "nodes", "build s", "solve s", "ns/node", "bytes/node");
    for (volume, side) in sizes {
        if volume { run("3d", overlay([side; 3])?) } else { run("2d", overlay([side; 2])?) }?;
    }
    Ok(())
}

fn run<const D: usize>(name: &str, (mut graph, build): (GridGraph<D>, f64)) -> Result<(), MaxflowError> {
    let (start, nodes) = (Instant::now(), graph.len());
    let cut = graph.solve()?;
    let solve = start.elapsed().as_secs_f64();
    assert_eq!(graph.capacity_of(cut.source_side())?, cut.flow, "the flow is the capacity of the cut");
    let (nanoseconds, bytes) = (1e9 * solve / nodes as f64, peak_bytes() / nodes as f64);
    let stated = GridGraph::estimate(graph.shape()) as f64 + PROCESS;
    let peak = peak_bytes();
    assert!(peak.is_nan() || peak <= stated, "{peak} bytes at most, {stated} stated");
    println!("{name:>6} {nodes:>10} {build:>9.4} {solve:>9.4} {nanoseconds:>8.0} {bytes:>10.1}");
    Ok(())
}

/// Code, stacks, and what the allocator keeps.
const PROCESS: f64 = 16e6;

/// The problem, and the seconds to build it.
fn overlay<const D: usize>(shape: [usize; D]) -> Result<(GridGraph<D>, f64), MaxflowError> {
    let start = Instant::now();
    let mut graph = GridGraph::new(shape, [false; D])?;
    let at = |mut v: usize| {
        let mut at = [0; D];
        for a in (0..D).rev() {
            (at[a], v) = (v % shape[a], v / shape[a]);
        }
        at
    };
    let difference = |at: [usize; D]| (noise(at, 1) - noise(at, 2)).abs();
    for v in 0..graph.len() {
        let here = at(v);
        for axis in 0..D {
            if let Some(w) = graph.next(v, axis) {
                let cost = 1 + difference(here) + difference(at(w));
                graph.link(v, axis, cost, cost)?;
            }
        }
        let border = |a: usize| here[a] == 0 || here[a] + 1 == shape[a];
        let (old, new) = if D == 2 {
            ((0..D).any(border), (0..D).all(|a| 3 * shape[a] / 8 <= here[a] && here[a] <= 5 * shape[a] / 8))
        } else {
            (here[0] == 0, here[0] + 1 == shape[0])
        };
        if old {
            graph.pin(v, Side::Source)?;
        } else if new {
            graph.pin(v, Side::Sink)?;
        }
    }
    Ok((graph, start.elapsed().as_secs_f64()))
}

/// Value noise in four octaves, 0 to about 1000.
fn noise<const D: usize>(at: [usize; D], seed: u64) -> i32 {
    let octave = |shift: usize| {
        let corner = |k: usize| {
            let mut hash = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ shift as u64;
            let mut weight = 1_u64;
            for (a, &x) in at.iter().enumerate() {
                let (cell, within, high) = (x >> shift, x & ((1 << shift) - 1), k >> a & 1);
                hash = (hash ^ (cell + high) as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                hash ^= hash >> 29;
                weight *= if high == 1 { within } else { (1 << shift) - within } as u64;
            }
            (hash >> 40) % 250 * weight
        };
        (0..1 << D).map(corner).sum::<u64>() >> (shift * D)
    };
    [0, 1, 2, 4].map(octave).iter().sum::<u64>() as i32
}

/// Peak resident memory of this process so far, where the system tells.
fn peak_bytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|l| l.starts_with("VmHWM:")).unwrap_or("");
    line.split_ascii_whitespace().nth(1).and_then(|kib| kib.parse::<f64>().ok()).map_or(f64::NAN, |kib| kib * 1024.0)
}
