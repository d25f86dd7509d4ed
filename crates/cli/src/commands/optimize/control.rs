//! What the output has to follow besides looking like the exemplars. `[Kwatra05 4]`

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Grid, Plane};
use selvedge_guides::{encode_together, luminance};
use selvedge_texture_optimization::{Control, Wanted};

use crate::failure::Failure;
use crate::ground::check_size;
use crate::harmonise::{Layout, widened};
use crate::inputs::{self, Input};
use crate::loom::Loom;
use crate::pairs::{GuidanceArgs, Pair};
use crate::used::Used;
use crate::weaving::Weaving;

/// What a wish counts: olives of a wished colour are drawn with; below .01 hardly, from .2 on by the colour alone.
const LAMBDA: f64 = 0.03;

/// Options about constraints.
#[derive(Args, Clone, Debug)]
pub(super) struct ControlArgs {
    /// Colours that are wanted: a picture of the output's size, of the exemplars' kind.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    want: Option<PathBuf>,
    /// Where they are wanted: white by all of --lambda, grey by less, black not at all. Default: everywhere.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath, requires = "want")]
    want_where: Option<PathBuf>,
    /// How much what is wanted counts, where the texture counts 1: 0.03 draws with things of that colour, 1 the colours
    /// alone.
    #[arg(long, value_name = "L", default_value_t = LAMBDA, allow_negative_numbers = true)]
    lambda: f64,
    /// Where this picture is white, what the texture starts from stays to the bit. Needs --start, or --init with a map.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    fixed: Option<PathBuf>,
    #[command(flatten)]
    guides: GuidanceArgs,
}

impl ControlArgs {
    /// Files that are read, but guides.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        [self.want.as_ref(), self.want_where.as_ref(), self.fixed.as_ref(), self.guides.mask()]
            .into_iter()
            .flatten()
            .cloned()
            .collect()
    }

    /// What is followed.
    pub(super) fn pairs(&self, weaving: &Weaving) -> Result<Vec<Pair>, Failure> {
        self.guides.pairs(weaving)
    }

    /// Whether anything is wanted or followed, of which a start knows nothing.
    pub(super) fn steers(&self) -> bool {
        self.want.is_some() || self.guides.len() != 0
    }

    /// Channels of all that is followed, at most.
    pub(super) fn channels(&self) -> usize {
        self.guides.channels()
    }

    /// Bytes that pictures, wishes and maps take at all resolutions.
    pub(super) fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        if self.guides.len() != 0 {
            // Maps as they are read, encoded, turned, joined, and beside the features.
            let each = 8 * (channels + self.channels()) as u64;
            let maps: Bytes = sources.iter().map(|&source| Bytes::of_samples(source, each)).sum();
            return maps + self.wishes(channels + self.channels(), output);
        }
        if self.files().is_empty() { Bytes(0) } else { self.wishes(channels, output) }
    }

    fn wishes(&self, channels: usize, output: Domain<2>) -> Bytes {
        // A picture in any depth with its features, and numbers of 8 bytes, a third of them more when they are halved.
        let each = (channels as u64 + 1) * (16 + 1 + 22) + 8;
        Bytes::of_samples(output, each)
    }

    /// Refuses what is wrong by itself.
    pub(super) fn validate(&self, starts_from_map: bool) -> Result<(), Failure> {
        if self.fixed.is_some() && !starts_from_map {
            return Err(Failure::new(2, "--fixed has nothing to fix").remedy("give --start or --init a source map"));
        }
        // Not by clap: options as they are saved say it always.
        if self.want.is_none() && self.lambda != LAMBDA {
            let failure = Failure::new(2, "--lambda says how much what is wanted counts, and nothing is");
            return Err(failure.remedy("leave it out, or give --want PICTURE"));
        }
        Ok(Wanted::check_lambda(self.lambda)?)
    }

    /// Reads them.
    pub(super) fn read(&self, loom: &mut Loom<'_>, weaving: &Weaving) -> Result<Control, Failure> {
        let wanted = self.want.as_deref().map(|path| self.wanted(loom, path)).transpose()?;
        let fixed = self.fixed.as_deref().map(|path| white(loom, path)).transpose()?;
        Ok(Control { wanted, fixed, guidance: self.guides.guidance(loom, weaving)? })
    }

    fn wanted(&self, loom: &mut Loom<'_>, path: &Path) -> Result<Wanted, Failure> {
        let picture = plane(loom, path)?;
        let colors = loom.loaded.payload[0].color_channels();
        let of = Layout {
            colors: if picture.color_channels() == 1 { colors } else { picture.color_channels() },
            alpha: picture.alpha,
        };
        let (found, expected) = (of.colors, loom.loaded.exemplars.channels());
        if found != expected {
            let what = format!("{found} channels, and the exemplars are compared by {expected}");
            return Err(Failure::new(3, what).about(path).remedy("give a picture of the exemplars' kind"));
        }
        // By the exemplars' own curve: what is wished for is a colour of theirs, whatever else the picture shows.
        let picture = widened(picture, of)?;
        let features = loom.loaded.encoder.encode(&[picture]).map_err(|e| Failure::from(e).about(path))?;
        let lambda = self.lambda as f32;
        let weight = match &self.want_where {
            None => Grid::try_filled(loom.domain, 1, lambda)?,
            Some(path) => {
                let mask = plane(loom, path)?;
                let light = encode_together(&[&mask]).map_err(|e| Failure::from(e).about(path))?;
                luminance(&light[0])?.map(|v| f32::from(v) / 255.0 * lambda)?
            }
        };
        Ok(Wanted { features, weight })
    }

    /// Without what does not act.
    pub(super) fn used(&self, loom: &Loom<'_>, used: Used) -> Used {
        let used = if self.want.is_some() { used } else { used.without("lambda") };
        self.guides.used(loom, used)
    }
}

/// Where a picture of the output's size is white.
fn white(loom: &mut Loom<'_>, path: &Path) -> Result<Grid<bool, 2>, Failure> {
    inputs::white(&plane(loom, path)?, path)
}

/// A picture of the output's size.
fn plane(loom: &mut Loom<'_>, path: &Path) -> Result<Plane<2>, Failure> {
    let plane = loom.read(&Input::new(loom.session, path)?)?;
    check_size(path, plane.domain().shape, Some(loom.domain.shape), "the output has", "give one of that size")?;
    Ok(plane)
}
