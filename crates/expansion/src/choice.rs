//! Who has a choice.

use selvedge_core::{SampleId, try_vec};

use crate::error::Error;
use crate::frame::Frame;

/// The choice that a sample of a frame has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Nothing is there and nothing is offered.
    Empty,
    /// It keeps what is there.
    Old,
    /// It takes the offer.
    New,
    /// The cut decides.
    Free,
}

/// What the caller decides about a sample that could keep or take: a stroke of a brush, a constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pin {
    /// It keeps what is there.
    Old,
    /// It takes the offer.
    New,
}

/// What becomes of a sample that has nothing and is offered something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Holes {
    /// It takes the offer, whatever that costs. `[Kwatra03 3]`
    #[default]
    Fill,
    /// The cut decides: to have nothing is a label like any other, at the price that [`Prices`](crate::Prices) puts on
    /// the unassigned sample.
    Free,
}

impl<const D: usize> Frame<D> {
    /// The choice of each sample; `pin` is asked by places in the output, for samples that could keep or take.
    ///
    /// At every seam both sides should be defined beyond it. Hence samples next to one that can only keep what is there
    /// (the ring, and where the source ends) keep it as well, and those next to one that fills a hole take the offer.
    /// At the ends of an overlap, next to both, prices decide. Of an offer surrounded by what is there nothing is
    /// forced to show. Pins of the caller force no neighbour. `[Kwatra03 3.2]`
    ///
    /// # Errors
    /// [`Error::Core`] if memory is short.
    pub fn choices(&self, holes: Holes, pin: impl Fn(usize) -> Option<Pin>) -> Result<Vec<Choice>, Error> {
        let mut choices = try_vec(self.old.len(), Choice::Empty)?;
        for (i, choice) in choices.iter_mut().enumerate() {
            *choice = match (self.old[i].is_assigned(), self.new[i].is_assigned()) {
                (false, false) => Choice::Empty,
                (true, false) => Choice::Old,
                (false, true) if holes == Holes::Fill => Choice::New,
                (_, true) => match pin(self.places[i] as usize) {
                    Some(Pin::Old) => Choice::Old,
                    Some(Pin::New) => Choice::New,
                    None => Choice::Free,
                },
            };
        }
        self.force_neighbours(&mut choices)?;
        Ok(choices)
    }

    /// The sample that a place of the frame has whatever the cut says, if it has no choice.
    pub(crate) fn decided(&self, choices: &[Choice], place: usize) -> SampleId {
        if choices[place] == Choice::New { self.new[place] } else { self.old[place] }
    }

    fn force_neighbours(&self, choices: &mut [Choice]) -> Result<(), Error> {
        const OLD: u8 = 1;
        const NEW: u8 = 2;
        // Few force any: what has a choice, and what could have one, forces none.
        let mut forces = try_vec(choices.len(), 0_u8)?;
        for (i, forces) in forces.iter_mut().enumerate() {
            *forces = match choices[i] {
                Choice::Old if !self.new[i].is_assigned() => OLD,
                Choice::New if !self.old[i].is_assigned() => NEW,
                _ => 0,
            };
        }
        let mut near = try_vec(choices.len(), 0_u8)?;
        for axis in 0..D {
            self.pairs(axis).for_each(|(s, t)| {
                near[s] |= forces[t];
                near[t] |= forces[s];
            });
        }
        for (choice, near) in choices.iter_mut().zip(&near).filter(|(c, _)| **c == Choice::Free) {
            *choice = match *near {
                OLD => Choice::Old,
                NEW => Choice::New,
                _ => Choice::Free,
            };
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Exemplars, Grid, Origin, Patch, Source, SourceMap, Transform, Window};

    /// A row: `old` has samples where it is not a dot, a patch is offered at columns 2 to 7 of 10.
    fn row(old: &str) -> Frame<1> {
        let features = Grid::try_filled(Domain::open([20]), 1, 0).unwrap();
        let origin = Origin { exemplar: 0, transform: Transform::IDENTITY };
        let e = Exemplars::from_sources(vec![Source { features, valid: None, origin }], vec![1]).unwrap();
        let mut map = SourceMap::unassigned(&e, Domain::open([10])).unwrap();
        for (id, letter) in map.ids.plane_mut(0).iter_mut().zip(old.bytes()) {
            *id = if letter == b'.' { SampleId::UNASSIGNED } else { SampleId::new(0) };
        }
        Frame::of_patch(&e, &map, &Patch { source: 0, offset: [-5] }, &Window { start: [2], shape: [6] }).unwrap()
    }

    fn drawn(frame: &Frame<1>, holes: Holes, pin: impl Fn(usize) -> Option<Pin>) -> String {
        let letter = |c: Choice| match c {
            Choice::Empty => '.',
            Choice::Old => 'o',
            Choice::New => 'n',
            Choice::Free => 'f',
        };
        frame.choices(holes, pin).unwrap().into_iter().map(letter).collect()
    }

    #[test]
    fn rings_keep_holes_are_filled_and_both_force_their_neighbours() {
        assert_eq!(drawn(&row("xxxxxxxxxx"), Holes::Fill, |_| None), "ooffffoo");
        assert_eq!(drawn(&row("xxxxxx...."), Holes::Fill, |_| None), "ooffnnn.");
        assert_eq!(drawn(&row("x...xx...x"), Holes::Fill, |_| None), ".nnnnnn.");
        // Between a ring and a hole prices decide.
        assert_eq!(drawn(&row("xxx......."), Holes::Fill, |_| None), "ofnnnnn.");
    }

    #[test]
    fn holes_that_are_free_force_nobody() {
        assert_eq!(drawn(&row("xxxxxx...."), Holes::Free, |_| None), "oofffff.");
    }

    #[test]
    fn pins_decide_their_own_sample_alone() {
        let pin = |place: usize| match place {
            4 => Some(Pin::New),
            6 => Some(Pin::Old),
            _ => None,
        };
        assert_eq!(drawn(&row("xxxxxxxxxx"), Holes::Fill, pin), "oofnfooo");
        // Holes are filled all the same; a pinned hole that may stay one stays.
        assert_eq!(drawn(&row("xxxx......"), Holes::Fill, pin), "oonnnnn.");
        assert_eq!(drawn(&row("xxxxxx...."), Holes::Free, pin), "oofnfof.");
    }
}
