//! `--gain`: pictures that have the light and the contrast of those that they overlap. Clips have one gain over all
//! frames, so that none flickers.

use selvedge_core::{Bytes, Domain, Encoder, Exemplar, Exemplars, Grid, Plane};
use selvedge_graphcut_textures::labels::Label;
use serde_json::{Value, json};

use super::placed::shows;
use crate::failure::Failure;
use crate::loaded::ExemplarSet;
use crate::loom::Loom;

/// A gain beyond this or its inverse is no other exposure: the pictures show other things there, and least squares
/// would take their contrast away.
const MOST: f64 = 4.0;

/// By picture and channel, what samples are multiplied by, and what is added, in parts of full scale.
pub(super) type Tones = Vec<Vec<[f64; 2]>>;

/// Evens the pictures: each in turn, that which overlaps those before it most, to what they show there. The first stays
/// as it is.
pub(super) fn even(loom: &mut Loom<'_>, labels: &[Label<2>]) -> Result<Tones, Failure> {
    let payload: Vec<&Plane<2>> = loom.loaded.payload.iter().collect();
    let tones = tones(&payload, &loom.loaded.exemplars, loom.domain, labels)?;
    let light = loom.args.input.light;
    let ExemplarSet { payload, masks, encoder, exemplars, .. } = &mut loom.loaded;
    for (plane, tones) in payload.iter_mut().zip(&tones) {
        *plane = plane.toned(tones);
    }
    let each: Vec<&[Plane<2>]> = payload.iter().map(std::slice::from_ref).collect();
    let shown = each.iter().zip(masks.iter()).map(|(plane, mask)| Exemplar::new(plane).masked(mask.as_ref()));
    let shown: Vec<Exemplar<'_, 2>> = shown.collect();
    *encoder = Encoder::fit(&each)?;
    *exemplars = light.ignore(Exemplars::new(encoder, &shown)?)?;
    Ok(tones)
}

/// An upper bound of what that takes: features are made again of pictures that were evened, one of which stands twice
/// meanwhile.
pub(super) fn bytes<const D: usize>(sources: &[Domain<D>], channels: usize, output: Domain<D>) -> Bytes {
    let of = |source: &Domain<D>| Bytes::of_samples(*source, channels as u64 + 1);
    let largest = sources.iter().map(|source| Bytes::of_samples(*source, 16)).max().unwrap_or_default();
    sources.iter().map(of).sum::<Bytes>() + largest + Bytes::of_samples(output, 8)
}

/// As they are told.
pub(super) fn told(tones: &Tones) -> Value {
    let part = |i: usize| tones.iter().map(move |of| of.iter().map(|tone| tone[i]).collect::<Vec<f64>>());
    part(0).zip(part(1)).map(|(gain, offset)| json!({ "gain": gain, "offset": offset })).collect()
}

/// What makes planes even, as far as their exemplars may show.
pub(super) fn tones<const D: usize>(
    planes: &[&Plane<D>],
    exemplars: &Exemplars<D>,
    output: Domain<D>,
    labels: &[Label<D>],
) -> Result<Tones, Failure> {
    let (channels, full) = (planes[0].color_channels(), planes[0].samples.depth().full());
    let mut shown = Grid::try_filled(output, 1, 0_u64)?;
    for (bits, at) in shown.samples_mut().iter_mut().zip(output.positions()) {
        let here = (0..labels.len()).filter(|&i| shows(exemplars, &labels[i], at));
        *bits = here.fold(0, |bits, i| bits | 1 << i);
    }
    let value = |i: usize, c: usize, at: [u32; D]| {
        let from = std::array::from_fn(|axis| (at[axis] as i32 - labels[i].offset[axis]) as u32);
        planes[i].samples.value(c, planes[i].domain().index(from)) / full
    };
    let mut tones: Tones = vec![vec![[1.0, 0.0]; channels]; labels.len()];
    let mut even = 1_u64;
    for _ in 1..labels.len() {
        let rest = (0..labels.len()).filter(|i| even >> i & 1 == 0);
        let overlap = |i: usize| -> u64 {
            let both = shown.samples().iter().filter(|bits| **bits >> i & 1 == 1);
            both.map(|bits| u64::from((bits & even).count_ones())).sum()
        };
        // Of equal overlaps the first picture.
        let Some((_, next)) = rest.map(|i| (overlap(i), std::cmp::Reverse(i))).max() else { break };
        let next = next.0;
        let fitted = |c: usize| {
            let mut fit = Fit::default();
            for (at, bits) in output.positions().zip(shown.samples()).filter(|(_, bits)| **bits >> next & 1 == 1) {
                for other in (0..labels.len()).filter(|other| bits & even & 1 << other != 0) {
                    let [gain, offset] = tones[other][c];
                    fit.add(value(next, c, at), gain * value(other, c, at) + offset);
                }
            }
            fit.tone()
        };
        tones[next] = (0..channels).map(fitted).collect();
        even |= 1 << next;
    }
    Ok(tones)
}

/// Sums of a straight line by least squares.
#[derive(Clone, Copy, Debug, Default)]
struct Fit {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

impl Fit {
    fn add(&mut self, x: f64, y: f64) {
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
    }

    /// Gain and offset; of what does not vary, an offset alone, and of nothing, none.
    fn tone(self) -> [f64; 2] {
        if self.count == 0.0 {
            return [1.0, 0.0];
        }
        let (spread, both) = (self.count * self.xx - self.x * self.x, self.count * self.xy - self.x * self.y);
        // Below a hundredth of a grey level there is nothing but rounding.
        let varies = 1e-9 * self.count * self.count < spread;
        let gain = if varies { (both / spread).clamp(1.0 / MOST, MOST) } else { 1.0 };
        [gain, (self.y - gain * self.x) / self.count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_found_and_what_says_nothing_changes_nothing() {
        let mut fit = Fit::default();
        assert_eq!(fit.tone(), [1.0, 0.0]);
        [0.1, 0.4, 0.5].into_iter().for_each(|x| fit.add(x, 0.5 * x + 0.2));
        let [gain, offset] = fit.tone();
        assert!((gain - 0.5).abs() < 1e-9 && (offset - 0.2).abs() < 1e-9, "{gain} {offset}");
        let mut flat = Fit::default();
        (0..9).for_each(|_| flat.add(0.25, 0.75));
        assert_eq!(flat.tone(), [1.0, 0.5]);
        let mut unlike = Fit::default();
        [(0.0, 1.0), (1.0, 0.0)].into_iter().for_each(|(x, y)| unlike.add(x, y));
        assert_eq!(unlike.tone(), [0.25, 0.375]);
    }
}
