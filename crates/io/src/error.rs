//! What can go wrong with files: one enum of problems, and an error that says which file has one.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use selvedge_core::{Bytes, ErrorKind};

use crate::clip::ClipProblem;
use crate::name::{escaped, quoted};
use crate::{Depth, Format};

mod left;
mod system;
mod words;

pub use self::left::LeftFile;
use self::words::chosen_by;
pub(crate) use self::words::{LostFolder, WriteProtected, subject, verb};

/// A file and what is wrong with it. Shown as one line: `'dir/a.png': 0x7 px has no samples; give a larger picture`.
#[derive(Debug)]
pub struct Error {
    /// The file as the caller named it.
    pub path: PathBuf,
    /// What is wrong.
    pub problem: Problem,
}

impl Error {
    pub(crate) fn new(path: &Path, problem: impl Into<Problem>) -> Self {
        Self { path: path.to_path_buf(), problem: problem.into() }
    }

    /// The same, where some files of a set have their new content all the same.
    pub(crate) fn leaving(self, files: Vec<LeftFile>) -> Self {
        Self { path: self.path, problem: Problem::Left { cause: Box::new(self.problem), files } }
    }

    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        self.problem.kind()
    }

    /// What is wrong, without file and remedy, in one line.
    pub fn message(&self) -> String {
        const SIGNS: usize = 300; // A file may have names without end.
        let line = escaped(self.problem.to_string().as_bytes());
        match line.char_indices().nth(SIGNS) {
            Some((end, _)) => format!("{} ...", &line[..end]),
            None => line,
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> String {
        match &self.problem {
            Problem::NoChannel { .. } => chosen_by(&self.path),
            problem => problem.remedy(),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {}", quoted(&self.path), self.message(), self.remedy())
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        std::error::Error::source(&self.problem)
    }
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// A name whose extension is no format that can be written.
    #[error("'{extension}' is no format that can be written")]
    UnknownFormat {
        /// The extension, without its dot.
        extension: String,
    },
    /// The format has no such depth.
    #[error("{format} cannot hold {} samples", depth.name())]
    DepthNotHeld {
        /// The format.
        format: Format,
        /// The depth asked for.
        depth: Depth,
    },
    /// The format has no such number of channels.
    #[error("{format} cannot hold {channels} channel(s){}", if *alpha { " and alpha" } else { "" })]
    ChannelsNotHeld {
        /// The format.
        format: Format,
        /// Channels without alpha.
        channels: usize,
        /// Whether there is alpha besides.
        alpha: bool,
    },
    /// The format ends at a smaller size.
    #[error("{width}x{height} px is more than the {limit} px a side of {format}")]
    SideNotHeld {
        /// The format.
        format: Format,
        /// Samples along x.
        width: u32,
        /// Samples along y.
        height: u32,
        /// The format's limit.
        limit: u32,
    },
    /// No JPEG quality.
    #[error("quality {quality} is out of range")]
    Quality {
        /// The quality asked for.
        quality: u8,
    },
    /// Nothing in it.
    #[error("empty file")]
    Empty,
    /// The first bytes belong to no format that can be read.
    #[error("is no picture in a format that can be read")]
    UnknownContent,
    /// The first bytes belong to a format that is known and not read.
    #[error("is {0}, which is not read")]
    NotRead(&'static str),
    /// The data contradict themselves or end early.
    #[error("damaged {format} file ({cause})")]
    Damaged {
        /// The format.
        format: Format,
        /// The decoder's words.
        cause: String,
    },
    /// Sound, but beyond what is read.
    #[error("{what} {} not supported in {format}", verb(what))]
    Unsupported {
        /// The format.
        format: Format,
        /// What was found.
        what: String,
    },
    /// A side is 0.
    #[error("{width}x{height} px has no samples")]
    NoSamples {
        /// Samples along x.
        width: u64,
        /// Samples along y.
        height: u64,
    },
    /// A side is over the cap.
    #[error("{width}x{height} px is over the cap of {limit} px a side")]
    Side {
        /// Samples along x.
        width: u64,
        /// Samples along y.
        height: u64,
        /// The cap.
        limit: u32,
    },
    /// All samples together are over the cap.
    #[error("{width}x{height} px = {samples} px is over the cap of {limit} px")]
    Samples {
        /// Samples along x.
        width: u64,
        /// Samples along y.
        height: u64,
        /// Both multiplied.
        samples: u64,
        /// The cap.
        limit: u64,
    },
    /// Values that are no numbers.
    #[error("{count} value(s) are not finite, the first at x={x} y={y} in channel {channel}")]
    NotFinite {
        /// How many.
        count: u64,
        /// Channel of the first one, from 0.
        channel: usize,
        /// Column of the first one, from 0.
        x: u32,
        /// Row of the first one, from 0.
        y: u32,
    },
    /// Colours that were multiplied by an alpha of 0 and are not 0: they cannot be divided by it.
    #[error(
        "{count} sample(s) have light where alpha is 0, the first at x={x} y={y}, which straight alpha cannot hold"
    )]
    LightWithoutAlpha {
        /// How many.
        count: u64,
        /// Column of the first one, from 0.
        x: u32,
        /// Row of the first one, from 0.
        y: u32,
    },
    /// A layer or channel that the file does not have.
    #[error("no {wanted} in it; it holds {found}")]
    NoChannel {
        /// What was asked for.
        wanted: String,
        /// What there is.
        found: String,
    },
    /// An EXR file, or another, that is no source map.
    #[error("is no source map; it holds {found}")]
    NotAMap {
        /// What it is.
        found: String,
    },
    /// A source map where a picture is needed.
    #[error("is a source map, no picture")]
    IsAMap,
    /// A file that is no field of motion.
    #[error("is no flow; it holds {found}")]
    NotFlow {
        /// What it is.
        found: String,
    },
    /// A map names more exemplars than are given with it.
    #[error("the map names exemplar number {needed}, but {found} are given")]
    ExemplarCount {
        /// Exemplars given.
        found: usize,
        /// Exemplars needed.
        needed: usize,
    },
    /// There is no such file or folder.
    #[error("not found")]
    Missing,
    /// A file stands where the folder of a file should be.
    #[error("its folder is a file")]
    NoFolder,
    /// The folder of a file is a link to nothing.
    #[error("its folder is a link that leads nowhere")]
    LostFolder,
    /// The system refuses access.
    #[error("permission denied")]
    Denied,
    /// The file system can only be read.
    #[error("its file system is read-only")]
    ReadOnly,
    /// A file that nobody may write.
    #[error("is write-protected")]
    WriteProtected,
    /// A folder where a file is needed.
    #[error("is a folder")]
    Folder,
    /// A device, pipe or socket where a file is needed.
    #[error("is no regular file")]
    Special,
    /// It exists, and must not be replaced.
    #[error("exists already")]
    Exists,
    /// The output is one of the inputs.
    #[error("is the same file as the input {}", quoted(input))]
    IsInput {
        /// The input.
        input: PathBuf,
    },
    /// Any other refusal of the file system.
    #[error("{0}")]
    FileSystem(io::Error),
    /// The disk, the quota or the file-size limit is full.
    #[error("no space for {bytes} bytes")]
    NoSpace {
        /// The file's size.
        bytes: u64,
    },
    /// A set of files could not be written, and of some the old content, or none, could not be put back.
    #[error("{cause}; {} could not be put back as before", files.iter().map(LeftFile::shown).collect::<Vec<_>>().join(", "))]
    Left {
        /// Why the set could not be written.
        cause: Box<Problem>,
        /// Those that have their new content.
        files: Vec<LeftFile>,
    },
    /// More memory than allowed.
    #[error("needs about {needed} of memory, and {budget} are allowed")]
    Memory {
        /// An upper bound of what is needed.
        needed: Bytes,
        /// The budget.
        budget: Bytes,
    },
    /// An error of the samples themselves.
    #[error(transparent)]
    Core(#[from] selvedge_core::Error),
    /// What is wrong with a clip that is wrong with no picture.
    #[error(transparent)]
    Clip(#[from] ClipProblem),
    /// An encoder failed on valid samples.
    #[error("the {format} encoder failed ({cause})")]
    Encoder {
        /// The format.
        format: Format,
        /// The encoder's words.
        cause: String,
    },
}

impl Problem {
    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            // What the format cannot hold depends on the picture: the option was fine by itself.
            Self::UnknownFormat { .. } | Self::Quality { .. } => ErrorKind::Option,
            Self::Missing
            | Self::NoFolder
            | Self::LostFolder
            | Self::Denied
            | Self::ReadOnly
            | Self::WriteProtected
            | Self::Folder
            | Self::Special
            | Self::Exists
            | Self::IsInput { .. }
            | Self::FileSystem(_) => ErrorKind::FileSystem,
            Self::NoSpace { .. } => ErrorKind::NoSpace,
            Self::Left { cause, .. } => cause.kind(),
            Self::Memory { .. } => ErrorKind::Memory,
            Self::Encoder { .. } => ErrorKind::Internal,
            Self::Core(e) => e.kind(),
            Self::Clip(e) => e.kind(),
            _ => ErrorKind::Input,
        }
    }

    /// What to do about it, in terms of the data: options have other names in every program.
    pub fn remedy(&self) -> String {
        let fixed = match self {
            Self::UnknownFormat { .. } => return format!("write one of {}", Format::written()),
            Self::DepthNotHeld { format, depth } => {
                let depths: Vec<&str> = format.depths().iter().map(|d| d.name()).collect();
                return format!("convert it to {}, or write {}", depths.join(" or "), Format::holding(*depth));
            }
            Self::UnknownContent => return format!("give one of {}", Format::read()),
            Self::ChannelsNotHeld { format, channels: 1 | 3, alpha: true } => {
                return format!("write {}", format.instead(|other| other.holds_alpha()));
            }
            Self::ChannelsNotHeld { .. } => "write one or three channels, or exr",
            Self::SideNotHeld { format, width, height, .. } => {
                let (side, depth) = ((*width).max(*height), format.depths()[0]);
                return format!("write {}", format.instead(|other| other.check([1, side], 3, false, depth).is_ok()));
            }
            Self::NotFlow { .. } => "give a .flo file, a 16-bit PNG as KITTI has it, or two channels of an EXR file",
            Self::Empty | Self::Damaged { .. } => "write or copy the file again",
            Self::NotRead(_) | Self::Unsupported { .. } => "convert it to png, tiff or exr first",
            Self::NoSamples { .. } => "give a picture with samples",
            Self::Side { .. } | Self::Samples { .. } => "give a smaller picture",
            Self::NotFinite { .. } => "make them finite, or choose what becomes of them",
            Self::LightWithoutAlpha { .. } => {
                "write exr, or read the colours alone, by their names after the file's name: [R,G,B], [Y], or [1,2,3] of a TIFF"
            }
            Self::NoChannel { .. } => "choose with 'file.exr[layer]', 'file.exr[R,G,B]' or 'file.tif[4]'",
            Self::NotAMap { .. } => "give a file that was written as a map",
            Self::IsAMap => "give a picture, or apply the map to one",
            Self::ExemplarCount { .. } => "name every exemplar, in order",
            Self::Missing => "check the name",
            Self::NoFolder | Self::LostFolder => "name another folder",
            Self::Denied => "check the permissions",
            Self::ReadOnly => "write elsewhere",
            Self::WriteProtected => "make it writable, or choose another name",
            Self::Folder => "name a file in it",
            Self::Special => "give a regular file",
            Self::Exists | Self::IsInput { .. } => "choose another name",
            Self::FileSystem(_) => "check the path and the disk",
            Self::NoSpace { .. } => "free some, or write elsewhere",
            Self::Left { cause, .. } => return cause.remedy(),
            Self::Memory { .. } => "give a smaller picture, or allow more",
            Self::Core(e) => return e.remedy(),
            Self::Clip(e) => return e.remedy(),
            Self::Quality { .. } => "use 1 to 100",
            Self::Encoder { .. } => "please report it",
        };
        fixed.to_owned()
    }
}

#[cfg(test)]
mod tests;
