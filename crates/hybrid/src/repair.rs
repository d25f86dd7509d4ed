//! Repair: bad seams of any map, whoever made it, chosen anew sample by sample. (Nealen and Alexa 2004)

use selvedge_core::{
    Error as CoreError, Event, Exemplars, Grid, Run, SeamCosts, SeamMeasure, SourceMap, Start, Woven, reserve, try_vec,
};

use crate::canvas::Canvas;
use crate::composite::{beside, seam_limit};
use crate::error::Error;
use crate::estimate::estimate_repair;
use crate::options::{PixelSearch, Threshold};
use crate::pixel::Pixels;
use crate::plan::around;
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

/// Regions grow by so much where the first attempt made nothing better: more room for a transition.
const LARGER: u32 = 2;
/// Attempts at a region: as it is, larger, and larger once more. What none of them makes better is left alone.
const ATTEMPTS: u32 = 3;

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
/// Time `O(n log(n))` for `n` samples around bad seams, and `O(output)` a pass. Space `O(output + c * n)`.
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
    let limit = Limit::of(options.pixel_error, Of::Pixel, exemplars);
    let samples = start.map.domain().len();
    let mut mender = Mender {
        canvas: Canvas::new(start)?,
        pixels: Pixels::new(exemplars, allowed, options.search, None)?,
        costs: SeamCosts::new(exemplars, SeamMeasure::Difference)?,
        gradients: SeamCosts::new(exemplars, SeamMeasure::Gradient)?,
        limit: seam_limit(&limit),
        taken: try_vec(samples, false)?,
        stats: RepairStats::default(),
    };
    let mut before = Vec::new();
    reserve(&mut before, samples)?;
    before.extend_from_slice(mender.canvas.map.ids.plane(0));
    let complete = mender.mend(options, run)?;
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
    costs: SeamCosts<2>,
    /// What else must not become dearer.
    gradients: SeamCosts<2>,
    /// A seam that costs more is bad.
    limit: i64,
    /// By place, whether a region that is being grown has it.
    taken: Vec<bool>,
    stats: RepairStats,
}

impl Mender<'_> {
    /// Pass after pass; false if the run was cancelled.
    fn mend(&mut self, options: &RepairOptions, run: &Run<'_, 2>) -> Result<bool, Error> {
        self.stats.costs.push(self.costs.total(&self.canvas.map));
        self.stats.bad = [self.bad().count() as u64; 2];
        for pass in 0..options.passes {
            let regions = self.regions(options.radius)?;
            let mut better = 0;
            for region in regions {
                if run.observer.cancelled() {
                    return Ok(false);
                }
                better += u64::from(self.attempt(region, options.radius)?);
            }
            let total = self.costs.total(&self.canvas.map);
            self.stats.costs.push(total);
            self.stats.bad[1] = self.bad().count() as u64;
            let step = Event::step("repair", u64::from(pass) + 1, options.passes.into());
            run.observer.event(&Event { energy: Some(total), so_far: Some(&self.canvas.map), ..step });
            if better == 0 {
                break;
            }
        }
        Ok(true)
    }

    /// All bad seams: a position and the axis along which the next one follows.
    fn bad(&self) -> impl Iterator<Item = ([u32; 2], usize)> + '_ {
        let map = &self.canvas.map;
        let seams = map.domain().positions().flat_map(|at| [(at, 0), (at, 1)]);
        seams.filter(move |&(at, axis)| self.limit < i64::from(self.costs.at(map, at, axis)))
    }

    /// The places near bad seams, those that touch together.
    fn regions(&self, radius: u32) -> Result<Vec<Vec<usize>>, Error> {
        let domain = self.canvas.domain();
        let mut near = try_vec(domain.len(), false)?;
        let mut places = Vec::new();
        for (at, axis) in self.bad() {
            places.clear();
            beside(&self.canvas, at, axis, radius, &mut places);
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

    /// Chooses a region anew, and a larger one where that made nothing better; true if something did.
    fn attempt(&mut self, mut region: Vec<usize>, radius: u32) -> Result<bool, Error> {
        self.stats.regions[0] += 1;
        for attempt in 0..ATTEMPTS {
            if 0 < attempt {
                region = self.grown(&region, if attempt == 1 { LARGER.min(radius) } else { LARGER })?;
            }
            let before = self.prices(&region);
            let mut ids = Vec::new();
            reserve(&mut ids, region.len())?;
            ids.extend(region.iter().map(|&place| self.canvas.id(place)));
            region.iter().for_each(|&place| self.canvas.wait(place));
            self.pixels.resynthesize(&mut self.canvas, &region)?;
            let after = self.prices(&region);
            if after[0] < before[0] && after[1] <= before[1] {
                self.stats.regions[1] += 1;
                return Ok(true);
            }
            region.iter().zip(ids).for_each(|(&place, id)| self.canvas.set(place, id));
        }
        Ok(false)
    }

    /// A region and what lies around it, but for fixed samples and holes.
    fn grown(&mut self, region: &[usize], by: u32) -> Result<Vec<usize>, Error> {
        let (domain, by) = (self.canvas.domain(), by as i32);
        let side = 2 * by + 1;
        let mut grown: Vec<usize> = Vec::new();
        for &place in region {
            let at = domain.position(place);
            let around = (0..side * side).filter_map(|i| domain.step(at, [i / side - by, i % side - by]));
            for to in around.map(|to| domain.index(to)) {
                let may = !self.taken[to] && !self.canvas.is_fixed(to) && self.canvas.id(to).is_assigned();
                if may {
                    reserve(&mut grown, 1)?;
                    grown.push(to);
                    self.taken[to] = true;
                }
            }
        }
        grown.iter().for_each(|&place| self.taken[place] = false);
        grown.sort_unstable();
        Ok(grown)
    }

    /// What all seams cost that a sorted region's samples have a part in, each once, by both measures.
    fn prices(&self, region: &[usize]) -> [i64; 2] {
        let (map, domain) = (&self.canvas.map, self.canvas.domain());
        let mut sums = [0; 2];
        let mut add = |at: [u32; 2], axis: usize| {
            sums[0] += i64::from(self.costs.at(map, at, axis));
            sums[1] += i64::from(self.gradients.at(map, at, axis));
        };
        for &place in region {
            let at = domain.position(place);
            for axis in 0..2 {
                add(at, axis);
                let mut back = [0; 2];
                back[axis] = -1;
                let Some(before) = domain.step(at, back) else { continue };
                if region.binary_search(&domain.index(before)).is_err() {
                    add(before, axis);
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Origin, SampleId, Seed, Source, Transform};

    #[test]
    fn a_region_costs_each_seam_that_it_touches_once() {
        let mut rng = Seed(4).rng();
        let domain = Domain::open([6, 6]);
        let features = Grid::from_vec(domain, 1, (0..36).map(|_| rng.below(256) as u8).collect()).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let exemplars = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        let output = Domain { shape: [5, 7], periodic: [true, false] };
        let mut map = SourceMap::unassigned(&exemplars, output).unwrap();
        map.ids.plane_mut(0).iter_mut().for_each(|id| *id = SampleId::new(rng.below(36)));
        let mender = Mender {
            canvas: Canvas::new(Start { map, fixed: None, sources: None }).unwrap(),
            pixels: Pixels::new(&exemplars, vec![true], PixelSearch::Exact, None).unwrap(),
            costs: SeamCosts::new(&exemplars, SeamMeasure::Difference).unwrap(),
            gradients: SeamCosts::new(&exemplars, SeamMeasure::Gradient).unwrap(),
            limit: 0,
            taken: vec![false; output.len()],
            stats: RepairStats::default(),
        };
        for _ in 0..50 {
            let region: Vec<usize> = (0..output.len()).filter(|_| rng.below(3) == 0).collect();
            let mut expected = [0; 2];
            for (at, axis) in output.positions().flat_map(|at| [(at, 0), (at, 1)]) {
                let ends = [Some(at), output.next(at, axis)].into_iter().flatten().map(|end| output.index(end));
                if ends.into_iter().any(|end| region.contains(&end)) {
                    expected[0] += i64::from(mender.costs.at(&mender.canvas.map, at, axis));
                    expected[1] += i64::from(mender.gradients.at(&mender.canvas.map, at, axis));
                }
            }
            assert_eq!(mender.prices(&region), expected, "{region:?}");
        }
    }
}
