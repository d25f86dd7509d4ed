//! Pyramids: exemplars, guides and maps at half the size and back. Exact, and aware of what wraps.
//!
//! Sample `c` of a coarser level stands for the samples `2 c` and `2 c + 1` along each axis. Around a periodic axis of
//! odd length the last one stands for the last and the first sample. At the end of an open one, a source leaves the odd
//! sample out, since a coarse sample must stand for a whole block that can be copied, while an output has one coarse
//! sample more, so that everything is covered. An axis of a single sample stays, and so does time: a clip of half the
//! size has frames of half the size, as many as before ([`Domain::halves`]).

use crate::{Domain, Error, Exemplars, Grid, Source, SourceMap};

impl<const D: usize> Domain<D> {
    /// True for axes that have half as many samples at half the size: all but the time of clips. A frame less is a step
    /// of what moves, which cannot be made up for.
    pub const fn halves(axis: usize) -> bool {
        D != 3 || 0 < axis
    }

    /// Lengths along each axis after so many halvings.
    pub fn halved(sides: [u32; D], times: u32) -> [u32; D] {
        std::array::from_fn(|a| if Self::halves(a) { sides[a] >> times } else { sides[a] })
    }

    /// The domain of half the size that covers an output of this one.
    #[must_use]
    pub fn coarser(self) -> Self {
        let half = |a: usize| if Self::halves(a) { self.shape[a].div_ceil(2) } else { self.shape[a] };
        Self { shape: std::array::from_fn(half), ..self }
    }

    /// The coarse sample that stands for one of this domain.
    fn above(at: [u32; D]) -> [u32; D] {
        Self::halved(at, 1)
    }

    /// The first of the samples that a coarse one stands for.
    pub fn below(at: [u32; D]) -> [u32; D] {
        std::array::from_fn(|a| if Self::halves(a) { 2 * at[a] } else { at[a] })
    }
}

/// The domain of half the size whose samples all stand for whole blocks of a source.
fn within<const D: usize>(source: Domain<D>) -> Domain<D> {
    let half = |a: usize| {
        let side = source.shape[a];
        match Domain::<D>::halves(a) {
            false => side,
            true if source.periodic[a] => side.div_ceil(2),
            true => (side / 2).max(side.min(1)),
        }
    };
    Domain { shape: std::array::from_fn(half), ..source }
}

/// The samples that a coarser one stands for, by their place in a buffer; those beyond the end are left out.
fn finer<const D: usize>(domain: Domain<D>, coarse: [u32; D]) -> impl Iterator<Item = usize> {
    let axes = (0..D).filter(|&a| Domain::<D>::halves(a)).count();
    (0..1_u32 << axes).filter_map(move |corner| {
        let by = |a: usize| if Domain::<D>::halves(a) { (corner >> (D - 1 - a) & 1) as i32 } else { 0 };
        domain.step(Domain::below(coarse), std::array::from_fn(by)).map(|at| domain.index(at))
    })
}

/// The mean of the samples that each coarser one stands for, to the nearest.
pub(crate) fn mean<const D: usize>(grid: &Grid<u8, D>, coarse: Domain<D>) -> Result<Grid<u8, D>, Error> {
    let mut out = Grid::try_filled(coarse, grid.channels(), 0)?;
    for c in 0..grid.channels() {
        let from = grid.plane(c);
        for (to, at) in out.plane_mut(c).iter_mut().zip(coarse.positions()) {
            let (sum, n) = finer(grid.domain(), at).fold((0, 0), |(sum, n), i| (sum + u32::from(from[i]), n + 1));
            *to = ((2 * sum + n) / (2 * n)) as u8;
        }
    }
    Ok(out)
}

impl<const D: usize> Grid<u8, D> {
    /// Features of a source at half the size: means of what each sample stands for.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn coarser(&self) -> Result<Self, Error> {
        mean(self, within(self.domain()))
    }
}

impl<const D: usize> Grid<bool, D> {
    /// The valid samples of a source at half the size: those that stand for valid ones alone.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn coarser(&self) -> Result<Self, Error> {
        all(self, within(self.domain()))
    }
}

impl Grid<u8, 2> {
    /// A picture whose longest side becomes `longest`, for eyes: each sample is the mean of what it covers, to the
    /// nearest. The answer is open; one that is no larger is the same.
    ///
    /// # Errors
    /// [`Error::Allocation`].
    pub fn reduced(&self, longest: u32) -> Result<Self, Error> {
        let from = self.domain().shape;
        let side = from[0].max(from[1]);
        let longest = longest.clamp(1, side.max(1));
        let to = from.map(|s| ((u64::from(s) * u64::from(longest) / u64::from(side.max(1))) as u32).max(s.min(1)));
        let covers = [0, 1].map(|axis| (0..to[axis]).map(|i| covered(i, to[axis], from[axis])).collect::<Vec<_>>());
        let mut out = Self::try_filled(Domain::open(to), self.channels(), 0_u8)?;
        let whole = u64::from(from[0]) * u64::from(from[1]);
        for c in 0..self.channels() {
            for [y, x] in out.domain().positions() {
                let row = |j: u32| {
                    covers[1][x as usize].clone().map(|(i, w)| w * u64::from(self.get(c, [j, i]))).sum::<u64>()
                };
                let sum: u64 = covers[0][y as usize].clone().map(|(j, w)| w * row(j)).sum();
                out.set(c, [y, x], ((sum + whole / 2) / whole) as u8);
            }
        }
        Ok(out)
    }
}

/// What the sample `i` of `to` covers of `from`, and how much of each in parts of which a whole one has `to`.
fn covered(i: u32, to: u32, from: u32) -> impl Iterator<Item = (u32, u64)> + Clone {
    let [i, to, from] = [i, to, from].map(u64::from);
    let (begin, end) = (i * from, (i + 1) * from);
    (begin / to..end.div_ceil(to)).map(move |j| (j as u32, ((j + 1) * to).min(end) - (j * to).max(begin)))
}

/// True where all samples that a coarser one stands for are.
pub(crate) fn all<const D: usize>(mask: &Grid<bool, D>, coarse: Domain<D>) -> Result<Grid<bool, D>, Error> {
    let mut out = Grid::try_filled(coarse, 1, false)?;
    for (to, at) in out.samples_mut().iter_mut().zip(coarse.positions()) {
        *to = finer(mask.domain(), at).all(|i| mask.samples()[i]);
    }
    Ok(out)
}

impl<const D: usize> Exemplars<D> {
    /// The same sources at half the size: features are means, and a sample is valid only if all are that it stands for.
    /// Source `s` of the answer is source `s` of these; [`SourceMap::finer`] and [`SourceMap::coarser`] lead from
    /// samples of one to those of the other.
    ///
    /// The answer's origins name the exemplars that these were made of: a map of coarser sources is made finer before
    /// it is rendered.
    ///
    /// # Errors
    /// [`Error::NothingValid`] if no whole block is, [`Error::Allocation`].
    pub fn coarser(&self) -> Result<Self, Error> {
        let coarse = |source: &Source<D>| {
            let valid = source.valid.as_deref().map(Grid::<bool, D>::coarser).transpose()?;
            Ok(Source { features: source.features.coarser()?, valid: valid.map(Into::into), origin: source.origin })
        };
        let sources = self.sources().iter().map(|source| coarse(source)).collect::<Result<_, Error>>()?;
        Self::from_sources(sources, self.weights().to_vec())
    }
}

impl<const D: usize> SourceMap<D> {
    /// A map of coarser sources as one of these: each sample becomes the block of samples that it stands for, as far as
    /// the output reaches. Neighbours of one patch are neighbours of one patch again, and all are exact copies.
    ///
    /// # Errors
    /// [`Error::Pyramid`] if this is no map of these sources or of this output at half the size, [`Error::Allocation`].
    pub fn finer(&self, exemplars: &Exemplars<D>, output: Domain<D>) -> Result<Self, Error> {
        check(&self.table, exemplars, self.domain() == output.coarser())?;
        let mut map = Self::unassigned(exemplars, output)?;
        let table = &map.table;
        for (id, at) in map.ids.plane_mut(0).iter_mut().zip(output.positions()) {
            let Some((source, coarse)) = self.locate(Domain::above(at)) else { continue };
            let domain = table.sources()[source].1;
            let (first, block) = (Domain::below(coarse), Domain::below(Domain::above(at)));
            // A single sample along an axis stands for itself.
            let along = |a: usize| domain.nearest(a, i64::from(first[a] + at[a] - block[a]));
            *id = table.id(source, std::array::from_fn(along));
        }
        Ok(map)
    }

    /// The map at half the size, over the coarser sources: each sample becomes the one that stands for the first of its
    /// block. Undoes [`finer`](Self::finer).
    ///
    /// # Errors
    /// [`Error::Pyramid`] if `coarse` are not these sources at half the size, [`Error::Allocation`].
    pub fn coarser(&self, coarse: &Exemplars<D>) -> Result<Self, Error> {
        let fits = |(fine, coarse): (&(_, Domain<D>), &(_, Domain<D>))| within(fine.1) == coarse.1;
        let sources = coarse.table().sources();
        let fit = self.table.sources().len() == sources.len() && self.table.sources().iter().zip(sources).all(fits);
        if !fit {
            return Err(Error::Pyramid);
        }
        let mut map = Self::unassigned(coarse, self.domain().coarser())?;
        let domain = map.domain();
        for (id, at) in map.ids.plane_mut(0).iter_mut().zip(domain.positions()) {
            let Some((source, fine)) = self.locate(Domain::below(at)) else { continue };
            let shape = sources[source].1.shape;
            let above = Domain::above(fine);
            // The odd sample at a source's end has none that stands for it; the one before does.
            *id = map.table.id(source, std::array::from_fn(|a| above[a].min(shape[a] - 1)));
        }
        Ok(map)
    }
}

/// A table is that of exemplars at half the size.
fn check<const D: usize>(coarse: &crate::SourceTable<D>, exemplars: &Exemplars<D>, output: bool) -> Result<(), Error> {
    let (coarse, fine) = (coarse.sources(), exemplars.table().sources());
    let fit = coarse.len() == fine.len() && coarse.iter().zip(fine).all(|(c, f)| c.1 == within(f.1));
    if fit && output { Ok(()) } else { Err(Error::Pyramid) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Origin, Plane, Rng, Role, SampleId, Samples, Seed, Transform};

    fn random<const D: usize>(rng: &mut Rng) -> Exemplars<D> {
        let mut source = |exemplar| {
            let shape = std::array::from_fn(|_| 1 + rng.below(7));
            let domain = Domain { shape, periodic: std::array::from_fn(|_| rng.below(2) == 0) };
            let features = (0..domain.len() * 2).map(|_| rng.below(256) as u8).collect();
            let valid = (0..domain.len()).map(|_| rng.below(8) != 0).collect();
            Source {
                features: Grid::from_vec(domain, 2, features).unwrap(),
                valid: (exemplar != 0).then(|| Grid::from_vec(domain, 1, valid).unwrap()).map(Into::into),
                origin: Origin { exemplar, transform: Transform::IDENTITY },
            }
        };
        Exemplars::from_sources(vec![source(0), source(1), source(2)], vec![1, 2]).unwrap()
    }

    #[test]
    fn large_pictures_are_reduced_to_means() {
        let samples = (0..7 * 5).map(|i| i as u8 * 7).collect();
        let grid = Grid::from_vec(Domain::open([5, 7]), 1, samples).unwrap();
        let small = grid.reduced(3).unwrap();
        assert_eq!(small.domain().shape, [2, 3]);
        // Seven samples are three: the first has two and a third of them across, and of five down two and a half.
        let rows = [0, 1, 2].map(|y| f64::from(7 * 7 * y) * (7.0 / 3.0) + 7.0 * (1.0 + 2.0 / 3.0));
        let mean = (rows[0] + rows[1] + rows[2] / 2.0) / (2.5 * 7.0 / 3.0);
        assert_eq!(small.samples()[0], mean.round() as u8);
        let one = grid.reduced(1).unwrap();
        assert_eq!((one.domain().shape, one.samples()[0]), ([1, 1], 119));
    }

    /// The block of a coarse sample, by its definition.
    fn block<const D: usize>(fine: Domain<D>, coarse: [u32; D]) -> Vec<[u32; D]> {
        let covers = |p: [u32; D]| {
            (0..D).all(|a| {
                if !Domain::<D>::halves(a) {
                    return p[a] == coarse[a];
                }
                let [one, two] = [2 * coarse[a], 2 * coarse[a] + 1];
                p[a] == one || p[a] == if fine.periodic[a] { two % fine.shape[a] } else { two }
            })
        };
        fine.positions().filter(|&p| covers(p)).collect()
    }

    fn check_levels<const D: usize>(case: u64) {
        let mut rng = Seed(case).derive("pyramid", D as u64).rng();
        let fine = random::<D>(&mut rng);
        let coarse = fine.coarser().unwrap();
        for (fine, coarse) in fine.sources().iter().zip(coarse.sources()) {
            assert_eq!(coarse.domain(), within(fine.domain()));
            for at in coarse.domain().positions() {
                let block = block(fine.domain(), at);
                let valid = block.iter().all(|&p| fine.valid.as_deref().is_none_or(|v| v.get(0, p)));
                assert_eq!(coarse.valid.as_deref().is_none_or(|v| v.get(0, at)), valid);
                for c in 0..2 {
                    let mean =
                        block.iter().map(|&p| f64::from(fine.features.get(c, p))).sum::<f64>() / block.len() as f64;
                    let found = f64::from(coarse.features.get(c, at));
                    assert!((found - mean).abs() <= 0.5, "{found} {mean}");
                }
            }
        }
        let shape = std::array::from_fn(|_| 1 + rng.below(9));
        let output = Domain { shape, periodic: std::array::from_fn(|_| rng.below(2) == 0) };
        let mut map = SourceMap::unassigned(&coarse, output.coarser()).unwrap();
        let n = coarse.table().len();
        map.ids.plane_mut(0).iter_mut().for_each(|id| {
            let drawn = rng.below(n + 1);
            *id = if drawn == n { SampleId::UNASSIGNED } else { SampleId::new(drawn) };
        });
        let finer = map.finer(&fine, output).unwrap();
        assert_eq!(finer.domain(), output);
        for at in output.positions() {
            let (below, above) = (finer.locate(at), map.locate(Domain::halved(at, 1)));
            assert_eq!(below.is_some(), above.is_some());
            let (Some((source, p)), Some((coarse_source, c))) = (below, above) else { continue };
            assert_eq!(source, coarse_source);
            assert!(block(fine.sources()[source].domain(), c).contains(&p), "{c:?} {p:?}");
        }
        assert_eq!(finer.coarser(&coarse).unwrap(), map);
    }

    #[test]
    fn coarse_samples_stand_for_their_blocks_and_maps_go_down_and_up() {
        for case in 0..200 {
            check_levels::<1>(case);
            check_levels::<2>(case);
            check_levels::<3>(case);
        }
    }

    #[test]
    fn a_coarse_copy_is_a_fine_copy() {
        let domain = Domain::open([12, 10]);
        let features = Grid::from_vec(domain, 1, (0..120).collect()).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let fine = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        let coarse = fine.coarser().unwrap();
        let output = Domain::open([7, 8]);
        let mut map = SourceMap::unassigned(&coarse, output.coarser()).unwrap();
        for at in map.domain().positions() {
            map.ids.set(0, at, coarse.table().id(0, [at[0] + 1, at[1] + 1]));
        }
        let finer = map.finer(&fine, output).unwrap();
        assert!(output.positions().all(|at| finer.locate(at) == Some((0, [at[0] + 2, at[1] + 2]))));
    }

    #[test]
    fn maps_of_other_levels_are_refused() {
        let fine = random::<2>(&mut Seed(5).rng());
        let coarse = fine.coarser().unwrap();
        let output = Domain::open([6, 6]);
        let map = SourceMap::unassigned(&coarse, Domain::open([3, 3])).unwrap();
        assert!(map.finer(&fine, output).is_ok());
        assert_eq!(map.finer(&fine, Domain::open([7, 6])), Err(Error::Pyramid));
        assert_eq!(map.finer(&coarse, output), Err(Error::Pyramid));
        assert_eq!(map.coarser(&fine), Err(Error::Pyramid));
    }

    #[test]
    fn odd_samples_are_those_of_their_block() {
        let plane = Plane::new(Role::Scalar, Samples::U8(Grid::try_filled(Domain::open([6, 9]), 1, 0).unwrap()));
        let fine = Exemplars::of(&[std::slice::from_ref(&plane)]).unwrap();
        let coarse = fine.coarser().unwrap();
        let mut map = SourceMap::unassigned(&fine, Domain::open([2, 4])).unwrap();
        for (x, at) in [(0, [3, 5]), (2, [5, 8])] {
            map.ids.set(0, [0, x], fine.table().id(0, at));
        }
        let found = map.coarser(&coarse).unwrap();
        assert_eq!([0, 1].map(|x| found.locate([0, x])), [Some((0, [1, 2])), Some((0, [2, 3]))], "none stands for 8");
    }

    #[test]
    fn guides_have_the_levels_of_their_exemplars() {
        let fine = random::<2>(&mut Seed(6).rng());
        let maps: Vec<_> = fine.sources().iter().map(|s| s.features.map(|f| f / 2).unwrap()).collect();
        let target = Grid::from_vec(Domain::open([1, 3]), 2, vec![10, 20, 31, 40, 41, 52]).unwrap();
        let asked = Grid::from_vec(Domain::open([1, 3]), 1, vec![true, false, true]).unwrap();
        let guide = crate::Guide::new(&fine, &maps, target).unwrap().asking(asked).unwrap();
        let coarse = guide.coarser().unwrap();
        coarse.check(&fine.coarser().unwrap()).unwrap();
        assert_eq!(coarse.target().samples(), [15, 31, 41, 52]);
        assert_eq!(coarse.asked().unwrap().samples(), [false, true]);
    }
}
