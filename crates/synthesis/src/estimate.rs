//! How much memory a run needs.

use selvedge_core::{Bytes, Domain, ErrorKind, Exemplars, Limits, par};
use selvedge_graphcut_textures as graphcut;

use crate::candidate::of_kind_by;
use crate::error::Error;
use crate::sizes::Sizes;
use crate::{Options, SEEN, mend};

/// Bytes that [`synthesize`](crate::synthesize) needs at most on the threads of this pool: what candidates and
/// comparisons hold at once, the best map, and what each candidate shows. The run itself holds each of its candidates
/// against the limits, not all that are made at once.
///
/// # Errors
/// Those of [`synthesize`](crate::synthesize) that are known before the work.
pub fn estimate(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    options: &Options,
    limits: &Limits,
) -> Result<Bytes, Error> {
    let [drafts, finished] = options.steps()?;
    let is_compared = 0 < drafts && output.shape.iter().all(|&n| selvedge_metrics::LEAST <= n);
    let sizes = if is_compared { Sizes::new(exemplars, output)? } else { Sizes::default() };
    let (small, to, channels) = (sizes.small(exemplars), sizes.output(output), exemplars.channels() as u64);
    let sampled = |of: &Exemplars<2>, each: u64| -> Bytes {
        of.domains().into_iter().map(|domain| Bytes::of_samples(domain, each)).sum()
    };
    // Features, half and quarter sizes, words, running answers: what the measures hold.
    let scoring = Bytes::of_samples(to, 12 + 4 * channels) + sampled(small, channels);
    // So many at once, of which the dearest kind: which it is takes a look at all of an exemplar, levels and regions do
    // not follow from it.
    let stage = |of: &Exemplars<2>, output: Domain<2>, number: usize| -> Result<Bytes, Error> {
        let usual = graphcut::Options::default();
        let whole = graphcut::Options { placement: graphcut::Placement::Entire, apart: Some(0), ..usual };
        let first = graphcut::plan(of, output, None, &whole, limits)?.chosen();
        let mut most = Bytes(0);
        for candidate in [false, true].into_iter().flat_map(|orderly| of_kind_by(of, orderly, first)) {
            match candidate.memory(of, output, limits) {
                // It is left out.
                Err(e) if matches!(e.kind(), ErrorKind::Option | ErrorKind::Input) => {}
                bytes => most = most.max(bytes?),
            }
        }
        let each = most.then(scoring) + Bytes::of_samples(output, 12);
        let measured = graphcut::measuring(&of.domains(), of.channels(), of.is_masked(), &usual);
        Ok(measured.then(each * number.min(par::threads()).max(1) as u64))
    };
    let made = if sizes.are_several() {
        stage(exemplars, output, finished)?.max(stage(small, to, drafts)?)
    } else {
        stage(exemplars, output, if is_compared { drafts.max(finished) } else { finished })?
    };
    let mends = options.mend && is_compared && mend::is_affordable(exemplars, output);
    let mending = if mends { mend::memory(exemplars, output).then(scoring) } else { Bytes(0) };
    let halves: Bytes = sizes.halves().iter().map(|half| sampled(half, channels + 1)).sum();
    let shown = Domain::open(output.shape.map(|side| side.min(SEEN)));
    let pictures = Bytes::of_samples(shown, channels) * (drafts + finished + usize::from(mends)) as u64;
    // Drafts that wait to be finished: a map, and the patches that were laid, one for 16 samples at most; where masks
    // leave single samples one for each.
    let masked = exemplars.is_masked();
    let waiting = Bytes::of_samples(to, if masked { 4 + 32 } else { 12 }) * finished as u64;
    let judge = if is_compared { sampled(small, 40) } else { Bytes(0) };
    Ok(halves + judge + made.then(mending) + waiting + Bytes::of_samples(output, 4) + pictures)
}
