//! Samples that are no numbers.

use half::f16;
use selvedge_core::{Grid, Samples};

use crate::error::Problem;
use crate::options::NonFinite;

/// Refuses or replaces samples that are infinite or no numbers; how many were replaced, if any.
pub(crate) fn enforce(samples: &mut Samples<2>, rule: NonFinite) -> Result<Option<u64>, Problem> {
    match samples {
        Samples::U8(_) | Samples::U16(_) => Ok(None),
        Samples::F16(grid) => {
            let bits = |v: f32| f16::from_f32(v).to_bits();
            replace(grid, rule, |v| f16::from_bits(v).to_f32(), [bits(0.0), f16::MIN.to_bits(), f16::MAX.to_bits()])
        }
        Samples::F32(grid) => replace(grid, rule, |v| v, [0.0, f32::MIN, f32::MAX]),
    }
}

fn replace<T: Copy>(
    grid: &mut Grid<T, 2>,
    rule: NonFinite,
    value: impl Fn(T) -> f32,
    [zero, least, greatest]: [T; 3],
) -> Result<Option<u64>, Problem> {
    let bad = |v: T| !value(v).is_finite();
    let Some(first) = grid.samples().iter().position(|&v| bad(v)) else { return Ok(None) };
    let count = grid.samples()[first..].iter().filter(|v| bad(**v)).count() as u64;
    if rule == NonFinite::Error {
        let n = grid.domain().len();
        let [y, x] = grid.domain().position(first % n);
        return Err(Problem::NotFinite { count, channel: first / n, x, y });
    }
    for v in &mut grid.samples_mut()[first..] {
        let number = value(*v);
        if !number.is_finite() {
            *v = match rule {
                NonFinite::Clamp if number == f32::INFINITY => greatest,
                NonFinite::Clamp if number == f32::NEG_INFINITY => least,
                _ => zero,
            };
        }
    }
    Ok(Some(count))
}

#[cfg(test)]
mod tests {
    use selvedge_core::Domain;

    use super::*;

    fn floats() -> Samples<2> {
        let values = vec![1.0, 2.0, 3.0, 4.0, f32::NAN, f32::INFINITY, 5.0, f32::NEG_INFINITY];
        Samples::F32(Grid::from_vec(Domain::open([2, 2]), 2, values).unwrap())
    }

    #[test]
    fn counted_with_the_first_position() {
        let refused = enforce(&mut floats(), NonFinite::Error);
        assert!(matches!(refused, Err(Problem::NotFinite { count: 3, channel: 1, x: 0, y: 0 })));
    }

    #[test]
    fn replaced_by_zero_or_the_nearest() {
        for (rule, expected) in [(NonFinite::Zero, [0.0, 0.0, 0.0]), (NonFinite::Clamp, [0.0, f32::MAX, f32::MIN])] {
            let mut samples = floats();
            assert_eq!(enforce(&mut samples, rule).unwrap(), Some(3));
            let Samples::F32(grid) = samples else { unreachable!() };
            assert_eq!(grid.plane(0), [1.0, 2.0, 3.0, 4.0]);
            assert_eq!(grid.plane(1), [expected[0], expected[1], 5.0, expected[2]]);
        }
    }

    #[test]
    fn half_floats_too() {
        let bits = vec![f16::INFINITY.to_bits(), f16::NAN.to_bits(), f16::MAX.to_bits()];
        let mut samples = Samples::F16(Grid::from_vec(Domain::open([1, 3]), 1, bits).unwrap());
        assert_eq!(enforce(&mut samples, NonFinite::Clamp).unwrap(), Some(2));
        let Samples::F16(grid) = samples else { unreachable!() };
        assert_eq!(grid.plane(0), [f16::MAX.to_bits(), 0, f16::MAX.to_bits()]);
    }
}
