//! What a method made.

use std::path::PathBuf;

use selvedge_core::{Grid, Plane, Render};
use serde_json::Value;

use crate::course::Course;
use crate::failure::Failure;
use crate::thumbnail::Thumbnail;
use crate::used::Used;

/// What a method made, and how it is laid over the payload.
pub(crate) struct Outcome {
    pub(crate) woven: Box<dyn Render<2>>,
    /// False if it was interrupted.
    pub(crate) complete: bool,
    pub(crate) stats: Value,
    /// How it was made, for people.
    pub(crate) how: String,
    /// Positions that no blending changes.
    pub(crate) kept: Option<Grid<bool, 2>>,
    /// Whether holes are meant, and transparent.
    pub(crate) holes: bool,
    /// How its seams became cheaper, for the page of `--report`.
    pub(crate) course: Option<Course>,
    /// Another command that makes the same.
    pub(crate) made_by: Option<MadeBy>,
    /// Other pictures that are written.
    pub(crate) others: Vec<(PathBuf, Plane<2>)>,
    /// What is done to the picture after all, but not to its map or other planes.
    pub(crate) after: Option<After>,
    /// What else is shown by `--explain` and the page: what was made and not kept, or what was followed.
    pub(crate) beside: Beside,
}

/// Changes a rendered picture.
pub(crate) type After = Box<dyn FnOnce(&mut Plane<2>) -> Result<(), Failure>>;

/// A command that makes what another one answered with.
pub(crate) struct MadeBy {
    pub(crate) command: &'static str,
    pub(crate) seed: u64,
    pub(crate) options: Used,
}

/// Pictures under a heading.
#[derive(Default)]
pub(crate) struct Beside {
    pub(crate) heading: &'static str,
    pub(crate) pictures: Vec<Thumbnail>,
}

impl Outcome {
    /// Of a method that stood at the beginning of nothing, and tells no course.
    pub(crate) fn new(woven: Box<dyn Render<2>>, complete: bool, stats: Value, how: String) -> Self {
        let (others, beside) = (Vec::new(), Beside::default());
        Self {
            woven,
            complete,
            stats,
            how,
            kept: None,
            holes: false,
            course: None,
            made_by: None,
            others,
            after: None,
            beside,
        }
    }

    /// Blending changes nothing there either.
    pub(crate) fn keep(&mut self, more: Option<Grid<bool, 2>>) {
        let Some(more) = more else { return };
        match &mut self.kept {
            Some(kept) => kept.samples_mut().iter_mut().zip(more.samples()).for_each(|(kept, more)| *kept |= more),
            kept => *kept = Some(more),
        }
    }
}
