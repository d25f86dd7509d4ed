//! Tiles: which transform sizes answer a search, and how many of them.

use crate::axes::Shape;
use crate::extension::Extension;

/// How positions are covered by tiles (overlap-save). Along each axis a transform of `size` samples answers `hop`
/// positions; `tiles` of them answer all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tiling {
    pub(crate) size: Shape,
    pub(crate) hop: Shape,
    pub(crate) tiles: Shape,
    /// Coordinate of the extension at which the first tile begins.
    pub(crate) start: Shape,
    /// About how many nanoseconds a search takes.
    pub(crate) cost: f64,
}

/// Positions asked of one block of a template.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    /// First position, counted from the range's first.
    pub(crate) first: Shape,
    pub(crate) count: Shape,
}

impl Tiling {
    /// The cheapest tiling for a block of a template, which begins at template sample `block`, and its positions.
    pub(crate) fn new(extension: &Extension, block: Shape, template: Shape, window: &Window) -> Self {
        let start = [0, 1, 2].map(|a: usize| window.first[a] + block[a]);
        let options = [0, 1, 2].map(|a: usize| sizes(extension, a, start[a], template[a], window.count[a]));
        let mut best = (f64::INFINITY, [(1, 1); 3]);
        for &t in &options[0] {
            for &y in &options[1] {
                for &x in options[2].iter().filter(|x| x.0.is_multiple_of(2)) {
                    let cost = cost([t, y, x], template, window.count);
                    if cost < best.0 {
                        best = (cost, [t, y, x]);
                    }
                }
            }
        }
        let (size, hop) = (best.1.map(|o| o.0), best.1.map(|o| o.1));
        Self { size, hop, tiles: [0, 1, 2].map(|a: usize| window.count[a].div_ceil(hop[a])), start, cost: best.0 }
    }

    /// True if both cut a source into the same tiles. Positions that a tile answers are asked of it, not of its
    /// spectra: where there is just one tile, they do not matter.
    pub(crate) fn shares_spectra(&self, other: &Self) -> bool {
        let axis = |a: usize| self.tiles[a] == 1 || self.hop[a] == other.hop[a];
        (self.size, self.start, self.tiles) == (other.size, other.start, other.tiles) && (0..3).all(axis)
    }

    pub(crate) fn n_tiles(&self) -> usize {
        self.tiles.iter().product()
    }

    /// First position of a tile, counted from the window's first.
    pub(crate) fn origin(&self, tile: usize) -> Shape {
        let at = crate::axes::position(self.tiles, tile);
        [0, 1, 2].map(|a: usize| at[a] * self.hop[a])
    }
}

/// Sizes worth trying along an axis, each with the positions that it answers.
fn sizes(extension: &Extension, axis: usize, start: usize, template: usize, count: usize) -> Vec<(usize, usize)> {
    let whole = count + template - 1;
    // The last axis needs an even size.
    let smallest_whole = smooth(whole, axis == 2);
    let mut options = vec![(smallest_whole, count)];
    // A little more may be faster: powers of two are, and factors of five are not.
    for size in [
        whole.next_power_of_two(),
        3 * (whole.div_ceil(3)).next_power_of_two(),
        27 * whole.div_ceil(27).next_power_of_two(),
    ] {
        if smallest_whole < size && size <= whole + whole / 8 && size.is_multiple_of(2) {
            options.push((size, count));
        }
    }
    // Where the first samples lie outside of the source, what wraps around to them meets only zeros.
    let (outside, end) = extension.beside(axis, start);
    let wrapped = smooth((whole - outside.min(template - 1)).max(end).max(template), axis == 2);
    if wrapped < smallest_whole {
        options.push((wrapped, count));
    }
    // Nor does wrapping hurt where the source itself wraps around with the transform.
    if template <= count && extension.period(axis) == Some(count) && smooth(count, axis == 2) == count {
        options.push((count, count));
    }
    let class = class(template);
    for exponent in 3..=10 {
        for size in [1 << exponent, 3 << (exponent - 1), 5 << (exponent - 2)] {
            if 2 * template <= size + size / 2 && class < size && size < smallest_whole {
                options.push((size, size - class + 1));
            }
        }
    }
    options
}

/// Templates of nearly the same size share the spectra of the source: sizes are rounded up by at most an eighth.
fn class(template: usize) -> usize {
    template.next_multiple_of((template.next_power_of_two() / 8).max(1))
}

/// About the nanoseconds of a search with three channels. The constants were fitted to warm searches, on one thread of
/// a processor with AVX2, of 16^2 to 128^2 samples in 192^2 to 1024^2 and of 15 x 50 x 75 in 30 x 100 x 150; they
/// decide speed only.
fn cost(axes: [(usize, usize); 3], template: Shape, count: Shape) -> f64 {
    let [t, y, x] = axes.map(|a| a.0 as f64);
    let log = |n: f64| passes(n as usize);
    let tiles: f64 = (0..3).map(|a| count[a].div_ceil(axes[a].1) as f64).product();
    let columns = (x / 2.0 + 1.0) * t * y;
    let answered = (axes[0].1.min(count[0]) * axes[1].1.min(count[1])) as f64;
    // Beyond the second-level cache, every pass costs more.
    let far = if 1.0e5 < columns { 1.5 } else { 1.0 };
    let inverse = columns * (2.5 + 0.5 * (log(y) + log(t))) * far + answered * x * (0.5 + 0.25 * log(x));
    let forward =
        3.0 * (columns * (1.0 + 0.5 * (log(y) + log(t))) + (template[0] * template[1]) as f64 * x * 0.25 * log(x));
    tiles * inverse + forward + tiles * 2000.0
}

/// Passes of a transform of `n` samples, in those of a power of two.
fn passes(n: usize) -> f64 {
    let slow = if n.is_multiple_of(5) {
        1.6
    } else if n.is_multiple_of(3) {
        1.25
    } else {
        1.0
    };
    slow * f64::from(usize::BITS - n.leading_zeros())
}

/// The least number of the form `2^a 3^b 5^c` that is not smaller; an even one if asked.
fn smooth(n: usize, even: bool) -> usize {
    let is_smooth = |mut m: usize| {
        for p in [2, 3, 5] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    (n..).find(|&m| is_smooth(m) && (!even || m.is_multiple_of(2))).expect("powers of two are smooth")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Positions;
    use crate::placement::Range;

    #[test]
    fn a_picture_moved_over_itself_takes_one_tile_of_what_it_and_its_way_are() {
        let shape = [1, 16, 16];
        let range =
            Range { first: [0, -8, -8], count: [1, 17, 17], ..Range::new(Positions::Inside, shape, [false; 3], shape) };
        let extension = Extension::new(shape, &range, shape).unwrap();
        let window = Window { first: [0; 3], count: range.count };
        let tiling = Tiling::new(&extension, [0; 3], shape, &window);
        assert_eq!((tiling.size, tiling.tiles), ([1, 24, 24], [1; 3]));
    }
}
