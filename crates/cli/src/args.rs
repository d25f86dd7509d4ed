//! What the user can type for every command, and values that several take.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use selvedge_core::{Bytes, Depth, Role};
use selvedge_io::{Format, NonFinite};

use crate::size;
use crate::turns::Seeds;

/// Options of every command.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Options of every command")]
pub(crate) struct Global {
    /// The same seed gives the same picture, on any number of threads. 1..4 or 1,2,3 are as many runs, whose outputs
    /// have '{seed}', or an n in such braces, in their names.
    #[arg(long, global = true, value_name = "N", default_value = "0")]
    pub(crate) seed: Seeds,
    /// Threads to work on; 0 means all cores.
    #[arg(short = 'j', long, global = true, value_name = "N", default_value_t = 0)]
    pub(crate) threads: usize,
    /// Write one JSON object about the run to standard output.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// How to show progress, on standard error.
    #[arg(long, global = true, value_enum, value_name = "HOW", default_value_t = Progress::Auto)]
    pub(crate) progress: Progress,
    /// Say nothing but errors.
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// Say more.
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// Refuse to need more memory than this, such as 2GiB. Default: half of what is available.
    #[arg(long, global = true, value_name = "SIZE", value_parser = size::bytes)]
    pub(crate) max_memory: Option<Bytes>,
    /// Refuse to replace files that exist.
    #[arg(long, global = true)]
    pub(crate) no_clobber: bool,
    /// When interrupted, write what there is to OUT.partial.EXT.
    #[arg(long, global = true)]
    pub(crate) keep_partial: bool,
    /// Check everything and say what would be done; write nothing but the file of --save-config.
    #[arg(long, global = true, alias = "pretend")]
    pub(crate) dry_run: bool,
    /// Refuse to read any file but those with these marks, by name and content: so 'selvedge info' tells the command of
    /// a picture.
    #[arg(long, global = true, value_name = "MARK", value_delimiter = ',', hide = true)]
    pub(crate) expect: Vec<String>,
    /// Take options from a TOML file; what is typed goes before it.
    #[arg(long, global = true, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    pub(crate) config: Option<PathBuf>,
    /// Write the options as used to a file for --config.
    #[arg(long, global = true, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    pub(crate) save_config: Option<PathBuf>,
}

impl Global {
    /// The seed of the run, or of the first one.
    pub(crate) fn seed(&self) -> u64 {
        self.seed.0.first().copied().unwrap_or_default()
    }
}

/// How to show progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Progress {
    /// A bar if standard error is a terminal.
    Auto,
    /// A bar.
    Bar,
    /// One JSON object a line.
    Json,
    /// Nothing.
    None,
}

/// How samples are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DepthArg {
    /// 8-bit integers.
    U8,
    /// 16-bit integers.
    U16,
    /// 16-bit floats.
    Half,
    /// 32-bit floats.
    Float,
}

impl From<DepthArg> for Depth {
    fn from(depth: DepthArg) -> Self {
        match depth {
            DepthArg::U8 => Self::U8,
            DepthArg::U16 => Self::U16,
            DepthArg::Half => Self::F16,
            DepthArg::Float => Self::F32,
        }
    }
}

/// Formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormatArg {
    /// 8 and 16 bits.
    Png,
    /// 8 bits, lossy.
    Jpeg,
    /// 8 and 16 bits, half, float.
    Tiff,
    /// Half and float.
    Exr,
    /// Float, rounded to 8-bit mantissas.
    Hdr,
    /// 8 bits, lossless.
    Webp,
    /// 8 bits, lossless.
    Tga,
}

impl From<FormatArg> for Format {
    fn from(format: FormatArg) -> Self {
        match format {
            FormatArg::Png => Self::Png,
            FormatArg::Jpeg => Self::Jpeg,
            FormatArg::Tiff => Self::Tiff,
            FormatArg::Exr => Self::Exr,
            FormatArg::Hdr => Self::Hdr,
            FormatArg::Webp => Self::Webp,
            FormatArg::Tga => Self::Tga,
        }
    }
}

/// What the channels of a plane mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum RoleArg {
    /// Grey or RGB; integers are sRGB-encoded, floats linear light.
    #[value(aliases = ["colour", "albedo", "basecolor", "diffuse"])]
    Color,
    /// A tangent-space normal: x right, y up.
    #[value(alias = "normal-gl")]
    Normal,
    /// The same with y down, as DirectX has it.
    NormalDx,
    /// A height, or a displacement.
    #[value(alias = "displacement")]
    Height,
    /// Roughness, metalness, occlusion, opacity, labels: anything else.
    #[value(aliases = ["roughness", "metallic", "metalness", "ao", "opacity"])]
    Scalar,
}

impl From<RoleArg> for Role {
    fn from(role: RoleArg) -> Self {
        match role {
            RoleArg::Color => Self::Color,
            RoleArg::Normal => Self::Normal,
            RoleArg::NormalDx => Self::NormalDown,
            RoleArg::Height => Self::Height,
            RoleArg::Scalar => Self::Scalar,
        }
    }
}

/// What becomes of float samples that are infinite or no numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum NonFiniteArg {
    /// The picture is refused.
    #[default]
    Error,
    /// Each becomes 0.
    Zero,
    /// Infinities become the greatest and the least value, what is no number 0.
    Clamp,
}

impl From<NonFiniteArg> for NonFinite {
    fn from(choice: NonFiniteArg) -> Self {
        match choice {
            NonFiniteArg::Error => Self::Error,
            NonFiniteArg::Zero => Self::Zero,
            NonFiniteArg::Clamp => Self::Clamp,
        }
    }
}

/// An option's value by the name that it is typed with.
pub(crate) fn typed_name(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or(String::new(), |v| v.get_name().to_owned())
}
