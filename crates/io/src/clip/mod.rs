//! Clips in files: frames of one header, read and written one after the other.
//!
//! [`ClipReader::open`] looks at a clip (a numbered sequence, a folder, a container), and hands its frames over one by
//! one; [`ClipWriter`] takes them and makes the files. Memory is that of one frame, and of what a container's decoder
//! holds. Every frame passes what a picture passes: caps, fallible allocation, finite samples. GIF and APNG grow in
//! memory until they are finished. [`read_clip`] stacks a whole clip,
//! [`frame_of`] takes one frame out of it.
//!
//! # Names
//! | name | clip |
//! |---|---|
//! | `name.####.exr`, `name.%04d.png` | the files with a number there, of at least so many digits |
//! | a folder | all pictures in it, in natural order |
//! | `name*.png` with `*` or `?` | the files that match, in natural order |
//! | any picture, with [`ClipOptions::flipbook`] | its cells, row by row |
//! | an animated PNG, GIF or WebP, a y4m file | its frames |
//! | mp4, mov, webm, mkv, avi | its frames without sound, by an `ffmpeg` that is installed |
//!
//! Numbers go up by one, or by the step of a [`Range`]: a frame that is missing, or is of another size, depth or
//! layout, is an error that names it.

mod animation;
mod apng;
mod container;
mod ffmpeg;
mod flipbook;
mod gif;
mod info;
mod manifest;
mod names;
mod order;
mod problem;
mod range;
mod rate;
mod reader;
mod sequence;
mod stack;
mod still;
mod writer;
mod y4m;
mod yuv;

pub use container::Container;
pub use ffmpeg::end_children;
pub use flipbook::Flipbook;
pub use info::ClipInfo;
pub use manifest::Manifest;
pub use names::{ClipName, clip_files};
pub use problem::ClipProblem;
pub use range::Range;
pub use rate::Rate;
pub use reader::{ClipOptions, ClipReader};
pub use stack::{frame_of, read_clip};
pub use writer::{ClipFile, ClipWriteOptions, ClipWriter};
