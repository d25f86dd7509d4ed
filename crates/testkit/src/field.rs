//! A plain grid of `f64` with the few filters that lighting needs.

/// Row-major numbers over `width * height` points.
#[derive(Debug)]
pub(crate) struct Field {
    width: u32,
    height: u32,
    values: Vec<f64>,
}

impl Field {
    pub(crate) fn new(width: u32, height: u32, values: Vec<f64>) -> Self {
        assert_eq!(values.len(), width as usize * height as usize, "one value a point");
        Self { width, height, values }
    }

    pub(crate) fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    pub(crate) fn at(&self, index: usize) -> f64 {
        self.values[index]
    }

    pub(crate) fn highest(&self) -> f64 {
        self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    pub(crate) fn map_index(&self, f: impl Fn(usize) -> f64) -> Self {
        Self { values: (0..self.values.len()).map(f).collect(), ..*self }
    }

    /// The value nearest to `(x, y)`; points outside take the border's.
    pub(crate) fn clamped(&self, x: f64, y: f64) -> f64 {
        let x = (x + 0.5).clamp(0.0, f64::from(self.width - 1)) as usize;
        let y = (y + 0.5).clamp(0.0, f64::from(self.height - 1)) as usize;
        self.values[y * self.width as usize + x]
    }

    /// Slopes along x and y by central differences, times `per_unit` points.
    pub(crate) fn slopes(&self, per_unit: f64) -> (Self, Self) {
        let w = self.width as usize;
        let slope = |dx: f64, dy: f64| {
            self.map_index(|i| {
                let (x, y) = ((i % w) as f64, (i / w) as f64);
                (self.clamped(x + dx, y + dy) - self.clamped(x - dx, y - dy)) * per_unit / 2.0
            })
        };
        (slope(1.0, 0.0), slope(0.0, 1.0))
    }

    /// Means over windows of `2 * radius + 1` points a side, taken twice: close to a Gaussian.
    pub(crate) fn blurred(&self, radius: u32) -> Self {
        let once = self.box_rows(radius).transposed().box_rows(radius);
        once.box_rows(radius).transposed().box_rows(radius)
    }

    fn box_rows(&self, radius: u32) -> Self {
        let (w, r) = (self.width as usize, radius as usize);
        let mut values = Vec::with_capacity(self.values.len());
        for row in self.values.chunks_exact(w) {
            let mut sums = vec![0.0];
            for v in row {
                sums.push(sums[sums.len() - 1] + v);
            }
            values.extend((0..w).map(|x| {
                let (lo, hi) = (x.saturating_sub(r), (x + r + 1).min(w));
                (sums[hi] - sums[lo]) / (hi - lo) as f64
            }));
        }
        Self { values, ..*self }
    }

    fn transposed(&self) -> Self {
        let (w, h) = (self.width as usize, self.height as usize);
        let values = (0..w).flat_map(|x| (0..h).map(move |y| self.values[y * w + x])).collect();
        Self { width: self.height, height: self.width, values }
    }

    /// Means of `sub * sub` points, for `width * height` pixels that start `margin` pixels inside.
    pub(crate) fn reduced(&self, sub: u32, margin: u32, width: u32, height: u32) -> Vec<f64> {
        let pixel = |px: u32, py: u32| {
            let mut sum = 0.0;
            for y in 0..sub {
                let row = ((py + margin) * sub + y) as usize * self.width as usize;
                let first = row + ((px + margin) * sub) as usize;
                sum += self.values[first..first + sub as usize].iter().sum::<f64>();
            }
            sum / f64::from(sub * sub)
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
    }
}
