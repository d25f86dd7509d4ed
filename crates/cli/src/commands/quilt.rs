//! `selvedge quilt`: image quilting. `[Efros01 2]`

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use selvedge_core::{Exemplars, Plane, Render};
use selvedge_quilting::{Continuation, Error, Options, Stage, quilt};
use serde_json::json;

use crate::args::Synthesis;
use crate::commands::Session;
use crate::failure::Failure;
use crate::files::{self, Input};
use crate::report::Report;
use crate::size::Tile;

/// Options of `quilt`.
#[derive(Args, Debug)]
pub(crate) struct Quilt {
    /// Pictures of the texture.
    #[arg(required = true, value_name = "EXEMPLAR")]
    exemplars: Vec<PathBuf>,
    #[command(flatten)]
    synthesis: Synthesis,
    /// Side of the blocks in pixels, or auto; it should hold the largest structure of the texture.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = auto_or_number)]
    block: Auto,
    /// Width of the overlap of blocks in pixels, or auto: a sixth of the block.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = auto_or_number)]
    overlap: Auto,
    /// Draw among blocks whose overlap error is up to this fraction above the least.
    #[arg(long, value_name = "T", default_value_t = 0.1)]
    tolerance: f64,
    /// How far to go: random blocks, agreeing blocks, or agreeing blocks with cut edges.
    #[arg(long, value_enum, default_value_t = StageArg::Cut)]
    stage: StageArg,
    /// Whether blocks may continue their neighbours verbatim.
    #[arg(long, value_enum, default_value_t = ContinuationArg::Avoid)]
    continuation: ContinuationArg,
}

/// A number, or a choice by the program.
#[derive(Clone, Copy, Debug)]
struct Auto(Option<u32>);

fn auto_or_number(text: &str) -> Result<Auto, String> {
    match text {
        "auto" => Ok(Auto(None)),
        _ => text.parse().map(|n| Auto(Some(n))).map_err(|_| "write a number of pixels, or auto".into()),
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum StageArg {
    /// Random blocks, tiled without overlap.
    Random,
    /// Overlapping blocks that agree with their neighbours.
    Overlap,
    /// The same with a minimum error boundary cut.
    Cut,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ContinuationArg {
    /// Not if there is any other.
    Avoid,
    /// As the paper has it.
    Allow,
}

impl Quilt {
    fn options(&self) -> Options {
        Options {
            block: self.block.0,
            overlap: self.overlap.0,
            tolerance: self.tolerance,
            stage: match self.stage {
                StageArg::Random => Stage::Random,
                StageArg::Overlap => Stage::Overlap,
                StageArg::Cut => Stage::Cut,
            },
            continuation: match self.continuation {
                ContinuationArg::Avoid => Continuation::Avoid,
                ContinuationArg::Allow => Continuation::Allow,
            },
        }
    }

    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<u8, Failure> {
        let mut report = Report::new("quilt");
        let options = self.options();
        options.validate()?;
        let output = self.synthesis.output.as_path();
        files::check_output(session, output, &self.exemplars.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
        let inputs = files::read_all(session, &self.exemplars, &mut report)?;
        let planes: Vec<&[Plane<2>]> = inputs.iter().map(|i| std::slice::from_ref(&i.picture.plane)).collect();
        let exemplars = Exemplars::of(&planes).map_err(|e| about(&inputs, Failure::from(e)))?;
        let domain = Tile::domain(self.synthesis.tile, self.synthesis.size.shape(planes[0][0].domain().shape));
        files::check_size(session, domain)?;
        report.stage("read");

        let woven = quilt(&exemplars, domain, &options, &session.run()).map_err(|e| failure(&inputs, e))?;
        session.check_complete(woven.complete)?;
        report.stage("synthesis");

        let payload: Vec<&Plane<2>> = planes.iter().map(|p| &p[0]).collect();
        let plane = woven.result.render(&payload)?;
        report.stage("render");
        if !session.global.dry_run {
            files::write(session, output, &plane, &inputs[0].picture.metadata, &mut report)?;
        }
        report.stage("write");

        let [h, w] = domain.shape;
        let stats = woven.stats;
        report.options = json!({
            "size": format!("{w}x{h}"),
            "tile": self.synthesis.tile.map(|t| format!("{t:?}").to_lowercase()),
            "block": stats.block,
            "overlap": stats.overlap,
            "tolerance": options.tolerance,
            "stage": format!("{:?}", options.stage).to_lowercase(),
            "continuation": format!("{:?}", options.continuation).to_lowercase(),
        });
        report.stats = json!({
            "blocks": stats.blocks,
            "candidates": stats.candidates,
            "overlap_error": stats.overlap_error,
            "cut_error": stats.cut_error,
        });
        let line = line(output, [w, h], &stats, report.elapsed());
        session.finish(&mut report, &line);
        Ok(0)
    }
}

fn line(output: &Path, [w, h]: [u32; 2], stats: &selvedge_quilting::Stats, seconds: f64) -> String {
    let name = crate::failure::shown(output);
    let (block, overlap, blocks) = (stats.block, stats.overlap, stats.blocks);
    format!("{name}: {w}x{h} px from {blocks} blocks of {block} px, overlap {overlap} px, in {seconds:.2} s")
}

/// Errors about exemplars name the file.
fn failure(inputs: &[Input], error: Error) -> Failure {
    let from_exemplar = matches!(error, Error::BlockExceedsExemplar { .. } | Error::Masked { .. });
    let failure = Failure::from(error);
    if from_exemplar { about(inputs, failure) } else { failure }
}

fn about(inputs: &[Input], failure: Failure) -> Failure {
    match inputs {
        [only] => failure.about(&only.path),
        _ => failure,
    }
}
