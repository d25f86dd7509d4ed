//! The energy layer against every labelling.

use crate::common::Draw;
use selvedge_maxflow::{BinaryEnergy, GraphEnergy, GridGraph, PairwiseTerm, Side};

/// An energy over a grid of 3 x 3, as lists.
struct Field {
    unary: Vec<[i32; 2]>,
    /// First node, axis, second node, term.
    pairs: Vec<(usize, usize, usize, PairwiseTerm)>,
}

impl Field {
    fn random(draw: &mut Draw, term: impl Fn(&mut Draw) -> PairwiseTerm) -> Self {
        let unary = (0..9).map(|_| [draw.below(9) as i32 - 4, draw.below(9) as i32 - 4]).collect();
        let right = (0..9).filter(|v| v % 3 < 2).map(|v| (v, 1, v + 1));
        let pairs = right.chain((0..6).map(|v| (v, 0, v + 3))).map(|(v, axis, w)| (v, axis, w, term(draw))).collect();
        Self { unary, pairs }
    }

    fn energy(&self) -> BinaryEnergy<2> {
        let mut energy = BinaryEnergy::new([3, 3], [false, false]).unwrap();
        for (v, u) in self.unary.iter().enumerate() {
            energy.unary(v, u[0], u[1]).unwrap();
        }
        for &(v, axis, _, term) in &self.pairs {
            energy.pairwise(v, axis, term).unwrap();
        }
        energy
    }

    /// The energy of a labelling, by definition.
    fn value(&self, is_zero: &[bool]) -> i64 {
        let unary: i32 = self.unary.iter().zip(is_zero).map(|(u, &zero)| u[usize::from(!zero)]).sum();
        let pairs = self.pairs.iter().map(|&(v, _, w, t)| match (is_zero[v], is_zero[w]) {
            (true, true) => t.e00,
            (true, false) => t.e01,
            (false, true) => t.e10,
            (false, false) => t.e11,
        });
        i64::from(unary + pairs.sum::<i32>())
    }

    fn labellings() -> impl Iterator<Item = Vec<bool>> {
        (0..512).map(|set| (0..9).map(|v| set >> v & 1 == 1).collect())
    }
}

fn any_term(draw: &mut Draw) -> PairwiseTerm {
    let mut e = || draw.below(12) as i32 - 3;
    PairwiseTerm { e00: e(), e01: e(), e10: e(), e11: e() }
}

fn regular_term(draw: &mut Draw) -> PairwiseTerm {
    let term = any_term(draw);
    PairwiseTerm { e00: term.e00.min(term.e01 + term.e10 - term.e11), ..term }
}

#[test]
fn regular_energies_reach_the_least_of_all_labellings() {
    let mut draw = Draw(11);
    for _ in 0..300 {
        let field = Field::random(&mut draw, regular_term);
        let minimum = field.energy().minimize().unwrap();
        let least = Field::labellings().map(|l| field.value(&l)).min().unwrap();
        assert_eq!(minimum.truncated, 0);
        assert_eq!(minimum.after, least);
        assert_eq!(minimum.after, field.value(minimum.cut.source_side()));
        assert_eq!(minimum.before, field.value(&[true; 9]));
    }
}

#[test]
fn a_fall_in_the_model_is_a_fall_in_truth() {
    let (mut draw, mut truncated, mut fell) = (Draw(12), 0, 0);
    for _ in 0..300 {
        let field = Field::random(&mut draw, any_term);
        let mut energy = field.energy();
        let minimum = energy.minimize().unwrap();
        let irregular = field.pairs.iter().filter(|(.., t)| t.e01 + t.e10 < t.e00 + t.e11).count();
        assert_eq!(minimum.truncated, irregular);
        assert_eq!(minimum.before, field.value(&[true; 9]), "before is the truth");
        assert_eq!(minimum.after, field.value(minimum.cut.source_side()), "after is the truth");
        assert!(minimum.after <= minimum.before, "the truth never rises");
        for labelling in Field::labellings() {
            assert_eq!(energy.value(&labelling).unwrap(), field.value(&labelling));
        }
        truncated += irregular;
        fell += usize::from(minimum.after < minimum.before);
    }
    assert!(truncated > 300 && fell > 250, "{truncated} terms truncated, {fell} energies fell: too few to tell");
}

#[test]
fn masked_nodes_have_no_terms() {
    let mut graph = GridGraph::new([1, 3], [false, false]).unwrap();
    graph.mask(1).unwrap();
    let mut energy = BinaryEnergy::from(graph);
    energy.unary(1, 100, 200).unwrap();
    energy.pairwise(0, 1, PairwiseTerm { e00: 1, e01: 50, e10: 60, e11: 2 }).unwrap();
    energy.unary(0, 0, 7).unwrap();
    energy.unary(2, 7, 1).unwrap();
    let minimum = energy.minimize().unwrap();
    assert_eq!((minimum.before, minimum.after, minimum.truncated), (7, 1, 0));
    assert_eq!([0, 1, 2].map(|v| minimum.cut.side(v)), [Side::Source, Side::Sink, Side::Sink]);
}

/// Columns of 4 side by side, ordered along their length, against every labelling in which no 1 is followed by a 0.
#[test]
fn ordered_energies_reach_the_least_of_all_ordered_labellings() {
    let (mut draw, mut bound) = (Draw(13), 0);
    for case in 0..300 {
        // Strong pulls on single nodes and between columns, none along them: without the order labels would change
        // often.
        let unary: Vec<[i32; 2]> = (0..12).map(|_| [draw.below(30) as i32, draw.below(30) as i32]).collect();
        let across: Vec<i32> = (0..8).map(|_| draw.below(40) as i32).collect();
        let along: Vec<i32> = (0..9).map(|_| draw.below(3) as i32).collect();
        let pin = (draw.below(12), [Side::Source, Side::Sink][draw.below(2)]);
        let build = || {
            let mut energy = BinaryEnergy::new([4, 3], [false, false]).unwrap();
            energy.graph_mut().pin(pin.0, pin.1).unwrap();
            unary.iter().enumerate().for_each(|(v, u)| energy.unary(v, u[0], u[1]).unwrap());
            let term = |c: i32| PairwiseTerm { e00: 0, e01: c, e10: c, e11: 0 };
            (0..8).for_each(|k| energy.pairwise(k / 2 * 3 + k % 2, 1, term(across[k])).unwrap());
            (0..9).for_each(|v| energy.pairwise(v, 0, term(along[v])).unwrap());
            energy
        };
        let value = |zero: &dyn Fn(usize) -> bool| {
            let own: i32 = (0..12).map(|v| unary[v][usize::from(!zero(v))]).sum();
            let differ = |v: usize, w: usize, c: i32| if zero(v) == zero(w) { 0 } else { c };
            let side: i32 = (0..8).map(|k| differ(k / 2 * 3 + k % 2, k / 2 * 3 + k % 2 + 1, across[k])).sum();
            i64::from(own + side + (0..9).map(|v| differ(v, v + 3, along[v])).sum::<i32>())
        };
        let labellings = (0..125).map(|n| [n % 5, n / 5 % 5, n / 25]);
        let pinned = |change: &[usize; 3]| (pin.0 / 3 < change[pin.0 % 3]) == (pin.1 == Side::Source);
        let least = labellings.filter(pinned).map(|c| value(&|v| v / 3 < c[v % 3])).min().unwrap();
        let free = build().minimize().unwrap();
        let mut energy = build();
        energy.ordered(0).unwrap();
        let minimum = energy.minimize().unwrap();
        assert_eq!(minimum.after, least, "case {case}");
        let zero = minimum.cut.source_side();
        assert!((0..9).all(|v| zero[v] || !zero[v + 3]), "case {case}");
        assert_eq!(minimum.after, value(&|v| zero[v]));
        bound += usize::from(free.after < least);
    }
    assert!(100 < bound, "the order mattered in {bound} cases");
}

#[test]
fn orders_that_cannot_be_are_refused() {
    let mut ring = BinaryEnergy::<2>::new([4, 3], [true, false]).unwrap();
    assert!(ring.ordered(0).is_err() && ring.ordered(2).is_err() && ring.ordered(1).is_ok());
    let mut line = BinaryEnergy::<1>::new([5], [false]).unwrap();
    line.graph_mut().pin(1, Side::Sink).unwrap();
    line.graph_mut().pin(3, Side::Source).unwrap();
    assert!(line.ordered(0).is_err(), "pins contradict the order");
}

#[test]
fn energies_of_whole_grids_are_those_given_one_by_one() {
    let mut draw = Draw(19);
    for case in 0..400 {
        let shape: [usize; 3] = std::array::from_fn(|_| 1 + draw.below(4));
        let periodic: [bool; 3] = std::array::from_fn(|_| draw.chance(40));
        let graph = GridGraph::new(shape, periodic).unwrap();
        let n = graph.len();
        // Some that cannot be regular, and some too large for the short way.
        let large = |draw: &mut Draw, at: usize| if draw.chance(3) { 1 << at } else { 0 };
        let unaries: Vec<[i32; 2]> =
            (0..n).map(|_| [draw.below(20) as i32 - large(&mut draw, 29), draw.below(20) as i32]).collect();
        let mut masked = vec![false; n];
        masked.iter_mut().for_each(|m| *m = case % 3 == 0 && draw.chance(20));
        let [mut bulk, mut single] = [(); 2].map(|()| BinaryEnergy::from(graph.clone()));
        for energy in [&mut bulk, &mut single] {
            (0..n).filter(|&v| masked[v]).for_each(|v| energy.graph_mut().mask(v).unwrap());
        }
        bulk.unaries(&unaries).unwrap();
        unaries.iter().enumerate().for_each(|(v, u)| single.unary(v, u[0], u[1]).unwrap());
        for axis in 0..3 {
            let mut terms = vec![PairwiseTerm::default(); n];
            for v in (0..n).filter(|&v| graph.next(v, axis).is_some()) {
                terms[v] = any_term(&mut draw);
                terms[v].e01 += large(&mut draw, 25);
                single.pairwise(v, axis, terms[v]).unwrap();
            }
            bulk.pairwises(axis, &terms).unwrap();
        }
        for _ in 0..8 {
            let labelling: Vec<bool> = masked.iter().map(|m| !m && draw.chance(50)).collect();
            assert_eq!(bulk.value(&labelling), single.value(&labelling), "case {case}");
        }
        assert_eq!(bulk.minimize(), single.minimize(), "case {case}");
    }
}

#[test]
fn what_does_not_fit_a_grid_is_refused() {
    let mut energy = BinaryEnergy::new([2, 2], [false, true]).unwrap();
    let term = PairwiseTerm { e00: 0, e01: 1, e10: 1, e11: 0 };
    let none = PairwiseTerm::default();
    let words = |result: Result<(), selvedge_maxflow::MaxflowError>| result.unwrap_err().to_string();
    assert_eq!(words(energy.unaries(&[[0, 1]; 3])), "3 values do not fit a graph of 4 nodes");
    assert_eq!(words(energy.pairwises(1, &[term; 5])), "5 values do not fit a graph of 4 nodes");
    assert_eq!(words(energy.pairwises(2, &[term; 4])), "node 0 has no neighbour along axis 2");
    assert_eq!(words(energy.pairwises(0, &[term, term, none, term])), "node 3 has no neighbour along axis 0");
    energy.pairwises(1, &[term; 4]).unwrap();
    energy.unaries(&[[1, 0], [0, 3], [0, 0], [0, 0]]).unwrap();
    assert_eq!(energy.minimize().unwrap().after, 1);
}

#[test]
fn an_energy_over_lists_is_that_over_a_grid() {
    let mut draw = Draw(20);
    for case in 0..300 {
        let field = Field::random(&mut draw, any_term);
        let mut lists = GraphEnergy::new(9).unwrap();
        for (v, u) in field.unary.iter().enumerate() {
            lists.unary(v, u[0].into(), u[1].into()).unwrap();
        }
        field.pairs.iter().for_each(|&(v, _, w, term)| lists.pairwise(v, w, term).unwrap());
        let itself = PairwiseTerm { e00: 1, e01: 99, e10: 99, e11: -2 };
        lists.pairwise(4, 4, itself).unwrap();
        let mut grid = field.energy();
        grid.unary(4, 1, -2).unwrap();
        for _ in 0..4 {
            let labelling: Vec<bool> = (0..9).map(|_| draw.chance(50)).collect();
            assert_eq!(lists.value(&labelling), grid.value(&labelling), "case {case}");
        }
        assert_eq!(lists.minimize(), grid.minimize(), "case {case}");
    }
}

#[test]
fn an_energy_over_lists_refuses_and_stays_as_it_was() {
    let mut energy = GraphEnergy::new(2).unwrap();
    energy.unary(0, 3, 0).unwrap();
    let term = PairwiseTerm { e00: 5, e01: 7, e10: 7, e11: -4 };
    assert!(energy.pairwise(0, 2, term).is_err(), "no such node");
    assert!(energy.unary(1, i64::MIN, i64::MAX).is_err(), "their difference is no number");
    energy.unary(1, 0, selvedge_maxflow::Graph::MAX_TOTAL - 10).unwrap();
    assert!(energy.pairwise(0, 1, term).is_err(), "too much in sum");
    assert_eq!(energy.value(&[true, true]), Ok(3));
    assert_eq!(energy.minimize().unwrap().after, 0);
}
