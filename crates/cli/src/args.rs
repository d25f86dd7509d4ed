//! What the user can type.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::commands;
use crate::size::{Bytes, Size, Tile};

/// Synthesises textures, materials and moving textures from examples.
#[derive(Debug, Parser)]
#[command(name = "selvedge", version, max_term_width = 100, arg_required_else_help = true)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Options of every command.
    #[command(flatten)]
    pub(crate) global: Global,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Image quilting: a larger texture from overlapping blocks of exemplars.
    Quilt(commands::quilt::Quilt),
    /// Graphcut textures: a larger texture from patches cut along the best seams.
    Graphcut(commands::graphcut::Graphcut),
}

/// Options of every command.
#[derive(Args, Clone, Debug)]
pub(crate) struct Global {
    /// The same seed gives the same picture, on any number of threads.
    #[arg(long, global = true, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Threads to work on; 0 means all cores.
    #[arg(short = 'j', long, global = true, value_name = "N", default_value_t = 0)]
    pub(crate) threads: usize,
    /// Write one JSON object about the run to standard output.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// How to show progress, on standard error.
    #[arg(long, global = true, value_enum, default_value_t = Progress::Auto)]
    pub(crate) progress: Progress,
    /// Say nothing but errors.
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// Say more.
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// Refuse to need more memory than this, such as 2GiB. Default: half of what is available.
    #[arg(long, global = true, value_name = "SIZE")]
    pub(crate) max_memory: Option<Bytes>,
    /// Refuse to replace files that exist.
    #[arg(long, global = true)]
    pub(crate) no_clobber: bool,
    /// Check everything and say what would be done; write nothing.
    #[arg(long, global = true)]
    pub(crate) dry_run: bool,
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

/// Options of the commands that make a picture of a chosen size.
#[derive(Args, Clone, Debug)]
pub(crate) struct Synthesis {
    /// The picture to write; the format follows the extension.
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Size of the output: 512, 512x384, or a factor of the first exemplar such as 2x.
    #[arg(long, value_name = "SIZE", default_value = "2x")]
    pub(crate) size: Size,
    /// Make the output tile without a seam along x, y or both.
    #[arg(long, value_enum, value_name = "AXES")]
    pub(crate) tile: Option<Tile>,
}
