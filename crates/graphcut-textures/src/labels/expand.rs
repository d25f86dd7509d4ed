//! Labels decided by expansions.

use selvedge_core::{Bytes, Domain, Event, Exemplars, Run, SeamCosts, SourceMap, Start, Woven, try_vec};

use crate::error::Error;
use crate::labels::label::Label;
use crate::labels::options::{LabelOptions, LabelStats};
use crate::labels::prices::{NONE, price_of};
use crate::labels::sets::Sets;
use crate::labels::sweeps::{Sweeps, shown};
use crate::labels::two::Two;

/// Decides which label shows at each position that is not fixed: sweeps of expansions, one for each label in the order
/// given, until a sweep brings nothing.
///
/// What `start` has stays until a label makes it cheaper. Where it has nothing, the first labelling is what the nearest
/// position has at which only one label may show; with [`own`](LabelOptions::own) prices it is the label of the least.
///
/// Every sample next to one that a label cannot show keeps what it has: at a seam both sides are defined beyond it, as
/// in [`Frame::choices`](selvedge_expansion::Frame::choices).
///
/// # Errors
/// [`Error::Labels`], [`Error::LabelSource`], [`Error::NoLabel`] (unless holes may stay), those of [`Start::check`],
/// and too little memory.
///
/// # Optimality
/// With two labels everywhere and prices that are a metric, the least price of all. With more, that of all seams never
/// rises, and no single expansion lowers it in the end. Measured against every labelling of 3x3 with three labels: the
/// tests say how often it is the least of all, and how far from it the worst case is.
///
/// # Complexity
/// With two labels and nothing that stands, one cut. Else a cut a label and sweep over the box of the positions that
/// may change; boxes without a change since a label last failed there are skipped. Space: about 90 bytes a sample of
/// the largest box, 8 of the output, and [`SeamCosts`](selvedge_core::SeamCosts).
///
/// # Events
/// `"labels"` after each expansion that changed something, with the price of all seams and the map.
///
/// # Determinism
/// The answer follows from the arguments alone, without any draw.
pub fn expand<const D: usize>(
    exemplars: &Exemplars<D>,
    start: Start<D>,
    labels: &[Label<D>],
    options: &LabelOptions<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, LabelStats>, Error> {
    options.validate(labels, exemplars.sources().len(), start.map.domain())?;
    start.check(exemplars)?;
    let output = start.map.domain();
    run.limits.admit(output, estimate_labels(&exemplars.domains(), exemplars.channels(), output))?;
    expand_by(exemplars, &SeamCosts::new(exemplars, options.seam)?, start, labels, options, run)
}

/// An upper bound of the bytes that [`expand`](crate::labels::expand) holds besides the exemplars themselves.
pub fn estimate_labels<const D: usize>(sources: &[Domain<D>], channels: usize, output: Domain<D>) -> Bytes {
    let samples: Bytes = sources.iter().map(|s| Bytes::of_samples(*s, 1)).sum();
    // Prices of seams; the map, its labels, and an expansion over all of it, of which arcs grow with the axes: of five
    // photographs of 1 MP 89 bytes a sample are seen.
    SeamCosts::<D>::bytes(samples, channels) + Bytes::of_samples(output, 66 + 26 * D as u64) + Bytes(1 << 20)
}

/// [`expand`], of what was checked, with prices that are known.
pub(super) fn expand_by<const D: usize>(
    exemplars: &Exemplars<D>,
    costs: &SeamCosts<D>,
    start: Start<D>,
    labels: &[Label<D>],
    options: &LabelOptions<D>,
    run: &Run<'_, D>,
) -> Result<Woven<SourceMap<D>, LabelStats>, Error> {
    if let Some(woven) = cut(exemplars, costs, &start, labels, options, run)? {
        return Ok(woven);
    }
    let mut sweeps = Sweeps::new(exemplars, costs, None, start, labels, options, run)?;
    let complete = sweeps.run_to_end()?;
    Ok(sweeps.answer(complete))
}

/// Two labels where nothing stands are one cut, and that is the best there is: sweeps take at least three to find as
/// cheap a one. `None` unless the cut is exact, and if the run was cancelled.
fn cut<const D: usize>(
    exemplars: &Exemplars<D>,
    costs: &SeamCosts<D>,
    start: &Start<D>,
    labels: &[Label<D>],
    options: &LabelOptions<D>,
    run: &Run<'_, D>,
) -> Result<Option<Woven<SourceMap<D>, LabelStats>>, Error> {
    let output = start.map.domain();
    if labels.len() != 2 || start.fixed.is_some() || start.sources.is_some() || start.map.holes() < output.len() {
        return Ok(None);
    }
    let Some(mut two) = Two::new(exemplars, costs, output, labels, options)? else { return Ok(None) };
    match two.cut(&try_vec(output.len(), NONE)?, &|| run.observer.cancelled()) {
        Err(error) if error.is_cancelled() => return Ok(None),
        other => other?,
    }
    let (standing, mut map) = (two.into_labels(), SourceMap::unassigned(exemplars, output)?);
    let sets = Sets::of(exemplars, labels, options, output, None);
    for (id, (at, &label)) in map.ids.plane_mut(0).iter_mut().zip(output.positions().zip(&standing)) {
        if label != NONE {
            *id = sets.sample(usize::from(label), at.map(|p| p as i32));
        }
    }
    let (shown, holes) = (shown(&standing, 2), map.holes());
    let energy = vec![price_of(costs, options.own.as_ref(), &map, &standing)];
    let event = Event { energy: energy.last().copied(), so_far: Some(&map), ..Event::step("labels", 1, 0) };
    run.observer.event(&event);
    let stats = LabelStats { shown, holes, energy, sweeps: 1, expansions: 1, ..LabelStats::default() };
    Ok(Some(Woven { result: map, stats, complete: true }))
}

#[cfg(test)]
mod tests;
