//! Sums of squared differences of samples that stand side by side.

/// The sum of squared differences of bytes.
pub(crate) fn squares(a: &[u8], b: &[u8]) -> u64 {
    // Sums of so many squares of bytes fit 32 bits.
    const FIT: usize = 1 << 16;
    let block = |(a, b): (&[u8], &[u8])| {
        let sum: u32 = a.iter().zip(b).map(|(&a, &b)| u32::from(a.abs_diff(b)).pow(2)).sum();
        u64::from(sum)
    };
    a.chunks(FIT).zip(b.chunks(FIT)).map(block).sum()
}
