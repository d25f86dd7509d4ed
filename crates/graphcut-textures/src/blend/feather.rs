//! Feathering: near a seam, a weighted sum of all patches that meet there. `[Kwatra03 5]`

use selvedge_core::{Domain, Error, Grid, Payload, Plane, Render, SampleId, SourceMap};

use super::mixing::Mixing;
use super::{Laid, Mixed, Part, gathered, render};

/// A source map whose seams are feathered with a Gaussian kernel.
///
/// Each patch that shows within reach of a position weighs as much there as the kernel's share of the positions that
/// it covers. Positions that only one patch reaches are copied bit for bit. Values are averaged as they are stored, colours
/// weighed by their alpha; normals keep their length.
#[derive(Clone, Debug)]
pub struct Feathered<'m, const D: usize> {
    laid: Laid<'m, D>,
    reach: u32,
    /// The kernel: steps from a position, and their weights.
    taps: Vec<([i32; D], f64)>,
}

impl<'m, const D: usize> Feathered<'m, D> {
    /// The greatest sigma.
    pub const MOST: f64 = 16.0;

    /// Feathers seams with a kernel of `sigma` samples, from 0 (no feathering) to 16; it ends at two sigma. Patches count
    /// where their source is `valid`: see [`Exemplars::validity`](selvedge_core::Exemplars::validity) and
    /// [`SourceTable::validity`](selvedge_core::SourceTable::validity).
    ///
    /// # Errors
    /// Those of [`validate`](Self::validate), [`crate::Error::ForeignMap`] if the map names unknown samples,
    /// [`crate::Error::Shape`] for validity of other shapes than the sources.
    pub fn new(map: &'m SourceMap<D>, valid: Vec<Option<&'m Grid<bool, D>>>, sigma: f64) -> Result<Self, crate::Error> {
        Self::validate(sigma)?;
        let reach = (2.0 * sigma).ceil() as u32;
        Ok(Self { laid: Laid::new(map, valid)?, reach, taps: taps(sigma, reach) })
    }

    /// Checks a sigma.
    ///
    /// # Errors
    /// [`crate::Error::Range`] unless it is from 0 to [`MOST`](Self::MOST).
    pub fn validate(sigma: f64) -> Result<(), crate::Error> {
        let in_range = (0.0..=Self::MOST).contains(&sigma);
        let wrong = || crate::Error::Range { option: "feather", value: sigma, range: "0 to 16" };
        if in_range { Ok(()) } else { Err(wrong()) }
    }

    /// The same, but positions where `kept` is true are copied, whatever is near.
    ///
    /// # Errors
    /// [`crate::Error::Shape`] if it has another shape than the map.
    pub fn keeping(self, kept: &'m Grid<bool, D>) -> Result<Self, crate::Error> {
        Ok(Self { laid: self.laid.keeping(kept)?, ..self })
    }

    fn blend(&self, payload: &Payload<'_, D>, mixing: &Mixing, part: &Part<D>) -> Result<Mixed, Error> {
        let near = Near::new(&self.laid, part, self.reach);
        let (mut mixed, mut ids, mut weights) = (Mixed::default(), Vec::new(), vec![]);
        for &(at, place) in &part.wanted {
            let meeting = near.meeting(at, &self.taps);
            if 1 < meeting.len() {
                let sum: f64 = meeting.iter().map(|m| m.1).sum();
                mixed.places.push(place);
                ids.extend(meeting.iter().map(|m| m.0));
                weights.push(meeting.into_iter().map(|m| m.1 / sum).collect::<Vec<f64>>());
            }
        }
        let samples = gathered(payload, mixing, ids)?;
        let mut first = 0;
        for weights in weights {
            for channel in &samples {
                mixed.values.push(channel[first..].iter().zip(&weights).map(|(v, w)| v * w).sum());
            }
            first += weights.len();
        }
        Ok(mixed)
    }
}

impl<const D: usize> Render<D> for Feathered<'_, D> {
    /// # Complexity
    /// Time `O(positions near seams * (4 sigma + 1)^D)`.
    fn render(&self, planes: &[&Plane<D>]) -> Result<Plane<D>, Error> {
        render(&self.laid, planes, self.reach, |payload, mixing, part| self.blend(payload, mixing, part))
    }
}

/// A Gaussian, sampled, the same along each axis.
fn taps<const D: usize>(sigma: f64, reach: u32) -> Vec<([i32; D], f64)> {
    let weight = |d: i32| if d == 0 { 1.0 } else { libm::exp(-f64::from(d * d) / (2.0 * sigma * sigma)) };
    let by = |local: [u32; D]| local.map(|l| l as i32 - reach as i32);
    let positions = Domain::open([2 * reach + 1; D]).positions().map(by);
    positions.map(|by| (by, by.iter().map(|&b| weight(b)).product())).collect()
}

/// What shows in a part of the output and around it.
struct Near<'a, const D: usize> {
    laid: &'a Laid<'a, D>,
    domain: Domain<D>,
    /// Where the part begins in the domain.
    corner: [i32; D],
    /// Source and position of each sample.
    located: Vec<Option<(usize, [u32; D])>>,
}

impl<'a, const D: usize> Near<'a, D> {
    fn new(laid: &'a Laid<'a, D>, part: &Part<D>, reach: u32) -> Self {
        let outer = laid.around(&part.window, reach);
        let ids = laid.map.ids.plane(0);
        let places = outer.places(laid.map.domain()).flatten();
        Self {
            laid,
            domain: Domain::open(outer.shape),
            corner: std::array::from_fn(|a| part.window.start[a] - outer.start[a]),
            located: places.map(|i| laid.map.table.locate(ids[i])).collect(),
        }
    }

    /// The samples that patches within reach have at a position of the part, each with its weight.
    fn meeting(&self, at: [u32; D], taps: &[([i32; D], f64)]) -> Vec<(SampleId, f64)> {
        let at: [i32; D] = std::array::from_fn(|a| at[a] as i32 + self.corner[a]);
        // By source, and the place in it that a patch has here, not wrapped.
        let mut patches: Vec<(usize, [i32; D], f64)> = Vec::new();
        for (by, weight) in taps {
            let Some(there) = self.domain.step([0; D], std::array::from_fn(|a| at[a] + by[a])) else { continue };
            let Some((source, from)) = self.located[self.domain.index(there)] else { continue };
            let here = std::array::from_fn(|a| from[a] as i32 - by[a]);
            match patches.iter_mut().find(|(s, p, _)| (*s, *p) == (source, here)) {
                Some((_, _, sum)) => *sum += weight,
                None => patches.push((source, here, *weight)),
            }
        }
        let table = &self.laid.map.table;
        let mut meeting: Vec<(SampleId, f64)> = Vec::new();
        for (source, here, weight) in patches {
            let place = table.sources()[source].1.step([0; D], here);
            let Some(place) = place.filter(|&p| self.laid.is_valid(source, p)) else { continue };
            let id = table.id(source, place);
            match meeting.iter_mut().find(|m| m.0 == id) {
                Some(m) => m.1 += weight,
                None => meeting.push((id, weight)),
            }
        }
        meeting
    }
}
