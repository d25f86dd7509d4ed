//! What is followed, and how widely its light is spread.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Grid, Guide, Plane};
use selvedge_guides::{blur, encode_together, luminance, match_histogram};

use crate::correspondence::{Correspondence, What};
use crate::failure::Failure;
use crate::followed::{self, Followed};
use crate::inputs::Input;
use crate::loom::Loom;
use crate::output_size::OutputSize;
use crate::pairs::{GuideArgs, Pair};
use crate::session::Session;
use crate::setup::Setup;
use crate::used::Used;
use crate::weaving::Weaving;

/// Bytes for each sample of the largest picture while a correspondence map is made of it.
const A_MAP: u64 = 64;

/// Options about what is followed.
#[derive(Args, Debug)]
pub(super) struct FollowArgs {
    /// The picture to draw, of any depth, grey or colour; the output has its size. May be left out if there is a
    /// --guide.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    target: Option<PathBuf>,
    /// What of the target to follow, each with its weight: luminance, blur (of what is larger than a grain),
    /// orientation, edge (how far the nearest one is) or position (where in the picture). Default: luminance.
    #[arg(long, value_name = "WHAT[=WEIGHT]", value_delimiter = ',')]
    correspondence: Vec<Correspondence>,
    /// Blur what is followed by a Gaussian of this many pixels, in exemplar and target.
    #[arg(long, value_name = "SIGMA", default_value_t = 0.0)]
    blur: f64,
    /// Bring the target's luminance into the exemplar's range.
    #[arg(long)]
    match_histogram: bool,
    #[command(flatten)]
    guides: GuideArgs,
}

impl FollowArgs {
    /// The picture that decides the output's size.
    pub(super) fn first(&self, weaving: &Weaving) -> Result<PathBuf, Failure> {
        let pairs = self.guides.pairs(weaving)?;
        let first = self.target.as_ref().or(pairs.first().map(|pair| &pair.target));
        let nothing = || Failure::new(2, "nothing to follow").remedy("give a --target or a --guide");
        first.cloned().ok_or_else(nothing)
    }

    /// The files that are followed, of which the first has the output's size. Refuses what is wrong by itself.
    pub(super) fn setup<'a>(
        &self,
        command: &'static str,
        weaving: &'a Weaving,
        session: &Session<'_>,
    ) -> Result<Setup<'a>, Failure> {
        self.check_followed()?;
        self.check_weights(weaving)?;
        let pairs = self.guides.pairs(weaving)?;
        let first = Input::new(session, &self.first(weaving)?)?;
        let others = self.target.iter().chain(pairs.iter().flat_map(Pair::files)).cloned().collect();
        let size = OutputSize::Picture(first, 1);
        Ok(Setup { others, guides: pairs.len(), ..Setup::new(command, weaving, size) })
    }

    /// Bytes that maps take while they are made, which ends before the search that takes so many begins, and then.
    pub(super) fn bytes(&self, sources: &[Domain<2>], output: Domain<2>, search: Bytes) -> Bytes {
        let pictures = || sources.iter().chain(std::iter::once(&output));
        let made = pictures().map(|picture| Bytes::of_samples(*picture, A_MAP)).max().unwrap_or_default();
        // Colours, luminance, and the guide's own channels before and after they are joined.
        let each = 4 + 2 * self.channels() as u64 + self.masks();
        pictures().map(|picture| Bytes::of_samples(*picture, each)).sum::<Bytes>() + made.then(search)
    }

    /// Bytes for each sample of what says where all that is followed shows anything.
    pub(super) fn masks(&self) -> u64 {
        followed::MASKS * (self.followed().len() + self.guides.len()) as u64
    }

    /// Channels of all that is followed, at most.
    pub(super) fn channels(&self) -> usize {
        self.followed().len() * What::CHANNELS + self.guides.len() * 3
    }

    /// Everything that is followed, as one guide.
    pub(super) fn guide(&self, loom: &mut Loom<'_>, weaving: &Weaving) -> Result<Guide<2>, Failure> {
        let of_target = self.target.as_ref().map(|path| self.of_target(loom, path)).transpose()?;
        let mut guides = of_target.unwrap_or_default();
        for pair in self.guides.pairs(weaving)? {
            guides.push((pair.read(loom)?.derive(|map| blur(map, self.blur))?, pair.weight));
        }
        Guide::join(&guides).map_err(|e| Failure::from(e).remedy("change --weight or --correspondence"))
    }

    /// The options as used.
    pub(super) fn used(&self, loom: &Loom<'_>) -> Used {
        let followed: Vec<String> = self.followed().iter().map(ToString::to_string).collect();
        let followed = self.target.is_some().then(|| followed.join(","));
        self.guides.used(loom, loom.used().set("correspondence", followed))
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
    fn check_weights(&self, weaving: &Weaving) -> Result<(), Failure> {
        let wrong = |w: &f64| !w.is_finite() || *w < 0.0;
        match self.correspondence.iter().map(|c| c.weight).chain(weaving.with.weight.iter().copied()).find(wrong) {
            Some(weight) => {
                let error = Failure::from(selvedge_core::Error::GuideWeight { weight });
                Err(error.remedy("change --weight or --correspondence"))
            }
            None => Ok(()),
        }
    }

    /// Guides of a target at a path, with their weights.
    fn of_target(&self, loom: &mut Loom<'_>, path: &Path) -> Result<Vec<(Guide<2>, f64)>, Failure> {
        let picture = Followed::read(loom, path)?;
        let planes: Vec<&Plane<2>> = loom.loaded.payload.iter().chain(std::iter::once(&picture.plane)).collect();
        let features = encode_together(&planes).map_err(|e| Failure::from(e).about(path))?;
        let mut maps = features.iter().map(luminance).collect::<Result<Vec<_>, _>>()?;
        let target = maps.pop().expect("the target's").with_periodic(loom.domain.periodic);
        if !self.match_histogram && self.followed().iter().any(|c| c.what == What::Luminance) {
            let (own, wanted) = (spread(maps.iter()), spread(std::iter::once(&target)));
            if own < wanted * 2 / 3 {
                let what =
                    format!("its light spans {wanted} levels, that of the exemplar {own}: --match-histogram fits them");
                loom.session.warn(path, &what);
            }
        }
        let light = followed::asked(Guide::new(&loom.loaded.exemplars, &maps, target)?, &picture)?;
        let of = |c: &Correspondence| -> Result<(Guide<2>, f64), Failure> {
            let guide = c.what.of(&light, self.blur)?;
            let matched = self.match_histogram && c.what == What::Luminance;
            Ok((if matched { match_histogram(guide)? } else { guide }, c.weight))
        };
        self.followed().iter().map(of).collect()
    }
}

/// Levels between the darkest and the lightest twentieth.
fn spread<'m>(maps: impl Iterator<Item = &'m Grid<u8, 2>>) -> usize {
    let mut counts = [0_u64; 256];
    maps.flat_map(|map| map.samples()).for_each(|v| counts[usize::from(*v)] += 1);
    let rest = counts.iter().sum::<u64>() / 20;
    let skipped = |levels: &mut dyn Iterator<Item = &u64>| {
        let mut passed = 0;
        levels
            .take_while(|n| {
                passed += **n;
                passed <= rest
            })
            .count()
    };
    let (dark, light) = (skipped(&mut counts.iter()), skipped(&mut counts.iter().rev()));
    255_usize.saturating_sub(dark + light)
}
