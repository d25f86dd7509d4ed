//! Picture files to planes and back: every depth kept, outputs whole or not at all, errors in one line.
//!
//! [`read()`] sniffs the format, checks what the header claims against [`Limits`](selvedge_core::Limits), and decodes
//! into a [`Plane`](selvedge_core::Plane) of the file's own depth. [`write()`] follows the name's extension and
//! replaces the file in one step. [`decode`] and [`encode`] do the same with bytes, for streams; [`probe()`] reads
//! headers only.
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
//!
//! # Formats
//! | | reads | writes | carries |
//! |---|---|---|---|
//! | PNG | 1 to 16 bits, palettes, interlaced | u8, u16 | profile, cICP, sRGB, gamma, chromaticities, density |
//! | JPEG | 8 bits, sequential and progressive, any sampling; CMYK turned into RGB | u8 | profile, density |
//! | TIFF | 1 to 16 bits, half, float; strips, tiles, planar, palettes | u8, u16, half, float | profile, chromaticities, density |
//! | EXR | half, float; any layer or channels | half, float | chromaticities, density |
//! | Radiance HDR | float | half, float, rounded to its 8-bit mantissas | |
//! | WebP | 8 bits | u8, lossless | profile |
//! | TGA | 8 bits, palettes | u8 | |
//! | GIF, BMP | first frame | – | – |
//!
//! What is written carries provenance besides.
//!
//! [`read_map`] and [`write_map`] keep source maps, [`read_mask`] reads masks, and [`check_outputs`] tells before a
//! long run whether its outputs could be written.
//!
//! # Damaged files
//! Any file gives a picture or an [`Error`]; third-party decoders that panic are caught, but the panic hook still
//! prints, so a program sets its own. Samples are allocated fallibly after the budget was checked; small buffers inside
//! of decoders are not. Encoders write into memory that may be refused.
#![forbid(unsafe_code)]

mod alpha;
mod atomic;
mod by_format;
pub mod clip;
mod codec;
mod conversion;
mod convert;
mod error;
mod exif;
mod exr;
mod finite;
pub mod flow;
mod format;
mod header;
mod held;
mod identity;
mod image;
mod jpeg;
mod linear;
mod map;
mod mask;
mod metadata;
mod name;
mod options;
mod paths;
mod png;
mod probe;
mod provenance;
mod read;
mod room;
mod samples;
mod sink;
mod tiff;
mod warning;
mod write;

pub use alpha::associate;
pub use atomic::{StagedFile, finish_all, remove_parts, write_bytes};
pub use conversion::Conversion;
pub use convert::convert;
pub use error::{Error, LeftFile, Problem};
pub use format::Format;
pub use identity::{Destination, same_file};
pub use map::{MapFile, decode_map, encode_map, read_map, write_map};
pub use mask::{MaskChannel, mask, read_mask};
pub use metadata::{Density, DensityUnit, Metadata};
pub use name::{breaks_lines, display_name, file_of, one_line, path_text, quoted};
pub use options::{NonFinite, ReadOptions};
pub use paths::{check_output, check_outputs};
pub use probe::{Info, probe, probe_bytes};
pub use provenance::{Fingerprint, Provenance};
pub use read::{Picture, decode, read};
pub use selvedge_core::{Association, Depth, ErrorKind};
pub use warning::Warning;
pub use write::{WriteOptions, changes, encode, write};
