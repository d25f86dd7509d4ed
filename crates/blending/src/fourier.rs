//! Lines as sums of waves: cosines where they end, sines where their ends are tied, all waves where they go around.
//!
//! Transforms of our own, because their last bits reach float samples: a library that chooses instructions by the
//! machine, and sines by the system, makes other files there. Sines are libm's and sums have one order.

use std::f64::consts::PI;

/// The greatest prime that lengths are divided by directly. A factor p costs p products a sample, Bluestein's detour
/// about as much as 60.
const LARGEST_PRIME: usize = 50;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Complex {
    re: f64,
    im: f64,
}

impl Complex {
    const ZERO: Self = Self { re: 0.0, im: 0.0 };

    /// `exp(-2 pi i part / whole)`.
    fn unit(part: usize, whole: usize) -> Self {
        let (sin, cos) = libm::sincos(-2.0 * PI * part as f64 / whole as f64);
        Self { re: cos, im: sin }
    }

    fn plus(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }

    fn minus(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }

    fn times(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }

    fn conjugate(self) -> Self {
        Self { re: self.re, im: -self.im }
    }

    /// Times `-i`.
    fn turned(self) -> Self {
        Self { re: self.im, im: -self.re }
    }

    /// Real and imaginary part exchanged: between two of them a transform is its own inverse but for its length.
    fn swapped(self) -> Self {
        Self { re: self.im, im: self.re }
    }
}

/// The discrete Fourier transform of one length.
struct Fourier {
    len: usize,
    /// Prime factors, fours first.
    factors: Vec<usize>,
    /// `exp(-2 pi i k / len)`.
    units: Vec<Complex>,
    /// For lengths with a large prime: a convolution of a length that has none.
    chirp: Option<Box<Chirp>>,
}

/// Bluestein's way: `exp(-pi i k^2 / len)`, and its transform.
struct Chirp {
    inner: Fourier,
    factors: Vec<Complex>,
    spectrum: Vec<Complex>,
}

impl Fourier {
    fn new(len: usize) -> Self {
        let factors = factors(len);
        let chirp = factors.iter().any(|&p| LARGEST_PRIME < p).then(|| Box::new(Chirp::new(len)));
        Self { len, factors, units: (0..len).map(|k| Complex::unit(k, len)).collect(), chirp }
    }

    fn transform(&self, from: &[Complex], to: &mut [Complex]) {
        match &self.chirp {
            Some(chirp) => chirp.transform(from, to),
            None => self.part(from, 1, to, &self.factors),
        }
    }

    /// The transform of every `stride`-th sample, as many as `to` holds.
    fn part(&self, from: &[Complex], stride: usize, to: &mut [Complex], factors: &[usize]) {
        let Some((&p, rest)) = factors.split_first() else {
            to[0] = from[0];
            return;
        };
        let m = to.len() / p;
        for (r, to) in to.chunks_exact_mut(m).enumerate() {
            self.part(&from[r * stride..], stride * p, to, rest);
        }
        match p {
            2 => self.twos(to, m, stride),
            4 => self.fours(to, m, stride),
            _ => self.primes(to, m, stride, p),
        }
    }

    fn twos(&self, to: &mut [Complex], m: usize, stride: usize) {
        let (low, high) = to.split_at_mut(m);
        for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
            let t = b.times(self.units[k * stride]);
            (*a, *b) = (a.plus(t), a.minus(t));
        }
    }

    fn fours(&self, to: &mut [Complex], m: usize, stride: usize) {
        let (low, high) = to.split_at_mut(2 * m);
        let ((a, b), (c, d)) = (low.split_at_mut(m), high.split_at_mut(m));
        for k in 0..m {
            let [t1, t2, t3] = [b[k], c[k], d[k]];
            let (t1, t2, t3) = (
                t1.times(self.units[k * stride]),
                t2.times(self.units[2 * k * stride]),
                t3.times(self.units[3 * k * stride]),
            );
            let (even, odd) = ([a[k].plus(t2), a[k].minus(t2)], [t1.plus(t3), t1.minus(t3).turned()]);
            (a[k], b[k], c[k], d[k]) =
                (even[0].plus(odd[0]), even[1].plus(odd[1]), even[0].minus(odd[0]), even[1].minus(odd[1]));
        }
    }

    fn primes(&self, to: &mut [Complex], m: usize, stride: usize, p: usize) {
        let mut terms = [Complex::ZERO; LARGEST_PRIME];
        for k in 0..m {
            for (r, term) in terms[..p].iter_mut().enumerate() {
                *term = to[r * m + k].times(self.units[r * k * stride]);
            }
            for q in 0..p {
                let turn = |r: usize| self.units[r * q % p * m * stride];
                let sum = terms[..p].iter().enumerate().map(|(r, t)| t.times(turn(r)));
                to[q * m + k] = sum.fold(Complex::ZERO, Complex::plus);
            }
        }
    }
}

impl Chirp {
    fn new(len: usize) -> Self {
        let inner = Fourier::new((2 * len - 1).next_power_of_two());
        // k^2 within two lengths, so that the angle stays exact.
        let factors: Vec<Complex> = (0..len).map(|k| Complex::unit(k * k % (2 * len), 2 * len)).collect();
        let mut around = vec![Complex::ZERO; inner.len];
        for (k, factor) in factors.iter().enumerate() {
            around[k] = factor.conjugate();
            around[(inner.len - k) % inner.len] = factor.conjugate();
        }
        let mut spectrum = vec![Complex::ZERO; inner.len];
        inner.transform(&around, &mut spectrum);
        Self { inner, factors, spectrum }
    }

    fn transform(&self, from: &[Complex], to: &mut [Complex]) {
        let n = self.inner.len;
        let (mut padded, mut product) = (vec![Complex::ZERO; n], vec![Complex::ZERO; n]);
        padded.iter_mut().zip(from.iter().zip(&self.factors)).for_each(|(p, (v, f))| *p = v.times(*f));
        self.inner.transform(&padded, &mut product);
        product.iter_mut().zip(&self.spectrum).for_each(|(p, s)| *p = p.times(*s).swapped());
        self.inner.transform(&product, &mut padded);
        for ((to, p), f) in to.iter_mut().zip(&padded).zip(&self.factors) {
            let p = p.swapped();
            *to = Complex { re: p.re / n as f64, im: p.im / n as f64 }.times(*f);
        }
    }
}

/// Prime factors of a length, but four for two twos.
fn factors(mut n: usize) -> Vec<usize> {
    let mut factors = Vec::new();
    let mut p = 4;
    while 1 < n {
        while n.is_multiple_of(p) {
            factors.push(p);
            n /= p;
        }
        p = match p {
            4 => 2,
            2 => 3,
            // What is left is a prime.
            _ if n < p * p => n,
            _ => p + 2,
        };
        if p < 2 {
            break;
        }
    }
    factors
}

/// What an axis has beyond its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ends {
    /// Nothing.
    Free,
    /// Its other end.
    Around,
    /// Samples that are held at 0.
    Tied,
}

/// The waves along an axis: those for which the difference from both neighbors, summed, is a multiple of the wave.
pub(crate) struct Waves {
    len: usize,
    fourier: Fourier,
    ends: Ends,
    /// `exp(-pi i k / (2 len))`.
    quarters: Vec<Complex>,
}

/// Memory that a line's transform works in.
#[derive(Default)]
pub(crate) struct Scratch {
    from: Vec<Complex>,
    to: Vec<Complex>,
}

impl Waves {
    pub(crate) fn new(len: u32, ends: Ends) -> Self {
        let len = len as usize;
        let quarters = (0..len).map(|k| Complex::unit(k, 4 * len)).collect();
        // What is tied goes on mirrored and turned over.
        let fourier = Fourier::new(if ends == Ends::Tied { 2 * (len + 1) } else { len });
        Self { len, fourier, ends, quarters }
    }

    /// By wave: what the differences from both neighbors sum up to, for a wave of height 1.
    pub(crate) fn eigenvalues(&self) -> Vec<f64> {
        let n = self.len as f64;
        let angle = |k: usize| match self.ends {
            Ends::Free => PI * k as f64 / n,
            Ends::Around => 2.0 * PI * k as f64 / n,
            Ends::Tied => PI * (k + 1) as f64 / (n + 1.0),
        };
        // 2 - 2 cos, without losing the digits of small ones.
        let value = |k: usize| 4.0 * libm::pow(libm::sin(angle(k) / 2.0), 2.0);
        (0..self.len).map(value).collect()
    }

    /// Two lines into heights of waves: a sum of cosines, of sines, or of both together (Hartley's transform).
    pub(crate) fn forward(&self, lines: [&mut [f64]; 2], scratch: &mut Scratch) {
        match self.ends {
            Ends::Free => self.cosines(lines, scratch),
            Ends::Around => self.around(lines, scratch),
            Ends::Tied => self.sines(lines, scratch),
        }
    }

    /// The inverse of [`forward`](Self::forward).
    pub(crate) fn backward(&self, [a, b]: [&mut [f64]; 2], scratch: &mut Scratch) {
        let scale = match self.ends {
            Ends::Free => return self.of_cosines([a, b], scratch),
            Ends::Around => 1.0 / self.len as f64,
            Ends::Tied => 2.0 / (self.len + 1) as f64,
        };
        self.forward([&mut *a, &mut *b], scratch);
        a.iter_mut().chain(b).for_each(|v| *v *= scale);
    }

    fn transform(&self, scratch: &mut Scratch) {
        scratch.to.resize(self.fourier.len, Complex::ZERO);
        self.fourier.transform(&scratch.from, &mut scratch.to);
    }

    fn sines(&self, [a, b]: [&mut [f64]; 2], scratch: &mut Scratch) {
        let both = |i: usize| Complex { re: a[i], im: b[i] };
        scratch.from.clear();
        scratch.from.push(Complex::ZERO);
        scratch.from.extend((0..self.len).map(both));
        scratch.from.push(Complex::ZERO);
        scratch.from.extend((0..self.len).rev().map(|i| Complex::ZERO.minus(both(i))));
        self.transform(scratch);
        // -2 i (a + i b).
        for (k, v) in scratch.to[1..=self.len].iter().enumerate() {
            (a[k], b[k]) = (-v.im / 2.0, v.re / 2.0);
        }
    }

    fn around(&self, [a, b]: [&mut [f64]; 2], scratch: &mut Scratch) {
        scratch.from.clear();
        scratch.from.extend(a.iter().zip(&*b).map(|(&re, &im)| Complex { re, im }));
        self.transform(scratch);
        for k in 0..self.len {
            let [of_a, of_b] = parted(&scratch.to, k);
            (a[k], b[k]) = ((of_a.re - of_a.im) / 2.0, (of_b.re - of_b.im) / 2.0);
        }
    }

    fn cosines(&self, [a, b]: [&mut [f64]; 2], scratch: &mut Scratch) {
        scratch.from.clear();
        // Every second sample, and the others from behind (Makhoul 1980).
        let order = (0..self.len).map(|i| folded(i, self.len));
        scratch.from.extend(order.map(|i| Complex { re: a[i], im: b[i] }));
        self.transform(scratch);
        for k in 0..self.len {
            let [of_a, of_b] = parted(&scratch.to, k).map(|f| f.times(self.quarters[k]).re / 2.0);
            (a[k], b[k]) = (of_a, of_b);
        }
    }

    /// The inverse of [`cosines`](Self::cosines).
    fn of_cosines(&self, [a, b]: [&mut [f64]; 2], scratch: &mut Scratch) {
        let n = self.len;
        scratch.from.clear();
        scratch.from.extend((0..n).map(|k| {
            let spectrum = |x: &[f64]| {
                let back = if k == 0 { 0.0 } else { x[n - k] };
                Complex { re: x[k], im: -back }.times(self.quarters[k].conjugate())
            };
            let (of_a, of_b) = (spectrum(a), spectrum(b));
            // a + i b, swapped for the inverse.
            Complex { re: of_a.re - of_b.im, im: of_a.im + of_b.re }.swapped()
        }));
        self.transform(scratch);
        for (i, v) in scratch.to.iter().enumerate() {
            let (at, v) = (folded(i, n), v.swapped());
            (a[at], b[at]) = (v.re / n as f64, v.im / n as f64);
        }
    }
}

/// Spectra of two lines that were transformed as one, twice as high.
fn parted(spectrum: &[Complex], k: usize) -> [Complex; 2] {
    let n = spectrum.len();
    let (here, there) = (spectrum[k], spectrum[(n - k) % n].conjugate());
    [here.plus(there), here.minus(there).turned()]
}

/// The sample that stands at `i` when every second one comes first, and the others from behind.
fn folded(i: usize, n: usize) -> usize {
    if 2 * i < n { 2 * i } else { 2 * (n - i) - 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Seed;

    #[test]
    fn lengths_are_the_product_of_their_factors() {
        for n in 1..2000 {
            let found = factors(n);
            assert_eq!(found.iter().product::<usize>(), n);
            let is_prime = |p: usize| (2..p).all(|d| !p.is_multiple_of(d));
            assert!(found.iter().all(|&p| p == 4 || is_prime(p)), "{n}: {found:?}");
        }
    }

    #[test]
    fn lines_are_sums_of_waves() {
        let mut rng = Seed(1).rng();
        for n in (1_u32..40).chain([53, 61, 64, 100, 106, 120, 121, 127, 128, 250]) {
            for ends in [Ends::Free, Ends::Around, Ends::Tied] {
                let waves = Waves::new(n, ends);
                let mut line = || (0..n).map(|_| f64::from(rng.below(1000))).collect::<Vec<f64>>();
                let lines = [line(), line()];
                let [mut a, mut b] = lines.clone();
                let mut scratch = Scratch::default();
                waves.forward([&mut a, &mut b], &mut scratch);
                for (line, found) in lines.iter().zip([&a, &b]) {
                    for (k, found) in found.iter().enumerate() {
                        let wave = |i: usize| {
                            let (i, k, n) = (i as f64, k as f64, f64::from(n));
                            let angle = 2.0 * PI * k * i / n;
                            match ends {
                                Ends::Free => libm::cos(PI * k * (i + 0.5) / n),
                                Ends::Around => libm::cos(angle) + libm::sin(angle),
                                Ends::Tied => libm::sin(PI * (k + 1.0) * (i + 1.0) / (n + 1.0)),
                            }
                        };
                        let slow: f64 = line.iter().enumerate().map(|(i, v)| v * wave(i)).sum();
                        assert!((slow - found).abs() < 1e-7, "{n} {ends:?} {k}: {slow} {found}");
                    }
                }
                waves.backward([&mut a, &mut b], &mut scratch);
                for (line, found) in lines.iter().zip([&a, &b]) {
                    assert!(line.iter().zip(found).all(|(l, f)| (l - f).abs() < 1e-9), "{n} {ends:?}");
                }
            }
        }
    }
}
