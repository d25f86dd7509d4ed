//! Cheapest paths along one strip of overlap. `[Efros01 2.1]`

use selvedge_core::{Error, try_vec};

/// The error surface of one strip, seen from the block's outer edge.
///
/// `along` runs along the edge, `across` from the outer edge inwards. The new block begins at the path:
/// a sample is new where its `across` is at least the path's.
#[derive(Clone, Debug)]
pub(crate) struct Strip {
    errors: Vec<u64>,
    width: usize,
}

/// Where a path starts, before it runs towards one end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    /// Anywhere in the row at the other end.
    OtherEnd,
    /// At one cell.
    Cell {
        /// Its row.
        along: usize,
        /// Its column.
        across: usize,
    },
}

/// One of the two ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// Row 0.
    Low,
    /// The last row.
    High,
}

/// Cumulative minimum errors, row by row in the order in which paths cross them. `[Efros01 eq. 1]`
#[derive(Clone, Debug)]
pub(crate) struct Cumulative {
    values: Vec<u64>,
    width: usize,
}

impl Cumulative {
    /// Rows crossed.
    pub(crate) fn len(&self) -> usize {
        self.values.len() / self.width
    }

    /// One row; unreachable cells are `u64::MAX`.
    pub(crate) fn row(&self, number: usize) -> &[u64] {
        &self.values[number * self.width..][..self.width]
    }
}

impl Strip {
    /// `error(along, across)` over `len * width` cells.
    pub(crate) fn new(len: usize, width: usize, error: impl Fn(usize, usize) -> u64) -> Result<Self, Error> {
        let mut errors = try_vec(len * width, 0)?;
        errors.iter_mut().enumerate().for_each(|(i, e)| *e = error(i / width, i % width));
        Ok(Self { errors, width })
    }

    /// Gives each cell that is not known the error of the last known one between it and the outer edge; 0 if there is
    /// none.
    pub(crate) fn carry_inwards(&mut self, known: impl Fn(usize, usize) -> bool) {
        for (along, row) in self.errors.chunks_mut(self.width).enumerate() {
            let mut last = 0;
            for (across, error) in row.iter_mut().enumerate() {
                if known(along, across) {
                    last = *error;
                } else {
                    *error = last;
                }
            }
        }
    }

    /// Rows.
    pub(crate) fn len(&self) -> usize {
        self.errors.len() / self.width
    }

    /// Cells in a row.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Error of a cell.
    pub(crate) fn error(&self, along: usize, across: usize) -> u64 {
        self.errors[along * self.width + across]
    }

    /// The row that is `depth` away from an end.
    pub(crate) fn row(&self, end: End, depth: usize) -> usize {
        match end {
            End::Low => depth,
            End::High => self.len() - 1 - depth,
        }
    }

    /// Cumulative minimum error of the paths from `start` towards `end`. `[Efros01 eq. 1]`
    pub(crate) fn cumulative(&self, start: Start, end: End) -> Result<Cumulative, Error> {
        let (first, only) = match start {
            Start::OtherEnd => (self.row(end, self.len() - 1), None),
            Start::Cell { along, across } => (along, Some(across)),
        };
        let w = self.width;
        let crossed = self.row(end, 0).abs_diff(first) + 1;
        let mut values = try_vec(crossed * w, 0)?;
        for number in 0..crossed {
            let along = if end == End::Low { first - number } else { first + number };
            let (done, rest) = values.split_at_mut(number * w);
            let last = &done[number.saturating_sub(1) * w..];
            for (c, value) in rest[..w].iter_mut().enumerate() {
                let reach = match number {
                    0 => {
                        if only.is_none_or(|only| only == c) {
                            0
                        } else {
                            u64::MAX
                        }
                    }
                    _ => last[c.saturating_sub(1)..(c + 2).min(w)].iter().copied().min().unwrap_or(u64::MAX),
                };
                *value = reach.saturating_add(self.error(along, c));
            }
        }
        Ok(Cumulative { values, width: w })
    }

    /// The cheapest path from `start` towards `end` that stops at a cell `depth` rows from the end, as `across` for
    /// each row it crosses. Ties go to the smallest `across`.
    pub(crate) fn trace(
        &self,
        start: Start,
        end: End,
        depth: usize,
        across: usize,
    ) -> Result<Vec<(usize, usize)>, Error> {
        let sums = self.cumulative(start, end)?;
        let last = sums.len() - 1 - depth;
        let mut path = try_vec(last + 1, (self.row(end, depth), across))?;
        for i in (0..last).rev() {
            let c = path[i + 1].1;
            let near = c.saturating_sub(1)..(c + 2).min(self.width);
            let c = near.min_by_key(|&c| sums.row(i)[c]).unwrap_or(c);
            path[i] = (self.row(end, sums.len() - 1 - i), c);
        }
        Ok(path)
    }
}
