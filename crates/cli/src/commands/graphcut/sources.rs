//! The sources of `graphcut`: orientations, scales, and which of them each place may copy from.

use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueHint};
use selvedge_core::{Grid, Source, Start, Transform};

use super::scales::{self, Field, Range, Scales};
use crate::failure::Failure;
use crate::loom::Loom;
use crate::options::Turning;
use crate::used::Used;
use crate::wrong::Wrong;

/// How exemplars are shown, and where.
#[derive(Args, Debug)]
pub(super) struct SourceArgs {
    #[command(flatten)]
    turning: Turning,
    /// Turn exemplars clockwise by these angles in degrees as well; their samples are interpolated.
    #[arg(long, value_name = "DEGREES", value_delimiter = ',', allow_hyphen_values = true, value_parser = angle)]
    rotate: Vec<f64>,
    /// Magnify exemplars by these factors as well, from 0.0625 to 16.
    #[arg(long, value_name = "FACTOR", value_delimiter = ',', value_parser = scales::scale, allow_negative_numbers = true, conflicts_with = "scale_field")]
    scale: Vec<f64>,
    /// How large the texture is at each place, for perspective: top=0.5,bottom=1.5 (and left=, right=) from side to
    /// side, or a picture that is stretched over the output.
    #[arg(long, value_name = "FIELD", value_hint = ValueHint::AnyPath)]
    scale_field: Option<Field>,
    /// The scales that black and white of a picture of scales stand for.
    #[arg(long, value_name = "LOW..HIGH", requires = "scale_field")]
    scale_range: Option<Range>,
    /// The factor between scales that a field is made of. Each place copies from those nearest to its own.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.2, value_parser = scales::step,
        allow_negative_numbers = true)]
    scale_step: f64,
}

/// An angle in degrees.
fn angle(text: &str) -> Result<f64, Wrong> {
    let angle = text.parse().ok().filter(|a: &f64| a.is_finite());
    angle.ok_or_else(|| Wrong::new(format!("'{text}' is no angle"), "write degrees, such as 30"))
}

/// One way to turn exemplars: clockwise degrees, and whether they are mirrored before.
type Orientation = (f64, bool);

impl SourceArgs {
    /// Refuses more sources than can be told apart, where that matters, and scales that are wrong by themselves.
    pub(super) fn validate(&self, exemplars: usize, backdrop: bool) -> Result<(), Failure> {
        let scales = self.scales()?.len();
        if self.have_field() || backdrop {
            scales::check_number(exemplars, self.orientations().len(), scales, backdrop)?;
        }
        Ok(())
    }

    /// True if places choose their sources by scale.
    pub(super) fn have_field(&self) -> bool {
        self.scale_field.is_some()
    }

    /// The picture of scales, if there is one.
    pub(super) fn file(&self) -> Option<&PathBuf> {
        self.scale_field.as_ref().and_then(Field::file)
    }

    /// Every orientation at every scale, scale by scale.
    pub(super) fn transforms(&self) -> Result<Vec<Transform>, Failure> {
        let mut all: Vec<Transform> = Vec::new();
        for scale in self.scales()? {
            let fresh: Vec<Transform> = self.turned(scale).filter(|transform| !all.contains(transform)).collect();
            all.extend(fresh);
        }
        Ok(all)
    }

    /// What the output goes on from, and which sources each place may copy from.
    pub(super) fn start(&self, loom: &mut Loom<'_>) -> Result<Start<2>, Failure> {
        let mut start = loom.start()?;
        if let Some(field) = self.field()? {
            // Of two, one at a time.
            start.sources = None;
            start.sources = Some(self.allowed(loom, &field)?);
        }
        Ok(start)
    }

    /// The options as used.
    pub(super) fn used(&self, used: Used) -> Used {
        match &self.scale_field {
            Some(field) => used
                .set("scale-field", field.to_string())
                .set("scale-range", self.scale_range.map(|range| range.to_string())),
            None => used.without("scale-field").without("scale-range").without("scale-step"),
        }
    }

    fn field(&self) -> Result<Option<Scales>, Failure> {
        let field = |f: &Field| Scales::new(f.clone(), self.scale_range, self.scale_step);
        self.scale_field.as_ref().map(field).transpose()
    }

    /// The scales of the exemplars.
    fn scales(&self) -> Result<Vec<f64>, Failure> {
        let typed = || std::iter::once(1.0).chain(self.scale.iter().copied()).collect();
        Ok(self.field()?.map_or_else(typed, |field| field.levels().to_vec()))
    }

    /// The orientations asked for, each once, as they are first.
    fn orientations(&self) -> Vec<Orientation> {
        let mut all: Vec<Orientation> = Vec::new();
        for degrees in std::iter::once(0.0).chain(self.rotate.iter().copied()) {
            for turn in self.turning.quarter_turns() {
                for &mirror in self.turning.mirrors() {
                    let orientation = ((degrees + 90.0 * f64::from(turn)).rem_euclid(360.0), mirror);
                    if !all.contains(&orientation) {
                        all.push(orientation);
                    }
                }
            }
        }
        all
    }

    /// Every orientation at a scale.
    fn turned(&self, scale: f64) -> impl Iterator<Item = Transform> {
        self.orientations().into_iter().map(move |(degrees, mirror)| Transform::new(degrees, scale, mirror))
    }

    /// By position, which sources may be copied from.
    fn allowed(&self, loom: &mut Loom<'_>, field: &Scales) -> Result<Grid<u64, 2>, Failure> {
        let picture = self.file().map(|path| loom.open(path)).transpose()?;
        let of_levels: Vec<u64> = field.levels().iter().map(|&scale| self.of_scale(loom, scale)).collect();
        field.allowed(loom.domain, picture.as_ref(), &of_levels)
    }

    /// The sources of a scale, but for the picture that is gone on from. What is the same at several scales is one
    /// source.
    fn of_scale(&self, loom: &Loom<'_>, scale: f64) -> u64 {
        let (given, turned) = (loom.loaded.given().len(), self.turned(scale).collect::<Vec<_>>());
        let sources = loom.loaded.exemplars.sources().iter().enumerate();
        let here = |(number, s): (usize, &Arc<Source<2>>)| {
            let laid = usize::from(s.origin.exemplar) < given && turned.contains(&s.origin.transform);
            if laid { 1 << number } else { 0_u64 }
        };
        sources.map(here).fold(0, |all, bit| all | bit)
    }
}
