//! What can be wrong with a search.

use selvedge_core::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The template's buffer does not follow from its shape and the searcher's channels.
    #[error("a template of shape {shape:?} and {channels} channels has {expected} features, not {found}")]
    TemplateLength {
        /// The template's shape, slowest axis first.
        shape: Vec<u32>,
        /// Channels of the exemplars.
        channels: usize,
        /// Features that these ask for.
        expected: u64,
        /// Features given.
        found: u64,
    },
    /// The mask and the template differ in size.
    #[error("a template of {expected} samples was given a mask of {found}")]
    MaskLength {
        /// Samples of the template.
        expected: u64,
        /// Samples of the mask.
        found: u64,
    },
    /// One side of the template is 0.
    #[error("the template is {shape:?}, which holds nothing")]
    EmptyTemplate {
        /// The template's shape, slowest axis first.
        shape: Vec<u32>,
    },
    /// A part of a template is empty or reaches beyond it.
    #[error("a part of {part:?} samples from {start:?} on does not lie inside a template of {shape:?}")]
    Part {
        /// The part's first sample, slowest axis first.
        start: Vec<u32>,
        /// The part's shape.
        part: Vec<u32>,
        /// The template's shape.
        shape: Vec<u32>,
    },
    /// Weights and channels, or the channels of what is compared, differ in number.
    #[error("{found} {what} for {expected}")]
    Count {
        /// What was counted, such as `weights`.
        what: &'static str,
        /// How many are needed.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// A mask does not match the picture that it lies over.
    #[error("a picture of {expected:?} samples was given a mask of {found:?}")]
    MaskShape {
        /// The picture's shape, slowest axis first.
        expected: Vec<u32>,
        /// The mask's shape.
        found: Vec<u32>,
    },
    /// Costs can only be summed over the same positions and, in partial cover, the same samples.
    #[error("costs of different positions cannot be summed")]
    Mismatch,
    /// A weighted sum could pass 64 bits.
    #[error("a weighted sum of costs may reach {bound:e}, beyond 64 bits")]
    Overflow {
        /// The largest possible sum, about.
        bound: f64,
    },
    /// The template or the map of costs is larger than the machine can address.
    #[error("a search over {positions} positions cannot be addressed")]
    TooLarge {
        /// Positions asked for.
        positions: u64,
    },
    /// What the core says, such as that memory is short.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
}

impl Error {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Overflow { .. } => ErrorKind::Option,
            Self::TooLarge { .. } => ErrorKind::Memory,
            Self::Core(e) => e.kind(),
            _ => ErrorKind::Input,
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::TemplateLength { .. } => "give every channel of every sample",
            Self::MaskLength { .. } | Self::MaskShape { .. } => "give one mark for each sample",
            Self::Count { .. } => "give one weight a channel, of which all have as many",
            Self::EmptyTemplate { .. } => "give every side at least 1",
            Self::Part { .. } => "keep parts inside of the template",
            Self::Mismatch => "search both with templates of one shape and one placement",
            Self::Overflow { .. } => "use smaller weights",
            Self::TooLarge { .. } => "use a smaller exemplar or template",
            Self::Core(e) => return e.remedy(),
        }
        .to_owned()
    }
}
