//! What may be made of exemplars: a method with its options.

use crate::error::Error;
use selvedge_core::{Domain, Exemplars, Run, SourceMap, Woven};
use selvedge_graphcut_textures as graphcut;
use selvedge_quilting as quilting;
use std::fmt::Debug;

/// The options that a method used, by the names of their flags, with every choice of its own made.
pub type Used = Vec<(&'static str, String)>;

/// One way to make an output. A method joins by being one.
pub trait Candidate: Debug + Send + Sync {
    /// The method's command.
    fn method(&self) -> &'static str;

    /// About how much work it is, in steps of about a nanosecond on one thread: what [`Options::effort`](crate::Options::effort) bounds.
    /// From sizes alone, so that the same candidates are made on every machine.
    fn work(&self, exemplars: &Exemplars<2>, output: Domain<2>) -> u64;

    /// Bytes that making it needs beside exemplars and output.
    fn memory(&self, exemplars: &[Domain<2>], channels: usize, output: Domain<2>) -> u64;

    /// Makes it.
    ///
    /// # Errors
    /// Those of the method.
    fn weave(
        &self,
        exemplars: &Exemplars<2>,
        output: Domain<2>,
        run: &Run<'_, 2>,
    ) -> Result<Woven<SourceMap<2>, Used>, Error>;
}

/// A quilt.
#[derive(Clone, Debug)]
pub struct Quilt(pub quilting::Options);

impl Candidate for Quilt {
    fn method(&self) -> &'static str {
        "quilt"
    }

    /// Each block is searched at every position: 8 ns each, as measured with blocks of 48 and 96 in 192^2.
    fn work(&self, exemplars: &Exemplars<2>, output: Domain<2>) -> u64 {
        let side = shortest(exemplars);
        let block = self.0.block.unwrap_or(side / 4).max(2);
        let step = u64::from(block - self.0.overlap.unwrap_or(block / 4).min(block - 1));
        (area(output) / (step * step) + 1).saturating_mul(8 * samples(exemplars))
    }

    fn memory(&self, exemplars: &[Domain<2>], channels: usize, output: Domain<2>) -> u64 {
        quilting::estimate(exemplars, channels, output, &self.0)
    }

    fn weave(
        &self,
        exemplars: &Exemplars<2>,
        output: Domain<2>,
        run: &Run<'_, 2>,
    ) -> Result<Woven<SourceMap<2>, Used>, Error> {
        let woven = quilting::quilt(exemplars, output, &self.0, run)?;
        let lower = |name: String| name.to_lowercase();
        let used = vec![
            ("block", woven.stats.block.to_string()),
            ("overlap", woven.stats.overlap.to_string()),
            ("tolerance", self.0.tolerance.to_string()),
            ("stage", lower(format!("{:?}", self.0.stage))),
            ("continuation", lower(format!("{:?}", self.0.continuation))),
            ("spread", self.0.spread.to_string()),
        ];
        Ok(Woven { result: woven.result, stats: used, complete: woven.complete })
    }
}

/// A graph cut.
#[derive(Clone, Debug)]
pub struct Graphcut(pub graphcut::Options<2>);

impl Candidate for Graphcut {
    fn method(&self) -> &'static str {
        "graphcut"
    }

    /// Whole exemplars take 4.6 us an output sample until all is covered, and four times that until seams are settled;
    /// regions of a fourth 1 us, and five times that: as measured for 512^2 from 192^2, and by the exemplars' samples.
    fn work(&self, exemplars: &Exemplars<2>, output: Domain<2>) -> u64 {
        let each = if self.0.placement == graphcut::Placement::Entire { 4600 } else { 1000 };
        let refined = match self.0.refine {
            Some(0) => 1,
            _ => 5,
        };
        (area(output) * each * refined).saturating_mul(samples(exemplars)) / (192 * 192)
    }

    fn memory(&self, exemplars: &[Domain<2>], channels: usize, output: Domain<2>) -> u64 {
        graphcut::estimate(exemplars, channels, output, &self.0)
    }

    fn weave(
        &self,
        exemplars: &Exemplars<2>,
        output: Domain<2>,
        run: &Run<'_, 2>,
    ) -> Result<Woven<SourceMap<2>, Used>, Error> {
        let woven = graphcut::graphcut(exemplars, output, &self.0, run)?;
        let (lower, stats) = (|name: String| name.to_lowercase(), &woven.stats);
        let sides = |[down, across]: [u32; 2]| {
            if down == across { down.to_string() } else { format!("{across}x{down}") }
        };
        let mut used = vec![
            ("placement", lower(format!("{:?}", stats.placement))),
            ("seam", lower(format!("{:?}", self.0.seam))),
            ("region", sides(stats.region)),
            ("reach", sides(stats.reach)),
            ("randomness", self.0.randomness.to_string()),
            ("variety", stats.variety.to_string()),
        ];
        used.extend(self.0.refine.map(|n| ("refine", n.to_string())));
        used.extend([("patience", self.0.patience.to_string()), ("tries", self.0.tries.to_string())]);
        Ok(Woven { result: woven.result, stats: used, complete: woven.complete })
    }
}

/// What is tried of exemplars, likeliest first for its work: the settings that blind rankings preferred to the methods' defaults on 24
/// textures, and the defaults, which may know better of a kind. Quilts cost little; whole exemplars keep structure; regions of
/// a fourth show the fewest copies at large sizes; refined ones cost five times as much.
pub fn candidates(exemplars: &Exemplars<2>) -> Vec<Box<dyn Candidate>> {
    let side = shortest(exemplars);
    let quilt = |block: u32| {
        let (block, overlap) = (block.max(1), Some((block / 4).max(1)).filter(|_| 2 <= block));
        let continuation = quilting::Continuation::Allow;
        let options =
            quilting::Options { block: Some(block), overlap, continuation, spread: 0.25, ..Default::default() };
        Box::new(Quilt(options)) as Box<dyn Candidate>
    };
    let region = |refine: Option<u32>| {
        let fourth = Some([(side / 4).max(1); 2]);
        let options =
            graphcut::Options { region: fourth, reach: fourth, variety: Some(0.25), refine, ..Default::default() };
        Box::new(Graphcut(options)) as Box<dyn Candidate>
    };
    let entire = |refine: Option<u32>| {
        let (placement, reach) = (graphcut::Placement::Entire, Some([u32::MAX; 2]));
        let options = graphcut::Options { placement, reach, variety: Some(0.5), refine, ..Default::default() };
        Box::new(Graphcut(options)) as Box<dyn Candidate>
    };
    vec![
        quilt(side / 2),
        region(Some(0)),
        quilt(side * 3 / 8),
        entire(Some(0)),
        quilt(side / 4),
        Box::new(Quilt(quilting::Options::default())),
        region(None),
        Box::new(Graphcut(graphcut::Options::default())),
        entire(None),
    ]
}

/// The lesser side of the exemplar where that is longest: it holds a block of that side.
fn shortest(exemplars: &Exemplars<2>) -> u32 {
    let sides = exemplars.sources().iter().map(|s| s.domain().shape.into_iter().min().unwrap_or(1));
    sides.max().unwrap_or(1)
}

fn samples(exemplars: &Exemplars<2>) -> u64 {
    u64::from(exemplars.table().len())
}

fn area(output: Domain<2>) -> u64 {
    output.shape.iter().map(|&n| u64::from(n)).product()
}
