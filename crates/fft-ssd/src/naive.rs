//! The definition, in plain loops.

use crate::axes::{Shape, index, position};
use crate::placement::Range;
use crate::source::SourceView;
use crate::template::Checked;
use crate::{Costs, Cover};

pub(crate) fn search<const D: usize>(
    source: &SourceView<'_>,
    weights: &[u8],
    template: &Checked<'_>,
    range: Range,
    cover: Cover,
    costs: &mut Costs<D>,
    number: usize,
) {
    let start = costs.sources[number].start;
    for i in 0..range.len() {
        let Some((error, count)) = at(source, weights, template, range, position(range.count, i), cover) else {
            continue;
        };
        if costs.is_wide {
            costs.wide[start + i] = error;
        } else {
            costs.narrow[start + i] = error as u32;
        }
        if !costs.counts.is_empty() {
            costs.counts[start + i] = count;
        }
    }
}

/// Error and compared samples at one position; `None` if it is no candidate.
fn at(
    source: &SourceView<'_>,
    weights: &[u8],
    template: &Checked<'_>,
    range: Range,
    at: Shape,
    cover: Cover,
) -> Option<(u64, u32)> {
    let (mut error, mut count, len) = (0_u64, 0_u32, template.len());
    for i in 0..len {
        let under = under(source, range, at, position(template.shape, i));
        let counts = template.counts(i);
        match under {
            Some(under) if counts => {
                count += 1;
                for (c, &w) in weights.iter().enumerate() {
                    let difference = template.features[c * len + i].abs_diff(source.plane(c)[under]);
                    error += u64::from(w) * u64::from(difference).pow(2);
                }
            }
            None if cover == Cover::Box || (cover == Cover::Mask && counts) => return None,
            _ => {}
        }
    }
    match cover {
        Cover::AtLeast(least) if u64::from(count) < least.max(1) => None,
        _ => Some((error, count)),
    }
}

/// The valid source sample under sample `x` of a template at a position; `None` outside or on an invalid one.
fn under(source: &SourceView<'_>, range: Range, at: Shape, x: Shape) -> Option<usize> {
    let mut p = [0; 3];
    for axis in 0..3 {
        let n = source.shape[axis] as isize;
        let mut q = range.first[axis] + (at[axis] + x[axis]) as isize;
        if range.wraps[axis] {
            q = q.rem_euclid(n);
        }
        if q < 0 || n <= q {
            return None;
        }
        p[axis] = q as usize;
    }
    let under = index(source.shape, p);
    source.valid.is_none_or(|v| v[under]).then_some(under)
}
