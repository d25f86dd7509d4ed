//! `selvedge compare`: by how much two pictures differ.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use selvedge_core::{Bytes, Depth, Domain, Grid, Plane, Role, Samples};
use selvedge_graphcut_textures::video::step;
use selvedge_io::clip::ClipOptions;
use selvedge_io::{Format, Info, Metadata, ReadOptions};
use serde_json::json;

use crate::clips::ClipInput;
use crate::failure::{Failure, n, shown};
use crate::harmonise::{Layout, alike, common_layout, converted, widened};
use crate::inputs::{self, Input};
use crate::memory;
use crate::options::NonFinite;
use crate::outputs::{self, Outputs};
use crate::report::{Done, Report};
use crate::session::Session;
use crate::stdio::STREAM;
use crate::wrong::Wrong;

/// Options of `compare`.
#[derive(Args, Debug)]
pub(crate) struct Compare {
    /// One picture; with --loop, a clip.
    #[arg(value_name = "A", value_hint = ValueHint::FilePath)]
    a: PathBuf,
    /// Another one of the same size.
    #[arg(value_name = "B", required_unless_present = "looped", value_hint = ValueHint::FilePath)]
    b: Option<PathBuf>,
    /// Exit with 1 if the clip does not close: if the step from its last frame to its first one, of the whole or of a
    /// block of 16x16 px, is larger than 99 of 100 of its own.
    #[arg(long = "loop", conflicts_with_all = ["b", "fail", "fail_percent", "hard_fail", "psnr", "diff"])]
    looped: bool,
    /// A pixel fails if it differs by more than this in any channel. Integers count from 0 to 1.
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = not_negative)]
    fail: f64,
    /// Exit with 1 if more than this percentage of the pixels fail.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = not_negative)]
    fail_percent: f64,
    /// Exit with 1 if any pixel differs by more than this.
    #[arg(long, value_name = "T", value_parser = not_negative)]
    hard_fail: Option<f64>,
    /// Exit with 1 if the peak signal-to-noise ratio is below this many decibels.
    #[arg(long, value_name = "DB", value_parser = not_negative)]
    psnr: Option<f64>,
    /// Write the differences as a picture; the greatest one is white.
    #[arg(long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    diff: Option<PathBuf>,
    #[command(flatten)]
    nonfinite: NonFinite,
}

/// Refuses a clip: of its frames one alone would be seen.
fn still(path: &Path, options: &ReadOptions) -> Result<(), Failure> {
    if path.as_os_str() == STREAM || inputs::is_pipe(path) {
        return Ok(());
    }
    let Some(clip) = ClipInput::found(path, options)? else { return Ok(()) };
    let frames = n("frame", clip.info().frames as usize);
    let failure = Failure::new(3, format!("is a clip of {frames}, and pictures are compared")).about(path);
    Err(failure.remedy("give one of its frames, or use --loop to ask whether it closes"))
}

fn not_negative(text: &str) -> Result<f64, Wrong> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && 0.0 <= number => Ok(number),
        _ => Err(Wrong::new(format!("'{text}' is out of range"), "write a number of at least 0")),
    }
}

impl Compare {
    /// Runs the command.
    pub(crate) fn run(&self, session: &Session<'_>) -> Result<Done, Failure> {
        let mut report = Report::new("compare");
        let b = match &self.b {
            Some(b) if !self.looped => b,
            _ => return self.closes(session, report),
        };
        let files = [self.a.clone(), b.clone()];
        inputs::check_streams(&files)?;
        let format = self.diff.as_ref().map(|path| outputs::format(path, None, None)).transpose()?;
        outputs::check(session, self.diff.as_slice(), &files)?;
        let [a, b] = self.read(session, b, format, &mut report)?;
        report.stage("read");
        let difference = Difference::of(&a, &b, self.fail);
        report.stage("compare");
        let mut outputs = Outputs::default();
        if let (Some(path), Some(format), false) = (&self.diff, format, session.global.dry_run) {
            let plane = picture(session, path, format, &a, &b, &difference)?;
            outputs.picture(path, format, &plane, &Metadata::default())?;
            report.stage("write");
        }
        let over = self.over(&difference);
        report.options = session.options.clone().without("loop");
        report.stats = difference.json(over);
        let verdict = if over { "differ" } else { "agree" };
        let text = format!("{} {}: {verdict}\n{}", shown(&self.a), shown(&files[1]), difference.text(&a));
        report.outputs.extend(outputs.noted());
        Ok(Done { exit: over.into(), outputs, ..Done::answered(report, text) })
    }

    /// Both pictures in one depth and with the same channels.
    fn read(
        &self,
        session: &Session<'_>,
        path: &Path,
        diff: Option<Format>,
        report: &mut Report,
    ) -> Result<[Plane<2>; 2], Failure> {
        let options = inputs::options(session.limits, Role::Color, self.nonfinite);
        [&self.a, path].into_iter().try_for_each(|path| still(path, &options))?;
        let inputs = [Input::new(session, &self.a)?, Input::new(session, path)?];
        let infos = [inputs[0].probe(&options)?, inputs[1].probe(&options)?];
        let [[w, h], [bw, bh]] = [0, 1].map(|i| [infos[i].width, infos[i].height]);
        if [h, w] != [bh, bw] {
            let what = format!("{bw}x{bh} px, but '{}' has {w}x{h} px", shown(&self.a));
            return Err(Failure::new(3, what).about(path).remedy("give pictures of the same size"));
        }
        let [a_layout, b_layout] = [0, 1].map(|i| Layout::of(&infos[i]));
        let common = common_layout([(self.a.as_path(), a_layout), (path, b_layout)])?;
        let depth = deeper(infos[0].depth, infos[1].depth);
        let needed = need(&infos, common, depth, diff);
        memory::check_fixed(&session.limits, needed)?;
        report.estimate = Some(needed.0);
        let read = |input: &Input, report: &mut Report| {
            let picture = input.read(session, &options, report)?;
            Ok::<_, Failure>((picture.plane, picture.metadata))
        };
        let ((a, a_tags), (b, b_tags)) = (read(&inputs[0], report)?, read(&inputs[1], report)?);
        if infos[0].depth != infos[1].depth || a_layout != b_layout {
            session.warn(path, &"its depth or its channels are others; both are compared in the wider ones");
        }
        let wide = |path, plane, tags| converted(session, path, widened(plane, common)?, depth, (tags, 0.0));
        let both = vec![wide(&self.a, a, &a_tags)?, wide(path, b, &b_tags)?];
        let both = alike(session, &[self.a.clone(), path.to_path_buf()], both)?;
        Ok(both.try_into().expect("two"))
    }

    /// Whether a clip closes.
    fn closes(&self, session: &Session<'_>, mut report: Report) -> Result<Done, Failure> {
        let frame = inputs::options(session.limits, Role::Color, self.nonfinite);
        outputs::check::<&Path>(session, &[], std::slice::from_ref(&self.a))?;
        let clip = ClipInput::open(session, &self.a, &ClipOptions { frame, ..ClipOptions::default() })?;
        let needed = memory::PROGRAM + clip.bytes() + memory::sources(&[clip.domain()], clip.info().channels);
        memory::check_fixed(&session.limits, needed)?;
        report.estimate = Some(needed.0);
        let clip = clip.read(session, &mut report)?;
        report.stage("read");
        let exemplars = clip.exemplars()?;
        let features = &exemplars.sources()[0].features;
        let usual = clip.usual(features)?;
        let closure = usual.closure(std::iter::once(step(features, clip.info.frames - 1, 0)));
        report.stage("compare");
        report.options = session.options.clone();
        report.stats = json!({
            "frames": clip.info.frames,
            "closes": closure.closes(),
            "whole": closure.whole,
            "block": closure.block,
        });
        let verdict = if closure.closes() { "closes" } else { "does not close" };
        let text = format!(
            "{}: {verdict}\n  step from the last frame to the first: {:.3} of what is usual, {:.3} in the worst block\n",
            shown(&self.a),
            closure.whole,
            closure.block
        );
        Ok(Done { exit: (!closure.closes()).into(), ..Done::answered(report, text) })
    }

    fn over(&self, difference: &Difference) -> bool {
        let failing = 100.0 * difference.failing as f64 / difference.pixels as f64;
        self.fail_percent < failing
            || self.hard_fail.is_some_and(|most| most < difference.greatest)
            || self.psnr.is_some_and(|least| difference.psnr().is_some_and(|psnr| psnr < least))
    }
}

/// An upper bound of what it takes: both pictures, one more while they are made alike, and the picture of differences
/// with its file.
fn need(infos: &[Info; 2], common: Layout, depth: Depth, diff: Option<Format>) -> Bytes {
    let domain = Domain::open([infos[0].height, infos[0].width]);
    let both = memory::pictures(infos, common.channels(), depth);
    let alike = memory::picture(domain, common.channels(), depth);
    let drawn = |format| memory::outputs(domain, (common.colors, Depth::F16), format, false);
    memory::PROGRAM + both + memory::reading(infos).max(alike).then(diff.map_or(Bytes(0), drawn))
}

/// The depth in which both can be compared: floats where one of them is float.
fn deeper(a: Depth, b: Depth) -> Depth {
    let float = |depth| matches!(depth, Depth::F16 | Depth::F32);
    if float(a) == float(b) { a.max(b) } else { Depth::F32 }
}

/// By how much two pictures differ. Integers count from 0 to 1, floats as they are.
struct Difference {
    pixels: u64,
    /// Pixels that differ at all.
    different: u64,
    /// Pixels that differ by more than is allowed.
    failing: u64,
    greatest: f64,
    /// Channel and place of the greatest difference.
    at: (usize, [u32; 2]),
    mean: f64,
    mean_square: f64,
}

impl Difference {
    fn of(a: &Plane<2>, b: &Plane<2>, allowed: f64) -> Self {
        let (n, channels) = (a.domain().len(), a.samples.channels());
        let mut found = Self {
            pixels: n as u64,
            different: 0,
            failing: 0,
            greatest: 0.0,
            at: (0, [0, 0]),
            mean: 0.0,
            mean_square: 0.0,
        };
        for i in 0..n {
            let mut most = 0.0_f64;
            for c in 0..channels {
                let d = difference(a, b, c, i);
                most = most.max(d);
                found.mean += d;
                found.mean_square += d * d;
                if found.greatest < d {
                    (found.greatest, found.at) = (d, (c, a.domain().position(i)));
                }
            }
            found.different += u64::from(0.0 < most);
            found.failing += u64::from(allowed < most);
        }
        let samples = (n * channels) as f64;
        Self { mean: found.mean / samples, mean_square: found.mean_square / samples, ..found }
    }

    /// In decibels, for a peak of 1; `None` for equal pictures.
    fn psnr(&self) -> Option<f64> {
        (0.0 < self.mean_square).then(|| -10.0 * libm::log10(self.mean_square))
    }

    fn json(&self, over: bool) -> serde_json::Value {
        let (channel, [y, x]) = self.at;
        json!({
            "over": over,
            "greatest": self.greatest,
            "greatest_at": (self.different != 0).then(|| json!({"x": x, "y": y, "channel": channel})),
            "mean": self.mean,
            "root_mean_square": self.mean_square.sqrt(),
            "psnr_db": self.psnr(),
            "pixels": self.pixels,
            "different_pixels": self.different,
            "failing_pixels": self.failing,
        })
    }

    fn text(&self, plane: &Plane<2>) -> String {
        let Some(psnr) = self.psnr() else { return "  equal in every sample\n".to_owned() };
        let steps = max(plane).map_or(String::new(), |max| format!(" ({:.0} of {max})", self.greatest * max));
        let (channel, [y, x]) = self.at;
        let percent = |part: u64| 100.0 * part as f64 / self.pixels as f64;
        [
            format!("  greatest difference: {:.6}{steps} at x={x} y={y} in channel {channel}\n", self.greatest),
            format!("  mean difference: {:.6}\n  psnr: {psnr:.2} dB\n", self.mean),
            format!("  different: {} of {} px, {:.2} %\n", self.different, self.pixels, percent(self.different)),
            format!("  failing: {} px, {:.2} %\n", self.failing, percent(self.failing)),
        ]
        .concat()
    }
}

/// The greatest integer of a depth.
fn max(plane: &Plane<2>) -> Option<f64> {
    match plane.samples.depth() {
        Depth::U8 => Some(255.0),
        Depth::U16 => Some(65_535.0),
        Depth::F16 | Depth::F32 => None,
    }
}

fn difference(a: &Plane<2>, b: &Plane<2>, channel: usize, index: usize) -> f64 {
    (a.samples.value(channel, index) - b.samples.value(channel, index)).abs() / max(a).unwrap_or(1.0)
}

/// Differences of the colour channels, the greatest of all white.
fn picture(
    session: &Session<'_>,
    path: &Path,
    format: Format,
    a: &Plane<2>,
    b: &Plane<2>,
    found: &Difference,
) -> Result<Plane<2>, Failure> {
    let gain = if found.greatest == 0.0 { 0.0 } else { 255.0 / found.greatest };
    let mut samples = Grid::try_filled(Domain::open(a.domain().shape), a.color_channels(), 0_u8)?;
    for c in 0..a.color_channels() {
        for (i, to) in samples.plane_mut(c).iter_mut().enumerate() {
            *to = (difference(a, b, c, i) * gain + 0.5) as u8;
        }
    }
    let plane = Plane::new(Role::Color, Samples::U8(samples));
    match format.depths() {
        [Depth::F16, ..] => converted(session, path, plane, Depth::F16, (&Metadata::default(), 0.0)),
        _ => Ok(plane),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(values: &[u8]) -> Plane<2> {
        let domain = Domain::open([1, values.len() as u32]);
        Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 1, values.to_vec()).unwrap()))
    }

    #[test]
    fn differences_are_counted_and_placed() {
        let found = Difference::of(&plane(&[0, 10, 255, 7]), &plane(&[0, 61, 255, 6]), 0.1);
        assert_eq!((found.different, found.failing, found.at), (2, 1, (0, [0, 1])));
        assert!((found.greatest - 0.2).abs() < 1e-12);
        assert!((found.mean - 52.0 / 255.0 / 4.0).abs() < 1e-12);
        let mean_square = (51.0_f64 * 51.0 + 1.0) / (255.0 * 255.0) / 4.0;
        assert!((found.psnr().unwrap() + 10.0 * libm::log10(mean_square)).abs() < 1e-9);
    }

    #[test]
    fn equal_pictures_have_no_ratio() {
        let found = Difference::of(&plane(&[1, 2]), &plane(&[1, 2]), 0.0);
        assert_eq!((found.psnr(), found.different), (None, 0));
    }
}
