//! The classes, by name: `A/64x512/brick` (columns x rows), `B/256/brick`, `C/75x50x20/box` and `C/75x50x20/time`,
//! `D/256/tissue/10` (its tenth expansion), `S/1000/gravel` and `S/75x50x20/gravel` (to be brushed). `B1` prices seams
//! by eq. 1, the others by eq. 5. A number after that is the seed.

use std::path::Path;

use selvedge_maxflow::{BinaryEnergy, GridGraph, PairwiseTerm, Side};

use super::Instance;
use super::texture::{Draw, SIDE, Texture};

/// Where a texture's sample at an output's origin stands.
type Offset = (usize, usize);

/// The instance of a name, with textures made up or from a folder.
pub(crate) fn instance(name: &str, folder: Option<&Path>) -> Instance {
    let words: Vec<&str> = name.split('/').collect();
    let numbers = |k: usize| words[k].split('x').map(|n| n.parse().expect("a size")).collect::<Vec<usize>>();
    let seed = |k: usize| words.get(k).map_or(1, |n| n.parse().expect("a seed"));
    match words[0] {
        "A" => strip(&Texture::named(words[2], folder), numbers(1)[1], numbers(1)[0], seed(3)),
        "B" => overlay(&Texture::named(words[2], folder), numbers(1)[0], seam, seed(3)),
        "B1" => overlay(&Texture::named(words[2], folder), numbers(1)[0], metric, seed(3)),
        "C" => {
            let texture = Texture::named("gravel", folder);
            let [columns, rows, frames] = numbers(1)[..] else { panic!("three sizes") };
            volume(&texture, [frames, rows, columns], words[2] == "time", seed(3))
        }
        "S" if numbers(1).len() == 1 => merge(&Texture::named(words[2], folder), numbers(1)[0], seed(3)),
        "S" => {
            let [columns, rows, frames] = numbers(1)[..] else { panic!("three sizes") };
            volume(&Texture::named(words[2], folder), [frames, rows, columns], true, seed(3))
        }
        _ => expansion(&Texture::named(words[2], folder), numbers(1)[0], numbers(3)[0], seed(4)),
    }
}

/// A price of a seam along an axis between two neighbours, of a sample of one offset and of another.
type Price = fn(&Texture, usize, [Offset; 2], [Offset; 2]) -> i32;

/// The matching cost over the gradients `[Kwatra03 eq. 5]`.
fn seam(texture: &Texture, axis: usize, [s, t]: [Offset; 2], [a, b]: [Offset; 2]) -> i32 {
    let at = |p: Offset, by: Offset| (p.0 + by.0, p.1 + by.1);
    let matching = texture.distance(at(s, a), at(s, b)) + texture.distance(at(t, a), at(t, b));
    let places = [at(s, a), at(t, a), at(s, b), at(t, b)];
    let gradients: f32 = places.into_iter().map(|p| texture.gradient(axis, p)).sum();
    (1000.0 * matching / (1.0 + gradients)).round() as i32
}

fn offset(draw: &mut Draw) -> Offset {
    (draw.below(SIDE), draw.below(SIDE))
}

/// Calls back for all neighbours of a grid of two axes: node, axis, position and position of the next.
fn pairs([rows, columns]: [usize; 2], mut each: impl FnMut(usize, usize, Offset, Offset)) {
    for v in 0..rows * columns {
        let (y, x) = (v / columns, v % columns);
        if x + 1 < columns {
            each(v, 1, (y, x), (y, x + 1));
        }
        if y + 1 < rows {
            each(v, 0, (y, x), (y + 1, x));
        }
    }
}

fn both_ways(cost: i32) -> PairwiseTerm {
    PairwiseTerm { e00: 0, e01: cost, e10: cost, e11: 0 }
}

/// With `e00` lowered where no graph can hold the term (eq. 5, and rounding): so that all solvers are asked the same.
fn regular(term: PairwiseTerm) -> PairwiseTerm {
    PairwiseTerm { e00: term.e00.min(term.e01 + term.e10 - term.e11), ..term }
}

/// A: the overlap of two patches, the left column of the one, the right of the other.
fn strip(texture: &Texture, rows: usize, columns: usize, seed: u64) -> Instance {
    let mut draw = Draw(seed);
    let offsets = [offset(&mut draw), offset(&mut draw)];
    let mut instance = Instance { shape: vec![rows, columns], ..Instance::default() };
    pairs([rows, columns], |v, axis, s, t| {
        instance.set(v, axis, both_ways(seam(texture, axis, [s, t], offsets)));
    });
    for y in 0..rows {
        instance.pins.extend([(y * columns, Side::Source), ((y + 1) * columns - 1, Side::Sink)]);
    }
    instance
}

/// B: a patch over a canvas that eight patches before it were cut into. Its border is the canvas's, its centre its own.
fn overlay(texture: &Texture, side: usize, price: Price, seed: u64) -> Instance {
    let mut draw = Draw(seed);
    let mut canvas = vec![offset(&mut draw); side * side];
    for _ in 0..8 {
        let [rows, columns] = [0, 1].map(|_| side * (40 + draw.below(40)) / 100);
        let [top, left] = [rows, columns].map(|n| draw.below(side - n + 1));
        let new = offset(&mut draw);
        let old: Vec<Offset> =
            (0..rows * columns).map(|v| canvas[(top + v / columns) * side + left + v % columns]).collect();
        let mut instance = laid_over(texture, price, &old, new, [rows, columns], (top, left));
        // Most of it, so that the canvas gets seams at all.
        for v in 0..rows * columns {
            let inside = |at: usize, of: usize| of / 6 <= at && at < of - of / 6;
            if inside(v / columns, rows) && inside(v % columns, columns) {
                instance.pins.push((v, Side::Sink));
            }
        }
        for (v, _) in least(&instance).iter().enumerate().filter(|(_, keeps)| !**keeps) {
            canvas[(top + v / columns) * side + left + v % columns] = new;
        }
    }
    let new = offset(&mut draw);
    let mut instance = laid_over(texture, price, &canvas, new, [side, side], (0, 0));
    instance.pins.push((side / 2 * side + side / 2, Side::Sink));
    instance
}

/// The terms of keeping what is there (label 0) or taking a patch, whose border is held at what is
/// there `[Kwatra03 3.1]`.
fn laid_over(
    texture: &Texture,
    price: Price,
    old: &[Offset],
    new: Offset,
    [rows, columns]: [usize; 2],
    at: Offset,
) -> Instance {
    let mut instance = Instance { shape: vec![rows, columns], ..Instance::default() };
    pairs([rows, columns], |v, axis, s, t| {
        let places = [s, t].map(|p| (p.0 + at.0, p.1 + at.1));
        let [here, there] = [old[v], old[if axis == 1 { v + 1 } else { v + columns }]];
        let price = |a: Offset, b: Offset| if a == b { 0 } else { price(texture, axis, places, [a, b]) };
        let term = PairwiseTerm { e00: price(here, there), e01: price(here, new), e10: price(new, there), e11: 0 };
        instance.set(v, axis, regular(term));
    });
    let border = |v: &usize| {
        let (y, x) = (v / columns, v % columns);
        y == 0 || x == 0 || y + 1 == rows || x + 1 == columns
    };
    instance.pins.extend((0..rows * columns).filter(border).map(|v| (v, Side::Source)));
    instance
}

/// Which nodes keep label 0 where the energy is least.
fn least(instance: &Instance) -> Vec<bool> {
    let shape = [instance.shape[0], instance.shape[1]];
    let mut energy = BinaryEnergy::from(GridGraph::new(shape, [false; 2]).expect("a grid"));
    for &(v, side) in &instance.pins {
        energy.graph_mut().pin(v, side).expect("a node");
    }
    if !instance.unaries.is_empty() {
        energy.unaries(&instance.unaries).expect("energies");
    }
    for (axis, terms) in instance.terms.iter().enumerate() {
        energy.pairwises(axis, terms).expect("terms");
    }
    energy.minimize().expect("memory suffices").cut.source_side().to_vec()
}

/// S: two pictures over each other, from the left to the right.
fn merge(texture: &Texture, side: usize, seed: u64) -> Instance {
    let mut draw = Draw(seed);
    let offsets = [offset(&mut draw), offset(&mut draw)];
    let mut instance = Instance { shape: vec![side, side], ..Instance::default() };
    pairs([side, side], |v, axis, s, t| {
        instance.set(v, axis, both_ways(metric(texture, axis, [s, t], offsets)));
    });
    for y in 0..side {
        instance.pins.extend([(y * side, Side::Source), ((y + 1) * side - 1, Side::Sink)]);
    }
    instance
}

/// C: a clip over another, of two layers that move against each other. `time`: from the first frame to the last; else
/// from the faces of the box to its core.
fn volume(texture: &Texture, shape: [usize; 3], time: bool, seed: u64) -> Instance {
    let mut draw = Draw(seed);
    let [frames, rows, columns] = shape;
    let clip: [Offset; 4] = std::array::from_fn(|_| offset(&mut draw));
    let stride = [rows * columns, columns, 1];
    let n = frames * rows * columns;
    // Both clips are parts of one, that is twice as long and somewhat larger.
    let value = |[z, y, x]: [usize; 3]| -> i32 {
        let layer = |k: usize, dy: usize, dx: usize| texture.grey((clip[k].0 + y + z * dy, clip[k].1 + x + z * dx));
        let slow = |k: usize| texture.grey((clip[k].0 + (y + 2 * z) / 8, clip[k].1 + (x + z) / 8));
        let share = (slow(2) - slow(3) + 32).clamp(0, 64);
        let grain = (y * 7 + x * 13 + z * 29).wrapping_mul(0x9e37_79b9) >> 12 & 7;
        (layer(0, 2, 1) * share + layer(1, SIDE - 1, 2) * (64 - share)) / 64 + grain as i32
    };
    let by = if time { [frames, 0, 0] } else { [frames / 2, rows / 3, columns / 3] };
    let clips: [Vec<i32>; 2] = [[0; 3], by].map(|by| {
        let at = |v: usize| [v / stride[0] + by[0], v / stride[1] % rows + by[1], v % columns + by[2]];
        (0..n).map(|v| value(at(v))).collect()
    });
    let at = |v: usize| [v / stride[0], v / stride[1] % rows, v % columns];
    let gradient = |k: usize, v: usize, axis: usize| {
        let (low, high) = (at(v)[axis] > 0, at(v)[axis] + 1 < shape[axis]);
        let (a, b) = (v - if low { stride[axis] } else { 0 }, v + if high { stride[axis] } else { 0 });
        (clips[k][a] - clips[k][b]).abs() / if low && high { 2 } else { 1 }
    };
    let mut instance = Instance { shape: shape.to_vec(), ..Instance::default() };
    for v in 0..n {
        for axis in (0..3).filter(|&axis| at(v)[axis] + 1 < shape[axis]) {
            let w = v + stride[axis];
            let matching = (clips[0][v] - clips[1][v]).abs() + (clips[0][w] - clips[1][w]).abs();
            let gradients: i32 = [(0, v), (0, w), (1, v), (1, w)].map(|(k, p)| gradient(k, p, axis)).iter().sum();
            instance.set(v, axis, both_ways(1000 * matching / (1 + gradients)));
        }
        let face = |axis: usize| at(v)[axis] == 0 || at(v)[axis] + 1 == shape[axis];
        let core = |axis: usize| (shape[axis] / 3..2 * shape[axis] / 3).contains(&at(v)[axis]);
        let (old, new) =
            if time { (at(v)[0] == 0, at(v)[0] + 1 == frames) } else { ((0..3).any(face), (0..3).all(core)) };
        if old || new {
            instance.pins.push((v, if old { Side::Source } else { Side::Sink }));
        }
    }
    instance
}

/// How many labels class D has.
const LABELS: usize = 60;

/// D: an expansion of a label over those before it, with a price of each label at each pixel: how well the texture's
/// brightness goes with a guide's in a window.
fn expansion(texture: &Texture, side: usize, count: usize, seed: u64) -> Instance {
    let mut draw = Draw(seed);
    let guide_at = offset(&mut draw);
    let guide: Vec<i32> = blurred(side, |y, x| texture.grey((guide_at.0 + y / 4 * 3, guide_at.1 + x / 4 * 3)), 6);
    let blurred_torus = blurred(SIDE, |y, x| texture.grey((y, x)), 3);
    let labels: Vec<Offset> = (0..LABELS).map(|_| offset(&mut draw)).collect();
    let own = |label: usize| -> Vec<i32> {
        let (dy, dx) = labels[label];
        let difference = |y: usize, x: usize| {
            let there = blurred_torus[(y + dy) % SIDE * SIDE + (x + dx) % SIDE];
            16 * (there - guide[y * side + x]).pow(2)
        };
        blurred(side, difference, 1)
    };
    let mut map = vec![0; side * side];
    let mut prices = own(0);
    let mut instance = Instance::default();
    for k in 1..=count {
        let label = 1 + (k - 1) % (LABELS - 1);
        let offered = own(label);
        instance = Instance { shape: vec![side, side], ..Instance::default() };
        instance.unaries = prices.iter().zip(&offered).map(|(&e0, &e1)| [e0, e1]).collect();
        pairs([side, side], |v, axis, s, t| {
            let w = if axis == 1 { v + 1 } else { v + side };
            let price = |a: usize, b: usize| {
                if a == b { 0 } else { metric(texture, axis, [s, t], [labels[a], labels[b]]) }
            };
            let term = PairwiseTerm {
                e00: price(map[v], map[w]),
                e01: price(map[v], label),
                e10: price(label, map[w]),
                e11: 0,
            };
            instance.set(v, axis, regular(term));
        });
        if k < count {
            for (v, _) in least(&instance).iter().enumerate().filter(|(_, keeps)| !**keeps) {
                (map[v], prices[v]) = (label, offered[v]);
            }
        }
    }
    instance
}

/// Price of a seam by the matching cost alone `[Kwatra03 eq. 1]`.
fn metric(texture: &Texture, _: usize, [s, t]: [Offset; 2], [a, b]: [Offset; 2]) -> i32 {
    let at = |p: Offset, by: Offset| (p.0 + by.0, p.1 + by.1);
    let matching = texture.distance(at(s, a), at(s, b)) + texture.distance(at(t, a), at(t, b));
    (16.0 * matching).round() as i32
}

/// The mean over windows of `2 radius + 1` samples a side, cut off at the edges.
fn blurred(side: usize, value: impl Fn(usize, usize) -> i32, radius: usize) -> Vec<i32> {
    let means = |from: &[i32], step: usize, place: &dyn Fn(usize) -> usize| -> Vec<i32> {
        (0..side * side)
            .map(|v| {
                let at = place(v);
                let (low, high) = (at.saturating_sub(radius), (at + radius).min(side - 1));
                let sum: i32 = (low..=high).map(|k| from[v + k * step - at * step]).sum();
                sum / (high + 1 - low) as i32
            })
            .collect()
    };
    let values: Vec<i32> = (0..side * side).map(|v| value(v / side, v % side)).collect();
    means(&means(&values, 1, &|v| v % side), side, &|v| v / side)
}
