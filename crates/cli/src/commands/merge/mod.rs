//! `selvedge merge`: several pictures, or clips, made one, cut along the seams that show least. `[Kwatra03 6B]`

mod checks;
mod clip_beside;
mod clip_blended;
mod clip_files;
mod clip_laid;
mod clip_needs;
mod clip_placed;
mod clip_seen;
mod clips;
mod gain;
mod placed;
mod strokes;
mod told;

use std::path::PathBuf;

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Grid, Start};
use selvedge_graphcut_textures::labels::{
    Label, LabelOptions, Prefer, estimate_aligned, estimate_labels, expand, preferred,
};

use self::placed::{At, bare};
use self::strokes::StrokeColor;
use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::fuse_keep::FuseKeep;
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::options::Seams;
use crate::outcome::Outcome;
use crate::output_size::OutputSize;
use crate::report::Done;
use crate::session::Session;
use crate::setup::Setup;
use crate::values::choices;
use crate::weaving::Weaving;

/// Options of `merge`.
#[derive(Args, Debug)]
#[command(mut_arg("exemplars", |arg| arg
    .value_names(["PICTURE"])
    .help("Pictures, numbered from 1; one that is given again may lie at another place. Or clips of as many frames, and pictures that are \
           held over all of them")))]
#[command(mut_arg("mask", |arg| arg
    .help("Show a picture only where this one is white. Give one for each picture, in order, or 'none'. For a clip one picture \
           for all frames, or one a frame: 'mask.####.png'")))]
#[command(mut_arg("map", |arg| arg
    .help("Write the source map: which sample stands at each place; for clips one a frame, 'maps.####.exr'. See 'selvedge \
           apply'")))]
#[command(mut_arg("with", |arg| arg
    .help("Lay the same weave over other planes of the pictures, such as the normals and heights of a material: a plane for \
           each picture, in order; more of them make more outputs. '{name}' and '{stem}' in OUT stand for the name of \
           picture and plane, with and without extension. Passes of clips are copied, also where seams of the clips are \
           hidden")))]
#[command(mut_arg("preview", |arg| arg
    .help("Write two by two copies of an output that tiles beside each other; of clips frames and slices through time, with \
           the seam. 8 bits, for eyes")))]
pub(crate) struct Merge {
    #[command(flatten)]
    weaving: Weaving,
    /// Where the second picture lies, and each further one: pixels across and down from the corner of the first, or
    /// auto, where it agrees best with the first. Default: 0,0.
    #[arg(long, value_name = "X,Y|auto", allow_hyphen_values = true)]
    at: Vec<At>,
    /// What must show, painted: each colour of --color its picture, all that is black or transparent whatever fits. It
    /// has the output's size. For clips one picture for all frames, or one a frame: 'strokes.####.png'.
    #[arg(long, value_name = "STROKES", value_hint = ValueHint::FilePath)]
    strokes: Option<PathBuf>,
    /// The picture that a colour of --strokes stands for, by its number: '#ffff00=1'.
    #[arg(long, value_name = "#RRGGBB=N", requires = "strokes")]
    color: Vec<StrokeColor>,
    /// Show the picture of this number wherever the other one, which has the output's size, is white. May be given
    /// several times.
    #[arg(long, num_args = 2, value_names = ["N", "MASK"], value_hint = ValueHint::FilePath)]
    keep: Vec<String>,
    /// What is wanted at each place, as far as seams allow it.
    #[arg(long, value_enum, value_name = "WHAT")]
    prefer: Option<PreferArg>,
    /// Give each picture the light and the contrast of those that it overlaps: a gain and an offset a channel, by least
    /// squares; the first stays as it is.
    #[arg(long)]
    gain: bool,
    /// Write which picture shows at each place: its number as a grey level of 8 bits, 0 where none does.
    #[arg(help_heading = "Files that are written", long, value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    label_map: Option<PathBuf>,
    #[command(flatten)]
    seams: Seams,
    #[command(flatten)]
    blending: Blending,
    #[command(flatten)]
    fuse_keep: FuseKeep,
}

choices!(PreferArg for Prefer {
    /// What most pictures have: who passes by vanishes.
    Median,
    /// What is in focus.
    Sharpest,
    /// The lightest.
    Brightest,
    /// The darkest.
    Darkest,
});

impl Method for Merge {
    fn setup(&self, _: &Session<'_>) -> Result<Setup<'_>, Failure> {
        self.validate()?;
        self.check_label_map()?;
        let kept = self.keep.chunks(2).map(|pair| PathBuf::from(&pair[1]));
        let size = OutputSize::Arranged(Box::new(|sources| self.extent(sources)));
        Ok(self.fuse_keep.setup(Setup {
            others: self.strokes.iter().cloned().chain(kept).collect(),
            writes: self.label_map.iter().cloned().collect(),
            blending: self.blending,
            ..Setup::new("merge", &self.weaving, size)
        }))
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let own = if self.prefer.is_some() { 4 * sources.len() as u64 } else { 0 };
        // What lies where it agrees is looked for before labels are decided.
        let found = self.found().map(|i| estimate_aligned(sources[0], sources[i], channels)).max().unwrap_or_default();
        let gained = if self.gain { gain::bytes(sources, channels, output) } else { Bytes(0) };
        found.max(gained).max(estimate_labels(sources, channels, output) + Bytes::of_samples(output, own + 8 + 4))
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        let labels = self.placed(loom)?;
        let tones = if self.gain { Some(gain::even(loom, &labels)?) } else { None };
        self.fuse_keep.read(loom)?;
        let (only, loom) = (self.only(loom, &labels)?, &*loom);
        let how = format!("from {}{}", n("picture", labels.len()), told::transparent(bare(loom, &labels)?));
        Ok(PlannedRun::new(self.used(loom, &labels), how, move || {
            let mut outcome = self.weave(loom, &labels, only)?;
            if let Some(tones) = &tones {
                outcome.stats["tones"] = gain::told(tones);
            }
            Ok(outcome)
        }))
    }
}

impl Merge {
    /// Runs the command: over clips, if it is given any.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        if self.is_of_clips(session)? { self.over_clips(session) } else { Method::run(self, session) }
    }

    fn weave(&self, loom: &Loom<'_>, labels: &[Label<2>], only: Option<Grid<u64, 2>>) -> Result<Outcome, Failure> {
        let exemplars = &loom.loaded.exemplars;
        let own = self.prefer.map(|prefer| preferred(exemplars, labels, loom.domain, prefer.into())).transpose()?;
        // What must show was seen to be there: holes are where no picture is.
        let options =
            LabelOptions { seam: self.seams.measure(), only, own, leave_holes: true, ..LabelOptions::default() };
        let start = Start::empty(exemplars, loom.domain)?;
        let woven = expand(exemplars, start, labels, &options, &loom.session.run())?;
        let (counts, how) = (told::counts(&woven.stats, labels), told::how(&woven.stats, "picture"));
        let holes = 0 < woven.stats.holes;
        let others = self.label_map.iter().map(|path| Ok((path.clone(), told::numbered(&woven.result)?)));
        let others = others.collect::<Result<_, Failure>>()?;
        Ok(Outcome { holes, others, ..Outcome::new(Box::new(woven.result), woven.complete, counts, how) })
    }
}
