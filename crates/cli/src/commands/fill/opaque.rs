//! Filled pictures in formats without transparency.

use crate::failure::Failure;
use crate::harmonise::Layout;
use crate::loom::Loom;
use crate::outputs;

/// Refuses a picture of which some stays translucent once its holes are filled, where its format holds no transparency.
/// What is copied is as opaque as what it is copied from.
pub(crate) fn check_opaque(loom: &Loom<'_>) -> Result<(), Failure> {
    let (shape, loaded) = (loom.domain.shape, &loom.loaded);
    for (e, plane) in loaded.payload.iter().enumerate().filter(|(_, plane)| plane.alpha) {
        let (colors, depth) = (plane.color_channels(), plane.samples.depth());
        let alpha = |i: usize| plane.samples.value(colors, i);
        // What the mask of the first leaves stands, transparent or not.
        let shows = |i: usize| match loaded.masks.get(e).and_then(Option::as_ref) {
            Some(mask) => mask.samples()[i] && (e == 0 || 0.0 < alpha(i)),
            None => 0.0 < alpha(i),
        };
        if (0..plane.domain().len()).any(|i| shows(i) && alpha(i) < depth.full()) {
            let layout = Layout { colors, alpha: true };
            outputs::check_held((loom.output(), loom.format), shape, (layout, depth), Some(&loaded.paths[e]))?;
        }
    }
    Ok(())
}
