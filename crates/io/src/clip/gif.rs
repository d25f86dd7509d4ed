//! Writing GIF: one palette for the whole clip and a dither that stands still, so that nothing flickers that did not.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};

use color_quant::NeuQuant;
use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use selvedge_core::{Plane, Samples, try_vec};

use super::info::FrameEncoder;
use super::problem::ClipProblem;
use super::rate::Rate;
use crate::error::Problem;
use crate::sink::Sink;

/// The palette learns from about so many pixels, taken evenly: more change it little and take a second each half
/// million.
const LEARNED: usize = 200_000;
/// How far the dither moves a value up and down at most, about half of what lies between neighbours in a palette of 256
/// that was made for the clip.
const DITHER: i32 = 8;
/// The palette's nearest colour is kept for values of so many bits a channel.
const BITS: u32 = 6;

/// A clip that grows by frames. All are held until the palette is known.
pub(super) struct GifWriter {
    rate: Rate,
    size: [u16; 2],
    alpha: bool,
    /// Interleaved red, green and blue; black where nothing shows.
    frames: Vec<Vec<[u8; 3]>>,
    /// Where nothing shows, in clips that have alpha.
    holes: Vec<Vec<bool>>,
}

fn unsupported(what: impl Into<String>) -> Problem {
    ClipProblem::Unsupported { container: "gif", what: what.into() }.into()
}

impl GifWriter {
    pub(super) fn new(rate: Rate) -> Self {
        Self { rate, size: [0, 0], alpha: false, frames: Vec::new(), holes: Vec::new() }
    }
}

impl FrameEncoder for GifWriter {
    fn frame(&mut self, plane: &Plane<2>) -> Result<(), Problem> {
        let Samples::U8(grid) = &plane.samples else {
            return Err(unsupported(format!("{} samples", plane.samples.depth().name())));
        };
        let colors = match plane.color_channels() {
            1 => [0, 0, 0],
            3 => [0, 1, 2],
            n => return Err(unsupported(format!("{n} channels"))),
        };
        let [height, width] = grid.domain().shape;
        let side = |v: u32| u16::try_from(v).map_err(|_| unsupported("a side over 65,535 px"));
        (self.size, self.alpha) = ([side(width)?, side(height)?], plane.alpha);
        let mut pixels = try_vec(grid.domain().len(), [0_u8; 3])?;
        for (i, pixel) in pixels.iter_mut().enumerate() {
            *pixel = colors.map(|c| grid.plane(c)[i]);
        }
        if plane.alpha {
            // A pixel shows or does not.
            let holes: Vec<bool> = grid.plane(plane.color_channels()).iter().map(|a| *a < 128).collect();
            pixels.iter_mut().zip(&holes).filter(|(_, hole)| **hole).for_each(|(pixel, _)| *pixel = [0; 3]);
            self.holes.push(holes);
        }
        self.frames.push(pixels);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Vec<u8>, Problem> {
        // The last place stands for what does not show.
        let most = if self.alpha { 255 } else { 256 };
        let mut palette = Palette::of(&self.frames, most)?;
        let mut file = Sink::default();
        let [width, height] = self.size;
        let mut global: Vec<u8> = palette.colors.iter().flatten().copied().collect();
        if self.alpha {
            global.resize(256 * 3, 0);
        }
        let mut encoder = Encoder::new(Borrowed(&mut file), width, height, &global).map_err(complaint)?;
        encoder.set_repeat(Repeat::Infinite).map_err(complaint)?;
        for (number, pixels) in self.frames.iter().enumerate() {
            let mut buffer = try_vec(pixels.len(), 0_u8)?;
            for (i, (to, pixel)) in buffer.iter_mut().zip(pixels).enumerate() {
                let hole = self.holes.get(number).is_some_and(|holes| holes[i]);
                *to =
                    if hole { u8::MAX } else { palette.index(*pixel, i % usize::from(width), i / usize::from(width)) };
            }
            let frame = Frame {
                width,
                height,
                delay: self.rate.ticks(number as u32, 100).min(u16::MAX.into()) as u16,
                dispose: if self.alpha { DisposalMethod::Background } else { DisposalMethod::Keep },
                transparent: self.alpha.then_some(u8::MAX),
                buffer: Cow::Owned(buffer),
                ..Frame::default()
            };
            encoder.write_frame(&frame).map_err(complaint)?;
        }
        drop(encoder);
        Ok(file.into_bytes())
    }
}

/// The encoder wants to own what it writes to.
struct Borrowed<'a>(&'a mut Sink);
impl Write for Borrowed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn complaint(error: EncodingError) -> Problem {
    match error {
        EncodingError::Io(e) => Problem::file_system(e, 0),
        other => unsupported(other.to_string()),
    }
}

/// The colours of a clip.
struct Palette {
    colors: Vec<[u8; 3]>,
    /// Places of all colours, where there are few enough of them that none is changed.
    exact: Option<BTreeMap<[u8; 3], u8>>,
    /// The nearest place of each value, found when it is asked for.
    nearest: Vec<Option<u8>>,
}

impl Palette {
    fn of(frames: &[Vec<[u8; 3]>], most: usize) -> Result<Self, Problem> {
        let mut exact = BTreeMap::new();
        for pixel in frames.iter().flatten() {
            exact.insert(*pixel, 0);
            if most < exact.len() {
                break;
            }
        }
        if exact.len() <= most {
            exact.values_mut().zip(0..=u8::MAX).for_each(|(place, i)| *place = i);
            return Ok(Self { colors: exact.keys().copied().collect(), exact: Some(exact), nearest: Vec::new() });
        }
        let pixels: usize = frames.iter().map(Vec::len).sum();
        let sampled = frames.iter().flatten().step_by(pixels.div_ceil(LEARNED));
        let learned: Vec<u8> = sampled.flat_map(|&[r, g, b]| [r, g, b, u8::MAX]).collect();
        let map = NeuQuant::new(1, most, &learned).color_map_rgb();
        let mut colors = map.as_chunks::<3>().0.to_vec();
        colors.sort_unstable();
        colors.dedup();
        Ok(Self { colors, exact: None, nearest: try_vec(1 << (3 * BITS), None)? })
    }

    fn index(&mut self, pixel: [u8; 3], x: usize, y: usize) -> u8 {
        if let Some(exact) = &self.exact {
            return exact.get(&pixel).copied().unwrap_or_default();
        }
        let moved = pixel.map(|v| (i32::from(v) + dither(x, y)).clamp(0, 255));
        let key = moved.iter().fold(0, |key, v| key << BITS | (*v as usize >> (8 - BITS)));
        let Self { colors, nearest, .. } = self;
        *nearest[key].get_or_insert_with(|| {
            // The middle of what has this key.
            let middle = moved.map(|v| (v >> (8 - BITS) << (8 - BITS)) + (1 << (7 - BITS)));
            let off =
                |color: &[u8; 3]| -> i32 { color.iter().zip(middle).map(|(a, b)| (i32::from(*a) - b).pow(2)).sum() };
            (0..).zip(colors.iter()).min_by_key(|(_, color)| off(color)).map_or(0, |(i, _)| i as u8)
        })
    }
}

/// A threshold from -DITHER to DITHER, by place.
fn dither(x: usize, y: usize) -> i32 {
    (2 * rank(x, y) - 63) * DITHER / 63
}

/// The rank of a place among the 64 of its square: bits of both coordinates interleaved, so that near ones differ most.
fn rank(x: usize, y: usize) -> i32 {
    let bit = |v: usize, i: usize| (v >> i & 1) as i32;
    (0..3).map(|i| (2 * (bit(x, i) ^ bit(y, i)) + bit(y, i)) << (2 * (2 - i))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dither_takes_each_rank_once() {
        let mut all: Vec<i32> = (0..64).map(|i| rank(i % 8, i / 8)).collect();
        all.sort_unstable();
        assert_eq!(all, (0..64).collect::<Vec<_>>());
        let values: Vec<i32> = (0..64).map(|i| dither(i % 8, i / 8)).collect();
        assert_eq!((values.iter().min(), values.iter().max(), values.iter().sum()), (Some(&-DITHER), Some(&DITHER), 0));
    }

    #[test]
    fn a_palette_may_be_full() {
        for most in [255, 256] {
            let grey: Vec<[u8; 3]> = (0..=255).map(|v| [v; 3]).take(most).collect();
            let mut palette = Palette::of(std::slice::from_ref(&grey), most).unwrap();
            for pixel in &grey {
                let place = palette.index(*pixel, 0, 0);
                assert_eq!(palette.colors[usize::from(place)], *pixel);
            }
            let more = [grey, vec![[9, 8, 7]]];
            assert!(Palette::of(&more, most).unwrap().exact.is_none());
        }
    }

    #[test]
    fn few_colours_stay_as_they_are() {
        let frames = vec![vec![[1, 2, 3], [4, 5, 6]], vec![[4, 5, 6], [255, 0, 9]]];
        let mut palette = Palette::of(&frames, 256).unwrap();
        for (i, pixel) in frames.iter().flatten().enumerate() {
            let place = palette.index(*pixel, i, 0);
            assert_eq!(palette.colors[usize::from(place)], *pixel);
        }
    }
}
