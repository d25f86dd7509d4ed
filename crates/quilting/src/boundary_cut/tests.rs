//! Cuts against those found by trying every one.

use super::*;
use selvedge_core::{Rng, Seed};

fn random_errors(rng: &mut Rng, n: usize, below: u32) -> Vec<u64> {
    (0..n).map(|_| u64::from(rng.below(below))).collect()
}

/// Cheapest path between two cells, by trying every one.
fn brute(error: &dyn Fn(usize, usize) -> u64, width: usize, from: (usize, usize), to: (usize, usize)) -> u64 {
    let here = error(from.0, from.1);
    if from.0 == to.0 {
        return if from.1 == to.1 { here } else { u64::MAX };
    }
    let near = from.1.saturating_sub(1)..(from.1 + 2).min(width);
    let rest = near.map(|c| brute(error, width, (from.0 + 1, c), to)).min().unwrap_or(u64::MAX);
    rest.saturating_add(here)
}

/// The cheapest cut, by trying every meeting cell of every corner and every path between them.
fn brute_cut([h, w]: [usize; 2], o: Overlaps, e: &[u64], known: &[bool]) -> u64 {
    let sides = [(o.left, h), (o.top, w), (o.right, h), (o.bottom, w)];
    let cell = |side: usize, a: usize, c: usize| match side {
        LEFT => a * w + c,
        TOP => c * w + a,
        RIGHT => a * w + w - 1 - c,
        _ => (h - 1 - c) * w + a,
    };
    // Where the old ends before the path, its last sample counts.
    let at = |side: usize, a: usize, c: usize| {
        (0..=c).rev().map(|c| cell(side, a, c)).find(|&i| known[i]).map_or(0, |i| e[i])
    };
    // A corner's candidates are its cells (depth on the first strip, depth on the second).
    let has = |c: usize| 0 < sides[c].0 && 0 < sides[(c + 1) % 4].0;
    let cells = |c: usize| -> Vec<[usize; 2]> {
        if !has(c) {
            return vec![[0, 0]];
        }
        (0..sides[(c + 1) % 4].0).flat_map(|u| (0..sides[c].0).map(move |v| [u, v])).collect()
    };
    let mut best = u64::MAX;
    for c0 in cells(0) {
        for c1 in cells(1) {
            for c2 in cells(2) {
                for c3 in cells(3) {
                    let chosen = [c0, c1, c2, c3];
                    let mut total = 0_u64;
                    for (side, &(width, len)) in sides.iter().enumerate() {
                        if width == 0 {
                            continue;
                        }
                        let ends = [End::Low, End::High].map(|end| {
                            let c = Ring::corner_at(side, end);
                            let cell = if c == side { chosen[c] } else { [chosen[c][1], chosen[c][0]] };
                            let along = if end == End::Low { cell[0] } else { len - 1 - cell[0] };
                            let open = if end == End::Low { 0 } else { len - 1 };
                            if has(c) { vec![(along, cell[1])] } else { (0..width).map(|x| (open, x)).collect() }
                        });
                        let path = ends[0].iter().flat_map(|&a| ends[1].iter().map(move |&b| (a, b)));
                        let error = |a: usize, c: usize| at(side, a, c);
                        let cost = path.map(|(a, b)| if a.0 <= b.0 { brute(&error, width, a, b) } else { u64::MAX });
                        total = total.saturating_add(cost.min().unwrap_or(u64::MAX));
                    }
                    for c in (0..4).filter(|&c| has(c)) {
                        let [u, v] = chosen[c];
                        let row = |side: usize, end: End, depth: usize| match end {
                            End::Low => depth,
                            End::High => sides[side].1 - 1 - depth,
                        };
                        let (second, (end_a, end_b)) = ((c + 1) % 4, CORNERS[c]);
                        let shared = at(c, row(c, end_a, u), v).min(at(second, row(second, end_b, v), u));
                        total = total.saturating_sub(shared);
                    }
                    best = best.min(total);
                }
            }
        }
    }
    best
}

#[test]
fn the_cut_is_the_cheapest_of_all() {
    let mut rng = Seed(1).rng();
    for case in 0..400 {
        let [h, w] = [4 + rng.below(3) as usize, 4 + rng.below(3) as usize];
        let mut side = |bit: u32, max: usize| if case >> bit & 1 == 1 { 1 + rng.below(max as u32) as usize } else { 0 };
        let o = Overlaps { left: side(0, w / 2), top: side(1, h / 2), right: side(2, w / 2), bottom: side(3, h / 2) };
        let e = random_errors(&mut rng, h * w, 50);
        let cut = boundary_cut([h, w], o, &e, None).unwrap();
        let all = vec![true; h * w];
        assert_eq!(boundary_cut([h, w], o, &e, Some(&all)).unwrap(), cut);
        let expected = |known: &[bool]| if o == Overlaps::default() { 0 } else { brute_cut([h, w], o, &e, known) };
        assert_eq!(cut.cost, expected(&all), "{h}x{w} {o:?}");
        // What is old is there in part.
        let known: Vec<bool> = (0..h * w).map(|_| rng.below(4) != 0).collect();
        let cut = boundary_cut([h, w], o, &e, Some(&known)).unwrap();
        assert_eq!(cut.cost, expected(&known), "{h}x{w} {o:?} {known:?}");
        assert!((0..h * w).all(|i| known[i] || cut.new[i]), "the new shows where nothing is old");
    }
}

#[test]
fn where_nothing_is_old_everything_is_new_and_nothing_is_paid() {
    let o = Overlaps { left: 3, top: 2, right: 2, bottom: 3 };
    let cut = boundary_cut([9, 8], o, &[7; 72], Some(&[false; 72])).unwrap();
    assert_eq!(cut, Cut { new: vec![true; 72], cost: 0 });
}

/// Every path between two cells, row by row.
fn all_paths(width: usize, from: (usize, usize), to: (usize, usize)) -> Vec<Vec<usize>> {
    if from.0 == to.0 {
        return if from.1 == to.1 { vec![vec![from.1]] } else { Vec::new() };
    }
    let near = from.1.saturating_sub(1)..(from.1 + 2).min(width);
    let rests = near.flat_map(|c| all_paths(width, (from.0 + 1, c), to));
    rests.map(|rest| std::iter::once(from.1).chain(rest).collect()).collect()
}

/// The cells of the cheapest cut along left and top that meet in their corner, by trying all, if it is the only one.
fn brute_corner([h, w]: [usize; 2], left: usize, top: usize, e: &[u64]) -> Option<Vec<usize>> {
    let mut all: Vec<(u64, Vec<usize>)> = Vec::new();
    for (y, x) in (0..top).flat_map(|y| (0..left).map(move |x| (y, x))) {
        let down = (0..left).flat_map(|end| all_paths(left, (y, x), (h - 1, end)));
        let down: Vec<Vec<usize>> =
            down.map(|p| p.iter().enumerate().map(|(i, c)| (y + i) * w + c).collect()).collect();
        let right = (0..top).flat_map(|end| all_paths(top, (x, y), (w - 1, end)));
        for along in right {
            let along: Vec<usize> = along.iter().enumerate().skip(1).map(|(i, c)| c * w + x + i).collect();
            for down in &down {
                let cells = [&down[..], &along[..]].concat();
                all.push((cells.iter().map(|&i| e[i]).sum(), cells));
            }
        }
    }
    all.sort_unstable();
    (all[0].0 < all[1].0).then(|| all.swap_remove(0).1)
}

/// What is not enclosed by a cut with the block's left and top edge: the cut's cells and all on their far side.
fn beyond(cells: &[usize], [h, w]: [usize; 2]) -> Vec<bool> {
    let mut new = vec![true; h * w];
    let edge = (0..w).chain((0..h).map(|y| y * w));
    let mut stack: Vec<usize> = edge.collect();
    while let Some(i) = stack.pop() {
        if cells.contains(&i) || !std::mem::replace(&mut new[i], false) {
            continue;
        }
        let (y, x) = (i / w, i % w);
        let next =
            [(0 < y).then(|| i - w), (y + 1 < h).then(|| i + w), (0 < x).then(|| i - 1), (x + 1 < w).then(|| i + 1)];
        stack.extend(next.into_iter().flatten());
    }
    new
}

#[test]
fn the_mask_is_bounded_by_the_cheapest_cut() {
    let mut rng = Seed(5).rng();
    let mut tried = 0;
    for _ in 0..60 {
        let [h, w] = [4 + rng.below(2) as usize, 4 + rng.below(2) as usize];
        let (left, top) = (2 + rng.below(2) as usize, 2 + rng.below(2) as usize);
        let e = random_errors(&mut rng, h * w, 10_000);
        let Some(cells) = brute_corner([h, w], left, top, &e) else { continue };
        let cut = boundary_cut([h, w], Overlaps { left, top, ..Overlaps::default() }, &e, None).unwrap();
        assert_eq!(cut.cost, cells.iter().map(|&i| e[i]).sum::<u64>());
        assert_eq!(cut.new, beyond(&cells, [h, w]), "{h}x{w} {left} {top} {e:?}");
        tried += 1;
    }
    assert!(40 < tried, "{tried}");
}

#[test]
fn the_errors_along_the_mask_are_the_cost() {
    let mut rng = Seed(6).rng();
    let [h, w] = [14, 11];
    for case in 0..100 {
        let e = random_errors(&mut rng, h * w, 100);
        let on = |side| if case % 4 == side { 5 } else { 0 };
        let overlaps = Overlaps { left: on(0), top: on(1), right: on(2), bottom: on(3) };
        let cut = boundary_cut([h, w], overlaps, &e, None).unwrap();
        // Line by line from the old side: the first new sample.
        let (lines, across) = if case % 2 == 0 { (h, w) } else { (w, h) };
        let index = |line: usize, a: usize| match case % 4 {
            0 => line * w + a,
            1 => a * w + line,
            2 => line * w + w - 1 - a,
            _ => (h - 1 - a) * w + line,
        };
        let border = (0..lines).map(|line| (0..across).map(|a| index(line, a)).find(|&i| cut.new[i]).unwrap());
        assert_eq!(border.map(|i| e[i]).sum::<u64>(), cut.cost, "{overlaps:?}");
    }
}

#[test]
fn no_straight_cut_is_cheaper() {
    let mut rng = Seed(2).rng();
    for _ in 0..200 {
        let (h, w, left) = (12, 12, 5);
        let e = random_errors(&mut rng, h * w, 1000);
        let cut = boundary_cut([h, w], Overlaps { left, ..Overlaps::default() }, &e, None).unwrap();
        let straight = (0..left).map(|x| (0..h).map(|y| e[y * w + x]).sum::<u64>()).min().unwrap();
        assert!(cut.cost <= straight);
    }
}

#[test]
fn the_new_side_is_right_of_the_left_path_and_below_the_top_path() {
    // Zero errors along an L through column 1 and row 2 force the cut.
    let (h, w) = (6, 6);
    let mut e = vec![9_u64; h * w];
    (2..h).for_each(|y| e[y * w + 1] = 0);
    (1..w).for_each(|x| e[2 * w + x] = 0);
    let cut = boundary_cut([h, w], Overlaps { left: 3, top: 3, ..Overlaps::default() }, &e, None).unwrap();
    let picture: Vec<String> =
        cut.new.chunks(w).map(|r| r.iter().map(|&n| if n { '#' } else { '.' }).collect()).collect();
    assert_eq!(cut.cost, 0);
    assert_eq!(picture, ["......", "......", ".#####", ".#####", ".#####", ".#####"]);
}

#[test]
fn the_two_sides_of_a_ring_are_connected() {
    // What is new is one piece, and so is what stays old: the cut is closed.
    let mut rng = Seed(3).rng();
    for _ in 0..100 {
        let (h, w) = (12, 14);
        let o = Overlaps { left: 4, top: 5, right: 6, bottom: 3 };
        let e = random_errors(&mut rng, h * w, 9);
        let new = boundary_cut([h, w], o, &e, None).unwrap().new;
        assert!(new[(h / 2) * w + w / 2]);
        assert_eq!(pieces(&new, [h, w], true), 1);
    }
}

/// Number of 8-connected pieces of a kind.
fn pieces(mask: &[bool], [h, w]: [usize; 2], kind: bool) -> usize {
    let mut seen = vec![false; h * w];
    let mut n = 0;
    for start in 0..h * w {
        if seen[start] || mask[start] != kind {
            continue;
        }
        n += 1;
        let mut stack = vec![start];
        while let Some(i) = stack.pop() {
            if std::mem::replace(&mut seen[i], true) {
                continue;
            }
            let (y, x) = (i / w, i % w);
            for (ny, nx) in (y.saturating_sub(1)..(y + 2).min(h))
                .flat_map(|ny| (x.saturating_sub(1)..(x + 2).min(w)).map(move |nx| (ny, nx)))
            {
                if mask[ny * w + nx] == kind && !seen[ny * w + nx] {
                    stack.push(ny * w + nx);
                }
            }
        }
    }
    n
}
