//! What the output has to follow besides looking like the exemplars. `[Kwatra05 4]`

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Domain, Grid, Plane};
use selvedge_guides::{encode_together, luminance};
use selvedge_io::MaskChannel;
use selvedge_texture_optimization::{Control, Wanted};

use crate::failure::Failure;
use crate::ground::check_size;
use crate::harmonise::{Layout, widened};
use crate::inputs::Input;
use crate::loom::Loom;
use crate::used::Used;

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
    #[arg(long, value_name = "L", default_value_t = 0.03, requires = "want", allow_negative_numbers = true)]
    lambda: f64,
    /// Where this picture is white, what the texture starts from stays to the bit. Needs --start, or --init with a map.
    #[arg(long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    fixed: Option<PathBuf>,
}

impl ControlArgs {
    /// Files that are read.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        [&self.want, &self.want_where, &self.fixed].into_iter().flatten().cloned().collect()
    }

    /// Bytes that pictures and wishes take at all resolutions.
    pub(super) fn bytes(&self, channels: usize, output: Domain<2>) -> Bytes {
        // A picture in any depth with its features, and numbers of 8 bytes, a third of them more when they are halved.
        let each = (channels as u64 + 1) * (16 + 1 + 11) + 8;
        if self.files().is_empty() { Bytes(0) } else { Bytes::of_samples(output, each) }
    }

    /// Refuses what is wrong by itself.
    pub(super) fn validate(&self, starts_from_map: bool) -> Result<(), Failure> {
        if self.fixed.is_some() && !starts_from_map {
            return Err(Failure::new(2, "--fixed has nothing to fix").remedy("give --start or --init a source map"));
        }
        if !(self.lambda.is_finite() && 0.0 <= self.lambda) {
            let what = format!("a lambda of {} is out of range", self.lambda);
            return Err(Failure::new(2, what).remedy("use 0 (no wish) or more"));
        }
        Ok(())
    }

    /// Reads them.
    pub(super) fn read(&self, loom: &mut Loom<'_>) -> Result<Control, Failure> {
        let wanted = self.want.as_deref().map(|path| self.wanted(loom, path)).transpose()?;
        let Some(path) = &self.fixed else { return Ok(Control { wanted, fixed: None }) };
        let mask = plane(loom, path)?;
        let fixed = selvedge_io::mask(&mask, MaskChannel::Light).map_err(|p| Failure::from_problem(path, p))?;
        Ok(Control { wanted, fixed: Some(fixed) })
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
    pub(super) fn used(&self, used: Used) -> Used {
        if self.want.is_some() { used } else { used.without("lambda") }
    }
}

/// A picture of the output's size.
fn plane(loom: &mut Loom<'_>, path: &Path) -> Result<Plane<2>, Failure> {
    let plane = loom.read(&Input::new(loom.session, path)?)?;
    check_size(path, plane.domain().shape, Some(loom.domain.shape), "the output has", "give one of that size")?;
    Ok(plane)
}
