//! A picture that is gone on from: one more exemplar, of which the holes are filled from the others.

use std::path::{Path, PathBuf};

use selvedge_core::{Domain, Grid, Plane};

use crate::failure::{Failure, shown};
use crate::session::Session;

/// A picture that is one more exemplar, after all others and only as it is, used where its mask is white.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Backdrop<'a> {
    pub(crate) picture: &'a Path,
    pub(crate) mask: Option<&'a Path>,
}

/// Exemplar and picture agree if their samples differ by so much of white on average: one of them may have been a JPEG.
/// Different pictures of one texture differ by ten times as much.
const AGREE: f64 = 0.01;

/// Takes the places of a picture's holes away from exemplars that are the same picture without them: what has to vanish
/// must not come back. The picture and its mask come last.
pub(crate) fn spare_holes(
    session: &Session<'_>,
    paths: &[PathBuf],
    planes: &[Plane<2>],
    masks: &mut [Option<Grid<bool, 2>>],
) -> Result<(), Failure> {
    let (Some((picture, exemplars)), Some((fixed, of_exemplars))) = (planes.split_last(), masks.split_last_mut())
    else {
        return Ok(());
    };
    let shows = picture.validity()?;
    let stands = |i: usize| {
        shows.as_ref().is_none_or(|shows| shows.samples()[i]) && fixed.as_ref().is_none_or(|fixed| fixed.samples()[i])
    };
    let n = picture.domain().len();
    let standing = (0..n).filter(|i| stands(*i)).count();
    for ((plane, mask), path) in exemplars.iter().zip(of_exemplars).zip(paths) {
        let alike = plane.domain() == picture.domain() && plane.color_channels() == picture.color_channels();
        if !alike || standing == 0 || standing == n || AGREE < difference(plane, picture, &stands) {
            continue;
        }
        let usable = |i: usize| mask.as_ref().is_none_or(|mask| mask.samples()[i]);
        let samples: Vec<bool> = (0..n).map(|i| usable(i) && stands(i)).collect();
        *mask = Some(Grid::from_vec(Domain::open(plane.domain().shape), 1, samples)?);
        let picture = shown(&paths[paths.len() - 1]);
        session.say(&format!(
            "'{}' agrees with '{picture}' around its holes: nothing is taken from their places",
            shown(path)
        ));
    }
    Ok(())
}

/// How much colours differ where the picture stands, in parts of white.
fn difference(plane: &Plane<2>, picture: &Plane<2>, stands: &dyn Fn(usize) -> bool) -> f64 {
    let part = |plane: &Plane<2>, c: usize, i: usize| plane.samples.value(c, i) / plane.samples.depth().full();
    let (mut sum, mut count) = (0.0, 0_u64);
    for i in (0..plane.domain().len()).filter(|i| stands(*i)) {
        for c in 0..plane.color_channels() {
            sum += (part(plane, c, i) - part(picture, c, i)).abs();
            count += 1;
        }
    }
    sum / count.max(1) as f64
}

/// What of a set is farther than so many steps along each axis from what is not in it; around the edges of a periodic
/// domain it goes on.
pub(crate) fn eroded(set: &Grid<bool, 2>, steps: u32) -> Result<Grid<bool, 2>, Failure> {
    let domain = set.domain();
    let mut out = set.map(|v| v)?;
    for axis in 0..2 {
        let from = out.map(|v| v)?;
        // Beyond the domain's own length everything was met.
        let reach = steps.min(domain.shape[axis]) as i32;
        for (i, at) in domain.positions().enumerate().filter(|(i, _)| from.samples()[*i]) {
            let gone = (-reach..=reach).any(|by| {
                let by = [0, 1].map(|a| if a == axis { by } else { 0 });
                domain.step(at, by).is_some_and(|other| !from.get(0, other))
            });
            out.samples_mut()[i] = !gone;
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_eroded_around_the_edges_that_repeat() {
        let domain = Domain { shape: [5, 6], periodic: [false, true] };
        let samples: Vec<bool> = domain.positions().map(|at| at != [2, 0]).collect();
        let set = Grid::from_vec(domain, 1, samples).unwrap();
        let near = |[y, x]: [u32; 2], n: u32| y.abs_diff(2) <= n && (x <= n || 6 - n <= x);
        for n in 0..3 {
            let out = eroded(&set, n).unwrap();
            assert!(domain.positions().all(|at| out.get(0, at) != near(at, n)), "{n}");
        }
        assert!(eroded(&set, u32::MAX).unwrap().samples().iter().all(|v| !v));
    }
}
