//! Exemplars that are lit unevenly: decided by as if they were not, or made even.

use clap::Args;
use selvedge_core::{Bytes, Domain, Exemplars, Plane};
use selvedge_io::Info;

use crate::wrong::Wrong;

/// Options for exemplars that are lit unevenly.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct LightArgs {
    /// Decide as if this share of uneven light were not there, 0 to 1. Samples stay exact copies, so '--spline auto'
    /// should join those that differ in shade.
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    ignore_light: Option<f64>,
    /// Take out of the exemplars the light that means with this deviation in px show. Changes samples.
    #[arg(long, value_name = "SIGMA", value_parser = deviation, allow_negative_numbers = true)]
    flatten: Option<f64>,
}

fn share(text: &str) -> Result<f64, Wrong> {
    let wrong = || Wrong::new(format!("'{text}' is no share of light"), "give 0 to 1, such as 0.8");
    text.parse().ok().filter(|share| (0.0..=1.0).contains(share)).ok_or_else(wrong)
}

fn deviation(text: &str) -> Result<f64, Wrong> {
    let wrong = || Wrong::new(format!("'{text}' is no deviation in px"), "give a number from 1 to 1000000, such as 40");
    text.parse().ok().filter(|sigma| (1.0..=1e6).contains(sigma)).ok_or_else(wrong)
}

impl LightArgs {
    /// The planes of exemplars, even if that was asked for.
    pub(crate) fn flatten(self, planes: &mut [Plane<2>]) -> Result<(), selvedge_core::Error> {
        let Some(sigma) = self.flatten else { return Ok(()) };
        for plane in planes {
            *plane = plane.flattened(sigma)?;
        }
        Ok(())
    }

    /// The exemplars, as decisions see them.
    pub(crate) fn ignore(self, exemplars: Exemplars<2>) -> Result<Exemplars<2>, selvedge_core::Error> {
        match self.ignore_light {
            Some(share) => exemplars.ignoring_light(share),
            None => Ok(exemplars),
        }
    }

    /// What this takes at most, beside the exemplars.
    pub(crate) fn memory(self, infos: &[Info], sources: &[Domain<2>], channels: usize) -> Bytes {
        let largest = infos.iter().map(|info| u64::from(info.width) * u64::from(info.height)).max().unwrap_or_default();
        // The plane that is made even exists twice, in at most four channels of four bytes.
        let flat = self.flatten.map(|_| Plane::<2>::flattened_bytes(largest) + Bytes(largest * 16));
        let ignored = self.ignore_light.map(|_| Exemplars::light_bytes(sources, channels));
        flat.unwrap_or_default().max(ignored.unwrap_or_default())
    }
}
