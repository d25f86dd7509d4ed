//! The program's command line as a whole: the one place that knows every command.

use std::ffi::OsString;

use clap::{Arg, CommandFactory, Parser, Subcommand};

use crate::args::Global;
use crate::commands;
use crate::failure::Failure;
use crate::method::Method as _;
use crate::paper;
use crate::report::Done;
use crate::session::Session;

/// Synthesises textures, materials and moving textures from examples.
#[derive(Debug, Parser)]
#[command(name = "selvedge", version, max_term_width = 100, subcommand_required = true, arg_required_else_help = true)]
#[command(after_help = PROGRAM)]
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
    /// A larger texture without knobs: it is made in several ways, and the best is kept.
    #[command(visible_alias = "synth", after_help = SYNTHESIZE)]
    Synthesize(commands::synthesize::Synthesize),
    /// Image quilting: a larger texture from overlapping blocks of exemplars.
    #[command(after_help = QUILT)]
    Quilt(commands::quilt::Quilt),
    /// Texture transfer: a picture drawn in the texture of exemplars.
    #[command(after_help = TRANSFER)]
    Transfer(commands::transfer::Transfer),
    /// Graphcut textures: a larger texture from patches cut along the best seams.
    #[command(after_help = GRAPHCUT)]
    Graphcut(commands::graphcut::Graphcut),
    /// Merge pictures along the seams that show least.
    #[command(after_help = MERGE)]
    Merge(commands::merge::Merge),
    /// Fill holes of a picture from the picture itself.
    #[command(after_help = FILL)]
    Fill(commands::fill::Fill),
    /// Make a picture larger: what it shows goes on around it.
    #[command(after_help = EXTEND)]
    Extend(commands::extend::Extend),
    /// Make a picture tile: closed over itself along the least seam, or with its border filled anew.
    #[command(after_help = TILE)]
    Tile(commands::tile::TileCommand),
    /// Texture by numbers: a picture of several textures, arranged like a map of labels.
    #[command(after_help = NUMBERS)]
    Numbers(commands::analogies::numbers::Numbers),
    /// Image analogies: what makes A' of A is done to B.
    #[command(after_help = ANALOGY)]
    Analogy(commands::analogies::analogy::Analogy),
    /// Detail synthesis: a picture of low resolution, enlarged with the detail of exemplars.
    #[command(after_help = DETAIL)]
    Detail(commands::analogies::detail::Detail),
    /// Hybrid synthesis: blocks that split where they do not fit, down to pixels.
    #[command(after_help = HYBRID)]
    Hybrid(commands::hybrid::Hybrid),
    /// Texture optimization: a whole texture at once, until each part of it is like a part of the exemplars.
    #[command(after_help = OPTIMIZE)]
    Optimize(commands::optimize::Optimize),
    /// A texture that flows along a field, frame after frame, and stays a texture.
    #[command(after_help = ANIMATE)]
    Animate(commands::animate::Animate),
    /// Video textures: a clip that loops without a visible end, over a seam in space and time.
    #[command(after_help = VIDEO)]
    Video(commands::video::Video),
    /// Apply a source map to other planes of the same exemplars, such as the maps of a material.
    #[command(after_help = APPLY)]
    Apply(commands::apply::Apply),
    /// Run the command that a picture carries once more, over the same files.
    #[command(after_help = AGAIN)]
    Again(commands::again::Again),
    /// Tell what is in a picture or a source map, and how it was made.
    #[command(after_help = INFO)]
    Info(commands::info::Info),
    /// Look at an exemplar: its size, the kind of texture, its lattice, and a command line to begin with.
    #[command(after_help = INSPECT)]
    Inspect(commands::inspect::Inspect),
    /// Compare two pictures; exit code 1 if they differ by more than is allowed.
    #[command(after_help = COMPARE)]
    Compare(commands::compare::Compare),
    /// Say what outputs are worth beside their exemplars, and rank them.
    #[command(after_help = SCORE)]
    Score(commands::score::Score),
    /// Random labels: what a new method's command is like, for the tests.
    #[cfg(test)]
    #[command(hide = true)]
    RandomLabels(commands::random_labels::RandomLabels),
    /// Write a script that completes command lines in a shell.
    #[command(after_help = COMPLETIONS)]
    Completions(commands::completions::Completions),
    /// Write manual pages.
    #[command(after_help = MAN)]
    Man(commands::man::Man),
}

impl Command {
    /// Runs the command; `run` runs other words.
    pub(crate) fn execute(
        &self,
        session: &Session<'_>,
        run: &dyn Fn(&[OsString]) -> Result<Done, Failure>,
    ) -> Result<Done, Failure> {
        match self {
            Self::Synthesize(synthesize) => synthesize.run(session),
            Self::Quilt(quilt) => quilt.run(session),
            Self::Transfer(transfer) => transfer.run(session),
            Self::Graphcut(graphcut) => graphcut.run(session),
            Self::Merge(merge) => merge.run(session),
            Self::Fill(fill) => fill.run(session),
            Self::Extend(extend) => extend.run(session),
            Self::Tile(tile) => tile.run(session),
            Self::Numbers(numbers) => numbers.run(session),
            Self::Analogy(analogy) => analogy.run(session),
            Self::Detail(detail) => detail.run(session),
            Self::Hybrid(hybrid) => hybrid.run(session),
            Self::Optimize(optimize) => optimize.run(session),
            Self::Animate(animate) => animate.run(session),
            Self::Video(video) => video.run(session),
            Self::Apply(apply) => apply.run(session),
            Self::Again(again) => again.run(session, &program(), run),
            Self::Info(info) => info.run(session),
            Self::Inspect(inspect) => inspect.run(session),
            Self::Compare(compare) => compare.run(session),
            Self::Score(score) => score.run(session),
            #[cfg(test)]
            Self::RandomLabels(labels) => labels.run(session),
            Self::Completions(completions) => completions.run(session, program()),
            Self::Man(man) => man.run(session, program()),
        }
    }
}

/// Options of every command that do nothing for a command: not listed for it, and told where they are typed.
pub(crate) fn idle(command: &clap::Command) -> Vec<&'static str> {
    let (weaves, command) = (weaves(command), command.get_name());
    const ALL: [(&str, &[&str]); 6] = [
        ("threads", &["info", "completions", "man"]),
        ("max_memory", &["completions", "man"]),
        ("no_clobber", &["info", "inspect", "score", "completions"]),
        ("dry_run", &["info", "inspect", "score", "completions"]),
        ("config", &["completions", "man"]),
        ("save_config", &["completions", "man"]),
    ];
    let draws = weaves || ["animate", "video"].contains(&command);
    let seed = (!draws).then_some("seed");
    let keep_partial = (!draws && command != "again").then_some("keep_partial");
    let named = ALL.iter().filter(|(_, commands)| commands.contains(&command)).map(|(option, _)| *option);
    seed.into_iter().chain(keep_partial).chain(named).collect()
}

/// The program's commands, each with the options that act on it.
pub(crate) fn program() -> clap::Command {
    let all = Cli::command();
    let options: Vec<Arg> = all.get_arguments().filter(|arg| arg.is_global_set()).cloned().collect();
    let commands: Vec<_> = all.get_subcommands().map(|c| (c.get_name().to_owned(), idle(c))).collect();
    // An option that a command has already is not handed down to it.
    let hidden = |idle: Vec<&str>| {
        let of_command = options.iter().filter(move |arg| idle.contains(&arg.get_id().as_str()));
        of_command.map(|arg| arg.clone().hide(true)).collect::<Vec<_>>()
    };
    commands
        .into_iter()
        .fold(all, |all, (name, idle)| all.mut_subcommand(&name, |c| paper::spelt_out(c).args(hidden(idle))))
}

/// Whether a command weaves pictures.
fn weaves(command: &clap::Command) -> bool {
    command.get_arguments().any(|arg| arg.get_id() == "each")
}

const PROGRAM: &str = "\
Examples:
  selvedge synthesize bricks.png -o wall.png --size 1024
  selvedge graphcut albedo.png -o 'wall-{name}' --size 2x --tile xy --with normal.png height.png
  selvedge fill photo.png --mask hole.png -o whole.png
  selvedge again wall.png -o wall-again.png
  selvedge help graphcut";
const QUILT: &str = "\
Examples:
  selvedge quilt bricks.png -o wall.png --size 1024
  selvedge quilt moss.png -o tile.png --tile xy --map tile-map.exr
  selvedge quilt a.png b.png --mask none --mask b-mask.png -o both.png";
const TRANSFER: &str = "\
Examples:
  selvedge transfer rice.png --target face.png -o face-of-rice.png
  selvedge transfer oil.png --target photo.jpg --match-histogram -o painted.png
  selvedge transfer map.png --guide labels.png plan.png -o drawn.png";
const GRAPHCUT: &str = "\
Examples:
  selvedge graphcut bricks.png -o wall.png --size 1024
  selvedge graphcut grass.png -o meadow.png --scale-field top=0.5,bottom=1.5
  selvedge graphcut photo.png --over photo.png --fixed keep.png -o mended.png";
const MERGE: &str = "\
Examples:
  selvedge merge left.png right.png --at 220,0 -o both.png --fuse
  selvedge merge river.png raft.png --strokes paint.png --color '#ffff00=2' -o out.png
  selvedge merge 1.png 2.png 3.png --prefer median -o empty-square.png";
const FILL: &str = "\
Examples:
  selvedge fill photo.png --mask hole.png -o whole.png
  selvedge fill cut-out.png -o whole.png
  selvedge fill wall.png --mask hole.png --from other-wall.png --source-mask none -o whole.png";
const EXTEND: &str = "\
Examples:
  selvedge extend wall.png --size 1.5x -o wider.png
  selvedge extend portrait.jpg --size 1920x1080 --anchor S -o wide.png";
const TILE: &str = "\
Examples:
  selvedge tile photo.jpg -o tile.png
  selvedge tile gravel.png -o tile.png --method band --band 64
  selvedge tile wood.png -o tile.png --tile x --overlap 96";
const NUMBERS: &str = "\
Examples:
  selvedge numbers shore.png --labels shore-labels.png --target plan.png -o new-shore.png";
const ANALOGY: &str = "\
Examples:
  selvedge analogy photo.png painting.png other-photo.png -o other-painting.png
  selvedge analogy flat.png style.png render.png --guide style-light.png light.png --weight 0.5 -o styled.png";
const DETAIL: &str = "\
Examples:
  selvedge detail brick-close.png --low wall.png --scale 8 -o wall-8x.png
  selvedge detail brick.png --low wall.png --scale 8 --guide brick-grout.png lines.png -o wall-8x.png";
const HYBRID: &str = "\
Examples:
  selvedge hybrid scales.png -o skin.png --size 512
  selvedge hybrid stones.png -o wall.png --block 64 -k 0 --max-error 0.03";
const OPTIMIZE: &str = "\
Examples:
  selvedge optimize gravel.png -o path.png --size 512
  selvedge optimize bricks.png -o wall.png --start wall-map.exr
  selvedge optimize moss.png -o tile.png --tile xy --init random";
const ANIMATE: &str = "\
Examples:
  selvedge animate keys.png --flow vortex -o 'turning.####.png' --size 256
  selvedge animate water.png --flow 'wind.####.flo' -o water.gif --rate 25
  selvedge animate fire.png --flow uniform --angle -90 --speed 2 --tile xy -o 'fire.####.png'";
const VIDEO: &str = "\
Clips are numbered files ('fire.####.exr', 'fire.%04d.png'), a folder of them, a quoted glob, an animated PNG, GIF or WebP,
or y4m, also by '-'. An ffmpeg that is installed reads and writes .mp4, .mov, .webm, .mkv and .avi. Sound is not carried.

Examples:
  selvedge video river.####.png -o loop.####.png
  selvedge video candle.gif -o loop.gif --period 48..96
  selvedge video river.mp4 -o loop.mov --encode '-c:v prores_ks -profile:v 3'
  selvedge video river.####.png -o wide.####.png --size 320x160x100
  selvedge video fire.####.exr --with velocity.####.exr -o '{stem}-loop.####.exr' --preview fire.png";
const APPLY: &str = "\
Examples:
  selvedge apply wall-map.exr bricks-height.png -o wall-height.png --role height
  selvedge apply 'maps.####.exr' 'normal.####.exr' -o 'loop-normal.####.exr'
  selvedge apply wall-map.exr normal.png roughness.png --role normal,scalar -o wall-{name}";
const AGAIN: &str = "\
Examples:
  selvedge again wall.png -o wall-again.png
  selvedge again wall.png -o wall-again.png --look-in ~/textures scans

The command that 'selvedge info' shows can be pasted as well, in the folder of its inputs and with -o OUT: by the marks
of --expect it refuses other files of their names. Only 'again' looks for the right ones.";
const INFO: &str = "\
Examples:
  selvedge info wall.png
  selvedge info wall-map.exr --json

To run the command that made a picture, use 'selvedge again', or paste what is told here, with -o OUT: by the marks of
--expect it refuses other files of the same names (commands of clips and frames have none).";
const INSPECT: &str = "\
Examples:
  selvedge inspect bricks.png";
const COMPARE: &str = "\
Examples:
  selvedge compare before.png after.png --fail 0.01 --diff changes.png";
const SCORE: &str = "\
Examples:
  selvedge score wall-1.png wall-2.png --exemplar bricks.png";
const COMPLETIONS: &str = "\
Examples:
  selvedge completions bash > ~/.local/share/bash-completion/completions/selvedge";
const MAN: &str = "\
Examples:
  selvedge man ~/.local/share/man/man1";

const SYNTHESIZE: &str = "\
Examples:
  selvedge synthesize bricks.png -o wall.png --size 1024
  selvedge synthesize moss.png -o tile.png --tile xy --effort 7";
