//! JPEG of 8 bits: sequential and progressive, with any sampling factors, in scans of one component or several.
//!
//! Read by ourselves: of the decoders that there are, none gives the values of libjpeg over all sampling factors and
//! scans. Over 929 files of the factors 1 to 4, `zune-jpeg` 0.5.15 gave them for 127 and other pictures, without a
//! word, for 295; `jpeg-decoder` 0.3.2 gave them for 757 and other pictures for 103. Arithmetic coding, 12 bits and
//! lossless processes are refused by name.
//!
//! Sections in brackets are those of the standard, ITU-T T.81.

mod components;
mod entropy;
mod frame;
mod idct;
mod markers;
mod picture;
mod read;
mod scan;
mod write;

pub(crate) use read::{decode, describe};
pub(crate) use write::encode;

use crate::Format;
use crate::error::Problem;

fn damaged(cause: &str) -> Problem {
    Problem::damaged(Format::Jpeg, cause)
}

fn unsupported(what: &str) -> Problem {
    Problem::unsupported(Format::Jpeg, what)
}
