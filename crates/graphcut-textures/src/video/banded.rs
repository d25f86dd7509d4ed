//! Surfaces looked for near those of smaller clips. `[Lombaert05]`
//!
//! The surface of a clip of half the size says within a few frames when each pixel jumps; it is decided again tile by
//! tile, within those frames, under what stands around the tile. No tile makes it dearer.

use std::ops::Range;

use selvedge_core::{Bytes, Domain, Window, par, try_vec};
use selvedge_maxflow::{BinaryEnergy, MaxflowError, PairwiseTerm};

use super::transition::{Stretches, cut_failed};
use crate::error::Error;

/// At the last of so many levels little is left of a frame.
pub(super) const MOST_LEVELS: u32 = 5;
/// Frames around what the smaller surface says, beyond how far it changes from pixel to pixel.
const AROUND: u32 = 12;
/// Sides of tiles, and of the strips that are laid over their borders afterwards.
const TILE: u32 = 128;
const STRIP: u32 = 32;

/// By pixel, before which frames of the window it may jump, counted within it: the first, and the last.
type Band = Vec<Range<u32>>;

/// An upper bound of what graphs take then: that of the smaller clip, or those of the tiles that threads cut at once.
pub(super) fn tiled(window: Domain<3>) -> Bytes {
    let [frames, height, width] = window.shape;
    let graph = |[h, w]: [u32; 2]| Bytes::of_samples(Domain::open([frames, h, w]), 64);
    let strip = graph([STRIP, height.max(width)]);
    let tile = graph([TILE.min(height), TILE.min(width)]);
    // What each pixel shows, and between which frames.
    let pixels = Bytes::of_samples(Domain::open([height, width]), 40);
    graph([height / 2 + 1, width / 2 + 1]).max(tile.max(strip) * par::threads() as u64) + pixels
}

impl Stretches {
    /// A surface, by frames of the window that each pixel shows before it jumps, and the bits that prices were
    /// shortened by: the cheapest, or a cheap one near that of half the size.
    pub(super) fn surface(
        &self,
        coarser: Option<([u32; 2], Vec<u32>)>,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<(Vec<u32>, u32), Error> {
        let [frames, height, width] = self.shape;
        let all = Window { start: [0; 2], shape: [height, width] };
        let Some((size, times)) = coarser else {
            let (shown, band) = (try_vec(self.pixels, 0)?, vec![0..frames; self.pixels]);
            return self.decided(&all, &shown, &band, cancelled);
        };
        let (mut shown, band) = self.near(size, &times)?;
        let mut most = 0;
        for tiles in passes(all.shape) {
            let found = par::map_indexed(tiles.len(), |i| self.decided(&tiles[i], &shown, &band, cancelled));
            let before = shown.clone();
            let mut shifted = false;
            for (tile, found) in tiles.iter().zip(found) {
                let (times, shift) = found?;
                (most, shifted) = (most.max(shift), shifted || 0 < shift);
                self.pixels_of(tile).zip(times).for_each(|(p, time)| shown[p] = time);
            }
            // Prices that were shortened may mislead.
            if shifted && self.total(&before) < self.total(&shown) {
                shown = before;
            }
        }
        Ok((shown, most))
    }

    /// The surface of half the size, and the frames around it.
    fn near(&self, [height, width]: [u32; 2], times: &[u32]) -> Result<(Vec<u32>, Band), Error> {
        let [frames, h, w] = self.shape;
        let (mut shown, mut band) = (try_vec(self.pixels, 0)?, Vec::with_capacity(self.pixels));
        let picture = Domain::open([h, w]);
        for (p, [y, x]) in picture.positions().enumerate() {
            let (y, x) = ((y / 2).min(height - 1), (x / 2).min(width - 1));
            shown[p] = times[(y * width + x) as usize];
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let near = rows.flat_map(|y| columns.clone().map(move |x| times[(y * width + x) as usize]));
            let (low, high) = near.fold((frames, 0), |(low, high), t| (low.min(t), high.max(t)));
            band.push(low.saturating_sub(AROUND)..(high + AROUND).min(frames));
        }
        Ok((shown, band))
    }

    /// Pixels of a tile, by their numbers in a frame.
    fn pixels_of(&self, tile: &Window<2>) -> impl Iterator<Item = usize> + use<> {
        let (start, width) = (tile.start.map(|s| s as u32), self.shape[2]);
        tile.local().positions().map(move |[y, x]| ((start[0] + y) * width + start[1] + x) as usize)
    }

    /// A tile's part of the surface, decided within a band, under what is shown around the tile.
    fn decided(
        &self,
        tile: &Window<2>,
        shown: &[u32],
        band: &[Range<u32>],
        cancelled: &dyn Fn() -> bool,
    ) -> Result<(Vec<u32>, u32), Error> {
        for shift in 0.. {
            let part = Part { stretches: self, tile: *tile, shown, band, shift };
            if let Some(times) = part.cut(cancelled)? {
                return Ok((times, shift));
            }
        }
        unreachable!("prices of no bits are all 0")
    }
}

/// Tiles that are decided beside each other, one set after the other: every fourth, then the strips over their borders.
fn passes([height, width]: [u32; 2]) -> Vec<Vec<Window<2>>> {
    let tile = |y: u32, x: u32, [h, w]: [u32; 2]| Window {
        start: [y as i32, x as i32],
        shape: [h.min(height - y), w.min(width - x)],
    };
    let corners = |first: u32, side: u32| (first..side).step_by(2 * TILE as usize);
    let every = |[y, x]: [u32; 2]| {
        let rows = corners(y * TILE, height);
        rows.flat_map(|y| corners(x * TILE, width).map(move |x| (y, x))).map(|(y, x)| tile(y, x, [TILE; 2])).collect()
    };
    let borders = |side: u32| (TILE..side).step_by(TILE as usize).map(|at| at - STRIP / 2);
    let upright = borders(width).map(|x| tile(0, x, [height, STRIP])).collect();
    let level = borders(height).map(|y| tile(y, 0, [STRIP, width])).collect();
    let mut all: Vec<Vec<Window<2>>> = [[0, 0], [0, 1], [1, 0], [1, 1]].into_iter().map(every).collect();
    all.extend([upright, level]);
    all
}

/// A tile to be cut.
struct Part<'a> {
    stretches: &'a Stretches,
    tile: Window<2>,
    shown: &'a [u32],
    band: &'a [Range<u32>],
    /// Bits that prices are shortened by.
    shift: u32,
}

impl Part<'_> {
    /// The cheapest times; `None` if prices are too large.
    fn cut(&self, cancelled: &dyn Fn() -> bool) -> Result<Option<Vec<u32>>, Error> {
        let pixels: Vec<usize> = self.stretches.pixels_of(&self.tile).collect();
        let bands = pixels.iter().map(|&p| &self.band[p]);
        let low = bands.clone().map(|band| band.start).min().unwrap_or(0);
        let high = bands.clone().map(|band| band.end).max().unwrap_or(0);
        let mut times: Vec<u32> = bands.map(|band| band.start).collect();
        if high <= low {
            return Ok(Some(times));
        }
        let [height, width] = self.tile.shape.map(|n| n as usize);
        let mut energy = BinaryEnergy::new([(high - low) as usize, height, width], [false; 3]).map_err(cut_failed)?;
        match self.fill(&mut energy, low..high, &pixels) {
            Err(MaxflowError::CapacityTooLarge { .. }) => return Ok(None),
            other => other.map_err(cut_failed)?,
        }
        let minimum = energy.minimize_until(cancelled).map_err(cut_failed)?;
        for (node, &kept) in minimum.cut.source_side().iter().enumerate() {
            let (i, t) = (node % pixels.len(), low + (node / pixels.len()) as u32);
            times[i] += u32::from(kept && self.band[pixels[i]].contains(&t));
        }
        Ok(Some(times))
    }

    fn fill(&self, energy: &mut BinaryEnergy<3>, frames: Range<u32>, pixels: &[usize]) -> Result<(), MaxflowError> {
        for t in frames.clone() {
            let first = (t - frames.start) as usize * pixels.len();
            for (i, _) in pixels.iter().enumerate().filter(|(_, p)| !self.band[**p].contains(&t)) {
                energy.graph_mut().mask(first + i)?;
            }
        }
        for t in frames.clone() {
            let first = (t - frames.start) as usize * pixels.len();
            for (i, &p) in pixels.iter().enumerate().filter(|(_, p)| self.band[**p].contains(&t)) {
                self.in_time(energy, first + i, (t, p))?;
                self.in_frame(energy, first + i, (t, p))?;
            }
        }
        energy.ordered(0)
    }

    fn price(&self, axis: usize, here: i64, there: i64) -> i32 {
        self.stretches.price(axis, here, there) >> self.shift
    }

    /// What it costs to jump before a frame, and after the last one that is in question. There is no way back.
    fn in_time(&self, energy: &mut BinaryEnergy<3>, node: usize, (t, p): (u32, usize)) -> Result<(), MaxflowError> {
        let n = self.stretches.pixels as i64;
        let here = i64::from(t) * n + p as i64;
        if t == self.band[p].start {
            energy.unary(node, 0, self.price(0, here - n, here))?;
        }
        let after = self.price(0, here, here + n);
        if t + 1 == self.band[p].end {
            energy.unary(node, after, 0)
        } else {
            energy.pairwise(node, 0, PairwiseTerm { e00: 0, e01: after, e10: 0, e11: 0 })
        }
    }

    /// What it costs to show another side than a neighbour in the frame, which costs the same either way.
    fn in_frame(&self, energy: &mut BinaryEnergy<3>, node: usize, (t, p): (u32, usize)) -> Result<(), MaxflowError> {
        let [_, height, width] = self.stretches.shape;
        let at = [p as u32 / width, p as u32 % width];
        let here = i64::from(t) * self.stretches.pixels as i64 + p as i64;
        for (axis, (stride, side)) in [(width as usize, height), (1, width)].into_iter().enumerate() {
            let (begin, len) = (self.tile.start[axis] as u32, self.tile.shape[axis]);
            if at[axis] + 1 < side {
                let (next, e) = (p + stride, self.price(axis + 1, here, here + stride as i64));
                let inside = at[axis] + 1 < begin + len;
                match self.fixed(inside, next, t) {
                    None => energy.pairwise(node, axis + 1, PairwiseTerm { e00: 0, e01: e, e10: e, e11: 0 })?,
                    Some(jumped) => energy.unary(node, if jumped { e } else { 0 }, if jumped { 0 } else { e })?,
                }
            }
            if 0 < at[axis]
                && let Some(jumped) = self.fixed(begin < at[axis], p - stride, t)
            {
                let e = self.price(axis + 1, here - stride as i64, here);
                energy.unary(node, if jumped { e } else { 0 }, if jumped { 0 } else { e })?;
            }
        }
        Ok(())
    }

    /// Whether a pixel has jumped at a frame, if that is not in question.
    fn fixed(&self, inside: bool, p: usize, t: u32) -> Option<bool> {
        let band = &self.band[p];
        match inside {
            false => Some(self.shown[p] <= t),
            true if band.contains(&t) => None,
            true => Some(band.end <= t),
        }
    }
}
