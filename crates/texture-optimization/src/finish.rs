//! The sharp finish: each sample one of the exemplars instead of an average. (Han, Zhou, Wei, Gong, Bao, Guo 2006; Tong
//! et al. 2002)

use selvedge_core::{Coherence, Domain, Exemplars, Grid, SampleId, Source, SourceMap, par};

use crate::control::Wishes;
use crate::error::Error;
use crate::optimized::{Held, Pulls};
use crate::picture;

/// Samples around one that are compared: windows of five by five hold a detail and its surroundings; larger ones blur
/// joins of detail no less, and take longer.
const RADIUS: u32 = 2;
/// Times that all samples may change. After three hardly any does.
const PASSES: u8 = 3;

/// A map of what `x` is the average of: of the samples that neighborhoods have at a position the one whose surroundings
/// are most like the average's; then passes in which samples may continue their neighbours', compared with what stands
/// there.
///
/// Time `O(samples * candidates * channels)`. Samples of a pass that do not meet are chosen at once, from what stands
/// before.
///
/// What `wishes` know for sure is compared as it is known, whatever the samples have: so a guide is followed.
pub(crate) fn sharp(
    pulls: &Pulls<'_>,
    x: &Grid<f64, 2>,
    held: Option<Held<'_>>,
    wishes: Option<&Wishes>,
) -> Result<SourceMap<2>, Error> {
    let exemplars = pulls.exemplars;
    let domain = pulls.all.domain;
    let mut map = SourceMap::unassigned(exemplars, domain)?;
    let target = Around { exemplars, shown: x };
    let voted = par::map_indexed(domain.len(), |i| {
        let at = domain.position(i);
        let mut offered: Vec<SampleId> = Vec::new();
        pulls.at(at).for_each(|(id, _)| {
            if !offered.contains(&id) {
                offered.push(id);
            }
        });
        target.nearest(at, &offered)
    });
    map.ids.plane_mut(0).iter_mut().zip(voted).for_each(|(id, voted)| *id = voted.unwrap_or(SampleId::UNASSIGNED));
    held.iter().for_each(|held| held.lay(&mut map));
    // When each sample changed last, in phases.
    let mut stamps: Grid<u8, 2> = Grid::try_filled(domain, 1, 0)?;
    let mut shown = picture::shown(exemplars, &map)?;
    for (wishes, at) in wishes.iter().flat_map(|wishes| domain.positions().map(move |at| (wishes, at))) {
        wishes.show(&mut shown, at);
    }
    for number in 0..PASSES {
        if !pass(exemplars, (&mut map, &mut shown), (&mut stamps, number), (held, wishes)) {
            break;
        }
    }
    Ok(map)
}

/// Whether any sample of a map, and of what it shows, changed. A sample is asked once more where something within its
/// surroundings changed since it was asked.
fn pass(
    exemplars: &Exemplars<2>,
    (map, shown): (&mut SourceMap<2>, &mut Grid<f64, 2>),
    (stamps, number): (&mut Grid<u8, 2>, u8),
    (held, wishes): (Option<Held<'_>>, Option<&Wishes>),
) -> bool {
    let domain = map.domain();
    let coherence = Coherence::new(exemplars);
    let mut changed = false;
    for (phase, now) in Domain::open([2, 2]).positions().zip(1 + 4 * number..) {
        let is_settled = |at: [u32; 2]| {
            let before = now.saturating_sub(4);
            let r = RADIUS as i32;
            let mut around = Domain::open([2 * RADIUS + 1; 2]).positions().map(|by| by.map(|b| b as i32 - r));
            before != 0 && around.all(|by| domain.step(at, by).is_none_or(|p| stamps.get(0, p) < before))
        };
        let around = Around { exemplars, shown };
        let [rows, columns] = [0, 1].map(|a| (domain.shape[a].saturating_sub(phase[a])).div_ceil(2));
        let ids = par::map_indexed(rows as usize, |row| {
            let mut offered = Vec::new();
            let at = |column: u32| [2 * row as u32 + phase[0], 2 * column + phase[1]];
            let one = |column: u32| {
                let (at, own) = (at(column), map.ids.get(0, at(column)));
                if held.is_some_and(|held| held.at(at).is_some()) || is_settled(at) {
                    return own;
                }
                coherence.around(map, at, 1, |_| true, &mut offered);
                offered.retain(|&id| id != own);
                if offered.is_empty() {
                    return own;
                }
                offered.insert(0, own);
                around.nearest(at, &offered).unwrap_or(own)
            };
            (0..columns).map(one).collect::<Vec<_>>()
        });
        for (row, ids) in ids.into_iter().enumerate() {
            for (column, id) in ids.into_iter().enumerate() {
                let at = [2 * row as u32 + phase[0], 2 * column as u32 + phase[1]];
                if map.ids.get(0, at) != id {
                    changed = true;
                    stamps.set(0, at, now);
                    map.ids.set(0, at, id);
                    picture::show(shown, exemplars, at, id);
                    wishes.iter().for_each(|wishes| wishes.show(shown, at));
                }
            }
        }
    }
    changed
}

/// A picture, whose surroundings of a position are compared with those of samples.
struct Around<'a> {
    exemplars: &'a Exemplars<2>,
    shown: &'a Grid<f64, 2>,
}

impl Around<'_> {
    /// The sample whose surroundings are most like those of a position; the first of equal ones.
    fn nearest(&self, at: [u32; 2], offered: &[SampleId]) -> Option<SampleId> {
        if let [only] = offered {
            return Some(*only);
        }
        let mut best: Option<(f64, SampleId)> = None;
        for &id in offered {
            let error = self.error(at, id, best.map_or(f64::INFINITY, |b| b.0));
            if best.is_none_or(|b| error < b.0) {
                best = Some((error, id));
            }
        }
        best.map(|b| b.1)
    }

    /// The mean squared difference over the surroundings, as far as picture and source both have them, and no mask
    /// hides them; anything from `limit` on where it is no less.
    fn error(&self, at: [u32; 2], id: SampleId, limit: f64) -> f64 {
        let Some((source, from)) = self.exemplars.locate(id) else { return f64::INFINITY };
        let source = &self.exemplars.sources()[source];
        let has_all = |domain: Domain<2>, at: [u32; 2]| {
            (0..2).all(|axis| RADIUS <= at[axis] && at[axis] + RADIUS < domain.shape[axis])
        };
        if source.valid.is_none() && has_all(self.shown.domain(), at) && has_all(source.domain(), from) {
            return self.error_within(at, (source, from), limit);
        }
        self.error_at_edges(at, (source, from))
    }

    /// The same sum in the same order where both have all of the surroundings, as nearly everywhere.
    fn error_within(&self, at: [u32; 2], (source, from): (&Source<2>, [u32; 2]), limit: f64) -> f64 {
        const SIDE: usize = 2 * RADIUS as usize + 1;
        let first = |domain: Domain<2>, at: [u32; 2], row: u32| domain.index([at[0] - RADIUS + row, at[1] - RADIUS]);
        let mut sum = 0.0;
        for row in 0..SIDE as u32 {
            let (p, q) = (first(self.shown.domain(), at, row), first(source.domain(), from, row));
            for by in 0..SIDE {
                for (c, &w) in self.exemplars.weights().iter().enumerate() {
                    let difference = self.shown.plane(c)[p + by] - f64::from(source.features.plane(c)[q + by]);
                    sum += f64::from(w) * difference * difference;
                }
            }
            if limit <= sum / (SIDE * SIDE) as f64 {
                break;
            }
        }
        sum / (SIDE * SIDE) as f64
    }

    fn error_at_edges(&self, at: [u32; 2], (source, from): (&Source<2>, [u32; 2])) -> f64 {
        let (here, there, r) = (self.shown.domain(), source.domain(), RADIUS as i32);
        let (mut sum, mut n) = (0.0, 0_u32);
        for by in Domain::open([2 * RADIUS + 1; 2]).positions() {
            let by = by.map(|b| b as i32 - r);
            let Some((p, q)) = here.step(at, by).zip(there.step(from, by)) else { continue };
            let (p, q) = (here.index(p), there.index(q));
            if source.valid.as_deref().is_some_and(|valid| !valid.plane(0)[q]) {
                continue;
            }
            n += 1;
            for (c, &w) in self.exemplars.weights().iter().enumerate() {
                let difference = self.shown.plane(c)[p] - f64::from(source.features.plane(c)[q]);
                sum += f64::from(w) * difference * difference;
            }
        }
        sum / f64::from(n)
    }
}
