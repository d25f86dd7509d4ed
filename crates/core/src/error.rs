//! What can be wrong with grids, planes, exemplars and maps.
//!
//! Here and in every crate above an error is three facts: what is wrong with its numbers (`Display`), what to do about
//! it (`remedy`, in terms of the data: options have other names in every program), and who can mend it (`kind`). They
//! are never one text, because a name or a decoder's words inside of it may hold any sign that would part them.

use crate::ErrorKind;

/// An error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An option of a method is out of its range.
    #[error("{option} is {value}, which is out of range")]
    Range {
        /// The option's name.
        option: &'static str,
        /// What it was set to.
        value: f64,
        /// What it may be, in words.
        range: &'static str,
    },
    /// An amount that a method was given is out of its range.
    #[error("{what} of {value} is out of range")]
    Amount {
        /// What it is of, with its article.
        what: &'static str,
        /// How much it is.
        value: f64,
        /// What it may be, in words.
        range: &'static str,
    },
    /// An output has no samples.
    #[error("an output of {} px holds nothing", across(shape))]
    EmptyOutput {
        /// Its shape, slowest axis first.
        shape: Vec<u32>,
    },
    /// A buffer's length does not follow from the shape and the number of channels.
    #[error("a grid of {expected} samples was given {found}")]
    Length {
        /// Samples that the shape asks for.
        expected: usize,
        /// Samples that were given.
        found: usize,
    },
    /// More samples than a map can number.
    #[error("{samples} samples are more than the {limit} allowed")]
    TooManySamples {
        /// Samples asked for.
        samples: u64,
        /// The limit.
        limit: u64,
    },
    /// The system gave no memory.
    #[error("no memory for {bytes} bytes")]
    Allocation {
        /// Bytes asked for.
        bytes: u64,
    },
    /// A plane and a picture of the `image` crate that have no counterpart.
    #[error("{layout} are no picture that the crate `image` has")]
    NotAnImage {
        /// Channels and depth.
        layout: String,
    },
    /// A plane of another depth than 8 bits was asked for its bytes.
    #[error("{layout} are not bytes")]
    NotBytes {
        /// Channels and depth.
        layout: String,
    },
    /// A vote that weighs less than nothing, or no number.
    #[error("a vote at place {place} weighs {weight}")]
    Vote {
        /// The place in the output, row-major.
        place: usize,
        /// What the vote weighs.
        weight: f32,
    },
    /// An output is over the caps of a run.
    #[error("the output of {} px is over the caps of {side} px a side and {samples} px in all", across(shape))]
    OverCaps {
        /// Its shape, slowest axis first.
        shape: Vec<u32>,
        /// The cap on a side.
        side: u32,
        /// The cap on all samples.
        samples: u64,
    },
    /// A run would need more memory than it may have.
    #[error("the run needs about {needed} of memory, and {budget} are allowed")]
    OverBudget {
        /// The estimate.
        needed: crate::Bytes,
        /// What is allowed.
        budget: crate::Bytes,
    },
    /// No exemplar was given.
    #[error("there are no exemplars")]
    NoExemplars,
    /// The planes of an exemplar have no channels.
    #[error("exemplar {exemplar} has planes without channels")]
    NoChannels {
        /// Its number, from 0.
        exemplar: usize,
    },
    /// An exemplar without planes.
    #[error("exemplar {exemplar} has no planes")]
    NoPlanes {
        /// Its number, from 0.
        exemplar: usize,
    },
    /// The planes of one exemplar, or a map and its plane, differ in shape.
    #[error("plane {plane} of exemplar {exemplar} is {} px, but {} px are needed", across(found), across(expected))]
    Shape {
        /// The exemplar, from 0.
        exemplar: usize,
        /// The plane, from 0.
        plane: usize,
        /// The expected shape, slowest axis first.
        expected: Vec<u32>,
        /// The shape found.
        found: Vec<u32>,
    },
    /// The mask of an exemplar has another shape.
    #[error("the mask of exemplar {exemplar} is {} px, but the exemplar is {} px", across(found), across(expected))]
    MaskShape {
        /// The exemplar, from 0.
        exemplar: usize,
        /// The exemplar's shape, slowest axis first.
        expected: Vec<u32>,
        /// The mask's shape.
        found: Vec<u32>,
    },
    /// Exemplars differ in roles, channels or depth.
    #[error("exemplar {exemplar} has {found}, but the first has {expected}")]
    Layout {
        /// The exemplar, from 0.
        exemplar: usize,
        /// What the first exemplar has.
        expected: String,
        /// What this one has.
        found: String,
    },
    /// A picture holds a value that is no number.
    #[error("plane {plane} of exemplar {exemplar} holds {count} values that are not finite, the first at {at:?}")]
    NotFinite {
        /// The exemplar, from 0.
        exemplar: usize,
        /// The plane, from 0.
        plane: usize,
        /// How many.
        count: usize,
        /// Where the first one is, slowest axis first.
        at: Vec<u32>,
    },
    /// An exemplar without a sample.
    #[error("exemplar {exemplar} is empty: it has {} px", across(shape))]
    EmptyExemplar {
        /// Its number, from 0.
        exemplar: usize,
        /// Its shape, slowest axis first.
        shape: Vec<u32>,
    },
    /// Every sample of every exemplar is masked or transparent.
    #[error("no sample of any exemplar is valid: every one is masked or transparent")]
    NothingValid,
    /// An angle or a magnification is no number or out of range.
    #[error("{transform:?} is out of range")]
    Transform {
        /// The transform asked for.
        transform: crate::Transform,
    },
    /// The weights do not match the channels.
    #[error("{found} weights for {expected} feature channels")]
    Weights {
        /// Feature channels.
        expected: usize,
        /// Weights given.
        found: usize,
    },
    /// Guides and what they lie under differ in number.
    #[error("{found} guide maps were given for {expected}")]
    GuideCount {
        /// How many are needed.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// A guide map and its exemplar differ in shape.
    #[error(
        "the guide map of exemplar {exemplar} is {} px, but the exemplar is {} px",
        across(found),
        across(expected)
    )]
    GuideShape {
        /// The exemplar, from 0.
        exemplar: usize,
        /// The exemplar's shape, slowest axis first.
        expected: Vec<u32>,
        /// The map's shape.
        found: Vec<u32>,
    },
    /// The targets of guides that are joined differ in shape.
    #[error("a guide's target is {} px, but the first one's is {} px", across(found), across(expected))]
    GuideTarget {
        /// The first target's shape, slowest axis first.
        expected: Vec<u32>,
        /// The shape found.
        found: Vec<u32>,
    },
    /// A guide's weight is negative or no number, or no guide has any weight.
    #[error("a guide's weight of {weight} cannot be used")]
    GuideWeight {
        /// The weight.
        weight: f64,
    },
    /// A guide's weight is so small beside another's that it would count nothing.
    #[error("a guide's weight of {weight:?} counts nothing beside one of {most:?}")]
    GuideProportion {
        /// The weight.
        weight: f64,
        /// The largest of all.
        most: f64,
    },
    /// A map names samples that its sources do not hold.
    #[error("the map names sample {id}, but its sources hold {samples}")]
    UnknownSample {
        /// The sample's number.
        id: u32,
        /// Samples in all sources.
        samples: u64,
    },
    /// A map shows a source that is not among those it is to show.
    #[error("the map shows its source {number}, and nothing here is the same")]
    MissingSource {
        /// The map's source, from 0.
        number: usize,
    },
    /// A constraint has another shape than the output.
    #[error("the {what} is {} px, but the output is {} px", across(found), across(expected))]
    StartShape {
        /// Which one.
        what: &'static str,
        /// The output's shape, slowest axis first.
        expected: Vec<u32>,
        /// The shape found.
        found: Vec<u32>,
    },
    /// A field of sources allows a position none.
    #[error("no source may be used at {at:?}")]
    NoSource {
        /// The position, slowest axis first.
        at: Vec<u32>,
    },
    /// A field of sources has one bit for each of at most 64.
    #[error("a field of sources tells {most} sources apart, not {found}")]
    TooManySources {
        /// Sources of the exemplars.
        found: usize,
        /// Bits of the field.
        most: usize,
    },
    /// A grid of a [`Start`](crate::Start) has not exactly one channel.
    #[error("the {what} has {found} channels")]
    Channels {
        /// Which one.
        what: &'static str,
        /// Its channels.
        found: usize,
    },
    /// A map to go on from was made from other exemplars.
    #[error(
        "the map was made from {found} sources with {held} samples, or names others than it holds, but the exemplars have {sources} with {samples}"
    )]
    ForeignMap {
        /// Sources of the map.
        found: usize,
        /// Samples that the map's sources hold.
        held: u32,
        /// Sources of the exemplars.
        sources: usize,
        /// Samples in all of them.
        samples: u32,
    },
    /// A map and exemplars that should be half or twice as large are not, or have other sources.
    #[error("the map and the exemplars are not neighbouring levels of one pyramid")]
    Pyramid,
    /// Rendering needs a plane for each exemplar.
    #[error("the map was made from {expected} exemplars, but {found} planes were given")]
    PlaneCount {
        /// Exemplars of the map.
        expected: usize,
        /// Planes given.
        found: usize,
    },
}

/// A shape as people write it, the fastest axis first.
fn across(shape: &[u32]) -> String {
    shape.iter().rev().map(u32::to_string).collect::<Vec<_>>().join("x")
}

impl Error {
    /// [`Error::Range`].
    pub fn range(option: &'static str, value: impl Into<f64>, range: &'static str) -> Self {
        Self::Range { option, value: value.into(), range }
    }

    /// Refuses an option that is not within its range, or no number.
    ///
    /// # Errors
    /// [`Error::Range`].
    pub fn within(
        option: &'static str,
        value: impl Into<f64>,
        range: std::ops::RangeInclusive<f64>,
        in_words: &'static str,
    ) -> Result<(), Self> {
        let value = value.into();
        if range.contains(&value) { Ok(()) } else { Err(Self::range(option, value, in_words)) }
    }

    /// [`Error::Amount`].
    pub fn amount(what: &'static str, value: impl Into<f64>, range: &'static str) -> Self {
        Self::Amount { what, value: value.into(), range }
    }

    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Allocation { .. } | Self::OverBudget { .. } => ErrorKind::Memory,
            Self::Range { .. }
            | Self::Amount { .. }
            | Self::EmptyOutput { .. }
            | Self::GuideWeight { .. }
            | Self::GuideProportion { .. }
            | Self::Transform { .. }
            | Self::Weights { .. } => ErrorKind::Option,
            _ => ErrorKind::Input,
        }
    }

    /// What to do about it, in terms of the data.
    pub fn remedy(&self) -> String {
        match self {
            Self::Range { range, .. } | Self::Amount { range, .. } => return format!("use {range}"),
            Self::EmptyOutput { shape } => return format!("use at least {}", across(&vec![1; shape.len()])),
            Self::Length { .. } => "give as many as the shape asks for",
            Self::Vote { .. } => "use weights that are finite and not negative",
            Self::Pyramid => "use the exemplars that were made coarser for it",
            Self::TooManySamples { .. } => "use smaller or fewer pictures",
            Self::Allocation { .. } => "use a smaller size",
            Self::OverCaps { .. } => "make it smaller",
            Self::OverBudget { .. } => "use a smaller output or exemplar, or allow more",
            Self::NoExemplars | Self::NoPlanes { .. } => "give at least one picture",
            Self::NoChannels { .. } => "give planes with at least one channel",
            Self::Shape { .. } => "give planes of one size",
            Self::MaskShape { .. } => "give a mask of the exemplar's size",
            Self::Layout { .. } => "convert one of them",
            Self::NotFinite { .. } => "clean them first",
            Self::EmptyExemplar { .. } => "give a picture with something in it",
            Self::NothingValid => "mask less, or give a picture with something in it",
            Self::Transform { .. } => "use finite angles and scales from 1/16 to 16",
            Self::Weights { .. } => "give one weight for each channel",
            Self::GuideCount { .. } => "give one for each exemplar",
            Self::GuideShape { .. } => "give a map of the exemplar's size",
            Self::GuideTarget { .. } => "give targets of one size",
            Self::GuideWeight { .. } => "use numbers from 0 up, not all of them 0",
            Self::GuideProportion { .. } => "use weights that are closer, or 0",
            Self::UnknownSample { .. } => "give a map that is whole",
            Self::MissingSource { .. } => "give what it was made from",
            Self::StartShape { .. } => "make them the same size",
            Self::NoSource { .. } => "allow at least one everywhere",
            Self::TooManySources { .. } => "use fewer exemplars, orientations or scales",
            Self::Channels { .. } => "give it one",
            Self::ForeignMap { .. } => "give the exemplars and orientations that it was made from",
            Self::PlaneCount { .. } => "give one plane for each exemplar, in order",
            Self::NotBytes { .. } => "take its samples, or convert it",
            Self::NotAnImage { .. } => "convert to 8- or 16-bit grey or RGB, or to float RGB, with or without alpha",
        }
        .to_owned()
    }
}
