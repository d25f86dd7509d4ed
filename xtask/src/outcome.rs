//! How a chore ends.

/// Nothing to say, or a line that says what went wrong (details have been printed).
pub(crate) type Outcome = Result<(), String>;
