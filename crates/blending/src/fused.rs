//! Joining in the gradient domain: the output's differences are those of its patches, also across seams.
//! `[Kwatra03 5]` names the choice among ways to hide seams; the least squares are those of Pérez, Gangnet and Blake
//! (2003).

use selvedge_core::{
    Averaging, Bytes, Domain, Error, Grid, Payload, Plane, Render, SampleId, SourceMap, Window, par, try_vec,
};

use crate::conjugate::Held;
use crate::map_view::MapView;
use crate::near::near_seams;
use crate::pieces::{Piece, Pieces};
use crate::poisson::Poisson;

/// Seams, or samples, whose numbers are looked up at once: few enough to stay near the processor.
const TOGETHER: usize = 1 << 12;

/// Blocks of that many that are held until they are added: enough for the threads of most machines, and a bound for
/// memory on the others.
const BLOCKS: usize = 16;

/// How far from the exact solution a held one may be, in parts of the range of values: 1e-4 of one of 255 grey levels.
const TOLERANCE: f64 = 1e-4 / 255.0;

/// A source map whose patches are fused: each keeps its differences from sample to sample, and what it is raised or
/// lowered by follows from its neighbors, by least squares. Steps at seams vanish, however high; detail stays as sharp
/// as it was.
///
/// Across a seam the difference asked for is the mean of those that both patches have there, or the stronger one. Where
/// only one goes on it is that one's, where none does, none. The mean of the output stays. Made for heights, whose
/// steps a blend can only tilt; what is coloured may take on the colour of its neighbors.
///
/// Values are taken as they are stored, but colours that are floats as the encoder compares them, since a step of light
/// that is seen in the dark is none where it is bright; colours are weighed by their alpha, and nothing leaves the
/// exemplars' range; normals keep their length. Where nothing changes samples are copied bit for bit.
#[derive(Clone, Debug)]
pub struct Fused<'m, const D: usize> {
    laid: MapView<'m, D>,
    reach: Option<u32>,
    stronger: bool,
}

impl<'m, const D: usize> Fused<'m, D> {
    /// Fuses all that is joined. Patches go on where their source is `valid`, as for [`Feathered`](crate::Feathered).
    ///
    /// # Errors
    /// [`selvedge_core::Error::UnknownSample`] if the map names one, [`crate::Error::Shape`] for validity of other
    /// shapes than the sources.
    pub fn new(map: &'m SourceMap<D>, valid: Vec<Option<&'m Grid<bool, D>>>) -> Result<Self, crate::Error> {
        Ok(Self { laid: MapView::new(map, valid)?, reach: None, stronger: false })
    }

    /// The same, but positions where `kept` is true are copied, and what is around them follows.
    ///
    /// # Errors
    /// [`crate::Error::Shape`] if it has another shape than the map.
    pub fn keeping(self, kept: &'m Grid<bool, D>) -> Result<Self, crate::Error> {
        Ok(Self { laid: self.laid.keeping(kept)?, ..self })
    }

    /// The same, but positions farther than so many samples from any seam, along an axis, are copied.
    #[must_use]
    pub fn within(self, reach: u32) -> Self {
        Self { reach: Some(reach), ..self }
    }

    /// The same, but across seams the stronger of both differences is asked for.
    #[must_use]
    pub fn stronger(self) -> Self {
        Self { stronger: true, ..self }
    }

    /// An upper bound of what rendering takes besides the planes and the output, for planes of so many channels; more
    /// if some of the output is to be copied.
    pub fn bytes(output: Domain<D>, channels: usize, copied: bool) -> Bytes {
        let samples = Bytes::of_samples(output, 1);
        let channels = channels as u64;
        let of_each = 8 * channels + 24 + if copied { 48 } else { 0 };
        // Were every sample beside a seam along every axis: two places and a number a channel, and while they are
        // looked up four ids and five numbers.
        let at_once = |blocks: usize| samples.min(Bytes((TOGETHER * blocks) as u64)) * D as u64;
        let held = at_once(BLOCKS) * (8 + 8 * channels);
        let looked_up = at_once(par::threads().min(BLOCKS)) * (16 + 40 * channels);
        samples * of_each + held + looked_up + Bytes(1 << 18)
    }

    /// What each channel of a piece is raised by, least squares of what seams ask for; `None` where they ask for
    /// nothing.
    fn raised(
        &self,
        piece: &Piece<D>,
        payload: &Payload<'_, D>,
        averaging: &Averaging,
    ) -> Result<Option<Vec<Vec<f64>>>, Error> {
        let (mut raised, mut is_asked) = (Vec::new(), false);
        for _ in averaging.ranges() {
            raised.push(try_vec(piece.window.len(), 0.0)?);
        }
        // Seams before the box end in it.
        let window = piece.window.grown(self.laid.map.domain(), [1; D], [0; D]);
        let blocks = window.len().div_ceil(TOGETHER);
        // Some blocks at a time: what they ask for is held until it is added, in order.
        for first in (0..blocks).step_by(BLOCKS) {
            let asked = |i| self.asked((piece, &window, first + i), payload, averaging);
            for Asked { seams, differences } in par::map_indexed((blocks - first).min(BLOCKS), asked) {
                is_asked |= !seams.is_empty();
                for (raised, differences) in raised.iter_mut().zip(&differences) {
                    for (&[p, q], d) in seams.iter().zip(differences) {
                        raised.get_mut(p as usize).into_iter().for_each(|p| *p -= d);
                        raised.get_mut(q as usize).into_iter().for_each(|q| *q += d);
                    }
                }
            }
        }
        if !is_asked {
            return Ok(None);
        }
        let poisson = Poisson::new(piece.domain(self.laid.map.domain()), piece.tied)?;
        for (raised, [low, high]) in raised.iter_mut().zip(averaging.ranges()) {
            match &piece.free {
                None => poisson.solve(raised),
                Some(free) => {
                    let span = if (high - low).is_finite() { high - low } else { 1.0 };
                    Held { free, poisson: &poisson }.solve(raised, span * TOLERANCE)?;
                }
            }
        }
        Ok(Some(raised))
    }

    /// Raises the samples of a piece.
    fn raise(
        &self,
        plane: &mut Plane<D>,
        (piece, raised): (&Piece<D>, &[Vec<f64>]),
        payload: &Payload<'_, D>,
        averaging: &Averaging,
    ) {
        let map = self.laid.map;
        let mut places = piece.window.places(map.domain()).flatten().enumerate();
        let (mut block, mut ids) = (Vec::new(), Vec::new());
        let (mut channels, mut values) = (vec![Vec::new(); raised.len()], vec![0.0; raised.len()]);
        loop {
            block.clear();
            block.extend(places.by_ref().filter(|&(i, _)| raised.iter().any(|raised| raised[i] != 0.0)).take(TOGETHER));
            if block.is_empty() {
                return;
            }
            ids.clear();
            ids.extend(block.iter().map(|&(_, place)| map.ids.plane(0)[place]));
            for (c, numbers) in channels.iter_mut().enumerate() {
                numbers.resize(ids.len(), 0.0);
                payload.numbers(c, &ids, numbers);
            }
            averaging.weigh(&mut channels);
            for (k, &(i, place)) in block.iter().enumerate() {
                for ((value, numbers), raised) in values.iter_mut().zip(&channels).zip(raised) {
                    *value = numbers[k] + raised[i];
                }
                averaging.set(&mut plane.samples, place, &mut values);
            }
        }
    }

    /// Where samples may change; `None` for everywhere.
    fn free(&self) -> Result<Option<Vec<bool>>, Error> {
        let map = self.laid.map;
        let mut free = match self.reach {
            Some(reach) => near_seams(map, reach)?,
            None => try_vec(map.domain().len(), true)?,
        };
        free.iter_mut().zip(map.ids.plane(0)).for_each(|(free, id)| *free &= id.is_assigned());
        if let Some(kept) = self.laid.kept {
            free.iter_mut().zip(kept.plane(0)).for_each(|(free, kept)| *free &= !kept);
        }
        Ok(free.contains(&false).then_some(free))
    }

    /// What the seams after each position of a block of a window ask for, as far as they touch a piece.
    fn asked(
        &self,
        (piece, window, block): (&Piece<D>, &Window<D>, usize),
        payload: &Payload<'_, D>,
        averaging: &Averaging,
    ) -> Asked {
        let map = self.laid.map;
        let (domain, local) = (map.domain(), window.local());
        let place = |at| piece.place(domain, at).map_or(u32::MAX, |place| place as u32);
        // On both sides of a seam: what shows, and what the other side's patch has there.
        let (mut seams, mut ids) = (Vec::new(), [const { Vec::new() }; 4]);
        for i in block * TOGETHER..((block + 1) * TOGETHER).min(window.len()) {
            let Some(at) = window.position(domain, local.position(i)) else { continue };
            for axis in (0..D).filter(|&axis| map.is_seam(at, axis)) {
                let Some(next) = domain.next(at, axis) else { continue };
                let both = [at, next].map(place);
                if both == [u32::MAX; 2] {
                    continue;
                }
                let [here, there] = [at, next].map(|at| map.ids.get(0, at));
                let step = |id, by: i32| self.step(id, std::array::from_fn(|a| if a == axis { by } else { 0 }));
                seams.push(both);
                for (ids, id) in ids.iter_mut().zip([here, step(there, -1), step(here, 1), there]) {
                    ids.push(id);
                }
            }
        }
        let numbers = ids.each_ref().map(|ids| {
            let mut channels = vec![vec![0.0; ids.len()]; averaging.ranges().len()];
            channels.iter_mut().enumerate().for_each(|(c, to)| payload.numbers(c, ids, to));
            averaging.weigh(&mut channels);
            channels
        });
        let [here, before, after, there] = &numbers;
        // Across seam i, as the patch on this side has it, and as the one beyond does.
        let own = |c: usize, i: usize| [after[c][i] - here[c][i], there[c][i] - before[c][i]];
        let goes_on = |i: usize| [ids[2][i].is_assigned(), ids[1][i].is_assigned()];
        let is_stronger = |i: usize| {
            let squares = (0..here.len()).map(|c| own(c, i).map(|d| d * d));
            let [first, second] = squares.fold([0.0, 0.0], |sum, squares| [sum[0] + squares[0], sum[1] + squares[1]]);
            second <= first
        };
        let asked = |c: usize, i: usize| match (own(c, i), goes_on(i)) {
            ([a, b], [true, true]) if !self.stronger => (a + b) / 2.0,
            ([a, b], [true, true]) => {
                if is_stronger(i) {
                    a
                } else {
                    b
                }
            }
            ([a, _], [true, false]) => a,
            ([_, b], [false, true]) => b,
            _ => 0.0,
        };
        let of = |c: usize| (0..seams.len()).map(|i| asked(c, i) - (there[c][i] - here[c][i])).collect();
        let differences = (0..here.len()).map(of).collect();
        Asked { seams, differences }
    }

    /// The sample `by` away in the same patch, if it may show.
    fn step(&self, id: SampleId, by: [i32; D]) -> SampleId {
        self.laid.map.table.step(id, by).filter(|&id| self.laid.may_show(id)).unwrap_or(SampleId::UNASSIGNED)
    }
}

/// What seams ask for.
struct Asked {
    /// The places on both sides in the piece's box; one that no box has for what is beyond it.
    seams: Vec<[u32; 2]>,
    /// By channel what the second has to be raised by, beyond the first.
    differences: Vec<Vec<f64>>,
}

impl<const D: usize> Render<D> for Fused<'_, D> {
    /// # Complexity
    /// Time `O(n log n)` in the output's samples. Where some are copied that of the boxes around what is not, and so
    /// often as conjugate gradients take in those which this does not fill, some tens.
    fn render(&self, planes: &[&Plane<D>]) -> Result<Plane<D>, Error> {
        let payload = Payload::new(&self.laid.map.table, planes)?;
        let mut plane = payload.gather(&self.laid.map.ids)?;
        if self.laid.map.domain().is_empty() {
            return Ok(plane);
        }
        let averaging = Averaging::of(planes).as_compared(planes);
        let mut fuse = |piece: &Piece<D>| -> Result<(), Error> {
            if let Some(raised) = self.raised(piece, &payload, &averaging)? {
                self.raise(&mut plane, (piece, &raised), &payload, &averaging);
            }
            Ok(())
        };
        match self.free()? {
            None => fuse(&Piece::all(self.laid.map.domain()))?,
            Some(free) => {
                let mut pieces = Pieces::new(self.laid.map.domain(), free);
                while let Some(piece) = pieces.next()? {
                    fuse(&piece)?;
                }
            }
        }
        Ok(plane)
    }
}
