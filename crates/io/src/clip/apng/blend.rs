//! How the parts of an animated PNG lie over each other.

/// A part of a canvas: where it begins, and its width and height.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) at: [usize; 2],
    pub(super) size: [usize; 2],
}

/// Interleaved samples of a canvas.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    pub(super) width: usize,
    pub(super) channels: usize,
    pub(super) samples: Vec<u16>,
    /// Of opaque samples.
    pub(super) opaque: u16,
}

impl Canvas {
    /// Lays rows of a part, replacing what is there, or over it as far as alpha (the last channel) says.
    pub(super) fn lay(&mut self, part: Part, rows: &[u16], over: bool) {
        let (channels, opaque) = (self.channels, self.opaque);
        let row = part.size[0] * channels;
        for (to, from) in self.rows_mut(part).zip(rows.chunks_exact(row.max(1))) {
            if over {
                to.chunks_exact_mut(channels)
                    .zip(from.chunks_exact(channels))
                    .for_each(|(to, from)| blend(to, from, opaque));
            } else {
                to.copy_from_slice(from);
            }
        }
    }

    /// Clears a part: nothing shows there.
    pub(super) fn clear(&mut self, part: Part) {
        self.rows_mut(part).for_each(|row| row.fill(0));
    }

    fn rows_mut(&mut self, part: Part) -> impl Iterator<Item = &mut [u16]> {
        let ([x, y], [width, height], channels) = (part.at, part.size, self.channels);
        let rows = self.samples.chunks_exact_mut(self.width * channels).skip(y).take(height);
        rows.map(move |row| &mut row[x * channels..][..width * channels])
    }
}

/// One pixel over another, both with straight alpha.
fn blend(to: &mut [u16], from: &[u16], opaque: u16) {
    let (Some(&alpha), full) = (from.last(), u64::from(opaque)) else { return };
    let (above, below) = (u64::from(alpha), to.last().map_or(0, |a| u64::from(*a)));
    if above == full || below == 0 {
        return to.copy_from_slice(from);
    }
    // In units of 1 / full^2.
    let (a, b) = (above * full, below * (full - above));
    let last = to.len() - 1;
    // What is below shows, so that this is not 0.
    let sum = a + b;
    for (to, from) in to[..last].iter_mut().zip(from) {
        *to = ((u64::from(*from) * a + u64::from(*to) * b + sum / 2) / sum) as u16;
    }
    to[last] = ((sum + full / 2) / full) as u16;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_lie_over_each_other_as_light_does() {
        let over = |from: [u16; 2], to: [u16; 2], opaque| {
            let mut to = to;
            blend(&mut to, &from, opaque);
            to
        };
        assert_eq!(over([9, 255], [1, 255], 255), [9, 255]);
        assert_eq!(over([9, 0], [1, 255], 255), [1, 255]);
        assert_eq!(over([9, 7], [1, 0], 255), [9, 7]);
        assert_eq!(over([200, 128], [100, 255], 255), [150, 255]);
        assert_eq!(over([200, 0], [100, 128], 255), [100, 128]);
        let [value, alpha] = over([60_000, 30_000], [20_000, 40_000], 65_535);
        let (a, b) = (30_000.0 / 65_535.0, 40_000.0 / 65_535.0 * (1.0 - 30_000.0 / 65_535.0));
        assert_eq!(value, f64::round((60_000.0 * a + 20_000.0 * b) / (a + b)) as u16);
        assert_eq!(alpha, f64::round((a + b) * 65_535.0) as u16);
    }

    #[test]
    fn parts_stay_inside() {
        let mut canvas = Canvas { width: 3, channels: 1, samples: vec![5; 9], opaque: 255 };
        let part = Part { at: [1, 1], size: [2, 1] };
        canvas.lay(part, &[7, 8], false);
        assert_eq!(canvas.samples, [5, 5, 5, 5, 7, 8, 5, 5, 5]);
        canvas.clear(part);
        assert_eq!(canvas.samples, [5, 5, 5, 5, 0, 0, 5, 5, 5]);
    }
}
