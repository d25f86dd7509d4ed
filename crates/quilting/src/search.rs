//! The plain search: the overlap error of every block of every source. `[Efros01 2.2]`

use selvedge_core::{Exemplars, Grid, Source, par};

/// What a block has to agree with: features of the output under the block, where there are any.
#[derive(Clone, Debug)]
pub(crate) struct Template {
    /// Height and width.
    pub(crate) shape: [u32; 2],
    /// Per channel, row-major; meaningless where `mask` is false.
    pub(crate) features: Vec<Vec<u8>>,
    /// Row-major: where the output is filled.
    pub(crate) mask: Vec<bool>,
}

/// One block of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Candidate {
    /// Sum of squared feature differences over the template, each channel by its weight.
    pub(crate) error: u64,
    /// The source.
    pub(crate) source: usize,
    /// The block's top left sample.
    pub(crate) at: [u32; 2],
}

/// Every candidate within `per_mille` thousandths of the least error, in order of error, source and position; those
/// that `avoid` names are left out as long as there are others. Empty if no valid block fits.
///
/// Time `O(candidates * template samples * channels)`.
pub(crate) fn within(
    exemplars: &Exemplars<2>,
    blocks: &ValidBlocks,
    template: &Template,
    per_mille: u64,
    avoid: impl Fn(usize, [u32; 2]) -> bool + Sync,
) -> Vec<Candidate> {
    let maps: Vec<Vec<u64>> = exemplars.sources().iter().map(|s| error_map(s, template, exemplars.weights())).collect();
    let all = || {
        blocks.positions(exemplars, template.shape).map(|(source, index, at)| Candidate {
            error: maps[source][index],
            source,
            at,
        })
    };
    let least = |avoiding: bool| all().filter(|c| !(avoiding && avoid(c.source, c.at))).map(|c| c.error).min();
    let (least, avoiding) = match least(true) {
        Some(error) => (error, true),
        None => match least(false) {
            Some(error) => (error, false),
            None => return Vec::new(),
        },
    };
    let near = |c: &Candidate| u128::from(c.error) * 1000 <= u128::from(least) * u128::from(1000 + per_mille);
    let mut found: Vec<Candidate> = all().filter(|c| near(c) && !(avoiding && avoid(c.source, c.at))).collect();
    found.sort_unstable();
    found
}

/// The error of the block at each position where it fits into the source, row-major; empty if it nowhere does.
fn error_map(source: &Source<2>, template: &Template, weights: &[u8]) -> Vec<u64> {
    let Some([rows, columns]) = positions(source, template.shape) else { return Vec::new() };
    let mut map = vec![0_u64; rows * columns];
    par::for_rows(&mut map, columns, |y, sums| {
        for (c, &weight) in weights.iter().enumerate() {
            add_channel(&source.features, c, u64::from(weight), y, template, sums);
        }
    });
    map
}

/// Adds one channel's errors of the blocks whose top row is `y`.
fn add_channel(features: &Grid<u8, 2>, channel: usize, weight: u64, y: usize, template: &Template, sums: &mut [u64]) {
    let (width, [h, w]) = (features.domain().shape[1] as usize, template.shape.map(|v| v as usize));
    let plane = features.plane(channel);
    for (i, _) in template.mask.iter().enumerate().take(h * w).filter(|(_, m)| **m) {
        let row = &plane[(y + i / w) * width + i % w..][..sums.len()];
        let t = i32::from(template.features[channel][i]);
        for (sum, &v) in sums.iter_mut().zip(row) {
            let d = i32::from(v) - t;
            *sum += (d * d) as u64 * weight;
        }
    }
}

/// Rows and columns of positions at which a block lies inside the source; `None` if it is too large.
fn positions(source: &Source<2>, block: [u32; 2]) -> Option<[usize; 2]> {
    let [h, w] = source.domain().shape;
    Some([(h.checked_sub(block[0])? + 1) as usize, (w.checked_sub(block[1])? + 1) as usize])
}

/// Tells whether a block holds masked samples: counts of them, summed over rectangles.
#[derive(Clone, Debug)]
pub(crate) struct ValidBlocks {
    tables: Vec<Option<Vec<u32>>>,
}

impl ValidBlocks {
    pub(crate) fn new(exemplars: &Exemplars<2>) -> Self {
        let table = |s: &Source<2>| s.valid.as_ref().map(summed_area);
        Self { tables: exemplars.sources().iter().map(table).collect() }
    }

    /// Every valid block of a shape: source, index among the source's positions, top left sample.
    pub(crate) fn positions(
        &self,
        exemplars: &Exemplars<2>,
        shape: [u32; 2],
    ) -> impl Iterator<Item = (usize, usize, [u32; 2])> {
        exemplars.sources().iter().enumerate().flat_map(move |(s, source)| {
            let [rows, columns] = positions(source, shape).unwrap_or([0, 0]);
            let width = source.domain().shape[1] as usize;
            (0..rows * columns).filter_map(move |i| {
                let (y, x) = (i / columns, i % columns);
                let masked = self.tables[s].as_ref().is_some_and(|t| rectangle(t, width + 1, [y, x], shape) != 0);
                (!masked).then_some((s, i, [y as u32, x as u32]))
            })
        })
    }
}

/// Masked samples above and left of each corner; one row and column more than the grid.
fn summed_area(valid: &Grid<bool, 2>) -> Vec<u32> {
    let [h, w] = valid.domain().shape.map(|v| v as usize);
    let mut table = vec![0_u32; (h + 1) * (w + 1)];
    for (y, row) in valid.samples().chunks(w).enumerate() {
        let mut sum = 0;
        for (x, &v) in row.iter().enumerate() {
            sum += u32::from(!v);
            table[(y + 1) * (w + 1) + x + 1] = table[y * (w + 1) + x + 1] + sum;
        }
    }
    table
}

fn rectangle(table: &[u32], stride: usize, [y, x]: [usize; 2], shape: [u32; 2]) -> u32 {
    let (y1, x1) = (y + shape[0] as usize, x + shape[1] as usize);
    table[y1 * stride + x1] + table[y * stride + x] - table[y * stride + x1] - table[y1 * stride + x]
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Origin, Seed, Transform};

    fn exemplars(shape: [u32; 2], valid: Option<Vec<bool>>) -> Exemplars<2> {
        let domain = Domain::open(shape);
        let mut rng = Seed(5).rng();
        let samples = (0..domain.len() * 2).map(|_| rng.below(256) as u8).collect();
        let source = Source {
            features: Grid::from_vec(domain, 2, samples).unwrap(),
            valid: valid.map(|v| Grid::from_vec(domain, 1, v).unwrap()),
            origin: Origin { exemplar: 0, transform: Transform::IDENTITY },
        };
        Exemplars::from_sources(vec![source], vec![1, 3]).unwrap()
    }

    fn template(e: &Exemplars<2>, at: [u32; 2], shape: [u32; 2]) -> Template {
        let features = (0..2).map(|c| {
            Domain::open(shape)
                .positions()
                .map(|[y, x]| e.sources()[0].features.get(c, [at[0] + y, at[1] + x]))
                .collect()
        });
        let mask = (0..shape[0] * shape[1]).map(|i| i % 3 != 1).collect();
        Template { shape, features: features.collect(), mask }
    }

    #[test]
    fn a_piece_of_the_exemplar_is_found_where_it_was_cut() {
        let e = exemplars([9, 11], None);
        let found = within(&e, &ValidBlocks::new(&e), &template(&e, [2, 5], [4, 3]), 0, |_, _| false);
        assert_eq!(found, [Candidate { error: 0, source: 0, at: [2, 5] }]);
        let others = within(&e, &ValidBlocks::new(&e), &template(&e, [2, 5], [4, 3]), 0, |_, at| at == [2, 5]);
        assert!(0 < others[0].error);
    }

    #[test]
    fn errors_are_those_of_the_definition() {
        let e = exemplars([7, 8], None);
        let t = template(&e, [1, 1], [3, 4]);
        let found = within(&e, &ValidBlocks::new(&e), &t, u64::from(u32::MAX), |_, at| at == [1, 1]);
        assert_eq!(found.len(), 5 * 5 - 1);
        for candidate in found {
            let mut error = 0;
            for (i, [y, x]) in Domain::open(t.shape).positions().enumerate().filter(|(i, _)| t.mask[*i]) {
                for c in 0..2 {
                    let v = e.sources()[0].features.get(c, [candidate.at[0] + y, candidate.at[1] + x]);
                    error += u64::from(v.abs_diff(t.features[c][i])).pow(2) * [1, 3][c];
                }
            }
            assert_eq!(candidate.error, error);
        }
    }

    #[test]
    fn blocks_with_masked_samples_are_no_candidates() {
        let domain = Domain::open([6, 6]);
        let valid: Vec<bool> = domain.positions().map(|p| p != [2, 3]).collect();
        let e = exemplars([6, 6], Some(valid));
        let t = template(&e, [0, 0], [3, 3]);
        let found = within(&e, &ValidBlocks::new(&e), &t, u64::from(u32::MAX), |_, at| at == [0, 0]);
        assert!(found.iter().all(|c| !((c.at[0]..c.at[0] + 3).contains(&2) && (c.at[1]..c.at[1] + 3).contains(&3))));
        assert_eq!(found.len(), 16 - 9 - 1);
    }
}
