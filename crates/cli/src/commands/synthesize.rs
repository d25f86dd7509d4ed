//! `selvedge synthesize`: the best of several candidates, without knobs.

use clap::Args;
use selvedge_analysis::Texture;
use selvedge_core::{Bytes, Domain, Grid, Plane, Role, Samples};
use selvedge_metrics::Columns;
use selvedge_synthesis::{Options, Stats, Trial, estimate, synthesize};
use serde_json::{Value, json};

use crate::blending::Blending;
use crate::failure::{Failure, n};
use crate::loom::Loom;
use crate::method::{Method, PlannedRun};
use crate::outcome::{Beside, MadeBy, Outcome};
use crate::output_size::OutputSize;
use crate::repairing::Repairing;
use crate::session::Session;
use crate::setup::Setup;
use crate::thumbnail::Thumbnail;
use crate::used::Used;
use crate::weaving::{Sizing, Weaving};

/// Options of `synthesize`.
#[derive(Args, Debug)]
pub(crate) struct Synthesize {
    #[command(flatten)]
    weaving: Weaving,
    #[command(flatten)]
    sizing: Sizing,
    /// How much is tried: 1 is one run, 3 finishes the best of three drafts, 9 the best twelve of forty.
    #[arg(long, value_name = "1..9", default_value_t = Options::default().effort,
        value_parser = clap::value_parser!(u8).range(1..=9))]
    effort: u8,
    /// Whether seams of what stands best are mended, as 'optimize --start MAP --schedule 1:16,1:8 --complete none'
    /// does: auto does where candidates are compared and exemplars times output are no more than 256^2 times 512^2
    /// pixels, and keeps that where it is preferred by what it shows and nothing melts; not where other planes come
    /// along and none of them is a --match, for it would leave crumbs in them.
    #[arg(long, value_enum, value_name = "WHEN", default_value_t = Mend::Auto)]
    mend: Mend,
    #[command(flatten)]
    repairing: Repairing,
    #[command(flatten)]
    blending: Blending,
}

/// Whether seams of what stands best are mended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Mend {
    /// Where that is better.
    Auto,
    /// Never.
    None,
}

impl Method for Synthesize {
    fn setup(&self, _: &Session<'_>) -> Result<Setup<'_>, Failure> {
        self.repairing.validate()?;
        let setup = Setup::new("synthesize", &self.weaving, OutputSize::Exemplar(self.sizing));
        let blending = if self.carries_shade() { Blending::SPLINED } else { self.blending };
        Ok(Setup { blending, repairing: self.repairing, ..setup })
    }

    fn bytes(&self, sources: &[Domain<2>], channels: usize, output: Domain<2>) -> Bytes {
        self.repairing.bytes(sources, channels, output)
    }

    fn choosing(&self, sources: &[Domain<2>], channels: usize, masked: bool) -> Bytes {
        // Its candidates are graph cuts.
        selvedge_graphcut_textures::measuring(sources, channels, masked, &Default::default())
    }

    fn plan<'l>(&'l self, loom: &'l mut Loom<'_>) -> Result<PlannedRun<'l>, Failure> {
        if self.carries_shade() && !is_lit_unevenly(loom)? {
            loom.blending = Blending::default();
        }
        let loom = &*loom;
        let (exemplars, options, limits) = (&loom.loaded.exemplars, self.options(), &loom.session.limits);
        let needs = |output| estimate(exemplars, output, &options, limits);
        let own = needs(loom.domain).map_err(|e| loom.loaded.about(e.into()))?;
        // Of other sizes what cannot be told cannot be made.
        let of = |output| if output == loom.domain { own } else { needs(output).unwrap_or(Bytes::MOST) };
        let needed = self.admit(loom, &of)?;
        let how = format!("as the best of what effort {} tries", self.effort);
        Ok(PlannedRun::new(loom.used(), how, move || {
            let woven = synthesize(exemplars, loom.domain, &options, &loom.session.run());
            let woven = woven.map_err(|e| loom.loaded.about(e.into()))?;
            let (stats, kept) = (&woven.stats, &woven.stats.tried[woven.stats.kept]);
            let counts = json!({
                "effort": self.effort,
                "kept": stats.kept,
                "candidates": stats.tried.iter().map(candidate).collect::<Vec<_>>(),
            });
            // What mends another is made by both: by this command again.
            let made_by = kept.mends.is_none().then(|| MadeBy {
                command: kept.method,
                seed: kept.seed.0,
                options: used(loom, kept),
            });
            let splined = self.carries_shade() && !loom.blending.is_none();
            let how = how_kept(stats) + if splined { "; its seams are splined, for its light is uneven" } else { "" };
            let tried = stats.tried.iter().enumerate().filter_map(|(i, t)| told(i, t, i == stats.kept));
            let mut pictures: Vec<_> = tried.collect();
            let shown = loom.is_explained();
            let mut outcome =
                self.repairing.outcome(loom.session, exemplars, woven, (None, None), (counts, how), shown)?;
            pictures.append(&mut outcome.beside.pictures);
            outcome.beside = Beside { heading: "Tried", pictures };
            Ok(Outcome { made_by, ..outcome })
        })
        .needing(needed))
    }
}

impl Synthesize {
    fn options(&self) -> Options {
        Options { effort: self.effort, mend: self.mend == Mend::Auto && !self.weaving.with.is_blind() }
    }

    /// True if seams of what is lit unevenly are hidden, though nobody asked: two readers preferred that on 8 and 7 of
    /// ten such textures. The planes of a material are copied, so that they fit each other.
    fn carries_shade(&self) -> bool {
        self.blending.is_none() && self.weaving.with.with.is_empty()
    }
}

/// True if light differs from place to place in any exemplar, as decisions see it.
fn is_lit_unevenly(loom: &Loom<'_>) -> Result<bool, Failure> {
    let textures = Texture::of_each(&loom.loaded.exemplars).map_err(|e| loom.loaded.about(e.into()))?;
    Ok(textures.iter().any(Texture::is_uneven))
}

/// The options of the method that made what is kept: with its command and seed they make it again.
fn used(loom: &Loom<'_>, kept: &Trial) -> Used {
    let own = kept.used.iter().map(|(name, text)| ((*name).to_owned(), value(text)));
    loom.used().without("effort").without("mend").before(&["repair", "feather", "spline", "fuse"], own)
}

/// A number where it is one.
fn value(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|_| text.into())
}

fn candidate(tried: &Trial) -> Value {
    let options: serde_json::Map<String, Value> =
        tried.used.iter().map(|(name, text)| ((*name).to_owned(), value(text))).collect();
    let columns = tried.scored.map(|(columns, _)| {
        columns
            .named()
            .into_iter()
            .map(|(name, value)| (name.to_owned(), json!(value)))
            .collect::<serde_json::Map<_, _>>()
    });
    json!({
        "method": tried.method,
        "options": options,
        "seed": tried.seed.0,
        "draft": tried.draft,
        "mends": tried.mends,
        "preference": tried.scored.map(|(_, preference)| preference),
        "columns": columns,
    })
}

/// A candidate for the page: what it shows, how it was made, and its columns.
fn told(number: usize, tried: &Trial, is_kept: bool) -> Option<Thumbnail> {
    let ((columns, preference), picture) = (tried.scored?, tried.picture.as_ref()?);
    let colors = if picture.channels() < 3 { 1 } else { 3 };
    let samples = picture.samples()[..colors * picture.domain().len()].to_vec();
    let picture = Plane::new(Role::Color, Samples::U8(Grid::from_vec(picture.domain(), colors, samples).ok()?));
    let kept = if is_kept { ", kept" } else { "" };
    let draft = if tried.draft { "draft by" } else { "by" };
    let mends = tried.mends.map_or(String::new(), |of| format!(", which mends {},", of + 1));
    let options = tried.used.iter().map(|(name, text)| format!(" --{name} {text}")).collect::<String>();
    let columns = columns.named().into_iter().map(|(name, value)| format!("\n{name} {value:.3}")).collect::<String>();
    let caption = format!(
        "{}{kept}: preference {preference:.2}, {draft} {}{mends}{options} --seed {}\n{columns}",
        number + 1,
        tried.method,
        tried.seed.0
    );
    Some(Thumbnail { picture, caption })
}

/// What was taken and why, in a line.
fn how_kept(stats: &Stats) -> String {
    let (tried, kept) = (&stats.tried, &stats.tried[stats.kept]);
    match kept.mends {
        Some(of) => how_cut(&tried[..stats.kept], &tried[of]) + ", its seams mended",
        None => match tried.split_last() {
            Some((last, before)) if last.mends.is_some() => how_cut(before, kept) + ", better unmended",
            _ => how_cut(tried, kept),
        },
    }
}

/// The same of what mends nothing.
fn how_cut(tried: &[Trial], kept: &Trial) -> String {
    let size = kept.used.iter().find(|(name, _)| matches!(*name, "block" | "region"));
    let size = size.map_or(String::new(), |(name, text)| format!(" ({name} {text} px)"));
    let by = format!("by {}{size}", kept.method);
    let Some((columns, _)) = kept.scored else { return by };
    let energy = |c: &Columns| c.seams.map_or(0.0, |s| s.energy);
    let median = |of: &dyn Fn(&Columns) -> f64| {
        let mut all: Vec<f64> = tried.iter().filter_map(|t| Some(of(&t.scored?.0))).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    format!(
        "{by}, the best of {}: seams cost {:.2} (median {:.2}), worst places {:.2} (median {:.2})",
        n("draft", tried.iter().filter(|t| t.draft).count()),
        energy(&columns),
        median(&energy),
        columns.worst,
        median(&|c| c.worst),
    )
}
