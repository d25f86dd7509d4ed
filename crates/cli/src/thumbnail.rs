//! What else was made and not kept.

use selvedge_core::Plane;

/// One of several that were made.
pub(crate) struct Thumbnail {
    pub(crate) picture: Plane<2>,
    /// How it was made, and what it is worth.
    pub(crate) caption: String,
}

impl Thumbnail {
    pub(crate) fn new(picture: Plane<2>, caption: impl Into<String>) -> Self {
        Self { picture, caption: caption.into() }
    }
}
