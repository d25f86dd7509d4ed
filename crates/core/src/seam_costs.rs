//! What a seam costs: the price of two patches meeting between neighbours, in integers.

use crate::{Bytes, Domain, Error, Exemplars, SampleId, SourceMap, SourceTable, try_vec};

/// See [`SeamCosts::SCALE`].
const SCALE: u32 = 16;

/// How the price of a seam is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum SeamMeasure {
    /// `M`: how much the two patches differ on both sides of the seam. A metric, so that costs of three patches obey
    /// the triangle inequality. `[Kwatra03 eq. 1]`
    Difference,
    /// `M'`: the same, divided by the gradients of both patches along the seam's axis. Seams in calm areas cost more.
    /// Not a metric. `[Kwatra03 eq. 5]`
    #[default]
    Gradient,
}

/// Prices of seams between exemplar samples, on one fixed-point scale.
///
/// # Units
/// The norm of a difference is `sqrt(sum of W_c (a_c - b_c)^2)` in 8-bit steps, times [`SCALE`](Self::SCALE), rounded
/// up: rounding up keeps the triangle inequality, rounding to nearest does not. [`SeamMeasure::Difference`] is in these
/// units. [`SeamMeasure::Gradient`] is a ratio times [`RATIO`](Self::RATIO), rounded up; one grey level (at the
/// channels' mean weight) is added to its denominator, since both patches may be flat.
///
/// # Where a patch ends
/// A seam between `s` and `t` compares both patches at both samples. Where one of them is not defined at one of the
/// two (its source ends there, or is masked), the other sample counts twice; where neither goes on, the difference of
/// the two samples themselves counts twice.
#[derive(Clone, Debug)]
pub struct SeamCosts<const D: usize> {
    table: SourceTable<D>,
    weights: Vec<u8>,
    /// Interleaved: all channels of a sample side by side, sources one after the other.
    features: Vec<u8>,
    /// Per sample, bit `2 a` (`2 a + 1`): the next (previous) sample along axis `a` is a stride away and valid. Above
    /// these the number of its source's [`strides`](Self::strides).
    links: Vec<u8>,
    /// The norm of one grey level in one channel, in the mean of the channels' weights.
    level: u32,
    /// Those of the sources, each once, as far as links can number them: to ask for a sample's source takes longer than
    /// all else that a price is made of.
    strides: Vec<[u32; D]>,
    /// By sample and axis; empty unless seams are weighed by gradients.
    gradients: Vec<[u32; D]>,
}

impl<const D: usize> SeamCosts<D> {
    /// The price of one grey level's difference at one sample.
    pub const SCALE: u32 = SCALE;
    /// The price of a seam whose difference equals its gradients: a price is an integer, and differences of a
    /// thousandth of the gradients still count.
    pub const RATIO: u32 = 1024;
    /// No seam costs more: a link of a cut holds two prices in `2^27`, max-flow's bound.
    pub const MAX: i32 = 1 << 26;

    /// The bytes that prices of exemplars of so many samples and channels hold, whatever their measure.
    pub fn bytes(samples: Bytes, channels: usize) -> Bytes {
        samples * (channels as u64 + 1 + 4 * D as u64)
    }

    /// Prepares the samples of all sources: about `channels + 1` bytes a sample, and `4 D` more for gradients.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn new(exemplars: &Exemplars<D>, measure: SeamMeasure) -> Result<Self, Error> {
        let table = exemplars.table().clone();
        let strides = numbered_strides(exemplars);
        let mut costs = Self {
            weights: exemplars.weights().to_vec(),
            level: grey_level(exemplars.weights()),
            features: interleaved(exemplars)?,
            links: links(exemplars, &strides)?,
            strides,
            gradients: Vec::new(),
            table,
        };
        if measure == SeamMeasure::Gradient {
            let mut gradients = try_vec(costs.table.len() as usize, [0; D])?;
            for (id, of) in gradients.iter_mut().enumerate() {
                *of = std::array::from_fn(|axis| costs.gradient(SampleId::new(id as u32), axis));
            }
            costs.gradients = gradients;
        }
        Ok(costs)
    }

    /// The features of a sample, channel by channel.
    #[inline]
    pub fn features(&self, id: SampleId) -> &[u8] {
        let channels = self.weights.len();
        &self.features[id.get() as usize * channels..][..channels]
    }

    /// `|a - b|`, scaled and rounded up.
    #[inline]
    pub fn norm(&self, a: SampleId, b: SampleId) -> u32 {
        let sum = match self.weights[..] {
            // Grey and colours: what is known to be short is not gone through one by one.
            [w] => self.squares(a, b, &[w]),
            [v, w, x] => self.squares(a, b, &[v, w, x]),
            _ => self.squares(a, b, &self.weights),
        };
        let square = (sum * u64::from(Self::SCALE).pow(2)) as i64;
        // Exact: a correctly rounded root of an integer below 2^52 is never on the wrong side of another integer.
        // Without SSE 4.1 `ceil` is a call, and numbers without a sign are converted in several steps.
        let root = (square as f64).sqrt() as i64;
        (root + i64::from(root * root < square)) as u32
    }

    /// The weighed sum of squared differences over channels of such weights, all there are.
    #[inline(always)]
    fn squares<W: AsRef<[u8]> + ?Sized>(&self, a: SampleId, b: SampleId, weights: &W) -> u64 {
        let weights = weights.as_ref();
        let of = |id: SampleId| &self.features[id.get() as usize * weights.len()..][..weights.len()];
        let squares = of(a).iter().zip(of(b)).zip(weights);
        squares.map(|((&a, &b), &w)| u64::from(a.abs_diff(b)).pow(2) * u64::from(w)).sum()
    }

    /// The sample that continues a patch in a direction: `2 a` forward, `2 a + 1` backward along axis `a`. `None` where
    /// the source ends or is masked.
    #[inline]
    pub fn continued(&self, id: SampleId, direction: usize) -> Option<SampleId> {
        let links = self.links[id.get() as usize];
        if links >> direction & 1 == 0 {
            return self.wrapped(id, direction);
        }
        let number = usize::from((links & !VALID) >> (2 * D));
        let stride = match self.strides.get(number) {
            Some(strides) => strides[direction / 2],
            None => strides_of(self.table.sources()[self.table.source(id)?].1)[direction / 2],
        };
        Some(SampleId::new(if direction.is_multiple_of(2) { id.get() + stride } else { id.get() - stride }))
    }

    /// Around the border of a periodic source.
    #[cold]
    fn wrapped(&self, id: SampleId, direction: usize) -> Option<SampleId> {
        let (source, at) = self.table.locate(id)?;
        let domain = self.table.sources()[source].1;
        let axis = direction / 2;
        let border = if direction.is_multiple_of(2) { domain.shape[axis] - 1 } else { 0 };
        if !domain.periodic[axis] || at[axis] != border {
            return None;
        }
        let mut to = at;
        to[axis] = domain.shape[axis] - 1 - border;
        let to = self.table.id(source, to);
        (self.links[to.get() as usize] & VALID != 0).then_some(to)
    }

    /// The price of `here` and `there` as neighbours along an axis; 0 where the one continues the other.
    ///
    /// # Panics
    /// If a sample is unassigned or unknown.
    #[inline]
    pub fn between(&self, axis: usize, here: SampleId, there: SampleId) -> i32 {
        let ahead = self.continued(here, 2 * axis);
        if ahead == Some(there) { 0 } else { self.of_two_patches(axis, here, there, ahead) }
    }

    fn of_two_patches(&self, axis: usize, here: SampleId, there: SampleId, ahead: Option<SampleId>) -> i32 {
        let behind = self.continued(there, 2 * axis + 1);
        let (here_too, there_too) = match (behind, ahead) {
            (Some(b), Some(a)) => ([here, b], [a, there]),
            (Some(b), None) => ([here, b], [here, b]),
            (None, Some(a)) => ([a, there], [a, there]),
            (None, None) => ([here, there], [here, there]),
        };
        let norm = self.norm(here_too[0], here_too[1]) + self.norm(there_too[0], there_too[1]);
        self.weigh(axis, norm, [here_too[0], here_too[1], there_too[0], there_too[1]])
    }

    /// The price of a seam along an axis from `norm = |A(s) - B(s)| + |A(t) - B(t)|` and the four samples.
    #[inline]
    pub fn weigh(&self, axis: usize, norm: u32, samples: [SampleId; 4]) -> i32 {
        let price = if self.gradients.is_empty() {
            u64::from(norm)
        } else {
            let gradient: u32 = samples.iter().map(|s| self.gradients[s.get() as usize][axis]).sum();
            (u64::from(norm) * u64::from(Self::RATIO)).div_ceil(u64::from(gradient) + u64::from(self.level))
        };
        price.min(Self::MAX as u64) as i32
    }

    /// The price of the seam between a position and the next along an axis; 0 without one, and where a sample is not
    /// assigned.
    pub fn at(&self, map: &SourceMap<D>, at: [u32; D], axis: usize) -> i32 {
        let Some(next) = map.domain().next(at, axis) else { return 0 };
        let (here, there) = (map.ids.get(0, at), map.ids.get(0, next));
        if here.is_assigned() && there.is_assigned() { self.between(axis, here, there) } else { 0 }
    }

    /// The price of all seams of a map.
    pub fn total(&self, map: &SourceMap<D>) -> i64 {
        let (domain, ids) = (map.domain(), map.ids.plane(0));
        let price = |axis: usize, here: &[SampleId], there: &[SampleId]| {
            let assigned = here.iter().zip(there).filter(|(here, there)| here.is_assigned() && there.is_assigned());
            assigned.map(|(&here, &there)| i64::from(self.between(axis, here, there))).sum::<i64>()
        };
        let along = |axis: usize| {
            let (stride, side) = (domain.strides()[axis], domain.shape[axis] as usize);
            let of = |lines: &[SampleId]| {
                let around = if domain.periodic[axis] { &lines[..stride] } else { &[] };
                price(axis, lines, &lines[stride..]) + price(axis, &lines[lines.len() - stride..], around)
            };
            ids.chunks_exact((stride * side).max(1)).map(of).sum::<i64>()
        };
        (0..D).map(along).sum()
    }

    /// The norm of a patch's gradient along an axis: central differences, one-sided where the source ends.
    fn gradient(&self, id: SampleId, axis: usize) -> u32 {
        match (self.continued(id, 2 * axis), self.continued(id, 2 * axis + 1)) {
            (Some(next), Some(previous)) => self.norm(next, previous) / 2,
            (Some(other), None) | (None, Some(other)) => self.norm(id, other),
            (None, None) => 0,
        }
    }
}

/// See [`SeamCosts::level`].
fn grey_level(weights: &[u8]) -> u32 {
    let sum: u32 = weights.iter().map(|&w| u32::from(w)).sum();
    let mean = f64::from(sum) / weights.len() as f64;
    ((mean.sqrt() * f64::from(SCALE)).ceil() as u32).max(1)
}

/// Marks valid samples, beside the bits of directions.
const VALID: u8 = 1 << 7;

fn interleaved<const D: usize>(exemplars: &Exemplars<D>) -> Result<Vec<u8>, Error> {
    let channels = exemplars.channels();
    let mut features = try_vec(exemplars.table().len() as usize * channels, 0_u8)?;
    for (s, source) in exemplars.sources().iter().enumerate() {
        let first = exemplars.table().first(s) as usize * channels;
        for c in 0..channels {
            for (to, &from) in features[first + c..].iter_mut().step_by(channels).zip(source.features.plane(c)) {
                *to = from;
            }
        }
    }
    Ok(features)
}

fn strides_of<const D: usize>(domain: Domain<D>) -> [u32; D] {
    domain.strides().map(|s| s as u32)
}

/// The strides of sources, each once; the first few where there are more than links can number.
fn numbered_strides<const D: usize>(exemplars: &Exemplars<D>) -> Vec<[u32; D]> {
    let most = usize::from(!VALID >> (2 * D));
    let mut numbered = Vec::new();
    for source in exemplars.sources() {
        let strides = strides_of(source.domain());
        if numbered.len() < most && !numbered.contains(&strides) {
            numbered.push(strides);
        }
    }
    numbered
}

fn links<const D: usize>(exemplars: &Exemplars<D>, numbered: &[[u32; D]]) -> Result<Vec<u8>, Error> {
    let mut links = try_vec(exemplars.table().len() as usize, 0_u8)?;
    let mut first = 0;
    for source in exemplars.sources() {
        let (domain, strides) = (source.domain(), source.domain().strides());
        let number = numbered.iter().position(|n| *n == strides_of(domain)).unwrap_or(numbered.len());
        let valid = |i: usize| source.valid.as_deref().is_none_or(|v| v.samples()[i]);
        for (i, at) in domain.positions().enumerate() {
            let mut bits = if valid(i) { VALID } else { 0 } | (number as u8) << (2 * D);
            for axis in 0..D {
                bits |= u8::from(at[axis] + 1 < domain.shape[axis] && valid(i + strides[axis])) << (2 * axis);
                bits |= u8::from(0 < at[axis] && valid(i - strides[axis])) << (2 * axis + 1);
            }
            links[first + i] = bits;
        }
        first += domain.len();
    }
    Ok(links)
}

#[cfg(test)]
mod tests;
