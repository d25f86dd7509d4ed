//! Where pictures lie beside each other.

use std::str::FromStr;

use selvedge_core::Domain;
use selvedge_graphcut_textures::labels::{Label, aligned};

use super::Merge;
use crate::failure::Failure;
use crate::loom::Loom;
use crate::wrong::Wrong;

/// Where a picture lies: down and across, or a choice by the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct At(Option<[i32; 2]>);

impl FromStr for At {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let number = |s: &str| s.trim().parse::<i32>().ok().filter(|n| n.unsigned_abs() < 1 << 20);
        let both = || text.split_once(',').and_then(|(x, y)| Some([number(y)?, number(x)?]));
        match text {
            "auto" => Ok(Self(None)),
            _ => both()
                .map(|at| Self(Some(at)))
                .ok_or_else(|| Wrong::new(format!("'{text}' is no place"), "write 220,-8 (across and down), or auto")),
        }
    }
}

impl Merge {
    /// Where a picture is said to lie; the first, and those of which nothing is said, lie at the corner.
    fn at(&self, picture: usize) -> At {
        let typed = picture.checked_sub(1).and_then(|further| self.at.get(further).copied());
        typed.unwrap_or(At(Some([0, 0])))
    }

    /// How far the pictures reach together, at most.
    pub(super) fn extent(&self, sources: &[Domain<2>]) -> Domain<2> {
        // Of a place that is to be found, no more is known than that both pictures lie side by side at most.
        let at = |picture: usize| self.at(picture).0.unwrap_or(sources[0].shape.map(|side| side as i32));
        self.weaving.tiled(extent(sources.iter().enumerate().map(|(i, source)| (at(i), source.shape))).1)
    }

    /// Where each picture lies in the output, which reaches as far as they do.
    pub(super) fn placed(&self, loom: &mut Loom<'_>) -> Result<Vec<Label<2>>, Failure> {
        let (exemplars, simd) = (&loom.loaded.exemplars, loom.session.run::<2>().simd);
        let place = |source: usize| match self.at(source) {
            At(Some(offset)) => Ok(Label { source, offset }),
            At(None) => aligned(exemplars, 0, source, simd)?.ok_or_else(|| {
                let what = "it overlaps the first picture nowhere by an eighth of the smaller of both";
                Failure::new(3, what).about(&loom.loaded.paths[source]).remedy("say where it lies with --at X,Y")
            }),
        };
        let mut labels = (0..exemplars.sources().len()).map(place).collect::<Result<Vec<_>, Failure>>()?;
        let shape = |label: &Label<2>| exemplars.sources()[label.source].domain().shape;
        let (corner, reach) = extent(labels.iter().map(|label| (label.offset, shape(label))));
        labels.iter_mut().for_each(|label| label.offset = [0, 1].map(|axis| label.offset[axis] - corner[axis]));
        loom.domain.shape = reach;
        Ok(labels)
    }
}

/// The least corner of boxes, by their corners and shapes, and how far they reach from it.
fn extent(boxes: impl Iterator<Item = ([i32; 2], [u32; 2])> + Clone) -> ([i32; 2], [u32; 2]) {
    let corner = [0, 1].map(|axis| boxes.clone().map(|(at, _)| at[axis]).min().unwrap_or(0));
    let end = |axis: usize| boxes.clone().map(|(at, shape)| i64::from(at[axis]) + i64::from(shape[axis])).max();
    let reach = |axis: usize| (end(axis).unwrap_or(1) - i64::from(corner[axis])).clamp(1, u32::MAX.into()) as u32;
    (corner, [reach(0), reach(1)])
}
