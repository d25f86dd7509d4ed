//! Real transforms over three axes by complex ones: two rows go through one row transform.
//!
//! A spectrum is kept by columns: for each of the `width / 2 + 1` frequencies along x, `height * frames` values in the
//! order `[ky][kt]`, so that the last transform forward and the first one back are contiguous. Several planes lie
//! column by column beside each other: `[kx][plane][ky][kt]`.

use super::workers::{C64, Worker, deal};
use crate::Error;
use crate::axes::Shape;
use crate::memory::fit;
use rustfft::{Fft, FftPlanner, FftPlannerScalar};
use selvedge_core::par;
use std::sync::Arc;

const ZERO: C64 = C64 { re: 0.0, im: 0.0 };

/// The transforms of one size.
pub(crate) struct Transforms {
    pub(crate) size: Shape,
    forward: [Arc<dyn Fft<f64>>; 3],
    inverse: [Arc<dyn Fft<f64>>; 3],
}

impl std::fmt::Debug for Transforms {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Transforms").field("size", &self.size).finish_non_exhaustive()
    }
}

impl Transforms {
    /// Plans transforms; `scalar` forbids vector instructions.
    pub(crate) fn new(size: Shape, scalar: bool) -> Self {
        if scalar {
            let mut planner = FftPlannerScalar::new();
            Self {
                size,
                forward: size.map(|n| planner.plan_fft_forward(n)),
                inverse: size.map(|n| planner.plan_fft_inverse(n)),
            }
        } else {
            let mut planner = FftPlanner::new();
            Self {
                size,
                forward: size.map(|n| planner.plan_fft_forward(n)),
                inverse: size.map(|n| planner.plan_fft_inverse(n)),
            }
        }
    }

    /// Frequencies along x that a real row has.
    pub(crate) fn half(&self) -> usize {
        self.size[2] / 2 + 1
    }

    /// Values of a column.
    pub(crate) fn column(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Values of a spectrum.
    pub(crate) fn len(&self) -> usize {
        self.half() * self.column()
    }

    /// As many workers as there are threads, with memory for these transforms.
    pub(crate) fn prepare(&self, workers: &mut Vec<Worker>) -> Result<(), Error> {
        let (line, scratch) = self.working();
        workers.resize_with(par::threads(), Worker::default);
        for worker in workers {
            for (buffer, len) in [(&mut worker.line, line), (&mut worker.second, line), (&mut worker.scratch, scratch)]
            {
                let len = buffer.len().max(len);
                fit(buffer, len)?;
            }
            let len = worker.real.len().max(2 * line);
            fit(&mut worker.real, len)?;
        }
        Ok(())
    }

    /// Scratch that any of the transforms needs, and the longest line.
    fn working(&self) -> (usize, usize) {
        let scratch = self.forward.iter().chain(&self.inverse).map(|f| f.get_inplace_scratch_len()).max().unwrap_or(0);
        (self.size[2].max(self.column()), scratch)
    }

    /// Spectra of `planes` real planes. `load(plane, t, y, row)` adds the row's values to zeros;
    /// rows from `extent` on are zero and not asked for.
    pub(crate) fn forward(
        &self,
        planes: usize,
        extent: [usize; 2],
        load: impl Fn(usize, usize, usize, &mut [f64]) + Sync + Send,
        rows: &mut Vec<C64>,
        spectra: &mut [C64],
        workers: &mut [Worker],
    ) -> Result<(), Error> {
        let [frames, height] = extent;
        let (half, pairs) = (self.half(), height.div_ceil(2));
        fit(rows, planes * frames * pairs * 2 * half)?;
        deal(rows, 2 * half, workers, |pair, two, worker| {
            let (plane, t, y) = (pair / pairs / frames, pair / pairs % frames, 2 * (pair % pairs));
            let n = self.size[2];
            let real = &mut worker.real[..2 * n];
            real.fill(0.0);
            load(plane, t, y, &mut real[..n]);
            if y + 1 < height {
                load(plane, t, y + 1, &mut real[n..]);
            }
            for (x, z) in worker.line[..n].iter_mut().enumerate() {
                *z = C64::new(worker.real[x], worker.real[n + x]);
            }
            self.forward[2].process_with_scratch(&mut worker.line[..n], &mut worker.scratch);
            part(&worker.line[..n], two);
        });
        let rows = &*rows;
        deal(spectra, self.column(), workers, |number, column, worker| {
            let (plane, kx) = (number % planes, number / planes);
            let line = &mut worker.line[..frames * self.size[1]];
            line.fill(ZERO);
            for t in 0..frames {
                let from = (plane * frames + t) * pairs * 2 * half + kx;
                for (y, z) in line[t * self.size[1]..][..height].iter_mut().enumerate() {
                    *z = rows[from + y * half];
                }
            }
            self.forward[1].process_with_scratch(line, &mut worker.scratch);
            transpose(line, self.size[1], column, self.size[0]);
            if self.size[0] != 1 {
                self.forward[0].process_with_scratch(column, &mut worker.scratch);
            }
        });
        Ok(())
    }

    /// A column of a spectrum back to `[t][y]`, the first `frames` frames of it.
    pub(crate) fn inverse_column(&self, column: &mut [C64], frames: usize, worker: &mut Worker) {
        let [all, height, _] = self.size;
        if all != 1 {
            self.inverse[0].process_with_scratch(column, &mut worker.scratch);
            let line = &mut worker.line[..column.len()];
            line.copy_from_slice(column);
            for t in 0..frames {
                for (y, z) in column[t * height..][..height].iter_mut().enumerate() {
                    *z = line[y * all + t];
                }
            }
        }
        self.inverse[1].process_with_scratch(&mut column[..frames * height], &mut worker.scratch);
    }

    /// One complex row back, in place.
    pub(crate) fn inverse_row(&self, row: &mut [C64], scratch: &mut [C64]) {
        self.inverse[2].process_with_scratch(row, scratch);
    }
}

/// The spectra of two real rows `a` and `b` from that of `a + i b`.
fn part(z: &[C64], two: &mut [C64]) {
    let n = z.len();
    let (a, b) = two.split_at_mut(n / 2 + 1);
    for (k, (a, b)) in a.iter_mut().zip(b).enumerate() {
        let (z, mirror) = (z[k], z[(n - k) % n].conj());
        *a = (z + mirror) * 0.5;
        let difference = (z - mirror) * 0.5;
        *b = C64::new(difference.im, -difference.re);
    }
}

/// `[t][y]` of some frames to `[y][t]` of all; frames that are not there stay as they are after clearing.
fn transpose(from: &[C64], height: usize, to: &mut [C64], frames: usize) {
    if frames == 1 {
        to.copy_from_slice(from);
        return;
    }
    to.fill(ZERO);
    for (t, frame) in from.chunks(height).enumerate() {
        for (y, &z) in frame.iter().enumerate() {
            to[y * frames + t] = z;
        }
    }
}
