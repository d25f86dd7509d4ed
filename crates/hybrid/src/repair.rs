//! Repair: bad seams of any map, whoever made it, chosen anew sample by sample. (Nealen and Alexa 2004)

use std::collections::BTreeMap;

use selvedge_core::{
    Error as CoreError, Event, Exemplars, Grid, Run, SampleId, SeamCosts, SeamMeasure, SourceMap, Start, Woven,
    collected, par, reserve, try_vec,
};

use crate::canvas::Canvas;
use crate::changes::Changes;
use crate::composite::{beside, seam_limit};
use crate::error::Error;
use crate::estimate::estimate_repair;
use crate::options::{PixelSearch, Threshold};
use crate::pixel::{PixelScratch, Pixels};
use crate::plan::around;
use crate::site::{GROWN, Site};
use crate::stats::Stats;
use crate::thresholds::{Limit, Of};

/// Options of [`repair`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RepairOptions {
    /// A seam is bad if its price exceeds that of two samples of this error. Default: [`Threshold::Auto`].
    pub pixel_error: Threshold,
    /// How far around bad seams samples are chosen anew, from 1 to 64.
    pub radius: u32,
    /// Passes over the map at most; it ends sooner where nothing becomes better. At least 1.
    pub passes: u32,
    /// Which samples are tried.
    pub search: PixelSearch,
    /// Exemplars go on around their borders, as for [`Options::circular`](crate::Options): what continues there is no
    /// seam.
    pub circular: bool,
}

/// A region is tried as it is, larger by so much, and larger once more: more room for a transition. What none of them
/// makes better is left alone.
const LARGER: u32 = GROWN / 2;
/// Regions that are tried beside each other: enough that all threads have work, and few enough that hardly one lies
/// beside another that is changed.
const TOGETHER: usize = 64;

impl Default for RepairOptions {
    fn default() -> Self {
        Self { pixel_error: Threshold::Auto, radius: 2, passes: 4, search: PixelSearch::Coherent, circular: false }
    }
}

impl RepairOptions {
    /// Checks what can be checked without a map.
    ///
    /// # Errors
    /// [`Range`](selvedge_core::Error::Range).
    pub fn validate(&self) -> Result<(), Error> {
        self.pixel_error.check("pixel_error")?;
        CoreError::within("radius", self.radius, 1.0..=64.0, "1 to 64")?;
        if self.passes == 0 { Err(CoreError::range("passes", 0.0, "at least 1").into()) } else { Ok(()) }
    }
}

/// Counts of a repair.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RepairStats {
    /// Price of all seams ([`SeamMeasure::Difference`]), before and after each pass; it never rises.
    pub costs: Vec<i64>,
    /// Bad seams before and after, between neighbours.
    pub bad: [u64; 2],
    /// Regions around bad seams that were chosen anew, and those of them that became better.
    pub regions: [u64; 2],
    /// Samples that differ from what was there.
    pub pixels: u64,
}

/// Chooses samples around bad seams of a map anew, region by region, from what is known around inwards. What makes the
/// region's seams no cheaper in sum, or dearer by [`SeamMeasure::Gradient`], is undone: neither price of all seams ever
/// rises, and a map without bad seams stays as it is. Fixed samples and holes stay.
///
/// The second price is the one that agrees with eyes: seams that are spread over many small ones are cheaper in sum,
/// and lie where nothing hides them.
///
/// # Errors
/// Wrong options ([`RepairOptions::validate`]), those of [`Start::check`], one over the run's limits, no memory.
///
/// # Complexity
/// Time `O(n log(n))` for `n` samples around bad seams and in the boxes around them, and `O(output)` a pass. Space
/// `O(output + c * n)`.
///
/// # Events
/// `"repair"` after each pass, with the price of all seams and the map so far.
///
/// # Determinism
/// The map follows from exemplars, start and options alone; nothing is drawn.
pub fn repair(
    exemplars: &Exemplars<2>,
    mut start: Start<2>,
    options: &RepairOptions,
    run: &Run<'_, 2>,
) -> Result<Woven<SourceMap<2>, RepairStats>, Error> {
    options.validate()?;
    let domains = exemplars.domains();
    let needed = estimate_repair(&domains, exemplars.channels(), start.map.domain(), options.circular);
    run.limits.admit(start.map.domain(), needed)?;
    start.check(exemplars)?;
    let going_on = if options.circular { Some(around(exemplars)?) } else { None };
    let exemplars = going_on.as_ref().unwrap_or(exemplars);
    // Samples of sources that may not be used at all places stay, but are chosen nowhere else.
    let allowed = everywhere(exemplars, start.sources.take().as_ref());
    let mut mender = Mender::new(exemplars, allowed, start, options)?;
    let before: Vec<SampleId> = collected(mender.canvas.map.ids.plane(0).iter().copied())?;
    let complete = mender.mend(options.passes, run)?;
    let Mender { canvas, mut stats, .. } = mender;
    stats.pixels = before.iter().zip(canvas.map.ids.plane(0)).filter(|(a, b)| a != b).count() as u64;
    Ok(Woven { result: canvas.map, stats, complete })
}

/// By source, whether a field (see [`Start::sources`]) allows it everywhere.
fn everywhere(exemplars: &Exemplars<2>, field: Option<&Grid<u64, 2>>) -> Vec<bool> {
    let bits = field.map_or(u64::MAX, |field| field.plane(0).iter().fold(u64::MAX, |all, bits| all & bits));
    (0..exemplars.sources().len()).map(|s| field.is_none() || bits >> s & 1 == 1).collect()
}

/// A map that is mended.
struct Mender<'a> {
    canvas: Canvas,
    pixels: Pixels<'a>,
    /// By thread.
    scratches: Vec<PixelScratch>,
    costs: SeamCosts<2>,
    /// What else must not become dearer.
    gradients: SeamCosts<2>,
    /// A seam that costs more is bad.
    limit: i64,
    /// By place, whether the seam after it is bad, along each axis.
    bad: Vec<[bool; 2]>,
    radius: u32,
    changes: Changes,
    stats: RepairStats,
}

/// Places near bad seams that touch, in the order of the map's buffer.
type Region = Vec<usize>;

/// Regions that were tried in vain, each after which change.
type Vain = BTreeMap<Region, u32>;

/// What makes a region's seams cheaper.
struct Mend {
    places: Region,
    ids: Vec<SampleId>,
    gain: i64,
}

impl<'a> Mender<'a> {
    fn new(
        exemplars: &'a Exemplars<2>,
        allowed: Vec<bool>,
        start: Start<2>,
        options: &RepairOptions,
    ) -> Result<Self, Error> {
        let domain = start.map.domain();
        Ok(Self {
            canvas: Canvas::new(start)?,
            pixels: Pixels::new(exemplars, allowed, options.search, None)?,
            scratches: (0..par::threads()).map(|_| PixelScratch::default()).collect(),
            costs: SeamCosts::new(exemplars, SeamMeasure::Difference)?,
            gradients: SeamCosts::new(exemplars, SeamMeasure::Gradient)?,
            limit: seam_limit(&Limit::of(options.pixel_error, Of::Pixel, exemplars)),
            bad: try_vec(domain.len(), [false; 2])?,
            radius: options.radius,
            changes: Changes::new(domain)?,
            stats: RepairStats::default(),
        })
    }

    /// Pass after pass; false if the run was cancelled.
    fn mend(&mut self, passes: u32, run: &Run<'_, 2>) -> Result<bool, Error> {
        let mut total = self.costs.total(&self.canvas.map);
        for place in 0..self.bad.len() {
            self.judge(place);
        }
        self.stats.bad[0] = self.stats.bad[1];
        self.stats.costs.push(total);
        let mut vain = Vain::new();
        for pass in 0..passes {
            let Some(gain) = self.pass(&mut vain, run)? else { return Ok(false) };
            total -= gain;
            self.stats.costs.push(total);
            let step = Event::step("repair", u64::from(pass) + 1, passes.into());
            run.observer.event(&Event { energy: Some(total), so_far: Some(&self.canvas.map), ..step });
            if gain == 0 {
                break;
            }
        }
        Ok(true)
    }

    /// Notes whether the seams after a place are bad.
    fn judge(&mut self, place: usize) {
        let at = self.canvas.domain().position(place);
        let bad = [0, 1].map(|axis| self.limit < i64::from(self.costs.at(&self.canvas.map, at, axis)));
        let count = |bad: [bool; 2]| bad.into_iter().filter(|&is| is).count() as u64;
        self.stats.bad[1] = self.stats.bad[1] + count(bad) - count(self.bad[place]);
        self.bad[place] = bad;
    }

    /// Region after region, and by how much seams became cheaper; `None` if the run was cancelled.
    fn pass(&mut self, vain: &mut Vain, run: &Run<'_, 2>) -> Result<Option<i64>, Error> {
        let (before, mut gain) = (std::mem::take(vain), 0);
        for some in self.regions()?.chunks(TOGETHER) {
            if run.observer.cancelled() {
                return Ok(None);
            }
            gain += self.try_together(some, &before, vain)?;
        }
        Ok(Some(gain))
    }

    /// Tries some regions beside each other, and those again near which another one changed the map meanwhile: as if
    /// they had been tried one after the other.
    fn try_together(&mut self, regions: &[Region], before: &Vain, vain: &mut Vain) -> Result<i64, Error> {
        let mut scratches = std::mem::take(&mut self.scratches);
        let start = self.changes.now();
        let tried = par::map_with(&mut scratches, regions.len(), |scratch, i| {
            let region = &regions[i];
            let known = before.get(region).filter(|&&since| self.changes.none_near(region, since));
            known.map_or_else(|| Some(self.attempt(region, scratch)), |_| None)
        });
        let mut gain = 0;
        for (region, tried) in regions.iter().zip(tried) {
            let tried = match tried {
                _ if !self.changes.none_near(region, start) => self.attempt(region, &mut scratches[0])?,
                Some(tried) => tried?,
                None => {
                    vain.insert(region.clone(), before[region]);
                    continue;
                }
            };
            self.stats.regions[0] += 1;
            match tried {
                Some(mend) => gain += self.accept(mend),
                None => drop(vain.insert(region.clone(), self.changes.now())),
            }
        }
        self.scratches = scratches;
        Ok(gain)
    }

    fn accept(&mut self, mend: Mend) -> i64 {
        self.stats.regions[1] += 1;
        mend.places.iter().zip(&mend.ids).for_each(|(&place, &id)| self.canvas.set(place, id, Stats::CHOSEN));
        self.changes.note(&mend.places);
        let domain = self.canvas.domain();
        for &place in &mend.places {
            let at = domain.position(place);
            for by in [[0, 0], [-1, 0], [0, -1]] {
                domain.step(at, by).into_iter().for_each(|at| self.judge(domain.index(at)));
            }
        }
        mend.gain
    }

    /// The places near bad seams, those that touch together.
    fn regions(&self) -> Result<Vec<Region>, Error> {
        let domain = self.canvas.domain();
        let mut near = try_vec(domain.len(), false)?;
        let mut places = Vec::new();
        let seams = self.bad.iter().enumerate().flat_map(|(place, &bad)| [(place, 0), (place, 1)].into_iter().zip(bad));
        for ((place, axis), _) in seams.filter(|&(_, is_bad)| is_bad) {
            places.clear();
            beside(&self.canvas, domain.position(place), axis, self.radius, &mut places);
            places.iter().filter(|&&place| !self.canvas.is_fixed(place)).for_each(|&place| near[place] = true);
        }
        let mut regions = Vec::new();
        for first in 0..near.len() {
            if !std::mem::take(&mut near[first]) {
                continue;
            }
            let (mut region, mut next) = (vec![first], 0);
            while next < region.len() {
                let at = domain.position(region[next]);
                next += 1;
                for i in 0..9 {
                    let Some(to) = domain.step(at, [i / 3 - 1, i % 3 - 1]).map(|to| domain.index(to)) else { continue };
                    if std::mem::take(&mut near[to]) {
                        reserve(&mut region, 1)?;
                        region.push(to);
                    }
                }
            }
            region.sort_unstable();
            regions.push(region);
        }
        Ok(regions)
    }

    /// Chooses a region anew, and a larger one where that makes nothing better; `None` if none of them does.
    fn attempt(&self, region: &[usize], scratch: &mut PixelScratch) -> Result<Option<Mend>, Error> {
        let measures = [&self.costs, &self.gradients];
        let mut site = Site::new(&self.canvas, region)?;
        let mut region = site.here(region)?;
        for larger in [0, LARGER.min(self.radius), LARGER] {
            if 0 < larger {
                region = site.grown(&region, larger)?;
            }
            let (before, ids) = (site.prices(&region, measures), site.ids(&region)?);
            region.iter().for_each(|&place| site.canvas.wait(place));
            self.pixels.resynthesize(&mut site.canvas, &region, scratch)?;
            let after = site.prices(&region, measures);
            if after[0] < before[0] && after[1] <= before[1] {
                let places = collected(region.iter().map(|&place| site.there(place)))?;
                return Ok(Some(Mend { places, ids: site.ids(&region)?, gain: before[0] - after[0] }));
            }
            region.iter().zip(ids).for_each(|(&place, id)| site.canvas.set(place, id, Stats::STOOD));
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, hybrid};
    use selvedge_core::Domain;
    use selvedge_testkit::simple;

    #[test]
    fn regions_tried_beside_each_other_end_as_if_tried_one_after_the_other() {
        let plane = simple::spots(60, 50, 7, 1);
        let exemplars = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let options = RepairOptions { pixel_error: Threshold::OfRandom(0.3), ..RepairOptions::default() };
        let mut skipped = 0;
        for (seed, periodic) in [(1, false), (2, true), (3, false)] {
            let output = Domain { shape: [260, 200], periodic: [periodic, false] };
            let blocks = Options { block: Some([32; 2]), tries: 1, tolerance: 1.0, ..Options::default() };
            let map = hybrid(&exemplars, output, &blocks, &Run::seeded(seed)).unwrap().result;
            let start = || Start { map: map.clone(), fixed: None, sources: None };
            let mender = || Mender::new(&exemplars, vec![true], start(), &options).unwrap();
            let mut all = mender();
            assert!(all.mend(options.passes, &Run::seeded(0)).unwrap());
            // Region after region, nothing skipped and nothing tried ahead.
            let (mut naive, mut tried) = (mender(), 0);
            (0..output.len()).for_each(|place| naive.judge(place));
            for _ in 0..all.stats.costs.len() - 1 {
                for region in naive.regions().unwrap() {
                    tried += 1;
                    let mend = naive.attempt(&region, &mut PixelScratch::default()).unwrap();
                    if let Some(mend) = mend {
                        naive.accept(mend);
                    }
                }
            }
            assert_eq!(all.canvas.map, naive.canvas.map);
            assert_eq!(all.stats.regions[1], naive.stats.regions[1]);
            assert_eq!(all.stats.bad[1], naive.stats.bad[1]);
            let bad = (0..output.len()).map(|place| naive.bad[place].iter().filter(|&&bad| bad).count() as u64);
            assert_eq!(bad.sum::<u64>(), naive.stats.bad[1]);
            skipped += tried - all.stats.regions[0];
        }
        assert!(10 < skipped, "{skipped}");
    }
}
