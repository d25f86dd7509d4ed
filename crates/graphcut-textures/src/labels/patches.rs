//! Exact nearest neighbours of small patches, away from where they are.

use selvedge_core::{Domain, Exemplars, SourceMap, reserve, try_vec};

use crate::error::Error;
use crate::labels::parts::{Codes, Parts, Sums, Tree, Wanted};

/// All valid patches of a shape in all sources.
pub(super) struct Patches<'e, const D: usize> {
    exemplars: &'e Exemplars<D>,
    shape: [u32; D],
    parts: Parts<D>,
    codes: Codes,
    /// The weight of each value of a row of a patch, its samples side by side.
    weights: Vec<u32>,
    /// The one weight of all channels, if they have the same.
    even: Option<u32>,
    sources: Vec<Shown>,
}

/// One source.
struct Shown {
    /// Samples one after the other, their channels side by side.
    features: Vec<u8>,
    /// Where the rows of the first patch begin in them.
    rows: Vec<usize>,
    /// All patches that are valid.
    tree: Tree,
}

impl<'e, const D: usize> Patches<'e, D> {
    pub(super) fn new(exemplars: &'e Exemplars<D>, shape: [u32; D]) -> Result<Self, Error> {
        let weights = exemplars.weights().iter().map(|&w| u32::from(w));
        let weights: Vec<u32> = weights.cycle().take(exemplars.channels() * shape[D - 1] as usize).collect();
        let even = weights.first().copied().filter(|first| weights.iter().all(|w| w == first));
        let parts = Parts::of(shape, exemplars.table().len() as usize);
        let codes = Codes::of(&parts, exemplars.weights());
        let mut patches = Self { exemplars, shape, parts, codes, weights, even, sources: Vec::new() };
        for number in 0..exemplars.sources().len() {
            let shown = patches.shown(number)?;
            patches.sources.push(shown);
        }
        Ok(patches)
    }

    fn shown(&self, number: usize) -> Result<Shown, Error> {
        let (source, channels) = (&self.exemplars.sources()[number], self.exemplars.channels());
        let domain = source.domain();
        let mut features = try_vec(domain.len() * channels, 0_u8)?;
        for c in 0..channels {
            let plane = source.features.plane(c);
            features[c..].iter_mut().step_by(channels).zip(plane).for_each(|(to, &from)| *to = from);
        }
        let whole = match &source.valid {
            Some(valid) => boxes(domain, valid.samples(), self.shape)?,
            None => boxes(domain, &try_vec(domain.len(), true)?, self.shape)?,
        };
        let mut starts = Vec::new();
        reserve(&mut starts, whole.iter().filter(|whole| **whole).count())?;
        starts.extend((0..domain.len()).filter(|&start| whole[start]).map(|start| start as u32));
        let strides = domain.strides();
        let place = |at: [u32; D]| (0..D).map(|a| at[a] as usize * strides[a]).sum::<usize>() * channels;
        let mut across = self.shape;
        across[D - 1] = 1;
        let rows = Domain::open(across).positions().map(place).collect();
        let tree = Tree::new(starts, &Sums::new(&features, domain, &self.parts, &self.codes)?)?;
        Ok(Shown { features, rows, tree })
    }

    /// Source and first sample of the patch most like what stands in the box at a position of a map; none closer than
    /// `apart` to where it comes from. Of equal ones the nearest, then the first. What does not stand is not compared.
    pub(super) fn nearest(&self, map: &SourceMap<D>, at: [u32; D], apart: u32) -> Option<(usize, [u32; D])> {
        let template = self.template(map, at);
        let (own, place) = template.origin?;
        let mut best: Option<(u64, u64, usize, usize)> = None;
        let mut reach = u64::MAX;
        for (number, shown) in self.sources.iter().enumerate() {
            let domain = self.exemplars.sources()[number].domain();
            let mut ask = |start: usize| {
                let from = domain.position(start);
                let far = (0..D).map(|a| (i64::from(from[a]) - i64::from(place[a])).unsigned_abs().pow(2)).sum();
                if number != own || u64::from(apart).pow(2) <= far {
                    let error = self.error(shown, start, &template, best.map_or(u64::MAX, |b| b.0));
                    let found = error.map(|error| (error, far, number, start));
                    best = found.filter(|found| best.is_none_or(|best| *found < best)).or(best);
                }
                best.map_or(u64::MAX, |best| self.codes.reach(best.0))
            };
            shown.tree.search(&template.wanted, &mut reach, &mut ask);
        }
        best.map(|(_, _, number, start)| (number, self.exemplars.sources()[number].domain().position(start)))
    }

    /// The error of a patch, unless it is more than the least so far.
    fn error(&self, shown: &Shown, start: usize, template: &Template<D>, least: u64) -> Option<u64> {
        let (first, width) = (start * self.exemplars.channels(), self.weights.len());
        let parts = template.features.chunks_exact(width).zip(template.mask.chunks_exact(width));
        let mut error = 0;
        for (&row, (part, mask)) in shown.rows.iter().zip(parts) {
            let row = &shown.features[first + row..][..width];
            error += match self.even {
                Some(weight) => squares(row, part, mask) * u64::from(weight),
                None => weighted(row, part, mask, &self.weights),
            };
            if least < error {
                return None;
            }
        }
        Some(error)
    }

    /// What stands in the box at a position of a map.
    fn template(&self, map: &SourceMap<D>, at: [u32; D]) -> Template<D> {
        let (domain, channels, shape) = (map.domain(), self.exemplars.channels(), Domain::open(self.shape));
        let len = shape.len() * channels;
        let (mut features, mut mask, mut origin) = (vec![0; len], vec![0; len], None);
        let (mut sums, mut known) = (vec![0; self.parts.count() * channels], vec![0; self.parts.count()]);
        for (i, step) in shape.positions().enumerate() {
            let place = domain.step(at, step.map(|s| s as i32)).map(|p| map.ids.get(0, p));
            let Some((source, from)) = place.and_then(|id| self.exemplars.locate(id)) else { continue };
            let first = self.exemplars.sources()[source].domain().index(from) * channels;
            let values = i * channels..(i + 1) * channels;
            let sample = &self.sources[source].features[first..][..channels];
            features[values.clone()].copy_from_slice(sample);
            mask[values].fill(u8::MAX);
            origin = origin.or_else(|| Some((source, std::array::from_fn(|a| from[a] as i32 - step[a] as i32))));
            let Some(part) = self.parts.at(step) else { continue };
            let of = sums[part..].iter_mut().step_by(self.parts.count());
            of.zip(sample).for_each(|(sum, &value)| *sum += u32::from(value));
            known[part] += 1;
        }
        let whole = known.iter().map(|&known| known == self.parts.samples());
        Template { features, mask, origin, wanted: Wanted::new(&self.codes, &sums, whole) }
    }
}

/// What patches are compared with.
struct Template<const D: usize> {
    features: Vec<u8>,
    /// By value, all bits where something stands, and none where nothing does.
    mask: Vec<u8>,
    /// The source of the first sample that stands, and where the box begins in it.
    origin: Option<(usize, [i32; D])>,
    /// The parts of which all samples stand.
    wanted: Wanted,
}

/// So many squares of bytes fit into 32 bits, in which they are summed faster: 255^2 * 256 < 2^32.
const SUMMED: usize = 256;

/// Squared differences of two rows.
#[inline]
fn squares(a: &[u8], b: &[u8], mask: &[u8]) -> u64 {
    let parts = a.chunks(SUMMED).zip(b.chunks(SUMMED)).zip(mask.chunks(SUMMED)).map(|((a, b), mask)| {
        let squares = a.iter().zip(b).zip(mask).map(|((&a, &b), &mask)| {
            let d = u32::from(a.abs_diff(b) & mask);
            d.wrapping_mul(d)
        });
        u64::from(squares.fold(0, u32::wrapping_add))
    });
    parts.sum()
}

/// The same, each with a weight of its own.
fn weighted(a: &[u8], b: &[u8], mask: &[u8], weights: &[u32]) -> u64 {
    let both = a.iter().zip(b).zip(mask.iter().zip(weights));
    both.map(|((&a, &b), (&mask, &w))| u64::from(u32::from(a.abs_diff(b) & mask).pow(2) * w)).sum()
}

/// By position, whether all of a box that starts there is set and lies inside.
pub(super) fn boxes<const D: usize>(domain: Domain<D>, set: &[bool], shape: [u32; D]) -> Result<Vec<bool>, Error> {
    let mut whole = try_vec(set.len(), false)?;
    whole.copy_from_slice(set);
    for (axis, stride) in domain.strides().into_iter().enumerate() {
        let mut run = try_vec(set.len(), 0_u32)?;
        for i in (0..set.len()).rev() {
            let goes_on = i / stride % domain.shape[axis] as usize + 1 < domain.shape[axis] as usize;
            let ahead = if goes_on { run[i + stride] } else { 0 };
            run[i] = if whole[i] { ahead + 1 } else { 0 };
        }
        whole.iter_mut().zip(&run).for_each(|(whole, &run)| *whole = shape[axis] <= run);
    }
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Grid, Origin, Seed, Source, Transform};

    #[test]
    fn neighbours_are_those_of_the_definition() {
        for case in 0..30 {
            let mut rng = Seed(case).rng();
            let domain = Domain::open([9 + rng.below(6), 9 + rng.below(6)]);
            let features = (0..domain.len() * 2).map(|_| 40 * rng.below(4) as u8).collect();
            let features = Grid::from_vec(domain, 2, features).unwrap();
            let valid = Grid::from_vec(domain, 1, (0..domain.len()).map(|_| rng.below(40) != 0).collect()).unwrap();
            let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
            let source = Source { features, valid: Some(valid.into()), origin };
            let e = Exemplars::from_sources(vec![source], vec![1, 3]).unwrap();
            let mut map = SourceMap::unassigned(&e, domain).unwrap();
            map.lay_under(&e, 0).unwrap();
            let (shape, apart) = ([3, 2], 2 + rng.below(3));
            let (source, patches) = (&e.sources()[0], Patches::new(&e, shape).unwrap());
            let samples = |at: [u32; 2]| -> Option<Vec<[u8; 2]>> {
                let one = |step: [u32; 2]| {
                    let at = [at[0] + step[0], at[1] + step[1]];
                    let valid = domain.contains(at) && source.valid.as_deref().unwrap().get(0, at);
                    valid.then(|| [0, 1].map(|c| source.features.get(c, at)))
                };
                Domain::open(shape).positions().map(one).collect()
            };
            for at in domain.positions() {
                let Some(own) = samples(at) else { continue };
                let mut best = None;
                for from in domain.positions() {
                    let far: u32 = [0, 1].map(|a| from[a].abs_diff(at[a]).pow(2)).iter().sum();
                    let Some(other) = samples(from).filter(|_| apart * apart <= far) else { continue };
                    let squares = own.iter().zip(&other).map(|(a, b)| {
                        u32::from(a[0].abs_diff(b[0])).pow(2) + 3 * u32::from(a[1].abs_diff(b[1])).pow(2)
                    });
                    let found = (squares.sum::<u32>(), far, from);
                    best = Some(best.map_or(found, |best| found.min(best)));
                }
                assert_eq!(patches.nearest(&map, at, apart), best.map(|b| (0, b.2)), "case {case} at {at:?}");
            }
        }
    }
}
