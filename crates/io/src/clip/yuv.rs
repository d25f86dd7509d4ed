//! Between RGB and luma with chroma, in integers of 16 bits after the point, so that every machine gives the same
//! samples.

/// What values stand for black and white.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Range {
    /// 0 and 255, or the most that its bits hold.
    Full,
    /// 16 and 235, chroma from 16 to 240; of more bits so many times as much. [BT.709-6, 4.5]
    Limited,
}

/// How values stand for colours: of 8 bits for samples of 8, of up to 16 for samples of 16.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Coding {
    pub(super) range: Range,
    /// Bits of a value, 8 to 16.
    pub(super) bits: u32,
}

/// Weights of red and blue in luma, of 2^16. [ITU-R BT.601-7, 2.5.1; BT.709-6, 3.2]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Matrix {
    red: i64,
    blue: i64,
}

const ONE: i64 = 1 << 16;

impl Matrix {
    const BT601: Self = Self { red: 19_595, blue: 7_471 };
    const BT709: Self = Self { red: 13_933, blue: 4_732 };

    /// No header names a matrix: players take that of small or of large pictures.
    pub(super) const fn of_height(height: u32) -> Self {
        if height < 720 { Self::BT601 } else { Self::BT709 }
    }

    /// Red, green and blue of luma and chroma.
    pub(super) fn rgb(self, coding: Coding, [y, cb, cr]: [u16; 3]) -> [u16; 3] {
        let (full, Scales { black, luma, chroma, zero }) = (coding.full(), coding.scales());
        // In 2^16ths of a sample's steps.
        let y = (i64::from(y) - black) * ONE * full / luma;
        let [cb, cr] = [cb, cr].map(|v| (i64::from(v) - zero) * ONE * full / chroma);
        let (red, blue) = (y + cr * 2 * (ONE - self.red) / ONE, y + cb * 2 * (ONE - self.blue) / ONE);
        let green = (y * ONE - red * self.red - blue * self.blue) / (ONE - self.red - self.blue);
        [red, green, blue].map(|v| rounded(v, full))
    }

    /// Luma and chroma of red, green and blue.
    pub(super) fn yuv(self, coding: Coding, rgb: [u16; 3]) -> [u16; 3] {
        let (full, Scales { black, luma, chroma, zero }) = (coding.full(), coding.scales());
        let [r, g, b] = rgb.map(i64::from);
        let y = r * self.red + g * (ONE - self.red - self.blue) + b * self.blue;
        let of = |v: i64, weight: i64| (v * ONE - y) * ONE / (2 * (ONE - weight));
        let scaled = |v: i64, to: i64, zero: i64| rounded(v * to / full + zero * ONE, (1 << coding.bits) - 1);
        [scaled(y, luma, black), scaled(of(b, self.blue), chroma, zero), scaled(of(r, self.red), chroma, zero)]
    }
}

/// Black, what lies from it to white, what lies between the ends of chroma, and no colour.
struct Scales {
    black: i64,
    luma: i64,
    chroma: i64,
    zero: i64,
}

impl Coding {
    /// The largest sample of a picture that is coded so.
    fn full(self) -> i64 {
        if self.bits == 8 { 0xff } else { 0xffff }
    }

    fn scales(self) -> Scales {
        let unit = 1 << (self.bits - 8);
        let zero = 128 * unit;
        match self.range {
            Range::Full => Scales { black: 0, luma: 256 * unit - 1, chroma: 256 * unit - 1, zero },
            Range::Limited => Scales { black: 16 * unit, luma: 219 * unit, chroma: 224 * unit, zero },
        }
    }

    /// The grey of a luma.
    pub(super) fn grey(self, y: u16) -> u16 {
        let (full, Scales { black, luma, .. }) = (self.full(), self.scales());
        rounded((i64::from(y) - black) * ONE * full / luma, full)
    }
}

/// From 2^16ths to the nearest integer up to a largest one.
fn rounded(v: i64, most: i64) -> u16 {
    ((v + ONE / 2) >> 16).clamp(0, most) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_agree_with_the_standards_formulas() {
        for (matrix, kr, kb) in [(Matrix::BT601, 0.299, 0.114), (Matrix::BT709, 0.2126, 0.0722)] {
            for (range, bits) in [Range::Full, Range::Limited].into_iter().flat_map(|r| [8, 10, 16].map(|b| (r, b))) {
                let coding = Coding { range, bits };
                let unit = f64::from(1 << (bits - 8));
                let [black, luma, chroma] = match range {
                    Range::Full => [0.0, 256.0 * unit - 1.0, 256.0 * unit - 1.0],
                    Range::Limited => [16.0 * unit, 219.0 * unit, 224.0 * unit],
                };
                let most = coding.full() as f64;
                let of_bytes = |v: u16| if bits == 8 { v } else { 257 * v };
                let mut worst = [0.0_f64; 2];
                for rgb in (0..=255_u16)
                    .step_by(15)
                    .flat_map(|r| (0..=255).step_by(17).map(move |g| [r, g, 255 - g / 2].map(of_bytes)))
                {
                    let [r, g, b] = rgb.map(|v| f64::from(v) / most);
                    let y = kr * r + (1.0 - kr - kb) * g + kb * b;
                    let exact = [
                        black + luma * y,
                        128.0 * unit + chroma * (b - y) / (2.0 * (1.0 - kb)),
                        128.0 * unit + chroma * (r - y) / (2.0 * (1.0 - kr)),
                    ];
                    let yuv = matrix.yuv(coding, rgb);
                    let clamped = exact.map(|e| e.clamp(0.0, 256.0 * unit - 1.0));
                    let off = yuv.iter().zip(clamped).map(|(v, e)| (f64::from(*v) - e).abs());
                    worst[0] = off.fold(worst[0], f64::max);
                    let back = matrix.rgb(coding, yuv);
                    let off = back.iter().zip(rgb).map(|(a, b)| f64::from(a.abs_diff(b)));
                    worst[1] = off.fold(worst[1], f64::max);
                }
                // Two steps of the values, in those of the samples; weights are cut to 2^16ths.
                let (of_values, of_samples) =
                    (0.51 + unit / 60.0, 2.0 * (most / (219.0 * unit)).max(1.0) + unit / 60.0);
                assert!(worst[0] <= of_values && worst[1] <= of_samples, "{matrix:?} {coding:?}: {worst:?}");
            }
        }
        let limited = |bits| Coding { range: Range::Limited, bits };
        assert_eq!(Matrix::BT709.rgb(limited(8), [16, 128, 128]), [0, 0, 0]);
        assert_eq!(Matrix::BT601.rgb(limited(8), [235, 128, 128]), [255, 255, 255]);
        assert_eq!(Matrix::BT709.rgb(limited(10), [940, 512, 512]), [65_535; 3]);
        assert_eq!((limited(12).grey(256), limited(12).grey(3760)), (0, 65_535));
    }
}
