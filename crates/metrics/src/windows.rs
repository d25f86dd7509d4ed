//! Columns of nearest windows: coherence, completeness, use, repeats.

use crate::Error;
use selvedge_core::{Domain, Exemplars, Grid, Seed, SimdLevel, par};
use selvedge_fft_ssd::{Costs, Field, Neighbor, Options, Placement, Scratch, SsdSearcher, Template, Windows, nearest};

/// Windows drawn at full size: their mean distance varies by some 2 % between draws, less than candidates differ.
const DRAWN: usize = 2000;
/// Fewer are drawn from larger exemplars, each of which is searched for every one: as many as take some two seconds,
/// but no fewer than vary by 5 %.
const LEAST_DRAWN: usize = 320;
const DRAWN_TIMES_SAMPLES: usize = DRAWN << 18;
/// So many pairs of samples, of a picture and of what it is compared with, are compared at each size whatever they are:
/// a second or less. 1024^2 from 256^2 are compared throughout. Of larger ones, whose pairs grow with the fourth power
/// of sides, tiles are.
const PAIRS: u64 = 1 << 32;
/// Sides of a tile in those of a window: windows that overlap share their work.
const TILE: u32 = 4;
/// So many tiles at least, whatever it takes: fewer may all lie in one part of a large picture. A guess.
const LEAST_TILES: u64 = 16;
/// A window this close is a copy of its place, whatever phase the halving had: a copy laid at an odd offset is averaged
/// over other samples than its place was. The value is a guess.
const COPY: f64 = 0.4;

/// Exemplars at one size, with what distances are divided by.
pub(crate) struct Level {
    pub(crate) exemplars: Exemplars<2>,
    /// Root mean square difference of one sample and all channels to a contrast of 1.
    pub(crate) contrast: f64,
}

impl Level {
    pub(crate) fn new(exemplars: Exemplars<2>) -> Self {
        let contrast = crate::marginals::contrast(&exemplars);
        Self { exemplars, contrast }
    }

    /// Distance from a sum of squares.
    fn distance(&self, error: u64, side: u32) -> f64 {
        let weights: f64 = self.exemplars.weights().iter().map(|&w| f64::from(w)).sum();
        (error as f64 / (f64::from(side * side) * weights)).sqrt() / self.contrast
    }

    /// Windows of the output and the nearest of the exemplars.
    pub(crate) fn coherent(&self, output: &Grid<u8, 2>, windows: Windows, simd: SimdLevel) -> Result<Near<'_>, Error> {
        let fields = Field::all(&self.exemplars);
        let (found, of) = found(Field::new(output), &fields, self.exemplars.weights(), windows, (PAIRS, simd))?;
        Ok(Near { level: self, found, of, windows })
    }

    /// Distances of the exemplars' windows to the nearest of the output.
    pub(crate) fn complete(&self, output: &Grid<u8, 2>, windows: Windows, simd: SimdLevel) -> Result<f64, Error> {
        let mut distances = Vec::new();
        for source in self.exemplars.firsts() {
            let weights = self.exemplars.weights();
            let (found, _) = found(Field::of(source), &[Field::new(output)], weights, windows, (PAIRS, simd))?;
            distances.extend(found.iter().map(|(_, n)| self.distance(n.error, windows.side)));
        }
        Ok(mean(&distances))
    }

    /// Windows drawn from the output, and those that lie across its wrap.
    pub(crate) fn sampled(&self, output: &Grid<u8, 2>, side: u32, simd: SimdLevel) -> Result<Drawn, Error> {
        let (domain, over) = (output.domain(), Windows { side, step: 1 }.over(output.domain()));
        if over.is_empty() {
            return Ok(Drawn::default());
        }
        let searcher = SsdSearcher::with_options(&self.exemplars, Options { simd, ..Options::default() })?;
        let samples = self.exemplars.table().len() as usize;
        let n = (DRAWN_TIMES_SAMPLES / samples.max(1)).clamp(LEAST_DRAWN, DRAWN).min(over.len());
        let at = |i: usize| over.position(if n == over.len() { i } else { draw(i, over.len()) });
        let drawn = self.distances(output, &searcher, side, (n, &at))?;
        let mut across = Vec::new();
        for axis in (0..2).filter(|&axis| domain.periodic[axis] && side <= domain.shape[axis]) {
            let along = domain.shape[1 - axis];
            let step = (side / 2).max(along.div_ceil(MOST_ACROSS.min(n as u32 / 10).max(LEAST_ACROSS)));
            let middle = domain.shape[axis] - side / 2;
            let at = |i: usize| std::array::from_fn(|a| if a == axis { middle } else { i as u32 * step });
            // Where the other axis ends no window lies across its border.
            let n = match domain.periodic[1 - axis] {
                true => along / step,
                false => along.checked_sub(side).map_or(0, |rest| rest / step + 1),
            };
            let n = n as usize;
            let near = self.distances(output, &searcher, side, (n, &at))?.concat();
            across.push(mean(&near.iter().map(|(_, distance)| *distance).collect::<Vec<_>>()));
        }
        Ok(Drawn { drawn, across, inside: domain.shape.map(|n| n.saturating_sub(side)) })
    }

    /// Distances of windows at some places, in blocks of fifty, each of which has a scratch.
    fn distances(
        &self,
        output: &Grid<u8, 2>,
        searcher: &SsdSearcher<2>,
        side: u32,
        (n, at): (usize, &(dyn Fn(usize) -> [u32; 2] + Sync)),
    ) -> Result<Vec<Vec<Placed>>, Error> {
        let block = |block: usize| {
            let (mut scratch, mut costs) = (Scratch::new(), Costs::new());
            let mut distances = Vec::new();
            for i in block * BLOCK..n.min((block + 1) * BLOCK) {
                let features = cut(output, at(i), [side; 2]);
                let template = Template::new([side; 2], &features);
                searcher.search(&template, Placement::INSIDE, &mut scratch, &mut costs)?;
                distances.extend(costs.best().map(|best| (at(i), self.distance(best.error, side))));
            }
            Ok(distances)
        };
        par::map_indexed(n.div_ceil(BLOCK), block).into_iter().collect()
    }
}

/// Windows that have a scratch together.
const BLOCK: usize = 50;
/// Windows across the wrap along an axis, at most: a tenth of those that are drawn elsewhere.
const MOST_ACROSS: u32 = 200;
/// And at least, along an axis that is long enough: fewer may miss what is torn. A guess.
const LEAST_ACROSS: u32 = 20;
/// A distance that is nothing, where two are compared as a ratio.
const GROUND: f64 = 0.05;

/// The first sample of a window, and its distance.
type Placed = ([u32; 2], f64);

/// Distances of windows at full size.
#[derive(Default)]
pub(crate) struct Drawn {
    drawn: Vec<Vec<Placed>>,
    /// Means across the wrap of each periodic axis.
    across: Vec<f64>,
    /// The last places of windows that lie across no wrap.
    inside: [u32; 2],
}

impl Drawn {
    pub(crate) fn mean(&self) -> f64 {
        let sums = self.drawn.iter().map(|block| block.iter().map(|(_, distance)| distance).sum::<f64>());
        sums.reduce(|a, b| a + b).unwrap_or(0.0) / self.drawn.iter().map(Vec::len).sum::<usize>().max(1) as f64
    }

    /// By how much windows across the wrap are farther than the worst twentieth elsewhere, the larger of the axes:
    /// where a joint of a wall lies on the wrap there is a step, but the exemplar has it as well.
    pub(crate) fn torn(&self) -> f64 {
        let is_inside = |at: &[u32; 2]| (0..2).all(|axis| at[axis] <= self.inside[axis]);
        let elsewhere = self.drawn.iter().flatten().filter(|(at, _)| is_inside(at)).map(|(_, distance)| *distance);
        let worst = worst(elsewhere.collect());
        let excess = |&across: &f64| (across + GROUND) / (worst + GROUND) - 1.0;
        self.across.iter().map(excess).fold(0.0, f64::max)
    }
}

/// The windows of an output and their nearest places.
pub(crate) struct Near<'a> {
    level: &'a Level,
    /// By the first samples of the windows that were compared.
    found: Vec<Found>,
    /// How many windows there are.
    of: usize,
    windows: Windows,
}

/// The first sample of a window, and the window most like it.
type Found = ([u32; 2], Neighbor);

/// All windows of a picture that are like any, or those of keyed tiles of it where so many pairs would be too many; and
/// how many windows there are.
fn found(
    picture: Field<'_>,
    sources: &[Field<'_>],
    weights: &[u8],
    windows: Windows,
    (pairs, simd): (u64, SimdLevel),
) -> Result<(Vec<Found>, usize), Error> {
    let domain = picture.features.domain();
    let over = windows.over(domain);
    let samples = sources.iter().map(|source| source.features.domain().len() as u64).sum::<u64>().max(1);
    let whole = |near: Grid<Option<Neighbor>, 2>, from: [u32; 2]| {
        let over = near.domain();
        let at = move |i: usize| over.position(i).map(|p| p * windows.step);
        let placed = move |(i, near): (usize, Option<Neighbor>)| {
            near.map(|near| ([0, 1].map(|axis| from[axis] + at(i)[axis]), near))
        };
        near.samples().iter().copied().enumerate().filter_map(placed).collect::<Vec<Found>>()
    };
    if domain.len() as u64 <= pairs / samples {
        return Ok((whole(nearest(picture, sources, weights, windows, simd)?, [0; 2]), over.len()));
    }
    // Windows along a tile's side, and its samples.
    let along = 1 + (TILE - 1) * windows.side / windows.step;
    let side = (along - 1) * windows.step + windows.side;
    let most = (pairs / samples / u64::from(side * side)).max(LEAST_TILES);
    let tiles = Domain::open(over.shape.map(|n| n.div_ceil(along)));
    let near = |i: &usize| {
        let from = tiles.position(*i).map(|p| p * along);
        let count = |axis: usize| along.min(over.shape[axis] - from[axis]);
        let shape = [0, 1].map(|axis| (count(axis) - 1) * windows.step + windows.side);
        let from = from.map(|p| p * windows.step);
        let part = Domain::open(shape);
        let features = Grid::from_vec(part, weights.len(), cut(picture.features, from, shape))?;
        let valid = picture.valid.map(|v| Grid::from_vec(part, 1, cut(v, from, shape))).transpose()?;
        let tile = Field { features: &features, valid: valid.as_ref() };
        Ok(whole(nearest(tile, sources, weights, windows, simd)?, from))
    };
    let drawn = drawn(tiles.len(), most);
    let found: Vec<Result<Vec<Found>, Error>> = par::map_indexed(drawn.len(), |i| near(&drawn[i]));
    Ok((found.into_iter().collect::<Result<Vec<_>, Error>>()?.concat(), over.len()))
}

/// So many keyed numbers below `n`, each once, in their order.
fn drawn(n: usize, most: u64) -> Vec<usize> {
    let mut keyed: Vec<(u64, usize)> = (0..n).map(|i| (Seed(0).derive("metrics/tile", i as u64).0, i)).collect();
    keyed.sort_unstable();
    keyed.truncate(most.min(n as u64) as usize);
    let mut drawn: Vec<usize> = keyed.into_iter().map(|(_, i)| i).collect();
    drawn.sort_unstable();
    drawn
}

impl Near<'_> {
    fn distances(&self) -> Vec<f64> {
        self.found.iter().map(|(_, n)| self.level.distance(n.error, self.windows.side)).collect()
    }

    pub(crate) fn mean(&self) -> f64 {
        mean(&self.distances())
    }

    /// Mean of the farthest twentieth.
    pub(crate) fn worst(&self) -> f64 {
        worst(self.distances())
    }

    /// Divergence of the use of boxes of `side` samples from an even one, in bits. Where not all windows were compared,
    /// boxes are larger, so that they hold some: of one or two in each, most of the divergence is chance.
    pub(crate) fn unevenness(&self, side: u32) -> f64 {
        let (all, some) = (self.of.max(1), self.found.len().max(1));
        // Twice the side for each fourth of them.
        let side = (0..(all / some).checked_ilog2().unwrap_or(0).div_ceil(2)).fold(side, |side, _| 2 * side);
        let mut boxes = Vec::new();
        for (number, source) in self.level.exemplars.sources().iter().enumerate() {
            let [rows, columns] = Windows { step: side, ..self.windows }.over(source.domain()).shape;
            for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                boxes.push((number as u32, y, x));
            }
        }
        let mut counts = vec![0_u32; boxes.len()];
        for (_, n) in &self.found {
            let key = (n.source, n.position[0] / side, n.position[1] / side);
            let place = boxes.partition_point(|&b| b < key).min(boxes.len() - 1);
            counts[place] += 1;
        }
        let total: u32 = counts.iter().sum();
        let bits = |&n: &u32| {
            let share = f64::from(n) / f64::from(total.max(1));
            if n == 0 { 0.0 } else { share * libm::log2(share * counts.len() as f64) }
        };
        counts.iter().map(bits).sum()
    }

    /// Mean number of other windows, `apart` samples away or farther, at the same place within one sample. Of some
    /// windows it is as many of all as are met of them.
    pub(crate) fn repeats(&self, apart: u32) -> f64 {
        let is_copy = |n: &Neighbor| self.level.distance(n.error, self.windows.side) <= COPY;
        let copies = self.found.iter().filter(|(_, n)| is_copy(n));
        let mut copies: Vec<_> = copies.map(|&(at, n)| ((n.source, n.position), at)).collect();
        copies.sort_unstable();
        let mut pairs = 0_u64;
        for &((source, [y, x]), at) in &copies {
            for row in y.saturating_sub(1)..=y + 1 {
                let from = copies.partition_point(|&(p, _)| p < (source, [row, x.saturating_sub(1)]));
                let near = copies[from..].iter().take_while(|(p, _)| *p <= (source, [row, x + 1]));
                let far = |to: [u32; 2]| apart <= at[0].abs_diff(to[0]).max(at[1].abs_diff(to[1]));
                pairs += near.filter(|&&(_, to)| far(to)).count() as u64;
            }
        }
        let compared = self.found.len().max(1) as f64;
        pairs as f64 / compared * (self.of.max(1) as f64 / compared)
    }
}

/// A keyed place among `n`.
fn draw(i: usize, n: usize) -> usize {
    Seed(0).derive("metrics/window", i as u64).rng().below_u64(n as u64) as usize
}

/// Samples of a window, around periodic axes.
fn cut<T: Copy>(from: &Grid<T, 2>, at: [u32; 2], [height, width]: [u32; 2]) -> Vec<T> {
    let domain = from.domain();
    let mut features = Vec::with_capacity((height * width) as usize * from.channels());
    for c in 0..from.channels() {
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            features.push(from.get(c, [(at[0] + y) % domain.shape[0], (at[1] + x) % domain.shape[1]]));
        }
    }
    features
}

/// Mean of the farthest twentieth.
fn worst(mut all: Vec<f64>) -> f64 {
    all.sort_unstable_by(f64::total_cmp);
    mean(&all[all.len() - all.len().div_ceil(20)..])
}

/// 0 of nothing.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(shape: [u32; 2], periodic: bool, key: u64) -> Grid<u8, 2> {
        let domain = Domain { shape, periodic: [periodic; 2] };
        let mut rng = Seed(key).rng();
        let samples = (0..2 * domain.len()).map(|_| rng.below(256) as u8).collect();
        Grid::from_vec(domain, 2, samples).unwrap()
    }

    #[test]
    fn windows_of_tiles_are_some_of_all_and_found_alike() {
        let (source, windows) = (noise([40, 44], false, 1), Windows { side: 8, step: 4 });
        let mask = noise([150, 131], false, 3).samples()[..150 * 131].iter().map(|&v| v < 250).collect();
        let mask = Grid::from_vec(Domain::open([150, 131]), 1, mask).unwrap();
        for periodic in [false, true] {
            let picture = noise([150, 131], periodic, 2);
            for valid in [None, Some(&mask)] {
                let picture = Field { features: &picture, valid };
                let of = |pairs| {
                    let by = (pairs, SimdLevel::Auto);
                    found(picture, &[Field::new(&source)], &[1, 2], windows, by).unwrap()
                };
                let ((all, n), (some, m)) = (of(u64::MAX), of(0));
                assert_eq!((n, n), (m, all.len()));
                // Sixteen tiles of at most seven by seven windows.
                assert!(400 < some.len() && some.len() <= 16 * 49, "{}", some.len());
                assert!(some.iter().all(|found| all.contains(found)), "{periodic}");
                let mut places: Vec<[u32; 2]> = some.iter().map(|(at, _)| *at).collect();
                places.sort_unstable();
                places.dedup();
                assert_eq!(places.len(), some.len(), "each once");
            }
        }
    }
}
