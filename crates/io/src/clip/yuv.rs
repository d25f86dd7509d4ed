//! Between RGB and luma with chroma, in integers of 16 bits after the point, so that every machine gives the same
//! samples.

/// What values stand for black and white.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Range {
    /// 0 and 255.
    Full,
    /// 16 and 235; chroma from 16 to 240.
    Limited,
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
    pub(super) fn rgb(self, range: Range, [y, cb, cr]: [u8; 3]) -> [u8; 3] {
        let (black, luma, chroma) = range.scales();
        // In 2^16ths of 255.
        let y = (i64::from(y) - black) * ONE * 255 / luma;
        let [cb, cr] = [cb, cr].map(|v| (i64::from(v) - 128) * ONE * 255 / chroma);
        let (red, blue) = (y + cr * 2 * (ONE - self.red) / ONE, y + cb * 2 * (ONE - self.blue) / ONE);
        let green = (y * ONE - red * self.red - blue * self.blue) / (ONE - self.red - self.blue);
        [red, green, blue].map(rounded)
    }

    /// Luma and chroma of red, green and blue.
    pub(super) fn yuv(self, range: Range, rgb: [u8; 3]) -> [u8; 3] {
        let (black, luma, chroma) = range.scales();
        let [r, g, b] = rgb.map(i64::from);
        let y = r * self.red + g * (ONE - self.red - self.blue) + b * self.blue;
        let of = |v: i64, weight: i64| (v * ONE - y) * ONE / (2 * (ONE - weight));
        let scaled = |v: i64, to: i64, zero: i64| rounded(v * to / 255 + zero * ONE);
        [scaled(y, luma, black), scaled(of(b, self.blue), chroma, 128), scaled(of(r, self.red), chroma, 128)]
    }
}

impl Range {
    /// Black, what lies from it to white, and what lies between the ends of chroma.
    const fn scales(self) -> (i64, i64, i64) {
        match self {
            Self::Full => (0, 255, 255),
            Self::Limited => (16, 219, 224),
        }
    }

    /// The grey of a luma.
    pub(super) fn grey(self, y: u8) -> u8 {
        let (black, luma, _) = self.scales();
        rounded((i64::from(y) - black) * ONE * 255 / luma)
    }
}

/// From 2^16ths to the nearest integer of 8 bits.
fn rounded(v: i64) -> u8 {
    ((v + ONE / 2) >> 16).clamp(0, 255) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_agree_with_the_standards_formulas() {
        for (matrix, kr, kb) in [(Matrix::BT601, 0.299, 0.114), (Matrix::BT709, 0.2126, 0.0722)] {
            for (range, black, luma, chroma) in [(Range::Full, 0.0, 255.0, 255.0), (Range::Limited, 16.0, 219.0, 224.0)]
            {
                let mut worst = [0.0_f64; 2];
                for rgb in (0..=255_u16)
                    .step_by(15)
                    .flat_map(|r| (0..=255).step_by(17).map(move |g| [r as u8, g, 255 - g / 2]))
                {
                    let [r, g, b] = rgb.map(|v| f64::from(v) / 255.0);
                    let y = kr * r + (1.0 - kr - kb) * g + kb * b;
                    let exact = [
                        black + luma * y,
                        128.0 + chroma * (b - y) / (2.0 * (1.0 - kb)),
                        128.0 + chroma * (r - y) / (2.0 * (1.0 - kr)),
                    ];
                    let yuv = matrix.yuv(range, rgb);
                    let off = yuv.iter().zip(exact).map(|(v, e)| (f64::from(*v) - e.clamp(0.0, 255.0)).abs());
                    worst[0] = off.fold(worst[0], f64::max);
                    let back = matrix.rgb(range, yuv);
                    let off = back.iter().zip(rgb).map(|(a, b)| f64::from(a.abs_diff(b)));
                    worst[1] = off.fold(worst[1], f64::max);
                }
                assert!(worst[0] <= 0.51 && worst[1] <= 2.0, "{matrix:?} {range:?}: {worst:?}");
            }
        }
        assert_eq!(Matrix::BT709.rgb(Range::Limited, [16, 128, 128]), [0, 0, 0]);
        assert_eq!(Matrix::BT601.rgb(Range::Limited, [235, 128, 128]), [255, 255, 255]);
    }
}
