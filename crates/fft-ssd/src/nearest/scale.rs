//! Errors that are scaled by where they lie.

/// Scaled error and position of a window of one source.
pub(super) type Best = Option<(f32, [u32; 2])>;

/// What an error is multiplied by at a position to whose nearest window it is `least`: infinite if none can stand
/// there.
pub(super) fn factor(least: u64, added: f64) -> f32 {
    if least == u64::MAX { f32::INFINITY } else { (1.0 / (least as f64 + added)) as f32 }
}
