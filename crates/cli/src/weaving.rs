//! The options of every command that weaves a picture from exemplars, and the names of what it writes.

use std::path::PathBuf;

use clap::{Arg, Args, ValueHint};
use selvedge_core::{Domain, Role};
use selvedge_io::ReadOptions;

use crate::exemplars::ExemplarArgs;
use crate::inputs;
use crate::options::Encoding;
use crate::session::Session;
use crate::size::{Size, Tile};
use crate::stdio::STREAM;
use crate::with::With;
use crate::{names, outputs, page};

/// Brings options that other commands have, too, under the heading of this one's. A heading of the group would be that
/// of all that comes after it as well.
fn written(arg: Arg) -> Arg {
    let is_written = ["format", "quality"].contains(&arg.get_id().as_str());
    if is_written { arg.help_heading("Files that are written") } else { arg }
}

/// Options of the commands that weave a picture of a chosen size.
#[derive(Args, Clone, Debug)]
#[command(mut_args(written))]
pub(crate) struct Weaving {
    #[command(flatten)]
    pub(crate) input: ExemplarArgs,
    #[command(flatten)]
    pub(crate) with: With,
    /// The picture to write, '-' for standard output; the format follows the extension.
    #[arg(help_heading = "Files that are written", short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) encoding: Encoding,
    /// Make the output tile without a seam along x, y or both; a size that is not in pixels follows the lattice.
    #[arg(long, value_enum, value_name = "AXES")]
    pub(crate) tile: Option<Tile>,
    /// Write the source map: which exemplar sample stands at each place. See 'selvedge apply'.
    #[arg(help_heading = "Files that are written", long, value_name = "FILE.exr", value_hint = ValueHint::FilePath)]
    pub(crate) map: Option<PathBuf>,
    /// Write a picture of the seams and of where each part came from, for eyes.
    #[arg(help_heading = "Files that are written", long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    pub(crate) explain: Option<PathBuf>,
    /// Write two by two copies of an output that tiles beside each other, 8 bits, for eyes.
    #[arg(help_heading = "Files that are written", long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    pub(crate) preview: Option<PathBuf>,
    /// Write the outputs of several runs into one picture, each above its seed, or above its number if it is one of
    /// --each.
    #[arg(help_heading = "Files that are written", long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    pub(crate) sheet: Option<PathBuf>,
    /// Weave from each exemplar alone, one after the other; '{stem}', '{name}' or an n in such braces in names tell
    /// their outputs apart.
    #[arg(long)]
    pub(crate) each: bool,
    /// Write a page about the run with its pictures inside: DIR/index.html. That of graphcut also shows what seams cost
    /// after refinements that changed something, evenly thinned to at most 25 pictures, and those of numbers, analogy,
    /// detail and transfer --method cms what they were like meanwhile; that of optimize its energy, what levels end
    /// with, and distances.
    #[arg(help_heading = "Files that are written", long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) report: Option<PathBuf>,
}

/// The size of an output that may have any.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Sizing {
    /// Size of the output: 512, 512x384, or a factor of the first exemplar such as 2x. Default: 2x, or the size of what
    /// the output starts from.
    #[arg(long, value_name = "SIZE")]
    size: Option<Size>,
}

impl Sizing {
    /// Height and width for a first exemplar of this shape.
    pub(crate) fn shape(self, exemplar: [u32; 2]) -> [u32; 2] {
        self.typed(exemplar).unwrap_or_else(|| Size::Factor(2.0).shape(exemplar))
    }

    /// True if none was asked for.
    pub(crate) fn is_open(self) -> bool {
        self.size.is_none()
    }

    /// True if the first exemplar decides.
    pub(crate) fn is_multiple(self) -> bool {
        !matches!(self.size, Some(Size::Pixels(..)))
    }

    /// The same, if it was asked for.
    pub(crate) fn typed(self, exemplar: [u32; 2]) -> Option<[u32; 2]> {
        Some(self.size?.shape(exemplar))
    }
}

/// Files that a run writes, by the names that they get.
#[derive(Clone, Debug)]
pub(crate) struct Written {
    pub(crate) output: PathBuf,
    pub(crate) map: Option<PathBuf>,
    pub(crate) explain: Option<PathBuf>,
    pub(crate) preview: Option<PathBuf>,
    pub(crate) report: Option<PathBuf>,
}

impl Weaving {
    /// The names of what is written: those of the first exemplar are filled in.
    pub(crate) fn written(&self) -> Written {
        let named = |path: &PathBuf| names::of_plane(path, &self.input.exemplars[0]);
        let maybe = |path: &Option<PathBuf>| path.as_ref().map(named);
        Written {
            output: named(&self.output),
            map: maybe(&self.map),
            explain: maybe(&self.explain),
            preview: maybe(&self.preview),
            report: maybe(&self.report),
        }
    }

    /// An output of a shape, with the topology asked for.
    pub(crate) fn tiled(&self, shape: [u32; 2]) -> Domain<2> {
        Tile::domain(self.tile, shape)
    }

    /// How pictures are read.
    pub(crate) fn read_options(&self, session: &Session<'_>) -> ReadOptions {
        inputs::options(session.limits, Role::Color, self.input.nonfinite)
    }

    /// All files that a run may write, were it interrupted.
    pub(crate) fn files_written(&self, session: &Session<'_>, written: &Written, exemplars: usize) -> Vec<PathBuf> {
        let layers = self.with.with.chunks(exemplars).map(|planes| names::of_plane(&self.output, &planes[0]));
        let made: Vec<PathBuf> =
            std::iter::once(written.output.clone()).chain(layers).chain(written.map.clone()).collect();
        let keeps = session.global.keep_partial && self.output.as_os_str() != STREAM;
        let partial: Vec<PathBuf> = made.iter().filter(|_| keeps).map(|path| outputs::partial(path)).collect();
        let page = written.report.as_deref().map(page::checked);
        made.into_iter()
            .chain(written.explain.clone())
            .chain(written.preview.clone())
            .chain(partial)
            .chain(page)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Command;

    #[test]
    fn options_of_what_is_made_stand_apart_from_files_that_are_written() {
        let command = Sizing::augment_args(Weaving::augment_args(Command::new("")));
        let heading = |long: &str| {
            let found = command.get_arguments().find(|arg| arg.get_long() == Some(long));
            found.unwrap_or_else(|| panic!("no --{long}")).get_help_heading()
        };
        let written = ["output", "format", "quality", "map", "explain", "preview", "sheet", "report"];
        assert_eq!(written.map(heading), [Some("Files that are written"); 8]);
        assert_eq!(["mask", "depth", "exposure", "tile", "each", "size"].map(heading), [None; 6]);
    }
}
