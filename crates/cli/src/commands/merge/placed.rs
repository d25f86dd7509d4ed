//! Where pictures lie beside each other.

use std::path::Path;
use std::str::FromStr;

use selvedge_core::{Domain, Exemplars};
use selvedge_graphcut_textures::labels::{Label, aligned};

use super::Merge;
use crate::failure::Failure;
use crate::loom::Loom;
use crate::method::Method;
use crate::wrong::Wrong;

/// Where a picture lies: down and across, or a choice by the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct At(pub(super) Option<[i32; 2]>);

impl FromStr for At {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let number = |s: &str| s.trim().parse::<i32>().ok().filter(|n| n.unsigned_abs() < 1 << 20);
        let wrong = || {
            let remedy = "write 220,-8 (across and down, each of less than 1048576), or auto";
            Wrong::new(format!("'{text}' is no place"), remedy)
        };
        let both = || text.split_once(',').and_then(|(x, y)| Some([number(y)?, number(x)?]));
        match text {
            "auto" => Ok(Self(None)),
            _ => both().map(|at| Self(Some(at))).ok_or_else(wrong),
        }
    }
}

impl Merge {
    /// Where a picture is said to lie; the first, and those of which nothing is said, lie at the corner.
    pub(super) fn at(&self, picture: usize) -> At {
        let typed = picture.checked_sub(1).and_then(|further| self.at.get(further).copied());
        typed.unwrap_or(At(Some([0, 0])))
    }

    /// The pictures that lie where they agree with the first.
    pub(super) fn found(&self) -> impl Iterator<Item = usize> {
        self.at.iter().enumerate().filter(|(_, at)| at.0.is_none()).map(|(further, _)| further + 1)
    }

    /// How far the pictures reach together at least: those whose places are to be found lie over the first.
    pub(super) fn extent(&self, sources: &[Domain<2>]) -> Domain<2> {
        let at = |picture: usize| self.at(picture).0.unwrap_or([0, 0]);
        self.weaving.tiled(extent(sources.iter().enumerate().map(|(i, source)| (at(i), source.shape))).1)
    }

    /// Where each picture lies in the output, which reaches as far as they do. Each meets another one.
    pub(super) fn placed(&self, loom: &mut Loom<'_>) -> Result<Vec<Label<2>>, Failure> {
        let (exemplars, simd) = (&loom.loaded.exemplars, loom.session.run::<2>().simd);
        let place = |source: usize| match self.at(source) {
            At(Some(offset)) => Ok(Label { source, offset }),
            At(None) => aligned(exemplars, 0, source, simd)?.ok_or_else(|| nowhere(&loom.loaded.paths[source])),
        };
        let mut labels = (0..exemplars.sources().len()).map(place).collect::<Result<Vec<_>, Failure>>()?;
        let (domains, channels) = (exemplars.domains(), exemplars.channels());
        let reach = arrange(&mut labels, &domains).map_err(|alone| apart(&loom.loaded.paths[alone]))?;
        loom.lay(reach, |domain| self.bytes(&domains, channels, domain)).map_err(|e| {
            let [height, width] = reach;
            let failure = Failure::new(e.exit, format!("together they reach over {width}x{height} px: {}", e.message));
            failure.remedy("lay the pictures closer with --at, or merge smaller ones")
        })?;
        Ok(labels)
    }
}

/// Lays pictures into the least box that holds them all, and says how far it reaches; else which of them lies apart.
pub(super) fn arrange(labels: &mut [Label<2>], domains: &[Domain<2>]) -> Result<[u32; 2], usize> {
    let (corner, reach) = extent(labels.iter().map(|label| (label.offset, domains[label.source].shape)));
    labels.iter_mut().for_each(|label| label.offset = [0, 1].map(|axis| label.offset[axis] - corner[axis]));
    alone(labels, domains).map_or(Ok(reach), Err)
}

/// Says that one agrees with the first nowhere.
pub(super) fn nowhere(path: &Path) -> Failure {
    let what = "it overlaps the first picture nowhere by an eighth of the smaller of both";
    Failure::new(3, what).about(path).remedy("say where it lies with --at X,Y")
}

/// Says that one meets no other.
pub(super) fn apart(path: &Path) -> Failure {
    let what = "it lies apart from the other pictures, and nothing would show between them";
    Failure::new(3, what).about(path).remedy("lay it closer with --at, until it meets another one")
}

/// The first picture that cannot be reached from the first of all over pictures that meet: share a side, or more.
fn alone(labels: &[Label<2>], domains: &[Domain<2>]) -> Option<usize> {
    let bounds = |label: usize, axis: usize| {
        let low = i64::from(labels[label].offset[axis]);
        (low, low + i64::from(domains[labels[label].source].shape[axis]))
    };
    let shared = |a: usize, b: usize, axis: usize| {
        let ((a, a_end), (b, b_end)) = (bounds(a, axis), bounds(b, axis));
        a_end.min(b_end) - a.max(b)
    };
    let meet = |a: usize, b: usize| {
        let shared = [0, 1].map(|axis| shared(a, b, axis));
        shared.iter().all(|&n| 0 <= n) && shared.iter().any(|&n| 0 < n)
    };
    let (mut reached, mut open) = (vec![false; labels.len()], vec![0]);
    reached[0] = true;
    while let Some(from) = open.pop() {
        for (to, reached) in reached.iter_mut().enumerate().filter(|(to, reached)| !**reached && meet(from, *to)) {
            *reached = true;
            open.push(to);
        }
    }
    reached.iter().position(|reached| !reached)
}

/// True if a picture has a sample at a position of the output.
pub(super) fn shows<const D: usize>(exemplars: &Exemplars<D>, label: &Label<D>, at: [u32; D]) -> bool {
    let source = &exemplars.sources()[label.source];
    let from = source.domain().step([0; D], std::array::from_fn(|axis| at[axis] as i32 - label.offset[axis]));
    from.is_some_and(|from| source.valid.as_deref().is_none_or(|valid| valid.get(0, from)))
}

/// How many samples of the output are in no picture. Its format has to hold transparency if there are any.
pub(super) fn bare(loom: &Loom<'_>, labels: &[Label<2>]) -> Result<usize, Failure> {
    let shown = |at: &[u32; 2]| labels.iter().any(|label| shows(&loom.loaded.exemplars, label, *at));
    let bare = loom.domain.positions().filter(|at| !shown(at)).count();
    loom.check_holes(bare)?;
    Ok(bare)
}

/// The least corner of boxes, by their corners and shapes, and how far they reach from it.
pub(super) fn extent(boxes: impl Iterator<Item = ([i32; 2], [u32; 2])> + Clone) -> ([i32; 2], [u32; 2]) {
    let corner = [0, 1].map(|axis| boxes.clone().map(|(at, _)| at[axis]).min().unwrap_or(0));
    let end = |axis: usize| boxes.clone().map(|(at, shape)| i64::from(at[axis]) + i64::from(shape[axis])).max();
    let reach = |axis: usize| (end(axis).unwrap_or(1) - i64::from(corner[axis])).clamp(1, u32::MAX.into()) as u32;
    (corner, [reach(0), reach(1)])
}
