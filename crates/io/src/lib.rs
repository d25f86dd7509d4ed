//! Picture files to planes and back: every depth kept, outputs whole or not at all, errors in one line.
//!
//! [`read()`] sniffs the format, checks what the header claims against [`Limits`](selvedge_core::Limits), and decodes into
//! a [`Plane`](selvedge_core::Plane) of the file's own depth. [`write()`] follows the name's extension and replaces the
//! file in one step. [`decode`] and [`encode`] do the same with bytes, for streams.
//!
//! ```
//! use selvedge_core::{Domain, Grid, Plane, Role, Samples};
//! use selvedge_io::{Metadata, ReadOptions, WriteOptions, decode, encode};
//!
//! let grey = Grid::from_vec(Domain::open([1, 3]), 1, vec![10_u16, 20, 65_535]).unwrap();
//! let plane = Plane::new(Role::Color, Samples::U16(grey));
//! let bytes = encode(&plane, &Metadata::default(), "grey.png", &WriteOptions::default())?;
//! assert_eq!(decode(&bytes, "grey.png", &ReadOptions::default())?.plane, plane);
//!
//! let cut = decode(&bytes[..50], "cut.png", &ReadOptions::default()).unwrap_err();
//! assert_eq!(cut.to_string(), "'cut.png': damaged png file (it ends early); write or copy the file again");
//! # Ok::<(), selvedge_io::Error>(())
//! ```
#![forbid(unsafe_code)]

mod atomic;
mod error;
mod format;
mod header;
mod metadata;
mod name;
mod png;
mod read;
mod samples;
mod warning;
mod write;

pub use atomic::write_bytes;
pub use error::{Error, ErrorKind, Problem};
pub use format::Format;
pub use metadata::{Density, DensityUnit, Metadata};
pub use name::{display_name, quoted};
pub use read::{Picture, ReadOptions, decode, read};
pub use selvedge_core::Depth;
pub use warning::Warning;
pub use write::{WriteOptions, encode, write};
