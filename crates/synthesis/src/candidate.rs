//! What may be made of exemplars: a method with its options.

use crate::error::Error;
use crate::sizes::shortest;
use selvedge_analysis::Texture;
use selvedge_core::{Bytes, Domain, Exemplars, Run, SourceMap, Woven};
use selvedge_graphcut_textures as graphcut;
use std::fmt::Debug;

/// The options that a method used, by the names of their flags, with every choice of its own made.
pub type Used = Vec<(&'static str, String)>;

/// One way to make an output. A method joins by being one.
pub trait Candidate: Debug + Send + Sync {
    /// The method's command.
    fn method(&self) -> &'static str;

    /// What tells at a fraction of the work what this one will be worth; `None` if nothing does.
    fn draft(&self) -> Option<Box<dyn Candidate>>;

    /// Bytes that making it needs beside exemplars and output; of exemplars without `masked` samples mostly less.
    fn memory(&self, exemplars: &[Domain<2>], channels: usize, output: Domain<2>, masked: bool) -> Bytes;

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

/// A graph cut.
#[derive(Clone, Debug)]
pub struct Graphcut(pub graphcut::Options<2>);

impl Candidate for Graphcut {
    fn method(&self) -> &'static str {
        "graphcut"
    }

    /// Covered, but its seams not settled: a sixth of the work (three textures). That drafts are preferred as what
    /// becomes of them is a guess: of most of 24 textures preferences are near each other.
    fn draft(&self) -> Option<Box<dyn Candidate>> {
        let draft = graphcut::Options { refine: Some(0), ..self.0 };
        (self.0.refine != Some(0)).then(|| Box::new(Self(draft)) as Box<dyn Candidate>)
    }

    fn memory(&self, exemplars: &[Domain<2>], channels: usize, output: Domain<2>, masked: bool) -> Bytes {
        let estimate = if masked { graphcut::estimate } else { graphcut::estimate_whole };
        estimate(exemplars, channels, output, &self.0)
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
        used.extend((0 < stats.apart).then(|| ("apart", stats.apart.to_string())));
        used.extend((1 < stats.levels).then(|| ("levels", stats.levels.to_string())));
        used.extend(self.0.refine.map(|n| ("refine", n.to_string())));
        used.extend([("patience", self.0.patience.to_string()), ("tries", self.0.tries.to_string())]);
        Ok(Woven { result: woven.result, stats: used, complete: woven.complete })
    }
}

/// True if some exemplar is better laid by how whole patches agree.
pub(crate) fn is_orderly(exemplars: &Exemplars<2>) -> Result<bool, Error> {
    Ok(Texture::of_each(exemplars).map_err(Error::Analysis)?.iter().any(Texture::is_orderly))
}

/// What is tried of exemplars, the likeliest first: graph cuts by default, which know the kind of the texture and how
/// much larger the output is, and regions between theirs and the whole exemplar, with as much reach.
///
/// Two readers ranked such candidates of 24 textures at twice the sides and of ten at four times, blind. Quilts, with
/// blocks of three eighths and a half, were last but one of six: preference takes them too often, so they are not among
/// these. Whole patches are not where many copies would show, however much preference likes them there.
pub(crate) fn of_kind(exemplars: &Exemplars<2>, orderly: bool) -> Vec<Box<dyn Candidate>> {
    // The exemplar that is longest on its lesser side holds a region of that side.
    let between = Some([(shortest(exemplars).max().unwrap_or(1) * 3 / 8).max(1); 2]);
    let second = if orderly {
        graphcut::Options { placement: graphcut::Placement::Entire, reach: between, ..Default::default() }
    } else {
        graphcut::Options { placement: graphcut::Placement::Sub, region: between, reach: between, ..Default::default() }
    };
    [graphcut::Options::default(), second].map(|options| Box::new(Graphcut(options)) as Box<dyn Candidate>).into()
}
