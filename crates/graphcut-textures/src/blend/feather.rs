//! Feathering: near a seam, a weighted sum of all patches that meet there. `[Kwatra03 5]`

use selvedge_core::{Domain, Error, Exemplars, Plane, Render, SampleId, SourceMap, par};

use super::{gathered, set};

/// A source map whose seams are feathered with a Gaussian kernel.
///
/// Each patch that shows within reach of a position weighs as much there as the kernel's share of the positions that
/// it covers. Positions that only one patch reaches are copied bit for bit. Values are averaged as they are stored.
#[derive(Clone, Debug)]
pub struct Feathered<const D: usize> {
    map: SourceMap<D>,
    /// Positions that are blended.
    places: Vec<u32>,
    /// Where each one's samples begin in the lists below, and their end.
    starts: Vec<u32>,
    ids: Vec<SampleId>,
    /// They sum to 1 at each position.
    weights: Vec<f32>,
}

impl<const D: usize> Feathered<D> {
    /// Feathers seams with a kernel of `sigma` samples, from 0 (no feathering) to 16; it ends at two sigma. Patches only
    /// count where their source is valid.
    ///
    /// # Errors
    /// [`crate::Error::Range`] for other values, [`crate::Error::ForeignMap`] if the map names unknown samples.
    ///
    /// # Complexity
    /// Time `O(positions near seams * (4 sigma + 1)^D)`.
    pub fn new(exemplars: &Exemplars<D>, map: SourceMap<D>, sigma: f64) -> Result<Self, crate::Error> {
        if !(0.0..=16.0).contains(&sigma) {
            return Err(crate::Error::Range { option: "feather", value: sigma, range: "0 to 16" });
        }
        crate::check_map(exemplars, &map)?;
        let kernel = Kernel::new(sigma);
        let near = near_seams(&map, kernel.reach);
        let row = map.domain().shape[D - 1] as usize;
        let rows = par::map_indexed(near.len() / row.max(1), |r| {
            let found = (r * row..(r + 1) * row).filter(|&i| near[i]);
            found
                .map(|i| (i as u32, kernel.meeting(exemplars, &map, i)))
                .filter(|(_, m)| 1 < m.len())
                .collect::<Vec<_>>()
        });
        let mut feathered = Self { map, places: vec![], starts: vec![0], ids: vec![], weights: vec![] };
        for (place, meeting) in rows.into_iter().flatten() {
            let sum: f64 = meeting.iter().map(|m| m.1).sum();
            feathered.places.push(place);
            feathered.ids.extend(meeting.iter().map(|m| m.0));
            feathered.weights.extend(meeting.iter().map(|m| (m.1 / sum) as f32));
            feathered.starts.push(feathered.ids.len() as u32);
        }
        Ok(feathered)
    }

    /// Positions that are blended.
    pub fn blended(&self) -> usize {
        self.places.len()
    }
}

impl<const D: usize> Render<D> for Feathered<D> {
    fn render(&self, planes: &[&Plane<D>]) -> Result<Plane<D>, Error> {
        let mut plane = self.map.render(planes)?;
        if self.places.is_empty() {
            return Ok(plane);
        }
        let samples = gathered(&self.map.table, self.ids.clone(), planes)?;
        for (place, range) in self.places.iter().zip(self.starts.windows(2)) {
            for c in 0..samples.channels() {
                let of = |i: u32| samples.value(c, i as usize) * f64::from(self.weights[i as usize]);
                set(&mut plane.samples, c, *place as usize, (range[0]..range[1]).map(of).sum());
            }
        }
        Ok(plane)
    }
}

/// A Gaussian, sampled; the same along each axis.
struct Kernel {
    reach: i32,
    /// By distance.
    weights: Vec<f64>,
}

impl Kernel {
    fn new(sigma: f64) -> Self {
        let reach = (2.0 * sigma).ceil() as i32;
        let weight = |d: i32| if d == 0 { 1.0 } else { libm::exp(-f64::from(d * d) / (2.0 * sigma * sigma)) };
        Self { reach, weights: (0..=reach).map(weight).collect() }
    }

    /// The samples that patches within reach have at a position, each with its weight, the heaviest first.
    fn meeting<const D: usize>(&self, exemplars: &Exemplars<D>, map: &SourceMap<D>, i: usize) -> Vec<(SampleId, f64)> {
        let mut meeting: Vec<(SampleId, f64)> = Vec::new();
        let at = map.domain().position(i);
        for local in Domain::open([2 * self.reach as u32 + 1; D]).positions() {
            let by: [i32; D] = local.map(|l| l as i32 - self.reach);
            let Some(there) = map.domain().step(at, by) else { continue };
            let id = map.ids.get(0, there);
            let Some(id) = map.table.step(id, by.map(|b| -b)).filter(|&id| is_valid(exemplars, id)) else { continue };
            let weight: f64 = by.iter().map(|b| self.weights[b.unsigned_abs() as usize]).product();
            match meeting.iter_mut().find(|m| m.0 == id) {
                Some(m) => m.1 += weight,
                None => meeting.push((id, weight)),
            }
        }
        meeting.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        meeting
    }
}

pub(super) fn is_valid<const D: usize>(exemplars: &Exemplars<D>, id: SampleId) -> bool {
    let Some(source) = exemplars.table().source(id) else { return false };
    let index = (id.get() - exemplars.table().first(source)) as usize;
    exemplars.sources()[source].valid.as_ref().is_none_or(|v| v.samples()[index])
}

/// Positions from which a seam is within reach along every axis.
fn near_seams<const D: usize>(map: &SourceMap<D>, reach: i32) -> Vec<bool> {
    let domain = map.domain();
    let mut near = vec![false; domain.len()];
    if reach == 0 {
        return near;
    }
    for at in domain.positions() {
        for axis in (0..D).filter(|&axis| map.is_seam(at, axis)) {
            near[domain.index(at)] = true;
            if let Some(next) = domain.next(at, axis) {
                near[domain.index(next)] = true;
            }
        }
    }
    for axis in 0..D {
        let before = near.clone();
        for (i, at) in domain.positions().enumerate().filter(|&(i, _)| before[i]) {
            debug_assert_eq!(domain.index(at), i);
            for d in -reach..=reach {
                let mut by = [0; D];
                by[axis] = d;
                if let Some(to) = domain.step(at, by) {
                    near[domain.index(to)] = true;
                }
            }
        }
    }
    near
}
