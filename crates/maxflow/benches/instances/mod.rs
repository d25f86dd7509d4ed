//! Instances as texture synthesis makes them: classes A to D of `DESIGN.md`.

mod classes;
mod strokes;
mod texture;

pub(crate) use strokes::Brush;

use std::path::Path;

use selvedge_maxflow::{PairwiseTerm, Side};

/// An energy of one binary label a grid node.
#[derive(Default)]
pub(crate) struct Instance {
    /// Lengths of the axes, slowest first; 2 or 3.
    pub(crate) shape: Vec<usize>,
    pub(crate) pins: Vec<(usize, Side)>,
    /// Energies of label 0 and label 1: a node each, or none.
    pub(crate) unaries: Vec<[i32; 2]>,
    /// By axis: of each node with the next, nothing at the end of an axis. As many axes as were given terms.
    pub(crate) terms: Vec<Vec<PairwiseTerm>>,
}

impl Instance {
    /// By name, with textures made up or from a folder; or of a file that [`bytes`](Self::bytes) were written to.
    pub(crate) fn named(name: &str, pictures: Option<&Path>) -> Self {
        match Path::new(name).extension() {
            Some(_) => Self::of_bytes(&std::fs::read(name).unwrap_or_else(|e| panic!("{name}: {e}"))),
            None => classes::instance(name, pictures),
        }
    }

    /// Sets the term of a node and the next along an axis.
    pub(crate) fn set(&mut self, v: usize, axis: usize, term: PairwiseTerm) {
        if self.terms.is_empty() {
            self.terms = vec![vec![PairwiseTerm::default(); self.len()]; self.shape.len()];
        }
        self.terms[axis][v] = term;
    }

    pub(crate) fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// As 32-bit integers, low bytes first: number of axes, shape, numbers of pins, unaries and terms; then (node, 0
    /// for the source or 1 for the sink), (energies), (node, axis, `e00`, `e01`, `e10`, `e11`).
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut words: Vec<i32> = vec![self.shape.len() as i32];
        words.extend(self.shape.iter().map(|&n| n as i32));
        words.extend([self.pins.len(), self.unaries.len(), self.listed().count()].map(|n| n as i32));
        words.extend(self.pins.iter().flat_map(|&(v, side)| [v as i32, i32::from(side == Side::Sink)]));
        words.extend(self.unaries.as_flattened());
        words.extend(self.listed().flat_map(|(v, axis, t)| [v as i32, axis as i32, t.e00, t.e01, t.e10, t.e11]));
        words.iter().flat_map(|w| w.to_le_bytes()).collect()
    }

    /// Node, the next, and term of all nodes that have a next.
    pub(crate) fn neighbours(&self) -> impl Iterator<Item = (usize, usize, PairwiseTerm)> + '_ {
        self.listed().map(|(v, axis, term)| (v, v + self.shape[axis + 1..].iter().product::<usize>(), term))
    }

    /// Node, axis and term of all nodes that have a next.
    fn listed(&self) -> impl Iterator<Item = (usize, usize, PairwiseTerm)> + '_ {
        let has_next = |v: usize, axis: usize| {
            let stride: usize = self.shape[axis + 1..].iter().product();
            v / stride % self.shape[axis] + 1 < self.shape[axis]
        };
        let all =
            self.terms.iter().enumerate().flat_map(|(axis, terms)| (0..).zip(terms).map(move |(v, &t)| (v, axis, t)));
        all.filter(move |&(v, axis, _)| has_next(v, axis))
    }

    fn of_bytes(bytes: &[u8]) -> Self {
        let mut words = bytes.as_chunks().0.iter().map(|&bytes| i32::from_le_bytes(bytes));
        let mut next = || words.next().expect("a whole file");
        let axes = next();
        let shape = (0..axes).map(|_| next() as usize).collect();
        let [pins, unaries, terms] = [next(), next(), next()];
        let side = |of: i32| if of == 0 { Side::Source } else { Side::Sink };
        let pins = (0..pins).map(|_| (next() as usize, side(next()))).collect();
        let unaries = (0..unaries).map(|_| [next(), next()]).collect();
        let mut instance = Self { shape, pins, unaries, terms: Vec::new() };
        for _ in 0..terms {
            let [v, axis, e00, e01, e10, e11] = std::array::from_fn(|_| next());
            instance.set(v as usize, axis as usize, PairwiseTerm { e00, e01, e10, e11 });
        }
        instance
    }
}
