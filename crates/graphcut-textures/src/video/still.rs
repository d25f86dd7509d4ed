//! Parts of a clip that stand still.

use selvedge_core::{
    Bytes, Domain, Error as CoreError, Exemplars, Grid, Run, SampleId, SeamCosts, SeamMeasure, SourceMap, Window,
};
use selvedge_expansion::{Frame, Holes, Pin, Scratch, expand};

use super::footage::the_clip;
use crate::error::Error;

/// An upper bound of the bytes that [`hold_still`] holds besides the clip's features and the map: two maps, prices of
/// seams over the clip, and a move over all of the map.
pub fn estimate_still(clip: Domain<3>, channels: usize, map: Domain<3>) -> Bytes {
    let prices = SeamCosts::<3>::bytes(Bytes::of_samples(clip, 1), channels);
    Bytes::of_samples(map, 8) + prices + selvedge_expansion::estimate(map.shape)
}

/// Shows one frame of the clip for good where `mask` is true, and around it where that makes seams cheaper: the cut
/// finds where stillness ends. All else stays as the map has it. The map's frames have the clip's size.
///
/// A still pixel is a seam in time by itself, the dearer the more the clip moves there: so what moves is not stilled
/// but where the mask says so, and what is calm may be.
///
/// # Errors
/// [`Error::OneClip`], [`Error::Frames`]; [`Error::Core`] for a frame that is not there, a mask or a map of another
/// size than the clip's frames, one over the run's limits, and if memory is short; [`Error::Cut`], also if the run is
/// cancelled.
///
/// # Optimality
/// Seams in time of what stands still are no metric beside those of what moves: of 40 brute-forced loops of 3 frames of
/// 1x4 the answer was the cheapest on 34, and it is never dearer than the mask itself held still.
///
/// # Complexity
/// One maximum flow over all of the map, and about 100 bytes for each of its samples.
///
/// # Determinism
/// The answer follows from the arguments alone.
pub fn hold_still(
    exemplars: &Exemplars<3>,
    map: &SourceMap<3>,
    (mask, frame): (&Grid<bool, 2>, u32),
    seam: SeamMeasure,
    run: &Run<'_, 3>,
) -> Result<SourceMap<3>, Error> {
    let [frames, height, width] = the_clip(exemplars)?.shape;
    let pixels = height * width;
    CoreError::within("still", frame, 0.0..=f64::from(frames - 1), "a frame of the clip")?;
    for found in [mask.domain().shape, [map.domain().shape[1], map.domain().shape[2]]] {
        if found != [height, width] {
            let what = "mask of still pixels";
            return Err(CoreError::StartShape { what, expected: vec![height, width], found: found.into() }.into());
        }
    }
    let clip = Domain::open([frames, height, width]);
    run.limits.admit(map.domain(), estimate_still(clip, exemplars.channels(), map.domain()))?;
    let still = |place: usize| SampleId::new(frame * pixels + place as u32 % pixels);
    let pinned = |place: usize| mask.plane(0)[place % pixels as usize];
    let costs = SeamCosts::new(exemplars, seam)?;
    let offered = Frame::new(map, &Window::all(map.domain()), (0..map.domain().len()).map(still))?;
    let choices = offered.choices(Holes::Fill, |place| pinned(place).then_some(Pin::New))?;
    let proposal = expand(&offered, &choices, &costs, &mut Scratch::default(), &|| run.observer.cancelled())?;
    let mut cut = map.clone();
    proposal.lay(&offered, &mut cut);
    // Where the model had to lower a price, the mask itself may be the better place.
    let mut sharp = map.clone();
    let ids = sharp.ids.plane_mut(0).iter_mut().enumerate();
    ids.filter(|(place, _)| pinned(*place)).for_each(|(place, id)| *id = still(place));
    Ok(if costs.total(&cut) <= costs.total(&sharp) { cut } else { sharp })
}
