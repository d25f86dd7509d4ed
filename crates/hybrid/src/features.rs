//! Features of sources: those of a sample side by side, and how far those of a place are from what is known.

use selvedge_core::{Error, Exemplars, Look, Window, try_vec};
use selvedge_quilting::search::Candidate;

/// Features of all sources, the channels of a sample side by side.
pub(crate) fn side_by_side(exemplars: &Exemplars<2>) -> Result<Vec<u8>, Error> {
    let channels = exemplars.channels();
    let mut features = try_vec(exemplars.table().len() as usize * channels, 0)?;
    for (s, source) in exemplars.sources().iter().enumerate() {
        let first = exemplars.table().first(s) as usize * channels;
        for c in 0..channels {
            let to = features[first + c..].iter_mut().step_by(channels);
            to.zip(source.features.plane(c)).for_each(|(to, &from)| *to = from);
        }
    }
    Ok(features)
}

/// By sample of a window, how much the chosen place differs from what is known; 0 elsewhere.
pub(crate) fn errors_of(
    exemplars: &Exemplars<2>,
    look: &Look,
    window: &Window<2>,
    chosen: Candidate,
) -> Result<Vec<u64>, Error> {
    let source = &exemplars.sources()[chosen.source];
    let (local, domain) = (window.local(), source.domain());
    let mut errors = try_vec(local.len(), 0_u64)?;
    let square = |a: u8, b: u8, weight: u8| u64::from(u32::from(a.abs_diff(b)).pow(2) * u32::from(weight));
    let [_, width] = local.shape.map(|n| n as usize);
    let is_inside = (0..2).all(|a| chosen.at[a] + window.shape[a] <= domain.shape[a]);
    for (c, &weight) in exemplars.weights().iter().enumerate() {
        let (old, new) = (&look.features()[c * local.len()..][..local.len()], source.features.plane(c));
        if is_inside && 0 < width {
            // Row by row, which is several times as fast.
            let rows =
                errors.chunks_exact_mut(width).zip(old.chunks_exact(width)).zip(look.known().chunks_exact(width));
            for (y, ((errors, old), known)) in (chosen.at[0]..).zip(rows) {
                let new = &new[domain.index([y, chosen.at[1]])..][..width];
                for (((error, &old), &new), &known) in errors.iter_mut().zip(old).zip(new).zip(known) {
                    *error += if known { square(old, new, weight) } else { 0 };
                }
            }
            continue;
        }
        let places = Window { start: chosen.at.map(|v| v as i32), shape: window.shape }.places(domain);
        for (i, place) in places.enumerate().filter(|&(i, _)| look.known()[i]) {
            errors[i] += place.map_or(0, |place| square(old[i], new[place], weight));
        }
    }
    Ok(errors)
}
