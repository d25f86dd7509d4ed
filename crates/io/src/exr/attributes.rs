//! The attributes of a part that are metadata.

use exr::meta::header::Header as Part;

use crate::metadata::{Density, DensityUnit, Metadata};
use crate::provenance::Provenance;

/// What a part says besides its channels.
pub(super) fn metadata(part: &Part) -> Metadata {
    let shared = &part.shared_attributes;
    let chromaticities = shared.chromaticities.map(|c| {
        let points = [c.white, c.red, c.green, c.blue].map(|p| [p.0, p.1].map(f64::from));
        points.concat().try_into().expect("four times two")
    });
    let aspect = f64::from(shared.pixel_aspect);
    let density = match part.own_attributes.horizontal_density.map(f64::from) {
        Some(x) => Some(Density { x, y: x * aspect, unit: DensityUnit::Inch }),
        None if aspect == 1.0 => None,
        None => Some(Density { x: 1.0, y: aspect, unit: DensityUnit::Aspect }),
    };
    let software = part.own_attributes.software_name.as_ref().map(|t| t.as_slice().to_vec());
    let provenance = software.and_then(|text| Provenance::parse(std::str::from_utf8(&text).ok()?));
    Metadata { chromaticities, density, provenance, ..Metadata::default() }
}

/// What a part says of its place and its light that nothing is made of: the picture is the data window.
pub(super) fn unread(part: &Part) -> impl Iterator<Item = &'static str> {
    let window = part.shared_attributes.display_window;
    let is_whole = part.own_attributes.layer_position == window.position && part.layer_size == window.size;
    let bright = part.own_attributes.white_luminance.is_some();
    let said = [(!is_whole, "place in its display window"), (bright, "white luminance")];
    said.into_iter().filter(|(said, _)| *said).map(|(_, tag)| tag)
}
