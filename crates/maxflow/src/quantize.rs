//! From floating-point costs to integer capacities.

use crate::error::{MaxflowError, Result};

/// Turns a cost into a capacity: `ceil(cost * scale)`.
///
/// Rounding up, unlike rounding to nearest, keeps the triangle inequality: `a <= b + c` gives
/// `ceil(a) <= ceil(b) + ceil(c)`. So costs that form a metric still form one in integers, and pairwise terms built
/// from them stay regular (see [`PairwiseTerm`](crate::PairwiseTerm)). Choose the scale so that the largest cost lands
/// well below `2^26`: a link takes twice that, both ways together, and refuses more
/// ([`GridGraph::MAX_LINK`](crate::GridGraph::MAX_LINK)); any `i32` can be asked for here.
///
/// # Errors
///
/// [`MaxflowError::Cost`] if the cost is NaN, negative or infinite, or does not fit after scaling.
///
/// ```
/// assert_eq!(selvedge_maxflow::capacity(0.49, 1.0)?, 1);
/// assert_eq!(selvedge_maxflow::capacity(12.5, 16.0)?, 200);
/// assert!(selvedge_maxflow::capacity(f64::NAN, 16.0).is_err());
/// # Ok::<(), selvedge_maxflow::MaxflowError>(())
/// ```
#[inline]
pub fn capacity(cost: f64, scale: f64) -> Result<i32> {
    let scaled = (cost * scale).ceil();
    // Written so that NaN is refused as well.
    if cost >= 0.0 && scale > 0.0 && scaled <= f64::from(i32::MAX) {
        Ok(scaled as i32)
    } else {
        Err(MaxflowError::Cost { cost, scale, max: i32::MAX.into() })
    }
}
