//! What must show: strokes and masks.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use std::str::FromStr;

use selvedge_core::{Exemplars, Grid, Plane};
use selvedge_graphcut_textures::labels::Label;

use super::Merge;
use super::placed::shows;
use crate::failure::Failure;
use crate::ground::check_size;
use crate::inputs::{Input, white};
use crate::loom::Loom;
use crate::wrong::Wrong;

/// Colours of strokes that are told when they stand for nothing.
const TOLD: usize = 8;

/// A colour, and the number of its picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct StrokeColor {
    pub(super) rgb: [u8; 3],
    pub(super) picture: usize,
}

impl FromStr for StrokeColor {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let parse = || {
            let (color, picture) = text.strip_prefix('#')?.split_once('=')?;
            let number = (color.len() == 6).then(|| u32::from_str_radix(color, 16).ok())??;
            Some(Self { rgb: [16, 8, 0].map(|by| (number >> by) as u8), picture: picture.parse().ok()? })
        };
        parse().ok_or_else(|| Wrong::new(format!("'{text}' is no colour of a picture"), "write '#ffff00=1'"))
    }
}

impl fmt::Display for StrokeColor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", hex(self.rgb), self.picture)
    }
}

pub(super) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

impl Merge {
    /// By position, which pictures may show; none if all may everywhere.
    pub(super) fn only(&self, loom: &mut Loom<'_>, labels: &[Label<2>]) -> Result<Option<Grid<u64, 2>>, Failure> {
        if self.strokes.is_none() && self.keep.is_empty() {
            return Ok(None);
        }
        let all = u64::MAX >> (64 - labels.len());
        let mut only = Grid::try_filled(loom.domain, 1, all)?;
        if let Some(path) = &self.strokes {
            let plane = sized(loom, path)?;
            let wanted = self.wanted(path, &plane)?;
            keep(&mut only, (&loom.loaded.exemplars, labels), path, |i| wanted[i])?;
        }
        for pair in self.keep.chunks(2) {
            let (number, path): (usize, &Path) = (pair[0].parse().unwrap_or(1), pair[1].as_ref());
            let mask = white(&sized(loom, path)?, path)?;
            let wanted = |i: usize| mask.samples()[i].then_some(number);
            keep(&mut only, (&loom.loaded.exemplars, labels), path, wanted)?;
        }
        Ok(Some(only))
    }

    /// The picture that each sample of the strokes asks for.
    pub(super) fn wanted(&self, path: &Path, plane: &Plane<2>) -> Result<Vec<Option<usize>>, Failure> {
        let mut unknown: BTreeMap<[u8; 3], usize> = BTreeMap::new();
        let mut wanted = Vec::new();
        for i in 0..plane.domain().len() {
            let rgb = color(plane, i);
            let found = self.color.iter().find(|color| Some(color.rgb) == rgb).map(|color| color.picture);
            if let (None, Some(rgb)) = (found, rgb.filter(|rgb| *rgb != [0; 3])) {
                *unknown.entry(rgb).or_default() += 1;
            }
            wanted.push(found);
        }
        if unknown.is_empty() {
            return Ok(wanted);
        }
        let mut list: Vec<([u8; 3], usize)> = unknown.into_iter().collect();
        list.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let told: Vec<String> =
            list.iter().take(TOLD).map(|(rgb, count)| format!("{} ({count} px)", hex(*rgb))).collect();
        let more = if list.len() <= TOLD { String::new() } else { format!(" and {} more", list.len() - TOLD) };
        let what = format!("{}{more} of its colours stand for no picture", told.join(", "));
        Err(Failure::new(3, what)
            .about(path)
            .remedy("give --color for each, or paint in exact colours without smooth edges"))
    }
}

/// The colour of a sample in 8 bits; none where it is transparent.
fn color(plane: &Plane<2>, i: usize) -> Option<[u8; 3]> {
    let white = plane.samples.depth().full();
    let value = |c: usize| (plane.samples.value(c, i) / white * 255.0 + 0.5).clamp(0.0, 255.0) as u8;
    let colors = plane.color_channels();
    if plane.alpha && value(colors) == 0 {
        return None;
    }
    Some(std::array::from_fn(|c| value(if colors < 3 { 0 } else { c })))
}

/// A picture that has the output's size.
fn sized(loom: &mut Loom<'_>, path: &Path) -> Result<Plane<2>, Failure> {
    let plane = loom.read(&Input::new(loom.session, path)?)?;
    let output = Some(loom.domain.shape);
    check_size(path, plane.domain().shape, output, "the output has", "paint over a picture of that size")?;
    Ok(plane)
}

/// Where a picture is asked for, no other may show, and it has to be there.
pub(super) fn keep<const D: usize>(
    only: &mut Grid<u64, D>,
    (exemplars, labels): (&Exemplars<D>, &[Label<D>]),
    path: &Path,
    wanted: impl Fn(usize) -> Option<usize>,
) -> Result<(), Failure> {
    let domain = only.domain();
    for (i, bits) in only.samples_mut().iter_mut().enumerate() {
        let Some(number) = wanted(i) else { continue };
        let at = domain.position(i);
        let refused = |why: &str, remedy: &str| {
            let what = format!("picture {number} is to show at {}, where {why}", place(&at));
            Err(Failure::new(3, what).about(path).remedy(remedy))
        };
        if !shows(exemplars, &labels[number - 1], at) {
            return refused("it is not or shows nothing", "paint inside of it, or move it with --at");
        }
        if *bits >> (number - 1) & 1 == 0 {
            return refused("another one is to show as well", "let strokes and masks of --keep not overlap");
        }
        *bits = 1 << (number - 1);
    }
    Ok(())
}

/// A place as people write it: across, down, and the frame of a clip, counted from 0.
fn place(at: &[u32]) -> String {
    match *at {
        [y, x] => format!("{x},{y}"),
        [t, y, x] => format!("{x},{y} of frame {t}"),
        _ => format!("{at:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read_as_they_are_written() {
        let color: StrokeColor = "#ffA001=12".parse().unwrap();
        assert_eq!((color.rgb, color.picture, color.to_string().as_str()), ([255, 160, 1], 12, "#ffa001=12"));
        assert!(
            ["", "ffff00=1", "#ffff0=1", "#ffff00", "#gggggg=1", "#ffff00=x"]
                .iter()
                .all(|t| t.parse::<StrokeColor>().is_err())
        );
    }
}
