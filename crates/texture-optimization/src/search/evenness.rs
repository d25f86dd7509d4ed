//! What was used often counts less: outputs that use their exemplars evenly. (Kaspar et al. 2015; Jamriska et al. 2015)

use selvedge_core::{Exemplars, Usage};
use selvedge_fft_ssd::{Coverage, Windows};

use crate::assignment::Place;
use crate::neighborhoods::places;

/// What stands for an error of a place by which nothing is divided: large beside rounding, small beside 64 bits.
const EVEN: f64 = (1_u64 << 32) as f64;

/// Times that an error of a place counts.
pub(super) fn times(uses: &Usage<2>, place: Place) -> f64 {
    uses.counted(1, place.source as usize, place.at) as f64 / 1000.0
}

/// What errors are divided by, for a search: by `of`, or nothing, and less where a place was used more often.
pub(super) fn counted(exemplars: &Exemplars<2>, size: u32, of: Option<(&Coverage, f64)>, uses: &Usage<2>) -> Coverage {
    let added = of.map(|(coverage, alpha)| coverage.added(alpha));
    let sources = exemplars.sources().iter().enumerate().map(|(s, source)| {
        let over = Windows { side: size, step: 1 }.over(source.domain());
        let mut least = vec![u64::MAX; over.len()];
        for at in places(source, size) {
            let i = over.index(at);
            let divisor = of.zip(added).map_or(EVEN, |((coverage, _), added)| coverage.least(s)[i] as f64 + added);
            least[i] = (divisor / times(uses, Place { source: s as u32, at })) as u64;
        }
        least
    });
    Coverage::told(sources.collect())
}
