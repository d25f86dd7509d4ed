//! How much memory a run will need, known from headers alone, and what would fit if it is too much.

use std::path::Path;

use selvedge_core::{Bytes, Depth, Domain, Error, Limits};
use selvedge_io::{Format, Info};

use crate::failure::Failure;

/// The program itself: code, stacks of its threads, small things. About 13 MiB are seen.
pub(crate) const PROGRAM: Bytes = Bytes(18 << 20);

/// Bytes of the samples of a picture or clip.
pub(crate) fn picture<const D: usize>(domain: Domain<D>, channels: usize, depth: Depth) -> Bytes {
    Bytes::of_samples(domain, depth.bytes()) * channels as u64
}

/// An upper bound of what pictures take that are kept: of so many channels, in a depth that each is converted to by
/// itself, once all were read.
pub(crate) fn pictures(infos: &[Info], channels: usize, depth: Depth) -> Bytes {
    let (before, after): (Vec<Bytes>, Vec<Bytes>) = infos
        .iter()
        .map(domain)
        .zip(infos)
        .map(|(domain, info)| (picture(domain, channels, info.depth), picture(domain, channels, depth)))
        .unzip();
    let converted = infos.iter().zip(&after).filter(|(info, _)| info.depth != depth).map(|(_, bytes)| *bytes).max();
    before.into_iter().sum::<Bytes>().max(after.into_iter().sum()) + converted.unwrap_or_default()
}

/// An upper bound of what reading takes beside the picture that is kept.
pub(crate) fn reading<'i>(infos: impl IntoIterator<Item = &'i Info>) -> Bytes {
    infos.into_iter().map(|info| Bytes(info.reading)).max().unwrap_or_default()
}

/// An upper bound of what masks take that are kept: where they are white.
pub(crate) fn masks<'i>(infos: impl IntoIterator<Item = &'i Info>) -> Bytes {
    infos.into_iter().map(|info| Bytes::of_samples(domain(info), 1)).sum()
}

fn domain(info: &Info) -> Domain<2> {
    Domain::open([info.height, info.width])
}

/// An upper bound of what sources take: features and validity.
pub(crate) fn sources<const D: usize>(sources: &[Domain<D>], channels: usize) -> Bytes {
    sources.iter().map(|domain| source(*domain, channels)).sum()
}

/// The same while the largest of them is turned or looked through.
pub(crate) fn making(sources: &[Domain<2>], channels: usize) -> Bytes {
    self::sources(sources, channels) + sources.iter().map(|domain| source(*domain, channels)).max().unwrap_or_default()
}

fn source<const D: usize>(domain: Domain<D>, channels: usize) -> Bytes {
    Bytes::of_samples(domain, channels as u64 + 1)
}

/// Bytes of a source map.
pub(crate) fn places<const D: usize>(domain: Domain<D>) -> Bytes {
    Bytes::of_samples(domain, 4)
}

/// An upper bound of what a map and the picture rendered from it take until they are written: the map, the samples, and
/// both as files.
pub(crate) fn outputs(domain: Domain<2>, (channels, depth): (usize, Depth), format: Format, map_file: bool) -> Bytes {
    let shape = domain.shape;
    // Three whole numbers a sample, as wide as floats.
    let map = if map_file { Format::Exr.encoding(shape, 3, Depth::F32) } else { Bytes(0) };
    places(domain) + picture(domain, channels, depth) + format.encoding(shape, channels, depth) + map
}

/// An upper bound of what an explanation of that height and width takes: as samples, as a file, and while that is made.
pub(crate) fn explained(shape: [u64; 2]) -> Bytes {
    Bytes(3 * 4) * shape[0] * shape[1]
}

/// How a user makes an output smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Resized {
    /// By an option.
    Size,
    /// By another picture to follow.
    Target,
    /// By the picture itself.
    Picture,
    /// By where pictures are laid.
    Places,
}

impl Resized {
    /// What to do about a larger one than may be.
    fn remedy(self) -> &'static str {
        match self {
            Self::Size => "use a smaller --size",
            Self::Target => "use a smaller --target",
            Self::Picture => "use a smaller picture",
            Self::Places => "lay the pictures closer together",
        }
    }

    fn to(self, [height, width]: [u32; 2]) -> String {
        match self {
            Self::Size => format!("--size {width}x{height}"),
            Self::Target => format!("a target of {width}x{height} px"),
            Self::Picture => format!("a picture of {width}x{height} px"),
            Self::Places => format!("places within {width}x{height} px"),
        }
    }
}

/// Refuses outputs over the caps.
pub(crate) fn check_caps(limits: &Limits, domain: Domain<2>, resized: Resized) -> Result<(), Failure> {
    let refused = |e| Failure::from(e).remedy(resized.remedy());
    limits.admit(domain, Bytes(0)).map_err(refused)
}

/// Refuses what exceeds the budget, and says what would fit: the largest output of the same shape, if any; else the
/// exemplar is to blame.
pub(crate) fn check(
    limits: &Limits,
    exemplar: Option<&Path>,
    domain: Domain<2>,
    resized: Resized,
    need: &dyn Fn(Domain<2>) -> Bytes,
) -> Result<Bytes, Failure> {
    let needed = need(domain);
    let Err(refused) = limits.admit(domain, needed) else { return Ok(needed) };
    if let Some(shape) = fitting(limits, domain, need) {
        return Err(exceeded(refused, &resized.to(shape)));
    }
    let failure = exceeded(refused, "a smaller exemplar");
    Err(exemplar.map_or(failure.clone(), |path| failure.about(path)))
}

/// Refuses what exceeds the budget where only the input can be made smaller.
pub(crate) fn check_fixed(limits: &Limits, needed: Bytes) -> Result<(), Failure> {
    limits.afford(needed).map_err(|refused| exceeded(refused, "smaller pictures"))
}

fn exceeded(refused: Error, smaller: &str) -> Failure {
    match refused {
        Error::OverBudget { needed, .. } => {
            let raised = (needed + Bytes(needed.0 / 8)).to_string().replace(' ', "");
            Failure::from(refused).remedy(format!("use {smaller} or --max-memory {raised}"))
        }
        other => other.into(),
    }
}

/// The largest shape of the same proportions, in 1024ths, that fits.
fn fitting(limits: &Limits, domain: Domain<2>, need: &dyn Fn(Domain<2>) -> Bytes) -> Option<[u32; 2]> {
    let scaled = |part: u64| domain.shape.map(|side| ((u64::from(side) * part / 1024) as u32).max(1));
    let fits = |part: u64| {
        let smaller = Domain { shape: scaled(part), ..domain };
        limits.admit(smaller, need(smaller)).is_ok()
    };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_fit_fits() {
        let need = |d: Domain<2>| Bytes(1000) + Bytes::of_samples(d, 10);
        let limits = |memory| Limits { memory, ..Limits::default() };
        let domain = Domain::open([300, 600]);
        assert_eq!(check(&limits(1_801_000), None, domain, Resized::Size, &need), Ok(Bytes(1_801_000)));
        let refused = check(&limits(1_000_000), None, domain, Resized::Size, &need).unwrap_err();
        assert_eq!(refused.exit, 6);
        let size = refused.remedy.unwrap();
        let shape = size.strip_prefix("use --size ").unwrap().split_once(' ').unwrap().0.to_owned();
        let (w, h) = shape.split_once('x').unwrap();
        let (w, h): (u32, u32) = (w.parse().unwrap(), h.parse().unwrap());
        assert!(
            need(Domain::open([h, w])).0 <= 1_000_000 && 1_000_000 < need(Domain::open([h + 1, w + 2])).0,
            "{shape}"
        );
        let refused = check(&limits(900), Some(Path::new("a.png")), domain, Resized::Size, &need).unwrap_err();
        assert_eq!(refused.path.as_deref(), Some("a.png"));
        let of_target = check(&limits(1_000_000), None, domain, Resized::Target, &need).unwrap_err().remedy.unwrap();
        assert!(of_target.starts_with("use a target of ") && !of_target.contains("--size"), "{of_target}");
        assert!(refused.remedy.unwrap().starts_with("use a smaller exemplar"));
    }
}
