//! What is odd about a file that could be read all the same.

use crate::Format;

/// What is odd about a file that could be read all the same; shown as one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// The extension names another format than the content is.
    #[error("the name says {named}, but the content is {content}")]
    Misnamed {
        /// The format by content, which was read.
        content: Format,
        /// The format by name.
        named: Format,
    },
    /// An animation, of which one frame was read.
    #[error("only the first frame of the animation is used")]
    FirstFrameOnly,
}
