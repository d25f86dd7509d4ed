//! Cheapest paths along one strip of overlap. `[Efros01 2.1]`

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

impl Strip {
    /// `error(along, across)` over `len * width` cells.
    pub(crate) fn new(len: usize, width: usize, error: impl Fn(usize, usize) -> u64) -> Self {
        let errors = (0..len).flat_map(|a| (0..width).map(move |c| (a, c))).map(|(a, c)| error(a, c)).collect();
        Self { errors, width }
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

    /// Cumulative minimum error of the paths from `start` towards `end`, row by row in the order in which they are
    /// crossed; unreachable cells are `u64::MAX`. `[Efros01 eq. 1]`
    pub(crate) fn cumulative(&self, start: Start, end: End) -> Vec<Vec<u64>> {
        let (first, init) = match start {
            Start::OtherEnd => (self.row(end, self.len() - 1), (0..self.width).map(|_| 0).collect()),
            Start::Cell { along, across } => {
                (along, (0..self.width).map(|c| if c == across { 0 } else { u64::MAX }).collect::<Vec<u64>>())
            }
        };
        let mut rows: Vec<Vec<u64>> = Vec::new();
        for along in self.rows_from(first, end) {
            let reach = |c: usize| match rows.last() {
                None => init[c],
                Some(row) => {
                    row[c.saturating_sub(1)..(c + 2).min(self.width)].iter().copied().min().unwrap_or(u64::MAX)
                }
            };
            let row = (0..self.width).map(|c| reach(c).saturating_add(self.error(along, c))).collect();
            rows.push(row);
        }
        rows
    }

    /// The rows from `first` to `end`, both included.
    fn rows_from(&self, first: usize, end: End) -> Box<dyn Iterator<Item = usize>> {
        match end {
            End::Low => Box::new((0..=first).rev()),
            End::High => Box::new(first..self.len()),
        }
    }

    /// The cheapest path from `start` towards `end` that stops at a cell `depth` rows from the end, as `across` for
    /// each row it crosses. Ties go to the smallest `across`.
    pub(crate) fn trace(&self, start: Start, end: End, depth: usize, across: usize) -> Vec<(usize, usize)> {
        let rows = self.cumulative(start, end);
        let last = rows.len() - 1 - depth;
        let mut path = vec![(self.row(end, depth), across)];
        let mut c = across;
        for (i, row) in rows[..last].iter().enumerate().rev() {
            let near = c.saturating_sub(1)..(c + 2).min(self.width);
            c = near.min_by_key(|&c| row[c]).unwrap_or(c);
            path.push((self.row(end, rows.len() - 1 - i), c));
        }
        path
    }
}
