//! Two labels over a whole output: one cut, solved again after strokes from the flow that there is.

use selvedge_core::{Domain, Exemplars, SampleId, SeamCosts, try_vec};
use selvedge_expansion::Prices;
use selvedge_maxflow::{BinaryEnergy, MaxflowError, Minimum, PairwiseTerm, Side};

use crate::error::Error;
use crate::labels::label::Label;
use crate::labels::options::LabelOptions;
use crate::labels::prices::NONE;
use crate::labels::sets::Sets;

/// The cut between two labels. A node is a position; label 1 is the source's side, the smallest of all that are
/// cheapest: where pictures agree the first shows.
#[derive(Debug)]
pub(super) struct Two<const D: usize> {
    energy: BinaryEnergy<D>,
    minimum: Minimum,
    /// By place, the label that shows without a stroke, if there is no choice; 2 where the cut decides.
    given: Vec<u8>,
    /// By place, the stroke that the graph knows.
    known: Vec<u8>,
    /// By place, the label of the last cut.
    pub(super) labels: Vec<u8>,
}

/// The cut decides.
const FREE: u8 = 2;

impl<const D: usize> Two<D> {
    /// `None` unless the cut is exact and shows something everywhere.
    ///
    /// # Errors
    /// [`Error::NoLabel`], [`Error::Cut`], [`Error::Core`].
    pub(super) fn new(
        exemplars: &Exemplars<D>,
        costs: &SeamCosts<D>,
        output: Domain<D>,
        labels: &[Label<D>],
        options: &LabelOptions<D>,
    ) -> Result<Option<Self>, Error> {
        let sets = Sets::of(exemplars, labels, options, output, None);
        let mut samples = try_vec(output.len(), [SampleId::UNASSIGNED; 2])?;
        let mut given = try_vec(output.len(), NONE)?;
        let (mut stuck, mut first) = (0, None);
        for (place, at) in output.positions().enumerate() {
            let at = at.map(|p| p as i32);
            samples[place] = [0, 1].map(|label| sets.sample(label, at));
            let may = [0, 1].map(|label| samples[place][label].is_assigned() && sets.lets(label, place));
            given[place] = match may {
                [true, true] => FREE,
                [true, false] => 0,
                [false, true] => 1,
                [false, false] => {
                    stuck += 1;
                    first = first.or(Some(place));
                    NONE
                }
            };
        }
        if let Some(place) = first.filter(|_| !options.leave_holes) {
            return Err(Error::NoLabel { at: output.position(place).to_vec(), places: stuck });
        }
        force_neighbours(output, &samples, &mut given)?;
        let mut energy = BinaryEnergy::new(output.shape.map(|n| n as usize), output.periodic).map_err(cut)?;
        for (place, _) in given.iter().enumerate().filter(|(_, given)| **given == NONE) {
            energy.graph_mut().mask(place).map_err(cut)?;
        }
        if let Some(own) = &options.own {
            for place in (0..output.len()).filter(|&place| given[place] == FREE) {
                energy.unary(place, own.plane(1)[place], own.plane(0)[place]).map_err(cut)?;
            }
        }
        let mut differences = try_vec(output.len(), 0)?;
        let both = |of: &[SampleId; 2]| of[0].is_assigned() && of[1].is_assigned();
        for (to, [a, b]) in differences.iter_mut().zip(&samples).filter(|(_, of)| both(of)) {
            *to = costs.norm(*a, *b);
        }
        let mut exact = true;
        for axis in 0..D {
            for (place, at) in output.positions().enumerate() {
                let Some(next) = output.next(at, axis).map(|next| output.index(next)) else { continue };
                // Where neither has a choice nothing is to be priced.
                if (given[place] != FREE && given[next] != FREE) || given[place] == NONE || given[next] == NONE {
                    continue;
                }
                let term = term(costs, axis, [samples[place], samples[next]], [differences[place], differences[next]]);
                exact &= i64::from(term.e00) + i64::from(term.e11) <= i64::from(term.e01) + i64::from(term.e10);
                energy.pairwise(place, axis, term).map_err(cut)?;
            }
        }
        if !exact {
            return Ok(None);
        }
        for (place, &label) in given.iter().enumerate() {
            pin(&mut energy, place, label)?;
        }
        let (known, labels) = (try_vec(output.len(), NONE)?, try_vec(output.len(), NONE)?);
        Ok(Some(Self { energy, minimum: Minimum::default(), given, known, labels }))
    }

    /// The labels of the last cut, by place; [`NONE`] in holes.
    pub(super) fn into_labels(self) -> Vec<u8> {
        self.labels
    }

    /// The labels of least price under strokes, from the last flow.
    ///
    /// # Errors
    /// [`Error::Cut`]; the flow found so far is kept.
    pub(super) fn cut(&mut self, strokes: &[u8], cancelled: &dyn Fn() -> bool) -> Result<(), Error> {
        for (place, (&stroke, known)) in strokes.iter().zip(&mut self.known).enumerate() {
            if stroke != *known {
                *known = stroke;
                pin(&mut self.energy, place, if stroke == NONE { self.given[place] } else { stroke })?;
            }
        }
        if cancelled() {
            return Err(cut(MaxflowError::Cancelled));
        }
        self.energy.minimize_into(&mut self.minimum, cancelled).map_err(cut)?;
        for (label, (place, given)) in self.labels.iter_mut().zip(self.given.iter().enumerate()) {
            *label = match self.minimum.cut.side(place) {
                _ if *given == NONE => NONE,
                Side::Source => 1,
                Side::Sink => 0,
            };
        }
        Ok(())
    }
}

/// Holds a node at a label, or lets it go.
fn pin<const D: usize>(energy: &mut BinaryEnergy<D>, place: usize, label: u8) -> Result<(), Error> {
    let graph = energy.graph_mut();
    match label {
        0 => graph.pin(place, Side::Sink),
        1 => graph.pin(place, Side::Source),
        FREE => graph.unpin(place),
        _ => Ok(()),
    }
    .map_err(cut)
}

/// The prices of two neighbours by their labels. Where a label is not defined, its price is that of the other, which
/// must show there: nothing depends on it.
fn term<const D: usize>(
    costs: &SeamCosts<D>,
    axis: usize,
    [here, there]: [[SampleId; 2]; 2],
    differences: [u32; 2],
) -> PairwiseTerm {
    let sample = |of: [SampleId; 2], label: usize| if of[label].is_assigned() { of[label] } else { of[1 - label] };
    let pair = |label: usize| [sample(here, label), sample(there, label)];
    let quad = costs.quad(axis, pair(1), pair(0), differences);
    PairwiseTerm { e00: quad.neither, e01: quad.t, e10: quad.s, e11: quad.both }
}

/// Positions next to one that has one label alone show it as well: at a seam both sides are defined beyond it, as in
/// [`Frame::choices`](selvedge_expansion::Frame::choices). Next to both, prices decide.
fn force_neighbours<const D: usize>(
    output: Domain<D>,
    samples: &[[SampleId; 2]],
    given: &mut [u8],
) -> Result<(), Error> {
    let mut near = try_vec(output.len(), [false; 2])?;
    let alone = |place: usize| match samples[place].map(SampleId::is_assigned) {
        [true, false] => Some(0),
        [false, true] => Some(1),
        _ => None,
    };
    for (place, at) in output.positions().enumerate() {
        for axis in 0..D {
            let Some(next) = output.next(at, axis).map(|next| output.index(next)) else { continue };
            for (a, b) in [(place, next), (next, place)] {
                if let Some(label) = alone(b) {
                    near[a][label] = true;
                }
            }
        }
    }
    for (given, near) in given.iter_mut().zip(&near).filter(|(given, _)| **given == FREE) {
        match near {
            [true, false] => *given = 0,
            [false, true] => *given = 1,
            _ => {}
        }
    }
    Ok(())
}

fn cut(error: MaxflowError) -> Error {
    Error::Cut(error.into())
}
