//! The coefficients of the preference, from a table of columns and ranks.

use crate::preference::{Model, TERMS, dot, terms};
use crate::{Columns, Seams};

/// Holds coefficients near 0 where the readers say nothing: the weight of one pair, in units of each term's spread.
const RIDGE: f64 = 3.0;
/// Newton's steps: the logarithm of the likelihood is concave, and six digits stand after ten.
const STEPS: usize = 30;

/// Coefficients and how far they can be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// From pairs of outputs with a map.
    pub mapped: Model,
    /// From all pairs.
    pub picture: Model,
    /// For both: the share of pairs that models made without their exemplar agree with.
    pub held_out: [f64; 2],
    /// For both: of the second reader's pairs, by models made from the first reader's and without their exemplar.
    pub across: [f64; 2],
    /// The share of pairs in which both readers agree.
    pub readers: f64,
}

/// One output of the table.
struct Output {
    exemplar: u32,
    ranks: [u32; 2],
    columns: Columns,
}

/// A pair that a reader ranked: the first was preferred.
struct Pair {
    exemplar: u32,
    reader: usize,
    difference: [f64; TERMS],
}

/// Fits the model to a table as in `data/rankings.csv`.
///
/// # Errors
/// A line that cannot be read, by its number.
pub fn fit(table: &str) -> Result<Fit, String> {
    let outputs = outputs(table)?;
    let sets = Sets { mapped: pairs(&outputs, true), all: pairs(&outputs, false) };
    let every = |_: &Pair| true;
    let (first, second) = (|p: &Pair| p.reader == 0, |p: &Pair| p.reader == 1);
    Ok(Fit {
        mapped: sets.mapped_model(&every),
        picture: sets.picture_model(&every),
        held_out: [true, false].map(|is_mapped| sets.agreement(is_mapped, &every, &every)),
        across: [true, false].map(|is_mapped| sets.agreement(is_mapped, &first, &second)),
        readers: readers(&outputs),
    })
}

/// All pairs, and those in which both outputs have a map.
struct Sets {
    mapped: Vec<Pair>,
    all: Vec<Pair>,
}

impl Sets {
    /// The model of pictures alone, from the pairs that are kept.
    fn picture_model(&self, keep: &dyn Fn(&Pair) -> bool) -> Model {
        let pairs: Vec<&Pair> = self.all.iter().filter(|p| keep(p)).collect();
        solve(&pairs, &[0, 1, 2, 3, 4, 5], [0.0; TERMS])
    }

    /// The model with maps. How repeats count at large sizes is taken from all pictures, since none of those with maps
    /// repeats itself much; they never count in favour there.
    fn mapped_model(&self, keep: &dyn Fn(&Pair) -> bool) -> Model {
        let pairs: Vec<&Pair> = self.mapped.iter().filter(|p| keep(p)).collect();
        let mut given = [0.0; TERMS];
        given[5] = self.picture_model(keep)[5].min(0.0);
        solve(&pairs, &[2, 4, 6], given)
    }

    /// The share of the pairs to test that a model agrees with which was made from those to keep, without their
    /// exemplar.
    fn agreement(&self, is_mapped: bool, keep: &dyn Fn(&Pair) -> bool, test: &dyn Fn(&Pair) -> bool) -> f64 {
        let pairs = if is_mapped { &self.mapped } else { &self.all };
        let mut exemplars: Vec<u32> = pairs.iter().map(|p| p.exemplar).collect();
        exemplars.sort_unstable();
        exemplars.dedup();
        let (mut right, mut n) = (0_u32, 0_u32);
        for exemplar in exemplars {
            let others = |p: &Pair| p.exemplar != exemplar && keep(p);
            let model = if is_mapped { self.mapped_model(&others) } else { self.picture_model(&others) };
            for pair in pairs.iter().filter(|p| p.exemplar == exemplar && test(p)) {
                n += 1;
                right += u32::from(0.0 < dot(&model, &pair.difference));
            }
        }
        f64::from(right) / f64::from(n.max(1))
    }
}

fn outputs(table: &str) -> Result<Vec<Output>, String> {
    let lines = table.lines().enumerate().filter(|(_, l)| !l.starts_with('#'));
    lines.skip(1).map(|(i, line)| output(line).ok_or(format!("line {} cannot be read", i + 1))).collect()
}

fn output(line: &str) -> Option<Output> {
    let cells: Vec<&str> = line.split(',').collect();
    let number = |i: usize| cells.get(i)?.parse::<f64>().ok();
    let count = |i: usize| cells.get(i)?.parse::<u32>().ok();
    let seams = match cells.get(20)? {
        &"" => None,
        _ => Some(Seams {
            colour: number(20)?,
            gradient: number(21)?,
            energy: number(22)?,
            torn: number(23)?,
            density: number(24)?,
            used: number(25)?,
        }),
    };
    let columns = Columns {
        coherence: number(4)?,
        coherence_2: number(5)?,
        coherence_4: number(6)?,
        arrangement: number(7)?,
        worst: number(8)?,
        completeness_2: number(9)?,
        completeness_4: number(10)?,
        unevenness: number(11)?,
        repeats: number(12)?,
        lattice: number(13)?,
        bland: number(14)?,
        sharpness: number(15)?,
        colour: number(16)?,
        shade: number(17)?,
        wrap: number(18)?,
        scale: number(19)?,
        seams,
    };
    Some(Output { exemplar: count(0)?, ranks: [count(2)?, count(3)?], columns })
}

/// Calls `each(better, other)` for pairs of one exemplar and size that a reader ranked.
fn each_pair<'a>(outputs: &'a [Output], reader: usize, mut each: impl FnMut(&'a Output, &'a Output)) {
    let size = |o: &Output| (o.exemplar, o.columns.scale.round() as i64);
    for a in outputs {
        for b in outputs.iter().filter(|b| size(a) == size(b)) {
            if a.ranks[reader] != 0 && a.ranks[reader] < b.ranks[reader] {
                each(a, b);
            }
        }
    }
}

fn pairs(outputs: &[Output], with_map: bool) -> Vec<Pair> {
    let mut all = Vec::new();
    for reader in 0..2 {
        each_pair(outputs, reader, |a, b| {
            if !with_map || (a.columns.seams.is_some() && b.columns.seams.is_some()) {
                let (better, other) = (terms(&a.columns), terms(&b.columns));
                let difference = std::array::from_fn(|t| better[t] - other[t]);
                all.push(Pair { exemplar: a.exemplar, reader, difference });
            }
        });
    }
    all
}

/// The share of the first reader's pairs that the second sees alike.
fn readers(outputs: &[Output]) -> f64 {
    let (mut alike, mut n) = (0_u32, 0_u32);
    each_pair(outputs, 0, |a, b| {
        if a.ranks[1] != 0 && b.ranks[1] != 0 {
            n += 1;
            alike += u32::from(a.ranks[1] < b.ranks[1]);
        }
    });
    f64::from(alike) / f64::from(n.max(1))
}

/// The coefficients of `free` terms that make the pairs likeliest, beside those that are given: ridge logistic
/// regression by Newton's method, each term in units of its spread.
fn solve(pairs: &[&Pair], free: &[usize], given: Model) -> Model {
    let spread = |t: usize| {
        let squares: f64 = pairs.iter().map(|p| p.difference[t] * p.difference[t]).sum();
        (squares / pairs.len().max(1) as f64).sqrt() + 1e-9
    };
    let spreads: Vec<f64> = free.iter().map(|&t| spread(t)).collect();
    let scaled = |p: &Pair, i: usize| p.difference[free[i]] / spreads[i];
    let (n, mut weights) = (free.len(), vec![0.0; free.len()]);
    for _ in 0..STEPS {
        let mut gradient: Vec<f64> = weights.iter().map(|w| -RIDGE * w).collect();
        let mut curvature = vec![vec![0.0; n]; n];
        (0..n).for_each(|i| curvature[i][i] = RIDGE);
        for pair in pairs {
            let own: f64 = (0..n).map(|i| weights[i] * scaled(pair, i)).sum();
            let odds = dot(&given, &pair.difference) + own;
            let likely = 1.0 / (1.0 + libm::exp(-odds));
            let own: Vec<f64> = (0..n).map(|i| scaled(pair, i)).collect();
            for ((slope, row), a) in gradient.iter_mut().zip(&mut curvature).zip(&own) {
                *slope += (1.0 - likely) * a;
                row.iter_mut().zip(&own).for_each(|(c, b)| *c += likely * (1.0 - likely) * a * b);
            }
        }
        let step = eliminated(curvature, gradient);
        weights.iter_mut().zip(step).for_each(|(w, s)| *w += s);
    }
    let mut model = given;
    for (i, &t) in free.iter().enumerate() {
        model[t] = weights[i] / spreads[i];
    }
    model
}

/// Solves a positive definite system.
fn eliminated(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for i in 0..n {
        for j in i + 1..n {
            let factor = a[j][i] / a[i][i];
            let (above, below) = a.split_at_mut(j);
            below[0].iter_mut().zip(&above[i]).for_each(|(to, from)| *to -= factor * from);
            b[j] -= factor * b[i];
        }
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MAPPED, PICTURE};

    const TABLE: &str = include_str!("../data/rankings.csv");

    #[test]
    fn the_coefficients_in_the_source_are_those_of_the_table() {
        let fitted = fit(TABLE).unwrap();
        for (found, stands) in [(fitted.mapped, MAPPED), (fitted.picture, PICTURE)] {
            let near = found.iter().zip(stands).all(|(a, b)| (a - b).abs() < 1e-3);
            assert!(near, "cargo xtask fit: {found:.3?}, the source has {stands:?}");
        }
    }

    #[test]
    fn held_out_exemplars_are_ranked_as_readers_rank_them() {
        let fitted = fit(TABLE).unwrap();
        assert!(0.8 <= fitted.held_out[0] && 0.8 <= fitted.across[0], "{fitted:?}");
        assert!(0.73 <= fitted.held_out[1] && 0.73 <= fitted.across[1], "{fitted:?}");
    }

    #[test]
    fn a_known_model_is_found_again() {
        // Odds of 3 to 1 for a difference of 1 in term 2: the logarithm of 3, but for the ridge.
        let pair = |sign: f64| Pair { exemplar: 0, reader: 0, difference: [0.0, 0.0, sign, 0.0, 0.0, 0.0, 0.0] };
        let many: Vec<Pair> = (0..4000).map(|i| pair(if i % 4 == 0 { -1.0 } else { 1.0 })).collect();
        let model = solve(&many.iter().collect::<Vec<_>>(), &[2, 4], [0.0; TERMS]);
        assert!((model[2] - libm::log(3.0)).abs() < 0.01 && model[4] == 0.0, "{model:?}");
    }

    #[test]
    fn a_broken_line_is_named() {
        let broken = TABLE.replacen(",quilt-2,1,", ",quilt-2,one,", 1);
        assert_eq!(fit(&broken), Err("line 3 cannot be read".to_owned()));
    }
}
