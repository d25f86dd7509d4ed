//! One number from the columns.

use crate::Columns;

/// Number of terms of the model.
pub const TERMS: usize = 1;

/// Coefficients by term.
pub type Model = [f64; TERMS];

/// The terms.
pub fn terms(columns: &Columns) -> [f64; TERMS] {
    [columns.coherence]
}

/// The number.
pub fn preference(columns: &Columns) -> f64 {
    -columns.coherence
}
