//! `selvedge transfer`: texture transfer. `[Efros01 3]`

mod by_cms;
mod followed;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum, ValueHint};
use selvedge_core::{Bytes, Domain, Guide, Plane};
use selvedge_guides::{Error, blur, encode_together, luminance, match_histogram, orientation};
use selvedge_quilting::{TransferOptions, TransferPlan, TransferStats, estimate_transfer};
use serde_json::json;

use self::by_cms::Labels;
use self::followed::{Correspondence, What, spread};
use crate::blending::Blending;
use crate::commands::quilt::{failure, pixels};
use crate::failure::{Failure, n, shown};
use crate::inputs::Input;
use crate::loom::{Loom, Outcome};
use crate::method::{Method, Planned};
use crate::report::Done;
use crate::session::Session;
use crate::setup::{OutputSize, Setup};
use crate::used::Used;
use crate::values::Auto;
use crate::weaving::Weaving;

/// Samples over which gradients are averaged for orientation, where `--blur` does not say more.
const LEAST_AVERAGE: f64 = 2.0;

/// Options of `transfer`.
#[derive(Args, Debug)]
pub(crate) struct Transfer {
    #[command(flatten)]
    weaving: Weaving,
    /// The picture to draw, of any depth, grey or colour; the output has its size. May be left out if there is a
    /// --guide.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    target: Option<PathBuf>,
    /// What of the target to follow, each with its weight: luminance or orientation. Default: luminance.
    #[arg(long, value_name = "WHAT[=WEIGHT]", value_delimiter = ',')]
    correspondence: Vec<Correspondence>,
    /// Blur what is followed by a Gaussian of this many pixels, in exemplar and target.
    #[arg(long, value_name = "SIGMA", default_value_t = 0.0)]
    blur: f64,
    /// Bring the target's luminance into the exemplar's range.
    #[arg(long)]
    match_histogram: bool,
    /// Follow a picture of your own: one that lies under the exemplar, and one that lies under the output. With several
    /// exemplars write theirs as one list, separated by commas. May be given several times.
    #[arg(long, num_args = 2, value_names = ["SRC", "TGT"], value_hint = ValueHint::FilePath)]
    guide: Vec<PathBuf>,
    /// By which method.
    #[arg(long, value_name = "METHOD", default_value = "quilt")]
    method: By,
    /// With --method cms, how much what is followed counts against seams.
    #[arg(short = 'K', long, value_name = "K")]
    constraint_weight: Option<f64>,
    /// With --method cms, half the side of the neighborhoods that are compared, in pixels.
    #[arg(short = 'N', long, value_name = "N")]
    neighborhood: Option<u32>,
    /// Side of the first pass's blocks in pixels, or auto; each pass takes them smaller by a third. auto is a ninth of
    /// the target's shorter side, 12 to 36; where small features such as eyes are lost, give about half of that.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = pixels())]
    block: Auto<u32>,
    /// Passes over the output; the paper took 3 to 5.
    #[arg(long, value_name = "N", default_value_t = TransferOptions::default().passes)]
    passes: u32,
    /// Share of the texture, 0 to 1, in every pass. Default: from 0.1 in the first to 0.9 in the last.
    #[arg(long, value_name = "A")]
    alpha: Option<f64>,
    /// Draw among blocks whose error is up to this fraction above the least.
    #[arg(long, value_name = "T", default_value_t = TransferOptions::default().tolerance)]
    tolerance: f64,
    /// How evenly the exemplar is used: 0 takes whatever fits best.
    #[arg(long, value_name = "S", default_value_t = TransferOptions::default().spread)]
    spread: f64,
    /// The paper to the letter: --tolerance 0.1 --spread 0.
    #[arg(long, conflicts_with_all = ["tolerance", "spread"])]
    paper: bool,
    #[command(flatten)]
    blending: Blending,
}

/// What a picture is put together from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum By {
    /// Blocks, in several passes of smaller and smaller ones.
    Quilt,
    /// Labels of any shape that lower one energy, where it is highest; exemplars are turned by quarter turns as well.
    Cms,
}

/// Files of one `--guide`.
pub(super) struct Pair {
    /// One an exemplar.
    pub(super) sources: Vec<PathBuf>,
    pub(super) target: PathBuf,
    pub(super) weight: f64,
}

impl Pair {
    /// All of them.
    pub(super) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.sources.iter().chain(std::iter::once(&self.target))
    }
}

/// A transfer whose options were understood, and the picture that the output has the size of.
struct Job<'a> {
    args: &'a Transfer,
    options: TransferOptions,
    pairs: Vec<Pair>,
    first: Input,
}

impl Method for Job<'_> {
    type Read = Guide<2>;

    fn setup(&self) -> Result<Setup<'_>, Failure> {
        Ok(Setup { block: self.args.block.0, ..self.args.setup(&self.pairs, &self.first) })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        let guides = self.args.followed().len() * 2 + self.pairs.len() * 3;
        Bytes(estimate_transfer(sources, channels, guides, output, &self.options))
    }

    fn read(&self, loom: &mut Loom<'_>) -> Result<Guide<2>, Failure> {
        self.args.guides(loom, &self.first, &self.pairs)
    }

    fn plan<'l>(&'l self, loom: &'l Loom<'_>, guide: Guide<2>) -> Result<Planned<'l>, Failure> {
        let sides: Vec<u32> = self.planned(loom, &guide)?.blocks().collect();
        let used = ["method", "constraint-weight", "neighborhood"];
        let used = used.into_iter().fold(self.args.used(loom, &sides), Used::without);
        Ok(Planned::new(used, how("blocks", &sides), move || {
            let woven = self.planned(loom, &guide)?.weave(&loom.session.run()).map_err(|e| failure(loom, e))?;
            let blocks: u64 = woven.stats.passes.iter().map(|p| p.blocks).sum();
            let how = how(&format!("{blocks} blocks"), &sides);
            Ok(Outcome::new(Box::new(woven.result), woven.complete, counts(&woven.stats), how))
        }))
    }
}

impl Job<'_> {
    fn planned<'l>(&self, loom: &'l Loom<'_>, guide: &'l Guide<2>) -> Result<TransferPlan<'l>, Failure> {
        let plan = TransferPlan::new(&loom.loaded.exemplars, guide, &self.options, &loom.session.run());
        plan.map_err(|e| failure(loom, e))
    }
}

impl Transfer {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let options = self.options();
        options.validate()?;
        self.blending.validate()?;
        self.check_followed()?;
        self.check_weights()?;
        let pairs = pairs(&self.guide, &self.weaving)?;
        let first = self.target.as_ref().or(pairs.first().map(|pair| &pair.target));
        let nothing = || Failure::new(2, "nothing to follow").remedy("give a --target or a --guide");
        let first = Input::new(session, first.ok_or_else(nothing)?)?;
        match self.method {
            By::Quilt => self.check_quilt().and_then(|()| Job { args: self, options, pairs, first }.run(session)),
            By::Cms => Labels::new(self, pairs, first)?.run(session),
        }
    }

    /// What both methods tell of themselves.
    fn setup<'s>(&'s self, pairs: &[Pair], first: &'s Input) -> Setup<'s> {
        let others = self.target.iter().chain(pairs.iter().flat_map(Pair::files)).cloned().collect();
        let setup = Setup::new("transfer", &self.weaving, OutputSize::Picture(first, 1));
        Setup { blending: self.blending, guides: pairs.len(), others, ..setup }
    }

    /// Refuses what is of labels alone.
    fn check_quilt(&self) -> Result<(), Failure> {
        let of_labels = [("-K", self.constraint_weight.is_some()), ("-N", self.neighborhood.is_some())];
        let Some((option, _)) = of_labels.iter().find(|(_, typed)| *typed) else { return Ok(()) };
        let what = format!("{option} is of labels, and --method quilt has none");
        Err(Failure::new(2, what).remedy("leave it out, or use --method cms"))
    }

    /// What of the target is followed.
    fn followed(&self) -> &[Correspondence] {
        const LUMINANCE: &[Correspondence] = &[Correspondence { what: What::Luminance, weight: 1.0 }];
        match (&self.target, &self.correspondence[..]) {
            (None, _) => &[],
            (Some(_), []) => LUMINANCE,
            (Some(_), given) => given,
        }
    }

    /// Refuses what would change nothing: --correspondence without a target, --match-histogram without its luminance.
    fn check_followed(&self) -> Result<(), Failure> {
        if self.target.is_none() && !self.correspondence.is_empty() {
            let what = "--correspondence says what of the --target is followed, and there is none";
            return Err(Failure::new(2, what).remedy("leave it out, or give a --target"));
        }
        if !self.match_histogram || self.followed().iter().any(|c| c.what == What::Luminance) {
            return Ok(());
        }
        let what = "--match-histogram changes the luminance of the --target, which is not followed";
        Err(Failure::new(2, what).remedy("leave it out, or give a --target and --correspondence luminance"))
    }

    /// Refuses weights that are wrong by themselves, before anything is read.
    fn check_weights(&self) -> Result<(), Failure> {
        let wrong = |w: &f64| !w.is_finite() || *w < 0.0;
        match self.correspondence.iter().map(|c| c.weight).chain(self.weaving.with.weight.iter().copied()).find(wrong) {
            Some(weight) => {
                let error = Failure::from(selvedge_core::Error::GuideWeight { weight });
                Err(error.remedy("change --weight or --correspondence"))
            }
            None => Ok(()),
        }
    }

    fn options(&self) -> TransferOptions {
        let options =
            TransferOptions { block: self.block.0, passes: self.passes, alpha: self.alpha, ..TransferOptions::paper() };
        if self.paper {
            return options;
        }
        TransferOptions { tolerance: self.tolerance, spread: self.spread, ..options }
    }

    /// Everything that is followed, as one guide. `first` is the target, or that of the first pair.
    fn guides(&self, loom: &mut Loom<'_>, first: &Input, pairs: &[Pair]) -> Result<Guide<2>, Failure> {
        let session = loom.session;
        let mut guides = Vec::new();
        let mut first = Some(first);
        if let Some(path) = &self.target
            && let Some(input) = first.take()
        {
            let target = loom.read(input)?;
            guides = self.of_target(loom, path, target)?;
        }
        for pair in pairs {
            let open = |path: &PathBuf| Input::new(session, path);
            let sources = pair.sources.iter().map(|p| loom.read(&open(p)?)).collect::<Result<Vec<_>, Failure>>()?;
            let target = match first.take() {
                Some(input) => loom.read(input),
                None => loom.read(&open(&pair.target)?),
            }?;
            let guide = guide_of(loom, pair, &sources, target)?.derive(|map| blur(map, self.blur))?;
            guides.push((guide, pair.weight));
        }
        Guide::join(&guides).map_err(|e| Failure::from(e).remedy("change --weight or --correspondence"))
    }

    /// Luminance and orientation, with their weights.
    fn of_target(&self, loom: &Loom<'_>, path: &Path, target: Plane<2>) -> Result<Vec<(Guide<2>, f64)>, Failure> {
        let about = |e: Error| Failure::from(e).about(path);
        let mut planes: Vec<&Plane<2>> = loom.loaded.payload.iter().collect();
        planes.push(&target);
        let mut maps = Vec::new();
        for features in encode_together(&planes).map_err(about)? {
            maps.push(luminance(&features)?);
        }
        let target = maps.pop().expect("the target's").with_periodic(loom.domain.periodic);
        if !self.match_histogram && self.followed().iter().any(|c| c.what == What::Luminance) {
            let (own, wanted) = (spread(maps.iter()), spread(std::iter::once(&target)));
            if own < wanted * 2 / 3 {
                let what =
                    format!("its light spans {wanted} levels, that of the exemplar {own}: --match-histogram fits them");
                loom.session.warn(path, &what);
            }
        }
        let light = Guide::new(&loom.loaded.exemplars, &maps, target)?;
        let of = |c: &Correspondence| -> Result<(Guide<2>, f64), Failure> {
            let guide = match c.what {
                What::Luminance => {
                    let blurred = light.derive(|map| blur(map, self.blur))?;
                    if self.match_histogram { match_histogram(blurred)? } else { blurred }
                }
                What::Orientation => light.derive(|map| orientation(map, self.blur.max(LEAST_AVERAGE)))?,
            };
            Ok((guide, c.weight))
        };
        self.followed().iter().map(of).collect()
    }

    /// The options as used.
    fn used(&self, loom: &Loom<'_>, sides: &[u32]) -> Used {
        let guides = named(&self.guide, loom.loaded.paths.len());
        let followed: Vec<String> = self.followed().iter().map(ToString::to_string).collect();
        // Weights of guides count even where no plane decides with the exemplars.
        let used = loom.used();
        let used = if used.has("weight") { used } else { used.with("weight", self.weaving.with.weight.clone()) };
        let used = used
            .set("correspondence", self.target.is_some().then(|| followed.join(",")))
            .set("guide", guides)
            .set("block", sides.first().copied())
            .set("tolerance", self.options().tolerance)
            .set("spread", self.options().spread);
        self.blending.used_if_any(used)
    }
}

/// The pairs that were typed, each with its weight.
pub(super) fn pairs(guide: &[PathBuf], weaving: &Weaving) -> Result<Vec<Pair>, Failure> {
    let exemplars = weaving.input.exemplars.len();
    weaving.with.validate(exemplars, guide.len() / 2)?;
    let pair = |(i, files): (usize, &[PathBuf])| {
        let sources = listed(&files[0], exemplars);
        if sources.len() != exemplars {
            let what =
                format!("'{}' names {} for {}", shown(&files[0]), n("file", sources.len()), n("exemplar", exemplars));
            return Err(Failure::new(2, what).remedy("give --guide one SRC for each, separated by commas"));
        }
        Ok(Pair { sources, target: files[1].clone(), weight: weaving.with.weight.get(i).copied().unwrap_or(1.0) })
    };
    guide.chunks(2).enumerate().map(pair).collect()
}

/// The guide that a pair of pictures makes.
pub(super) fn guide_of(
    loom: &Loom<'_>,
    pair: &Pair,
    sources: &[Plane<2>],
    target: Plane<2>,
) -> Result<Guide<2>, Failure> {
    for (i, plane) in sources.iter().enumerate() {
        let exemplar = loom.loaded.payload[i].domain().shape;
        check_shape(&pair.sources[i], plane, exemplar, &shown(&loom.loaded.paths[i]))?;
    }
    check_shape(&pair.target, &target, loom.domain.shape, "the output")?;
    let planes: Vec<&Plane<2>> = sources.iter().chain(std::iter::once(&target)).collect();
    let mut maps = encode_together(&planes).map_err(|e| Failure::from(e).about(&pair.target))?;
    let target = maps.pop().expect("the target's").with_periodic(loom.domain.periodic);
    Ok(Guide::new(&loom.loaded.exemplars, &maps, target)?)
}

/// Pairs by the names of their files, as pictures carry them.
pub(super) fn named(guide: &[PathBuf], exemplars: usize) -> Vec<Vec<String>> {
    let name = |path: &PathBuf| selvedge_io::display_name(path);
    let names = |list: &PathBuf| listed(list, exemplars).iter().map(name).collect::<Vec<_>>().join(",");
    guide.chunks(2).map(|g| vec![names(&g[0]), name(&g[1])]).collect()
}

/// The files of a SRC: a list with several exemplars, for one exemplar the name as it is.
pub(super) fn listed(sources: &Path, exemplars: usize) -> Vec<PathBuf> {
    match sources.to_str() {
        Some(text) if exemplars != 1 => text.split(',').map(PathBuf::from).collect(),
        _ => vec![sources.to_path_buf()],
    }
}

pub(super) fn check_shape(path: &Path, plane: &Plane<2>, expected: [u32; 2], of: &str) -> Result<(), Failure> {
    let ([h, w], [eh, ew]) = (plane.domain().shape, expected);
    if [h, w] == [eh, ew] {
        return Ok(());
    }
    let what = format!("{w}x{h} px, but {of} has {ew}x{eh} px");
    Err(Failure::new(3, what).about(path).remedy("give a guide of the same size"))
}

fn counts(stats: &TransferStats) -> serde_json::Value {
    let pass = |p: &selvedge_quilting::PassStats| {
        json!({
            "block": p.block,
            "overlap": p.overlap,
            "alpha": p.alpha,
            "blocks": p.blocks,
            "candidates": p.candidates,
            "cut_error": p.cut_error,
            "guide_error": p.guide_error,
        })
    };
    json!({ "passes": stats.passes.iter().map(pass).collect::<Vec<_>>() })
}

fn how(blocks: &str, sides: &[u32]) -> String {
    let sides: Vec<String> = sides.iter().map(u32::to_string).collect();
    format!("from {blocks} of {} px", sides.join(", "))
}
