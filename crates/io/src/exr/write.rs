//! Writing EXR: one part, half or float.

use exr::math::Vec2;
use exr::meta::attribute::{Chromaticities, SampleType};
use exr::meta::header::Header;
use selvedge_core::{Plane, Samples};

use super::blocks::{text, write_rows};
use crate::Format;
use crate::error::Problem;
use crate::metadata::{DensityUnit, Metadata};

/// The whole file. One colour channel is named `Y`, two `X` and `Y`, three `R`, `G` and `B`, more as they were; alpha
/// `A`.
pub(crate) fn encode(plane: &Plane<2>, metadata: &Metadata) -> Result<Vec<u8>, Problem> {
    let format = Format::Exr;
    let names = names(plane, metadata);
    let with = |kind| names.iter().map(move |name| (&name[..], kind)).collect::<Vec<_>>();
    let describe = |header: &mut Header| describe(header, metadata);
    let shape = plane.domain().shape;
    match &plane.samples {
        Samples::F16(grid) => write_rows(shape, &with(SampleType::F16), describe, |c, at, bytes| {
            for (to, from) in bytes.as_chunks_mut().0.iter_mut().zip(&grid.plane(c)[at..]) {
                *to = from.to_ne_bytes();
            }
        }),
        Samples::F32(grid) => write_rows(shape, &with(SampleType::F32), describe, |c, at, bytes| {
            for (to, from) in bytes.as_chunks_mut().0.iter_mut().zip(&grid.plane(c)[at..]) {
                *to = from.to_ne_bytes();
            }
        }),
        integers => Err(Problem::DepthNotHeld { format, depth: integers.depth() }),
    }
}

/// Names of the channels: those of the file that they are from, where it is none of the usual pictures.
fn names(plane: &Plane<2>, metadata: &Metadata) -> Vec<String> {
    let (colors, all) = (plane.color_channels(), plane.samples.channels());
    let mut sorted = metadata.channel_names.clone();
    sorted.sort_unstable();
    sorted.dedup();
    if 3 < colors && sorted.len() == all && metadata.channel_names.len() == all {
        return metadata.channel_names.clone();
    }
    usual(colors, plane.alpha)
}

/// Names of channels that have no others.
fn usual(colors: usize, alpha: bool) -> Vec<String> {
    let mut names: Vec<String> = match colors {
        1 => vec!["Y".into()],
        2 => ["X", "Y"].map(String::from).into(),
        3 => ["R", "G", "B"].map(String::from).into(),
        _ => (1..=colors).map(|c| format!("channel{c}")).collect(),
    };
    names.extend(alpha.then(|| "A".into()));
    names
}

/// Channels that were chosen and are written under other names, whatever their layers: as they were, and as they are.
pub(crate) fn renamed(plane: &Plane<2>, metadata: &Metadata) -> Option<(String, String)> {
    let (before, after) = (&metadata.channel_names, names(plane, metadata));
    let base = |name: &String| name.rsplit('.').next().unwrap_or_default().to_owned();
    let differ = before.len() == after.len() && before.iter().map(base).ne(after.iter().map(base));
    differ.then(|| (before.join(", "), after.join(", ")))
}

/// Standard attributes only: custom ones are written in no fixed order.
pub(super) fn describe(header: &mut Header, metadata: &Metadata) {
    header.own_attributes.software_name = metadata.provenance.as_ref().map(|made| text(&made.to_string()));
    header.shared_attributes.chromaticities = metadata.chromaticities.map(|c| {
        let at = |i: usize| Vec2(c[i] as f32, c[i + 1] as f32);
        Chromaticities { white: at(0), red: at(2), green: at(4), blue: at(6) }
    });
    let Some(density) = metadata.density else { return };
    let per_inch = match density.unit {
        DensityUnit::Aspect => None,
        DensityUnit::Inch => Some(density.x),
        DensityUnit::Centimetre => Some(density.x * 2.54),
        DensityUnit::Metre => Some(density.x * 0.0254),
    };
    header.own_attributes.horizontal_density = per_inch.map(|v| v as f32);
    let aspect = (density.y / density.x) as f32;
    if aspect.is_normal() && (1e-6..=1e6).contains(&aspect) {
        header.shared_attributes.pixel_aspect = aspect;
    }
}
