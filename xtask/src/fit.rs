//! The coefficients of `selvedge_metrics::preference`, made again.

use crate::outcome::Outcome;
use selvedge_metrics::{MAPPED, PICTURE, fit};

/// Where the table lies.
const TABLE: &str = "crates/metrics/data/rankings.csv";

/// Prints the coefficients and how far they agree with readers; an error if the source has others.
pub(crate) fn run(_: &[String]) -> Outcome {
    let table = std::fs::read_to_string(TABLE).map_err(|e| format!("{TABLE}: {e}"))?;
    let fitted = fit(&table).map_err(|why| format!("{TABLE}: {why}"))?;
    println!("pub const MAPPED: Model = {:.3?};", fitted.mapped);
    println!("pub const PICTURE: Model = {:.3?};", fitted.picture);
    let percent =
        |[mapped, picture]: [f64; 2]| format!("{:.1} % with maps, {:.1} % without", 100.0 * mapped, 100.0 * picture);
    println!("held-out exemplars agree in {}", percent(fitted.held_out));
    println!("and those of the second reader, by the first, in {}", percent(fitted.across));
    println!("the readers agree with each other in {:.1} %", 100.0 * fitted.readers);
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3);
    if near(&fitted.mapped, &MAPPED) && near(&fitted.picture, &PICTURE) {
        return Ok(());
    }
    Err("crates/metrics/src/preference.rs has other coefficients; write these there".to_owned())
}
