//! Weights of channels as the fast search takes them.

/// Weights of channels by which errors of a size fit 32 bits, as a search by displacement needs: in fewer steps where
/// finer ones would have every window compared with every other, which takes a hundred times as long. As they are where
/// none fit.
pub(crate) fn fitting(weights: &[u8], size: u32) -> Vec<u8> {
    let most = u64::from(u32::MAX - 1) / (65_025 * u64::from(size).pow(2));
    let heaviest = u32::from(weights.iter().copied().max().unwrap_or(0)).max(1);
    let steps = |n: u32| -> Vec<u8> {
        // What counts goes on counting.
        let step = |&w: &u8| ((u32::from(w) * n + heaviest / 2) / heaviest).max(u32::from(w != 0)) as u8;
        weights.iter().map(step).collect()
    };
    let fits = |weights: &Vec<u8>| weights.iter().map(|&w| u64::from(w)).sum::<u64>() <= most;
    (1..=heaviest).rev().map(steps).find(fits).unwrap_or_else(|| weights.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_keep_to_what_is_searched_by_displacement() {
        assert_eq!(fitting(&[1, 1, 1], 32), [1, 1, 1]);
        assert_eq!(fitting(&[77, 150, 29], 8), [77, 150, 29]);
        for size in [16, 32, 64] {
            let fine = [60, 61, 0, 255, 1];
            let found = fitting(&fine, size);
            let sum: u64 = found.iter().map(|&w| u64::from(w)).sum();
            let whole = u64::from(size).pow(2) * 65_025;
            assert!(
                sum * whole < u64::from(u32::MAX) && u64::from(u32::MAX) < (sum + 4) * whole,
                "{found:?} at {size}"
            );
            assert_eq!((found[2], found[4]), (0, 1));
            let share = f64::from(found[3]) / f64::from(found[0]);
            assert!((share - 4.25).abs() < 1.3, "{found:?}");
        }
        assert_eq!(fitting(&[1, 1, 1], 160), [1, 1, 1], "there are no fewer steps");
    }
}
