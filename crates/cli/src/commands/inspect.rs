//! `selvedge inspect`: what an exemplar is like, and what to try.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_analysis::{Period, periods};
use selvedge_core::{Exemplars, Role};
use selvedge_quilting::suggest_block;
use serde_json::{Value, json};

use crate::args::NonFiniteArg;
use crate::failure::{Failure, shown};
use crate::inputs::{self, Input};
use crate::outputs;
use crate::report::{Done, Report};
use crate::session::Session;
use crate::used::quoted;

/// Below this strength, in thousandths, an exemplar only resembles itself by chance.
const CLEAR: u32 = 300;

/// Options of `inspect`.
#[derive(Args, Debug)]
pub(crate) struct Inspect {
    /// A picture of the texture.
    #[arg(value_name = "EXEMPLAR", value_hint = ValueHint::FilePath)]
    exemplar: PathBuf,
    /// What becomes of float samples that are infinite or no numbers.
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = NonFiniteArg::Error)]
    nonfinite: NonFiniteArg,
}

impl Inspect {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("inspect");
        outputs::check::<&Path>(session, &[], std::slice::from_ref(&self.exemplar))?;
        let options = inputs::options(session.limits, Role::Color, self.nonfinite);
        let picture = Input::new(session, &self.exemplar)?.read(session, &options, &mut report)?;
        let plane = &picture.plane;
        let about = |failure: Failure| failure.about(&self.exemplar);
        let exemplars = Exemplars::of(&[std::slice::from_ref(plane)]).map_err(|e| about(e.into()))?;
        report.stage("read");
        let source = &exemplars.sources()[0];
        let found = periods(&source.features, source.valid.as_ref(), exemplars.weights());
        let lattice = lattice(&found.map_err(|e| about(e.into()))?);
        let block = suggest_block(&exemplars).map_err(|e| about(e.into()))?;
        report.stage("inspect");
        let ([h, w], format) = (plane.domain().shape, picture.format.name());
        let (channels, depth) = (plane.samples.channels(), plane.samples.depth().name());
        let command = self.command(format, block);
        report.stats = json!({
            "format": format,
            "width": w,
            "height": h,
            "channels": channels,
            "alpha": plane.alpha,
            "depth": depth,
            "periods": lattice.iter().map(json).collect::<Vec<_>>(),
            "block": block,
            "command": command,
        });
        let text = [
            format!("{}\n", shown(&self.exemplar)),
            format!("  {format}, {w}x{h} px, {channels} channel(s), {depth}\n"),
            format!("  period: {}\n", words(&lattice)),
            format!("  block: {block} px\n"),
            format!("  try: {command}\n"),
        ];
        Ok(Done::answered(report, text.concat()))
    }

    /// A command line to begin with: twice the size, into the same format.
    fn command(&self, format: &str, block: u32) -> String {
        let name = self.exemplar.to_string_lossy();
        let stem = self.exemplar.file_stem().unwrap_or_default().to_string_lossy();
        let extension = if matches!(format, "gif" | "bmp") { "png" } else { format };
        let output = quoted(&format!("{stem}-2x.{extension}"));
        format!("selvedge quilt {} -o {output} --size 2x --block {block}", quoted(&name))
    }
}

/// The strongest clear period, and the strongest that goes another way: between them they span the repetition.
fn lattice(found: &[Period<2>]) -> Vec<Period<2>> {
    let clear: Vec<Period<2>> = found.iter().copied().filter(|p| CLEAR <= p.strength).collect();
    let Some(&first) = clear.first() else { return Vec::new() };
    let other_way = |p: &&Period<2>| {
        let ([ay, ax], [by, bx]) = (first.vector.map(f64::from), p.vector.map(f64::from));
        // The sine of the angle between them is over a quarter.
        0.25 * (ax * ax + ay * ay).sqrt() * (bx * bx + by * by).sqrt() < (ax * by - ay * bx).abs()
    };
    std::iter::once(first).chain(clear.iter().find(other_way).copied()).collect()
}

fn json(period: &Period<2>) -> Value {
    let [y, x] = period.vector;
    json!({"x": x, "y": y, "strength": f64::from(period.strength) / 1000.0})
}

fn words(lattice: &[Period<2>]) -> String {
    let one = |period: &Period<2>| {
        let strength = f64::from(period.strength) / 1000.0;
        match period.vector {
            [0, x] => format!("{x} px along x ({strength:.2})"),
            [y, 0] => format!("{y} px along y ({strength:.2})"),
            [y, x] => format!("x={x} y={y} px ({strength:.2})"),
        }
    };
    let words: Vec<String> = lattice.iter().map(one).collect();
    if words.is_empty() { "none that is clear".to_owned() } else { words.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn period(y: i32, x: i32, strength: u32) -> Period<2> {
        Period { vector: [y, x], strength }
    }

    #[test]
    fn a_lattice_has_two_directions() {
        let found = [period(0, 8, 990), period(0, 16, 980), period(1, 24, 970), period(12, 4, 700), period(5, 0, 200)];
        assert_eq!(lattice(&found), [found[0], found[3]]);
        assert_eq!(words(&lattice(&found)), "8 px along x (0.99), x=4 y=12 px (0.70)");
        assert_eq!(words(&lattice(&found[4..])), "none that is clear");
    }
}
