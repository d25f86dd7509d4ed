//! Pictures that tile: closed over themselves along the least seam, or with a border that is filled anew.

use selvedge_core::{
    Domain, Error as CoreError, Exemplars, Grid, Run, SampleId, SeamCosts, SeamMeasure, Source, SourceMap, Start,
    Window, Woven,
};

use crate::error::Error;
use crate::labels::expand::{estimate_labels, expand, expand_by};
use crate::labels::label::Label;
use crate::labels::options::{LabelOptions, LabelStats};

/// Overlaps of a picture with itself are looked for from a sixteenth of its side on, up to a third of it: seams become
/// cheaper and cheaper beyond, and tiles small.
const LEAST: u32 = 16;
const MOST: u32 = 3;
/// Those whose samples agree best are cut, and a fourth of the side: how well seams run is not seen before. A guess:
/// each takes a cut.
const TRIED: usize = 6;
/// Places along each axis at which one period of a picture is cut out: both ends and the middle.
const PLACES: u32 = 3;

/// A picture closed over itself: it is laid beside itself so that `overlap` samples lie over each other along each axis
/// (0: it stays open), and cut along the least seam. Nothing is made up; the output is smaller by the overlap, and goes
/// around. What the picture does not show stays a hole.
///
/// # Errors
/// [`Range`](selvedge_core::Error::Range) for an overlap of 1, or more than half of a side; those of [`expand`].
pub fn close<const D: usize>(
    exemplars: &Exemplars<D>,
    overlap: [u32; D],
    seam: SeamMeasure,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, LabelStats>, Error> {
    close_part(exemplars, &Window::all(exemplars.sources()[0].domain()), overlap, seam, run)
}

/// [`close`], of a part of the picture.
fn close_part<const D: usize>(
    exemplars: &Exemplars<D>,
    part: &Window<D>,
    overlap: [u32; D],
    seam: SeamMeasure,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, LabelStats>, Error> {
    check_overlap(part.shape, overlap)?;
    let labels = copies(part, overlap);
    let output = Domain {
        shape: std::array::from_fn(|a| part.shape[a] - overlap[a]),
        periodic: std::array::from_fn(|a| overlap[a] != 0),
    };
    let options =
        LabelOptions { seam, only: Some(may_show(output, overlap)?), leave_holes: true, ..LabelOptions::default() };
    expand(exemplars, Start::empty(exemplars, output)?, &labels, &options, run)
}

/// The numbers of a picture's copies: bit `a` says that it is moved back along axis `a`.
fn numbers<const D: usize>(overlap: [u32; D]) -> impl Iterator<Item = usize> {
    (0..1 << D).filter(move |number| (0..D).all(|a| overlap[a] != 0 || number >> a & 1 == 0))
}

/// A part of the picture, and that part moved back by its length less the overlap along each axis.
fn copies<const D: usize>(part: &Window<D>, overlap: [u32; D]) -> Vec<Label<D>> {
    let back = |number: usize, a: usize| if number >> a & 1 == 1 { (part.shape[a] - overlap[a]) as i32 } else { 0 };
    let offset = |number| std::array::from_fn(|a| -part.start[a] - back(number, a));
    numbers(overlap).map(|number| Label { source: 0, offset: offset(number) }).collect()
}

/// By position, the copies that may show: the first sample is the one after the last, and where the overlap ends the
/// picture goes on by itself.
fn may_show<const D: usize>(output: Domain<D>, overlap: [u32; D]) -> Result<Grid<u64, D>, Error> {
    let mut only = Grid::try_filled(output, 1, 0_u64)?;
    for (bits, at) in only.samples_mut().iter_mut().zip(output.positions()) {
        let may = |number: usize, a: usize| match at[a] {
            _ if overlap[a] == 0 => true,
            0 => number >> a & 1 == 1,
            p if overlap[a] - 1 <= p => number >> a & 1 == 0,
            _ => true,
        };
        let shows = |&(_, number): &(usize, usize)| (0..D).all(|a| may(number, a));
        *bits = numbers(overlap).enumerate().filter(shows).fold(0, |bits, (i, _)| bits | 1 << i);
    }
    Ok(only)
}

/// The price of the seam by which a picture is [closed](close) along one axis: that of the overlap alone, for nothing
/// else of the picture has a seam.
fn price_along<const D: usize>(
    exemplars: &Exemplars<D>,
    costs: &SeamCosts<D>,
    axis: usize,
    overlap: u32,
    run: &Run<'_, D>,
) -> Result<i64, Error> {
    let all = Window::all(exemplars.sources()[0].domain());
    let along = |n: u32| std::array::from_fn(|a| if a == axis { n } else { 0 });
    let mut shape = all.shape;
    shape[axis] = overlap;
    let output = Domain::open(shape);
    let only = Some(may_show(output, along(overlap))?);
    let options = LabelOptions { only, leave_holes: true, ..LabelOptions::default() };
    let start = Start::empty(exemplars, output)?;
    let woven = expand_by(exemplars, costs, start, &copies(&all, along(overlap)), &options, run)?;
    Ok(woven.stats.energy.last().copied().unwrap_or(0))
}

/// A part of a picture of a length along each axis at which it comes again, closed over itself as by [`close`]; along
/// axes without one it has all of the picture, and stays open. Of some places evenly over the picture it is that of the
/// cheapest seam.
///
/// # Errors
/// [`Range`](selvedge_core::Error::Range) for a length of less than 2, or one that leaves nothing to overlap; those of
/// [`expand`].
pub fn close_period<const D: usize>(
    exemplars: &Exemplars<D>,
    period: [Option<u32>; D],
    seam: SeamMeasure,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, LabelStats>, Error> {
    let side = exemplars.sources()[0].domain().shape;
    let fits = |a: usize| period[a].is_none_or(|n| 2 <= n && n.saturating_add(2) <= side[a]);
    if let Some(axis) = (0..D).find(|&a| !fits(a)) {
        let found = period[axis].unwrap_or(0);
        return Err(CoreError::range("period", found, "at least 2, and 2 less than the side").into());
    }
    // No more lies over itself than the tile has.
    let shape = std::array::from_fn(|a| period[a].map_or(side[a], |n| side[a].min(n.saturating_mul(2))));
    let overlap = std::array::from_fn(|a| period[a].map_or(0, |n| shape[a] - n));
    let places = Domain::<D>::open(std::array::from_fn(|a| if shape[a] < side[a] { PLACES } else { 1 }));
    let mut best: Option<Woven<SourceMap<D>, LabelStats>> = None;
    for place in places.positions() {
        let start = |a: usize| ((side[a] - shape[a]) * place[a] / (PLACES - 1)) as i32;
        let woven = close_part(exemplars, &Window { start: std::array::from_fn(start), shape }, overlap, seam, run)?;
        let price = |woven: &Woven<SourceMap<D>, LabelStats>| (woven.stats.holes, woven.stats.energy.last().copied());
        if !woven.complete || best.as_ref().is_none_or(|best| price(&woven) < price(best)) {
            let complete = woven.complete;
            best = Some(woven);
            if !complete {
                break;
            }
        }
    }
    best.ok_or_else(|| CoreError::EmptyOutput { shape: side.to_vec() }.into())
}

/// Refuses overlaps over which a picture of a shape cannot be [closed](close).
///
/// # Errors
/// [`Range`](selvedge_core::Error::Range) for an overlap of 1, or more than half of a side.
pub fn check_overlap<const D: usize>(side: [u32; D], overlap: [u32; D]) -> Result<(), Error> {
    match (0..D).find(|&a| overlap[a] != 0 && !(2..=side[a] / 2).contains(&overlap[a])) {
        Some(axis) => {
            Err(CoreError::range("overlap", overlap[axis], "at least 2, and at most half of the side").into())
        }
        None => Ok(()),
    }
}

/// The overlap of the cheapest seam along each axis asked for.
///
/// # Errors
/// [`Range`](selvedge_core::Error::Range) for sides of less than 4, and those of [`close`].
pub fn overlaps<const D: usize>(
    exemplars: &Exemplars<D>,
    axes: [bool; D],
    seam: SeamMeasure,
    run: &Run<'_, D>,
) -> Result<[u32; D], Error> {
    let side = exemplars.sources()[0].domain().shape;
    let domains = exemplars.domains();
    run.limits.admit(domains[0], estimate_labels(&domains, exemplars.channels(), domains[0]))?;
    let costs = SeamCosts::new(exemplars, seam)?;
    let mut best = [0; D];
    for axis in (0..D).filter(|&a| axes[a]) {
        if side[axis] < 4 {
            return Err(CoreError::range("side", side[axis], "a picture of 4 or more a side").into());
        }
        let mut least = None;
        for n in tried(&exemplars.sources()[0], axis) {
            let found = (price_along(exemplars, &costs, axis, n, run)?, n);
            least = Some(least.map_or(found, |least: (i64, u32)| least.min(found)));
        }
        best[axis] = least.map_or(side[axis] / 4, |(_, n)| n);
    }
    Ok(best)
}

/// Overlaps along an axis at which a picture agrees with itself better than beside them, the best first; and a fourth
/// of its side.
fn tried<const D: usize>(source: &Source<D>, axis: usize) -> Vec<u32> {
    let (domain, side) = (source.domain(), source.domain().shape[axis]);
    let (first, last) = ((side / LEAST).max(2), (side / MOST).max(2));
    let means: Vec<f64> = (first..=last).map(|n| disagreement(source, axis, n)).collect();
    let beside = |i: usize, by: isize| i.checked_add_signed(by).and_then(|j| means.get(j)).copied();
    let peak = |i: &usize| [-1, 1].iter().all(|&by| beside(*i, by).is_none_or(|other| means[*i] <= other));
    let mut found: Vec<usize> = (0..means.len()).filter(peak).collect();
    found.sort_by(|&a, &b| means[a].total_cmp(&means[b]));
    debug_assert!(!domain.is_empty());
    let mut tried: Vec<u32> = found.into_iter().take(TRIED).map(|i| first + i as u32).collect();
    tried.push((side / 4).max(first));
    tried
}

/// Mean squared difference of a picture and itself where the last samples along an axis lie over the first.
fn disagreement<const D: usize>(source: &Source<D>, axis: usize, overlap: u32) -> f64 {
    let (domain, features) = (source.domain(), &source.features);
    let stride = domain.strides()[axis];
    let (side, by) = (domain.shape[axis] as usize, (domain.shape[axis] - overlap) as usize * stride);
    let (mut sum, mut count) = (0_u64, 0);
    for c in 0..features.channels() {
        for block in features.plane(c).chunks_exact(side * stride) {
            let ahead = &block[by..];
            // So few squares of bytes fit into 32 bits.
            for (a, b) in block[..ahead.len()].chunks(1 << 16).zip(ahead.chunks(1 << 16)) {
                let squares = a.iter().zip(b).map(|(&a, &b)| u32::from(a.abs_diff(b)).pow(2));
                sum += u64::from(squares.sum::<u32>());
            }
            count += ahead.len();
        }
    }
    sum as f64 / count.max(1) as f64
}

/// Refuses borders that leave nothing of a picture of a shape.
///
/// # Errors
/// [`Range`](selvedge_core::Error::Range).
pub fn check_band<const D: usize>(side: [u32; D], width: [u32; D]) -> Result<(), Error> {
    match (0..D).find(|&a| side[a] <= width[a].saturating_mul(2)) {
        Some(axis) => Err(CoreError::range("band", width[axis], "less than half of the side").into()),
        None => Ok(()),
    }
}

/// A picture whose border is a hole: all but `width` samples on both sides of each axis stays, and what is there goes
/// around those axes. The exemplars are those that the hole may be filled from.
///
/// # Errors
/// [`Range`](selvedge_core::Error::Range) unless something stays, and too little memory.
pub fn banded<const D: usize>(exemplars: &Exemplars<D>, width: [u32; D]) -> Result<(Exemplars<D>, Start<D>), Error> {
    let first = &exemplars.sources()[0];
    let side = first.domain().shape;
    check_band(side, width)?;
    let output = Domain { shape: side, periodic: std::array::from_fn(|a| 0 < width[a]) };
    let stays = |at: [u32; D]| (0..D).all(|a| (width[a]..side[a] - width[a]).contains(&at[a]));
    let fixed: Vec<bool> = output.positions().map(stays).collect();
    let valid = fixed.iter().enumerate().map(|(i, &f)| f && first.valid.as_deref().is_none_or(|v| v.samples()[i]));
    let valid = Grid::from_vec(first.domain(), 1, valid.collect())?;
    let mut sources: Vec<Source<D>> = exemplars.sources().iter().map(|source| (**source).clone()).collect();
    sources[0].valid = Some(valid.into());
    let exemplars = Exemplars::from_sources(sources, exemplars.weights().to_vec())?;
    let mut map = SourceMap::unassigned(&exemplars, output)?;
    for (i, id) in map.ids.plane_mut(0).iter_mut().enumerate().filter(|(i, _)| fixed[*i]) {
        *id = SampleId::new(i as u32);
    }
    Ok((exemplars, Start { map, fixed: Some(Grid::from_vec(output, 1, fixed)?), sources: None }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Origin, Seed, Transform};

    /// Noise that repeats itself after `period` columns.
    fn repeating(shape: [u32; 2], period: u32) -> Exemplars<2> {
        let mut rng = Seed(8).rng();
        let domain = Domain::open(shape);
        let cell: Vec<u8> = (0..shape[0] * period).map(|_| rng.below(256) as u8).collect();
        let value = |[y, x]: [u32; 2]| cell[(y * period + x % period) as usize];
        let features = Grid::from_vec(domain, 1, domain.positions().map(value).collect()).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap()
    }

    #[test]
    fn what_repeats_itself_closes_without_a_seam() {
        let e = repeating([20, 40], 11);
        let run = Run::seeded(0);
        let overlap = overlaps(&e, [false, true], SeamMeasure::Difference, &run).unwrap();
        assert_eq!((40 - overlap[1]) % 11, 0, "{overlap:?}");
        let woven = close(&e, overlap, SeamMeasure::Difference, &run).unwrap();
        assert_eq!(woven.stats.energy.last(), Some(&0));
        assert_eq!(woven.result.domain(), Domain { shape: [20, 40 - overlap[1]], periodic: [false, true] });
    }

    /// The least seam between the two copies, by a path for each row that may move by one: cuts are at most as dear.
    #[test]
    fn seams_are_no_dearer_than_a_straight_one_and_all_there_is() {
        let e = repeating([18, 30], 30);
        for (overlap, seam) in [([0, 8], SeamMeasure::Difference), ([6, 7], SeamMeasure::Gradient)] {
            let woven = close(&e, overlap, seam, &Run::seeded(0)).unwrap();
            let costs = SeamCosts::new(&e, seam).unwrap();
            assert_eq!(woven.stats.energy.last(), Some(&costs.total(&woven.result)));
            if overlap[0] != 0 {
                continue;
            }
            let alone = price_along(&e, &costs, 1, overlap[1], &Run::seeded(0)).unwrap();
            assert_eq!(woven.stats.energy.last(), Some(&alone), "an overlap by itself");
            for at in 1..overlap[1] - 1 {
                // Left of the column the end of the picture shows, from it on its beginning.
                let mut straight = woven.result.clone();
                let domain = straight.domain();
                for (i, [y, x]) in domain.positions().enumerate() {
                    let from = if x < at { x + domain.shape[1] } else { x };
                    straight.ids.plane_mut(0)[i] = e.table().id(0, [y, from]);
                }
                assert!(costs.total(&woven.result) <= costs.total(&straight), "column {at}");
            }
        }
    }

    #[test]
    fn what_a_picture_does_not_show_stays_a_hole() {
        let whole = repeating([24, 40], 10);
        let mut source = (*whole.sources()[0]).clone();
        let valid = source.domain().positions().map(|[y, x]| 2 < y || 3 < x).collect();
        source.valid = Some(Grid::from_vec(source.domain(), 1, valid).unwrap().into());
        let e = Exemplars::from_sources(vec![source], vec![1]).unwrap();
        let woven = close(&e, [6, 10], SeamMeasure::Difference, &Run::seeded(0)).unwrap();
        let holes = woven.result.holes();
        assert!(woven.complete && holes == woven.stats.holes && holes <= 12, "{holes}");
    }

    #[test]
    fn one_period_is_cut_out_and_closes() {
        let e = repeating([20, 60], 11);
        let woven = close_period(&e, [None, Some(11)], SeamMeasure::Difference, &Run::seeded(0)).unwrap();
        assert_eq!(woven.result.domain(), Domain { shape: [20, 11], periodic: [false, true] });
        assert_eq!((woven.stats.energy.last(), woven.stats.holes), (Some(&0), 0));
        let features = &e.sources()[0].features;
        let value = |at: [u32; 2]| features.get(0, woven.result.locate(at).unwrap().1);
        // Two rolls of a tile are the same tile: it is the period from somewhere on.
        let turn =
            (0..11).find(|t| (0..11).all(|x| (0..20).all(|y| value([y, x]) == features.get(0, [y, (x + t) % 11]))));
        assert!(turn.is_some());
        for period in [0, 1, 59, 60, u32::MAX] {
            let refused = close_period(&e, [None, Some(period)], SeamMeasure::Difference, &Run::seeded(0));
            assert!(matches!(refused, Err(Error::Core(CoreError::Range { .. }))), "{period}");
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        let e = repeating([8, 20], 5);
        let run = Run::seeded(0);
        for overlap in [[0, 1], [0, 11], [5, 0]] {
            assert!(matches!(
                close(&e, overlap, SeamMeasure::Difference, &run),
                Err(Error::Core(CoreError::Range { .. }))
            ));
        }
        assert!(matches!(banded(&e, [4, 0]), Err(Error::Core(CoreError::Range { .. }))));
        let (_, start) = banded(&e, [2, 3]).unwrap();
        assert_eq!((start.map.holes(), start.map.domain().periodic), (8 * 20 - 4 * 14, [true, true]));
        assert!(matches!(
            overlaps(&repeating([3, 9], 2), [true, false], SeamMeasure::Difference, &run),
            Err(Error::Core(CoreError::Range { .. }))
        ));
    }
}
