//! What may be made of exemplars: a method with its options.

use crate::error::Error;
use crate::sizes::shortest;
use selvedge_core::{Bytes, Domain, Exemplars, Limits, Run, SourceMap, Woven};
use selvedge_graphcut_textures as graphcut;
use std::fmt::Debug;

/// The options that a method used, by the names of their flags, with every choice of its own made.
pub type Settings = Vec<(&'static str, String)>;

/// One way to make an output. A method joins by being one.
pub trait Candidate: Debug + Send + Sync {
    /// The method's command.
    fn method(&self) -> &'static str;

    /// Makes what tells at a fraction of the work what this one will be worth.
    ///
    /// # Errors
    /// Those of the method.
    fn draft(&self, exemplars: &Exemplars<2>, output: Domain<2>, run: &Run<'_, 2>) -> Result<Draft, Error>;

    /// Bytes that making it needs at most beside exemplars and output.
    ///
    /// # Errors
    /// Those of the method that are known before the work.
    fn memory(&self, exemplars: &Exemplars<2>, output: Domain<2>, limits: &Limits) -> Result<Bytes, Error>;

    /// Makes it.
    ///
    /// # Errors
    /// Those of the method.
    fn weave(
        &self,
        exemplars: &Exemplars<2>,
        output: Domain<2>,
        run: &Run<'_, 2>,
    ) -> Result<Woven<SourceMap<2>, Settings>, Error>;
}

/// What tells what a candidate will be worth.
#[derive(Debug)]
pub struct Draft {
    /// What it has come to.
    pub woven: Woven<SourceMap<2>, Settings>,
    /// How it is finished; `None` if it is.
    pub rest: Option<Box<dyn Rest>>,
}

/// What is left to do of a candidate after its draft.
pub trait Rest: Debug + Send {
    /// The method's command.
    fn method(&self) -> &'static str;

    /// Makes what the candidate's [`weave`](Candidate::weave) would, of the same exemplars, output and run.
    ///
    /// # Errors
    /// Those of the method.
    fn finish(
        self: Box<Self>,
        exemplars: &Exemplars<2>,
        run: &Run<'_, 2>,
    ) -> Result<Woven<SourceMap<2>, Settings>, Error>;
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
    fn draft(&self, exemplars: &Exemplars<2>, output: Domain<2>, run: &Run<'_, 2>) -> Result<Draft, Error> {
        if self.0.refine == Some(0) {
            return Ok(Draft { woven: self.weave(exemplars, output, run)?, rest: None });
        }
        let covered = graphcut::cover(exemplars, output, &self.0, run)?;
        let woven = Woven {
            result: copied(&covered.woven.result)?,
            stats: used(&graphcut::Options { refine: Some(0), ..self.0 }, &covered.woven.stats),
            complete: covered.woven.complete,
        };
        Ok(Draft { woven, rest: Some(Box::new(Seams { covered, options: self.0 })) })
    }

    fn memory(&self, exemplars: &Exemplars<2>, output: Domain<2>, limits: &Limits) -> Result<Bytes, Error> {
        // Which way of matching is chosen takes a look at all of an exemplar; whole ones take the most, and levels and
        // regions are the same.
        let entire = graphcut::Placement::Entire;
        let placement = if self.0.placement == graphcut::Placement::Auto { entire } else { self.0.placement };
        let options = graphcut::Options { placement, apart: self.0.apart.or(Some(0)), ..self.0 };
        let plan = graphcut::plan(exemplars, output, None, &options, limits)?;
        let masked = exemplars.is_masked();
        let chosen = graphcut::measuring(&exemplars.domains(), exemplars.channels(), masked, &self.0);
        Ok(chosen.then(plan.bytes()))
    }

    fn weave(
        &self,
        exemplars: &Exemplars<2>,
        output: Domain<2>,
        run: &Run<'_, 2>,
    ) -> Result<Woven<SourceMap<2>, Settings>, Error> {
        Ok(told(graphcut::graphcut(exemplars, output, &self.0, run)?, &self.0))
    }
}

/// A graph cut whose seams are left to refine.
#[derive(Debug)]
struct Seams {
    covered: graphcut::Covered<2>,
    options: graphcut::Options<2>,
}

impl Rest for Seams {
    fn method(&self) -> &'static str {
        "graphcut"
    }

    fn finish(
        self: Box<Self>,
        exemplars: &Exemplars<2>,
        run: &Run<'_, 2>,
    ) -> Result<Woven<SourceMap<2>, Settings>, Error> {
        Ok(told(self.covered.refine(exemplars, run)?, &self.options))
    }
}

fn told(
    woven: Woven<SourceMap<2>, graphcut::Stats<2>>,
    options: &graphcut::Options<2>,
) -> Woven<SourceMap<2>, Settings> {
    Woven { stats: used(options, &woven.stats), result: woven.result, complete: woven.complete }
}

/// The options of a graph cut with what it chose.
fn used(options: &graphcut::Options<2>, stats: &graphcut::Stats<2>) -> Settings {
    let lower = |name: String| name.to_lowercase();
    let sides = |[down, across]: [u32; 2]| if down == across { down.to_string() } else { format!("{across}x{down}") };
    let mut used = vec![
        ("placement", lower(format!("{:?}", stats.settings.placement))),
        ("seam", lower(format!("{:?}", options.seam))),
        ("region", sides(stats.settings.region)),
        ("reach", sides(stats.settings.reach)),
        ("randomness", options.randomness.to_string()),
        ("variety", stats.settings.variety.to_string()),
    ];
    used.extend((0 < stats.settings.apart).then(|| ("apart", stats.settings.apart.to_string())));
    // Who says how far patches lie apart has none that stutters unless that is said as well.
    let stutters = stats.settings.stutter != graphcut::Stutter::Never;
    used.extend(stutters.then(|| ("stutter", lower(format!("{:?}", stats.settings.stutter)))));
    used.extend((1 < stats.settings.levels).then(|| ("levels", stats.settings.levels.to_string())));
    used.extend(options.refine.map(|n| ("refine", n.to_string())));
    used.extend([("patience", options.patience.to_string()), ("tries", options.tries.to_string())]);
    used
}

/// What is tried of exemplars, the likeliest first: graph cuts by default, which know the kind of the texture and how
/// much larger the output is, and regions between theirs and the whole exemplar, with as much reach.
///
/// Two readers ranked such candidates of 24 textures at twice the sides and of ten at four times, blind. Quilts, with
/// blocks of three eighths and a half, were last but one of six: preference takes them too often, so they are not among
/// these. Whole patches are not where many copies would show, however much preference likes them there.
///
/// Which they are follows from what is measured, or from how `orderly` they are known to be; that is answered as well.
pub(crate) fn of_kind(
    exemplars: &Exemplars<2>,
    output: Domain<2>,
    orderly: Option<bool>,
    limits: &Limits,
) -> Result<(Vec<Box<dyn Candidate>>, bool), Error> {
    let usual = graphcut::Options::default();
    // Exemplars are measured here, once for all candidates.
    let plan = graphcut::plan(exemplars, output, None, &usual, limits)?;
    let orderly = orderly.unwrap_or(plan.settings.is_orderly);
    Ok((of_kind_by(exemplars, orderly, unbound(plan.chosen())), orderly))
}

/// Where patches may stutter once, they may as they like. Graph cuts by themselves are preferred with that rule, the
/// best of several are not: three readers of 18 textures at twice the sides preferred 26 with it, 25 without, and two
/// thirds of all 24 against texturize, reached without it, were not reached with it (docs/defaults.md).
fn unbound(first: graphcut::Options<2>) -> graphcut::Options<2> {
    if first.stutter != graphcut::Stutter::Once {
        return first;
    }
    graphcut::Options { apart: Some(0), stutter: graphcut::Stutter::Never, ..first }
}

/// The same, of which the first has these options.
pub(crate) fn of_kind_by(
    exemplars: &Exemplars<2>,
    orderly: bool,
    first: graphcut::Options<2>,
) -> Vec<Box<dyn Candidate>> {
    // The exemplar that is longest on its lesser side holds a region of that side.
    let between = Some([(shortest(exemplars).max().unwrap_or(1) * 3 / 8).max(1); 2]);
    let second = graphcut::Options { reach: between, variety: None, ..first };
    let second = if orderly {
        graphcut::Options { placement: graphcut::Placement::Entire, ..second }
    } else {
        // Patches lie as far apart as in the first, whose region is less.
        graphcut::Options { placement: graphcut::Placement::Sub, region: between, ..second }
    };
    let candidate = |options| Box::new(Graphcut(options)) as Box<dyn Candidate>;
    [first, second].map(candidate).into()
}

/// A map once more, where there is memory for it.
fn copied(map: &SourceMap<2>) -> Result<SourceMap<2>, Error> {
    Ok(SourceMap { ids: map.ids.map(|id| id)?, table: map.table.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_testkit::exemplars::cobbles;

    #[test]
    fn the_second_lies_as_far_apart_as_the_first() {
        let e = Exemplars::of(&[&[cobbles()]]).unwrap();
        let second = |side| {
            let all = of_kind(&e, Domain::open([side; 2]), None, &Limits::default()).unwrap().0;
            format!("{:?}", all[1])
        };
        // The first chooses it by itself, and below six times the exemplar none does.
        for (side, apart) in [(384, 0), (600, 72)] {
            let told = format!("apart: Some({apart}), stutter: Never");
            assert!(second(side).contains(&told), "{}", second(side));
        }
    }
}
