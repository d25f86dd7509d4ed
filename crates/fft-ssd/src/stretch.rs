//! What of a template is compared at once.

/// Samples of a row of a template that are compared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// Where it begins in a plane of the template.
    pub(crate) own: usize,
    /// Where it begins from the place on.
    pub(crate) at: [usize; 2],
    pub(crate) len: usize,
}
