//! The inverse cosine transform of 8x8 samples, in integers.
//!
//! Loeffler, Ligtenberg and Moschytz, *Practical fast 1-D DCT algorithms with 11 multiplications* (1989), figure 1 read
//! backwards, over columns and then rows. With 13 bits of each factor and 2 more bits between both passes the values
//! are those of libjpeg's accurate transform.

const BITS: i32 = 13;
/// Kept between columns and rows.
const MORE: i32 = 2;

/// A factor as an integer.
const fn factor(v: f64) -> i32 {
    (v * (1 << BITS) as f64 + 0.5) as i32
}

/// Samples of 0..=255 from dequantized coefficients, both row by row.
pub(super) fn inverse(coefficients: &[i32; 64]) -> [u8; 64] {
    let mut half = [0; 64];
    for x in 0..8 {
        let column: [i32; 8] = std::array::from_fn(|y| coefficients[8 * y + x]);
        if column[1..] == [0; 7] {
            (0..8).for_each(|y| half[8 * y + x] = column[0] << MORE);
            continue;
        }
        let values = eight(column, BITS - MORE);
        (0..8).for_each(|y| half[8 * y + x] = values[y]);
    }
    let mut out = [0; 64];
    for (to, row) in out.as_chunks_mut::<8>().0.iter_mut().zip(half.as_chunks::<8>().0) {
        // Both passes together scale by 8.
        let values = eight(*row, BITS + MORE + 3);
        *to = values.map(|v| (v + 128).clamp(0, 255) as u8);
    }
    out
}

/// One pass, shifted to the right with rounding.
#[inline]
fn eight(v: [i32; 8], shift: i32) -> [i32; 8] {
    let times = |v: i32, f: i32| v.wrapping_mul(f);
    // Even part: a butterfly of 0 and 4, a rotation of 2 and 6.
    let turned = times(v[2].wrapping_add(v[6]), factor(0.541_196_100));
    let low = turned.wrapping_add(times(v[2], factor(0.765_366_865)));
    let high = turned.wrapping_sub(times(v[6], factor(1.847_759_065)));
    let (sum, difference) = (v[0].wrapping_add(v[4]) << BITS, v[0].wrapping_sub(v[4]) << BITS);
    let even =
        [sum.wrapping_add(low), difference.wrapping_add(high), difference.wrapping_sub(high), sum.wrapping_sub(low)];
    // Odd part: 7, 5, 3 and 1 in pairs.
    let [a, b, c, d] = [v[7], v[5], v[3], v[1]];
    let (ac, bd) = (a.wrapping_add(c), b.wrapping_add(d));
    let all = times(ac.wrapping_add(bd), factor(1.175_875_602));
    let ad = times(a.wrapping_add(d), factor(0.899_976_223));
    let bc = times(b.wrapping_add(c), factor(2.562_915_447));
    let ac = all.wrapping_sub(times(ac, factor(1.961_570_560)));
    let bd = all.wrapping_sub(times(bd, factor(0.390_180_644)));
    let odd = [
        times(d, factor(1.501_321_110)).wrapping_sub(ad).wrapping_add(bd),
        times(c, factor(3.072_711_026)).wrapping_sub(bc).wrapping_add(ac),
        times(b, factor(2.053_119_869)).wrapping_sub(bc).wrapping_add(bd),
        times(a, factor(0.298_631_336)).wrapping_sub(ad).wrapping_add(ac),
    ];
    let round = 1 << (shift - 1);
    let mut out = [0; 8];
    for i in 0..4 {
        out[i] = even[i].wrapping_add(odd[i]).wrapping_add(round) >> shift;
        out[7 - i] = even[i].wrapping_sub(odd[i]).wrapping_add(round) >> shift;
    }
    out
}

#[cfg(test)]
mod tests {
    use selvedge_core::Seed;

    use super::*;

    /// The definition [A.3.3].
    fn slow(coefficients: &[i32; 64]) -> [f64; 64] {
        let cosine = |at: usize, k: usize| {
            let scale = if k == 0 { 0.5_f64.sqrt() } else { 1.0 };
            scale * libm::cos((2 * at + 1) as f64 * k as f64 * std::f64::consts::PI / 16.0)
        };
        std::array::from_fn(|i| {
            let (y, x) = (i / 8, i % 8);
            let sum: f64 = (0..64).map(|k| f64::from(coefficients[k]) * cosine(y, k / 8) * cosine(x, k % 8)).sum();
            (sum / 4.0 + 128.0).clamp(0.0, 255.0)
        })
    }

    #[test]
    fn it_is_the_definition_to_less_than_one() {
        let mut rng = Seed(3).derive("idct", 0).rng();
        for round in 0..200 {
            let range = 1 + (1 << (round % 10));
            let mut block = [0; 64];
            for v in block.iter_mut().take(1 + round % 64) {
                *v = rng.below(2 * range + 1) as i32 - range as i32;
            }
            for (fast, slow) in inverse(&block).into_iter().zip(slow(&block)) {
                assert!((f64::from(fast) - slow).abs() < 0.6, "{fast} for {slow}");
            }
        }
        inverse(&[i32::MAX; 64]);
        inverse(&[i32::MIN; 64]);
    }
}
