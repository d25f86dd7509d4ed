//! What the texture is optimised from: noise, a quilt or a graph cut made by the program, or an earlier map.

use std::path::PathBuf;

use selvedge_core::{Bytes, Domain, Exemplars, Run, SourceMap, Start, Woven};
use selvedge_texture_optimization::Options;

use crate::failure::Failure;
use crate::wrong::Wrong;

/// What the texture is optimised from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::commands) enum Init {
    /// Chosen by the program.
    Auto,
    Quilt,
    Graphcut,
    /// Random neighborhoods.
    Random,
    Map(PathBuf),
}

pub(in crate::commands) fn init(text: &str) -> Result<Init, Wrong> {
    Ok(match text {
        "auto" => Init::Auto,
        "quilt" => Init::Quilt,
        "graphcut" => Init::Graphcut,
        "random" => Init::Random,
        _ if text.ends_with(".exr") || text == crate::stdio::STREAM => Init::Map(text.into()),
        _ => {
            let what = format!("'{text}' is nothing to start from");
            return Err(Wrong::new(what, "write auto, quilt, graphcut, random, or a source map's name (.exr)"));
        }
    })
}

impl Init {
    /// A graph cut, if nothing was said.
    pub(in crate::commands) fn chosen(&self) -> Self {
        if *self == Self::Auto { Self::Graphcut } else { self.clone() }
    }

    /// Options that suit it: all that is left of a graph cut is to mend its seams; a quilt gains by coarse levels
    /// (olives 209 instead of 277).
    pub(in crate::commands) fn suited(&self) -> Option<Options> {
        (*self == Self::Graphcut).then(Options::mending)
    }

    /// The map's file.
    pub(in crate::commands) fn map(&self) -> Option<&PathBuf> {
        if let Self::Map(path) = self { Some(path) } else { None }
    }

    /// As it is typed.
    pub(in crate::commands) fn typed(&self) -> String {
        match self {
            Self::Auto => "auto".into(),
            Self::Quilt => "quilt".into(),
            Self::Graphcut => "graphcut".into(),
            Self::Random => "random".into(),
            Self::Map(path) => selvedge_io::display_name(path),
        }
    }

    /// What choosing takes by what exemplars show, whether this is left open or what it is made with.
    pub(in crate::commands) fn choosing(&self, sources: &[Domain<2>], channels: usize, masked: bool) -> Bytes {
        match self {
            // What is left open is chosen by what a graph cut is chosen by.
            Self::Auto | Self::Graphcut => {
                selvedge_graphcut_textures::measuring(sources, channels, masked, &Default::default())
            }
            Self::Quilt => selvedge_quilting::measuring(sources, channels, masked, &Default::default()),
            Self::Random | Self::Map(_) => Bytes(0),
        }
    }

    /// How it is made, once it is [chosen](Self::chosen).
    pub(in crate::commands) fn planned<'e>(
        &self,
        exemplars: &'e Exemplars<2>,
        output: Domain<2>,
        run: &Run<'_, 2>,
    ) -> Result<Beginning<'e>, Failure> {
        let method = match self {
            Self::Quilt => {
                let plan = selvedge_quilting::Plan::new(exemplars, output, &Default::default(), run)?;
                Some(Method::Quilt(plan))
            }
            Self::Graphcut => {
                let plan = selvedge_graphcut_textures::plan(exemplars, output, None, &Default::default(), &run.limits)?;
                Some(Method::Graphcut(Box::new(plan)))
            }
            Self::Auto | Self::Random | Self::Map(_) => None,
        };
        Ok(Beginning { exemplars, output, method })
    }
}

/// A start that a method makes, or none.
pub(in crate::commands) struct Beginning<'e> {
    exemplars: &'e Exemplars<2>,
    output: Domain<2>,
    method: Option<Method<'e>>,
}

enum Method<'e> {
    Quilt(selvedge_quilting::Plan<'e>),
    Graphcut(Box<selvedge_graphcut_textures::Plan<'e, 2>>),
}

impl Beginning<'_> {
    /// Bytes that making it takes at most.
    pub(in crate::commands) fn bytes(&self) -> Bytes {
        match &self.method {
            Some(Method::Quilt(plan)) => plan.bytes(),
            Some(Method::Graphcut(plan)) => plan.bytes(),
            None => Bytes(0),
        }
    }

    /// Makes it; `None` for what is not made by a method.
    pub(in crate::commands) fn weave(&self, run: &Run<'_, 2>) -> Result<Option<Woven<SourceMap<2>, ()>>, Failure> {
        let (result, complete) = match &self.method {
            Some(Method::Quilt(plan)) => {
                let woven = plan.weave(run)?;
                (woven.result, woven.complete)
            }
            Some(Method::Graphcut(plan)) => {
                let woven = plan.weave(Start::empty(self.exemplars, self.output)?, run)?;
                (woven.result, woven.complete)
            }
            None => return Ok(None),
        };
        Ok(Some(Woven { result, stats: (), complete }))
    }
}
