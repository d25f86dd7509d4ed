//! Textures to make instances of: tori of bytes, made up from a name, or mirrored from a picture.

use std::path::Path;

/// SplitMix64.
#[derive(Clone)]
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// Uniform in `0..n`.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

fn mix(z: u64) -> u64 {
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// Rows and columns of a torus.
pub(crate) const SIDE: usize = 1024;

/// A seamless torus of `SIDE` rows and columns.
pub(crate) struct Texture {
    channels: usize,
    /// Row by row, channels innermost.
    values: Vec<u8>,
    /// Size of the central difference along an axis.
    gradients: [Vec<f32>; 2],
}

impl Texture {
    /// `brick`, `grass`, `gravel` (grey), `tissue` (colour), or any `NAME.pnm` of a folder.
    pub(crate) fn named(name: &str, folder: Option<&Path>) -> Self {
        match folder {
            Some(folder) => Self::mirrored(&folder.join(format!("{name}.pnm"))),
            None => Self::made(name),
        }
    }

    fn of(channels: usize, value: impl Fn(usize, usize, usize) -> u8) -> Self {
        let all = (0..SIDE * SIDE * channels).map(|i| (i / channels, i % channels));
        let values = all.map(|(p, c)| value(p / SIDE, p % SIDE, c)).collect();
        let mut texture = Self { channels, values, gradients: [Vec::new(), Vec::new()] };
        texture.gradients = [0, 1].map(|axis| {
            let step = |p: usize, by: usize| {
                let (y, x) = (p / SIDE, p % SIDE);
                if axis == 0 { ((y + by) % SIDE, x) } else { (y, (x + by) % SIDE) }
            };
            (0..SIDE * SIDE).map(|p| texture.distance(step(p, 1), step(p, SIDE - 1)) / 2.0).collect()
        });
        texture
    }

    fn made(name: &str) -> Self {
        match name {
            "brick" => Self::of(1, |y, x, _| {
                let shifted = (x + y / 32 % 2 * 32) % SIDE;
                let brick = hash([y / 32, shifted / 64], 1) % 48;
                let mortar = y % 32 < 3 || shifted % 64 < 3;
                let value = if mortar { 60 } else { 120 + brick };
                (value + noise(y, x, [1, 1, 2], 2) / 6 + noise(y, x, [8, 8, 16], 3) / 8) as u8
            }),
            "grass" => Self::of(1, |y, x, _| {
                ((noise(y, x, [8, 2, 1], 4) + noise(y, (x + 3 * y) % SIDE, [16, 2, 1], 5)) / 2) as u8
            }),
            "clouds" => Self::of(1, |y, x, _| noise(y, x, [64, 64, 32], 12) as u8),
            "gravel" => Self::of(1, |y, x, _| {
                let [near, next, stone] = stones(y, x, 16);
                (40 + stone % 60 + (6 * (next - near)).min(90) + noise(y, x, [1, 1, 2], 6) / 6) as u8
            }),
            _ => Self::of(3, |y, x, c| {
                let cells = noise(y, x, [16, 16, 4], 7);
                let stain = noise(y, x, [64, 64, 32], 8);
                let grain = noise(y, x, [2, 2, 1], 9 + c as u64) / 10;
                ([180, 150, 170][c] + grain + stain / 8 - cells * [2, 3, 1][c] / 8 * u64::from(cells > 120)) as u8
            }),
        }
    }

    /// A binary PGM or PPM picture of 8 bits, its first 512 rows and columns and their mirror images.
    fn mirrored(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let header: Vec<&[u8]> = bytes.splitn(5, |b| b.is_ascii_whitespace()).collect();
        let number = |k: usize| str::from_utf8(header[k]).ok().and_then(|s| s.parse().ok()).expect("a plain header");
        let (columns, rows): (usize, usize) = (number(1), number(2));
        let channels = if header[0] == b"P6" { 3 } else { 1 };
        let values = &header[4][header[4].len() - rows * columns * channels..];
        assert!(rows >= SIDE / 2 && columns >= SIDE / 2, "at least 512 x 512 pixels");
        let mirror = |k: usize| k.min(SIDE - 1 - k);
        Self::of(channels, |y, x, c| values[(mirror(y) * columns + mirror(x)) * channels + c])
    }

    fn pixel(&self, (y, x): (usize, usize)) -> &[u8] {
        &self.values[(y % SIDE * SIDE + x % SIDE) * self.channels..][..self.channels]
    }

    /// Euclidean distance of two pixels.
    pub(crate) fn distance(&self, a: (usize, usize), b: (usize, usize)) -> f32 {
        let squares = self.pixel(a).iter().zip(self.pixel(b)).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2));
        (squares.sum::<u32>() as f32).sqrt()
    }

    pub(crate) fn gradient(&self, axis: usize, (y, x): (usize, usize)) -> f32 {
        self.gradients[axis][y % SIDE * SIDE + x % SIDE]
    }

    /// Mean of the channels.
    pub(crate) fn grey(&self, at: (usize, usize)) -> i32 {
        self.pixel(at).iter().map(|&v| i32::from(v)).sum::<i32>() / self.channels as i32
    }
}

fn hash(cell: [usize; 2], seed: u64) -> u64 {
    mix(mix(mix(seed) ^ cell[0] as u64) ^ cell[1] as u64)
}

/// Value noise on the torus, 0 to 255: cells of `dy` rows and `dx` columns, and half as strong ones of `fine`.
fn noise(y: usize, x: usize, [dy, dx, fine]: [usize; 3], seed: u64) -> u64 {
    let octave = |dy: usize, dx: usize, seed: u64| {
        let corner = |k: usize| {
            let (cy, cx) = ((y / dy + k / 2) % (SIDE / dy), (x / dx + k % 2) % (SIDE / dx));
            let weight = |at: usize, high: usize, d: usize| if high == 1 { at % d } else { d - at % d };
            (hash([cy, cx], seed) & 255) * (weight(y, k / 2, dy) * weight(x, k % 2, dx)) as u64
        };
        (0..4).map(corner).sum::<u64>() / (dy * dx) as u64
    };
    (2 * octave(dy, dx, seed) + octave(fine, fine, seed + 100)) / 3
}

/// Distances to the nearest and the next of the stones, one in each cell, and what the nearest is like.
fn stones(y: usize, x: usize, cell: usize) -> [u64; 3] {
    let (mut near, mut next, mut stone) = (u64::MAX, u64::MAX, 0);
    let cells = SIDE / cell;
    for k in 0..25 {
        let (cy, cx) = (y / cell + cells + k / 5 - 2, x / cell + cells + k % 5 - 2);
        let drawn = hash([cy % cells, cx % cells], 11);
        let (py, px) = (cy * cell + drawn as usize % cell, cx * cell + (drawn >> 8) as usize % cell);
        let distance = ((py.abs_diff(y + SIDE).pow(2) + px.abs_diff(x + SIDE).pow(2)) as u64).isqrt();
        if distance < near {
            (near, next, stone) = (distance, near, drawn >> 16);
        } else {
            next = next.min(distance);
        }
    }
    [near, next, stone]
}
