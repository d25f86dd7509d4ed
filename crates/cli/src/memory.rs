//! How much memory a run will need, known from headers alone, and what would fit if it is too much.

use std::path::Path;

use selvedge_core::{Depth, Domain};
use selvedge_io::Info;

use crate::failure::Failure;

/// The program itself: code, stacks of its threads, small things. About 13 MiB are seen.
const PROGRAM: u64 = 18 << 20;

/// Bytes of a picture's samples.
pub(crate) fn picture(domain: Domain<2>, channels: usize, depth: Depth) -> u64 {
    samples(domain).saturating_mul(channels as u64).saturating_mul(bytes_of(depth))
}

/// Bytes of one sample.
fn bytes_of(depth: Depth) -> u64 {
    match depth {
        Depth::U8 => 1,
        Depth::U16 | Depth::F16 => 2,
        Depth::F32 => 4,
    }
}

fn samples(domain: Domain<2>) -> u64 {
    domain.shape.iter().fold(1, |n, &side| u64::saturating_mul(n, side.into()))
}

/// An upper bound of what exemplars take: each file and its samples twice while it is read, then samples in the depth
/// of the output.
pub(crate) fn exemplars(infos: &[Info], depth: Depth) -> u64 {
    let one = |info: &Info| {
        let domain = Domain::open([info.height, info.width]);
        let as_read = picture(domain, info.channels, info.depth).saturating_mul(3);
        let as_rendered = picture(domain, info.channels.max(4), depth);
        as_read.saturating_add(as_rendered)
    };
    infos.iter().map(one).fold(PROGRAM, u64::saturating_add)
}

/// An upper bound of what sources take: features and validity, twice while they are turned.
pub(crate) fn sources(sources: &[Domain<2>], channels: usize) -> u64 {
    let one = |domain: &Domain<2>| samples(*domain).saturating_mul(2 * channels as u64 + 2);
    sources.iter().map(one).fold(0, u64::saturating_add)
}

/// An upper bound of what resampled sources take while a map is rendered: their samples, in the depth of the output.
pub(crate) fn shown(resampled: &[Domain<2>], channels: usize, depth: Depth) -> u64 {
    resampled.iter().map(|domain| picture(*domain, channels, depth)).fold(0, u64::saturating_add)
}

/// An upper bound of what a map and the picture rendered from it take until they are written: the map, the samples,
/// and twice the size of each as a file that was not compressed.
pub(crate) fn outputs(domain: Domain<2>, channels: usize, depth: Depth, map_file: bool) -> u64 {
    let map = samples(domain).saturating_mul(4 + if map_file { 24 } else { 0 });
    map.saturating_add(picture(domain, channels, depth).saturating_mul(3))
}

/// Of two stages of which the one ends before the other begins: the greater, and some of the other, since not all that
/// is freed is given back.
pub(crate) fn stages(one: u64, other: u64) -> u64 {
    one.max(other).saturating_add(one.min(other) / 4)
}

/// An upper bound of what an explanation of that height and width takes: as samples, as a file, and while that is made.
pub(crate) fn explained(shape: [u64; 2]) -> u64 {
    shape[0].saturating_mul(shape[1]).saturating_mul(3 * 4)
}

/// How a user makes an output smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Resized {
    /// By an option.
    Size,
    /// By another picture to follow.
    Target,
}

impl Resized {
    /// The option that decides.
    pub(crate) fn flag(self) -> &'static str {
        match self {
            Self::Size => "--size",
            Self::Target => "--target",
        }
    }

    fn to(self, [height, width]: [u32; 2]) -> String {
        match self {
            Self::Size => format!("--size {width}x{height}"),
            Self::Target => format!("a target of {width}x{height} px"),
        }
    }
}

/// Refuses what exceeds the budget, and says what would fit: the largest output of the same shape, if any; else the
/// exemplar is to blame.
pub(crate) fn check(
    budget: u64,
    exemplar: Option<&Path>,
    domain: Domain<2>,
    resized: Resized,
    need: &dyn Fn(Domain<2>) -> u64,
) -> Result<u64, Failure> {
    let needed = need(domain);
    if needed <= budget {
        return Ok(needed);
    }
    if let Some(shape) = fitting(budget, domain, need) {
        return Err(exceeded(budget, needed, &resized.to(shape)));
    }
    let failure = exceeded(budget, needed, "a smaller exemplar");
    Err(exemplar.map_or(failure.clone(), |path| failure.about(path)))
}

/// Refuses what exceeds the budget where only the input can be made smaller.
pub(crate) fn check_fixed(budget: u64, needed: u64) -> Result<(), Failure> {
    if needed <= budget { Ok(()) } else { Err(exceeded(budget, needed, "smaller pictures")) }
}

fn exceeded(budget: u64, needed: u64, smaller: &str) -> Failure {
    let what = format!("the run needs about {} of memory, and {} are allowed", human(needed), human(budget));
    let raised = human(needed.saturating_add(needed / 8)).replace(' ', "");
    Failure::new(6, what).remedy(format!("use {smaller} or --max-memory {raised}"))
}

/// The largest shape of the same proportions, in 1024ths, that fits.
fn fitting(budget: u64, domain: Domain<2>, need: &dyn Fn(Domain<2>) -> u64) -> Option<[u32; 2]> {
    let scaled = |part: u64| domain.shape.map(|side| ((u64::from(side) * part / 1024) as u32).max(1));
    let fits = |part: u64| need(Domain { shape: scaled(part), ..domain }) <= budget;
    let (mut yes, mut no) = (0, 1024);
    if !fits(yes) {
        return None;
    }
    while yes + 1 < no {
        let middle = (yes + no) / 2;
        if fits(middle) { yes = middle } else { no = middle }
    }
    Some(scaled(yes))
}

/// An amount of memory as people write it.
pub(crate) fn human(bytes: u64) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while 1024.0 <= value && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    // Upwards, so that what is written suffices when it is typed.
    if unit == 0 || 10.0 <= value {
        format!("{} {}", value.ceil(), units[unit])
    } else {
        format!("{:.1} {}", (value * 10.0).ceil() / 10.0, units[unit])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_read_as_people_write_them() {
        assert_eq!([human(0), human(1023), human(1536)], ["0 B", "1023 B", "1.5 KiB"]);
        assert_eq!([human(100 << 20), human(5 << 30)], ["100 MiB", "5.0 GiB"]);
    }

    #[test]
    fn what_would_fit_fits() {
        let need = |d: Domain<2>| 1000 + samples(d) * 10;
        let domain = Domain::open([300, 600]);
        assert_eq!(check(1_801_000, None, domain, Resized::Size, &need), Ok(1_801_000));
        let refused = check(1_000_000, None, domain, Resized::Size, &need).unwrap_err();
        assert_eq!(refused.exit, 6);
        let size = refused.remedy.unwrap();
        let shape = size.strip_prefix("use --size ").unwrap().split_once(' ').unwrap().0.to_owned();
        let (w, h) = shape.split_once('x').unwrap();
        let (w, h): (u32, u32) = (w.parse().unwrap(), h.parse().unwrap());
        assert!(need(Domain::open([h, w])) <= 1_000_000 && 1_000_000 < need(Domain::open([h + 1, w + 2])), "{shape}");
        let refused = check(900, Some(Path::new("a.png")), domain, Resized::Size, &need).unwrap_err();
        assert_eq!(refused.path.as_deref(), Some("a.png"));
        let of_target = check(1_000_000, None, domain, Resized::Target, &need).unwrap_err().remedy.unwrap();
        assert!(of_target.starts_with("use a target of ") && !of_target.contains("--size"), "{of_target}");
        assert!(refused.remedy.unwrap().starts_with("use a smaller exemplar"));
    }
}
