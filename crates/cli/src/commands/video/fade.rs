//! The cross-fade that a seam is to be compared with: the loop of a jump, of which the last frames become those before
//! it.

use selvedge_core::{Domain, Grid, Plane, Samples};
use selvedge_graphcut_textures::video::Jump;

use crate::failure::Failure;

/// The loop of a jump, faded over so many frames, or as many as there are on either side of it, and how many it were.
pub(super) fn faded(clip: &Plane<3>, jump: &Jump, frames: u32) -> Result<(Plane<3>, u32), Failure> {
    let last = clip.domain().shape[0] - 1 - jump.from;
    let frames = frames.min(jump.period());
    // The end fades into what comes before the begin, or the begin out of what comes after the end, where more is
    // there.
    let (at, by, count) = if last < jump.to.min(frames) || frames <= jump.to {
        (jump.period() - frames.min(jump.to), -(i64::from(jump.period())), frames.min(jump.to))
    } else {
        (0, i64::from(jump.period()), frames.min(last))
    };
    let plan: Vec<Mix> = (0..jump.period())
        .map(|t| {
            let own = jump.to + t;
            let other = (i64::from(own) + by).max(0) as u32;
            let share = if (at..at + count).contains(&t) { t - at + 1 } else { 0 };
            // Of the end more and more is the other one, of the begin less and less.
            let share = if 0 < share && 0 < by { count + 1 - share } else { share };
            Mix { own, other: if share == 0 { own } else { other }, share, of: count + 1 }
        })
        .collect();
    let samples = match &clip.samples {
        Samples::U8(grid) => Samples::U8(mixed(grid, &plan, |a, b, s, n| mean(a.into(), b.into(), s, n) as u8)?),
        Samples::U16(grid) => Samples::U16(mixed(grid, &plan, |a, b, s, n| mean(a.into(), b.into(), s, n) as u16)?),
        Samples::F32(grid) => {
            let mean = |a: f32, b: f32, s, n| if s == 0 { a } else { a + (b - a) * (s as f32 / n as f32) };
            Samples::F32(mixed(grid, &plan, mean)?)
        }
        Samples::F16(_) => {
            let failure = Failure::new(3, "half samples are not faded");
            return Err(failure.remedy("convert the clip to float"));
        }
    };
    Ok((Plane { role: clip.role, samples, alpha: clip.alpha, association: clip.association }, count))
}

/// A frame: so many parts of `of` are the other one.
struct Mix {
    own: u32,
    other: u32,
    share: u32,
    of: u32,
}

fn mean(a: u64, b: u64, share: u32, of: u32) -> u64 {
    let (share, of) = (u64::from(share), u64::from(of));
    (a * (of - share) + b * share + of / 2) / of
}

fn mixed<T: Copy + Default>(
    clip: &Grid<T, 3>,
    plan: &[Mix],
    mean: impl Fn(T, T, u32, u32) -> T,
) -> Result<Grid<T, 3>, Failure> {
    let [_, height, width] = clip.domain().shape;
    let mut out = Grid::try_filled(Domain::open([plan.len() as u32, height, width]), clip.channels(), T::default())?;
    let n = (height * width) as usize;
    for c in 0..clip.channels() {
        let frame = |t: u32| &clip.plane(c)[t as usize * n..][..n];
        for (to, mix) in out.plane_mut(c).chunks_mut(n).zip(plan) {
            let both = frame(mix.own).iter().zip(frame(mix.other));
            to.iter_mut().zip(both).for_each(|(to, (a, b))| *to = mean(*a, *b, mix.share, mix.of));
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use selvedge_core::Role;

    use super::*;

    fn faded_values(from: u32, to: u32, frames: u32) -> Vec<u8> {
        let grid = Grid::from_vec(Domain::open([10, 1, 1]), 1, (0..10).map(|t| t * 20).collect()).unwrap();
        let clip = Plane::new(Role::Color, Samples::U8(grid));
        let (out, _) = faded(&clip, &Jump { from, to, error: 0.0 }, frames).unwrap();
        let Samples::U8(grid) = out.samples else { unreachable!() };
        grid.samples().to_vec()
    }

    #[test]
    fn the_end_becomes_what_comes_before_the_begin() {
        // Frames 3 to 8; the last two become 1 and 2, by thirds.
        assert_eq!(faded_values(8, 3, 2), [60, 80, 100, 120, 100, 80]);
        // Nothing comes before frame 0: the begin was what comes after the end.
        assert_eq!(faded_values(5, 0, 2), [80, 60, 40, 60, 80, 100]);
        assert_eq!(faded_values(9, 0, 4), (0..10).map(|t| t * 20).collect::<Vec<u8>>(), "there is nothing to fade");
    }
}
