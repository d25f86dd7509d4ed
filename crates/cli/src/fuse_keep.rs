//! `--fuse-keep`: what fusing leaves as it is.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use crate::blending::Blending;
use crate::failure::Failure;
use crate::ground;
use crate::loom::Loom;
use crate::setup::Setup;

/// What `--fuse` leaves as it is.
#[derive(Args, Clone, Debug)]
pub(crate) struct FuseKeep {
    /// Where this picture, which has the output's size, is white, --fuse changes nothing, and what is around follows.
    #[arg(help_heading = "How seams are hidden", long, value_name = "MASK", value_hint = ValueHint::FilePath)]
    fuse_keep: Option<PathBuf>,
}

impl FuseKeep {
    /// Of a command that has it.
    pub(crate) fn setup<'a>(&self, mut setup: Setup<'a>) -> Setup<'a> {
        setup.others.extend(self.fuse_keep.clone());
        setup.keeps |= self.fuse_keep.is_some();
        setup
    }

    /// Reads what is kept, once it is known whether anything is fused, and the output's shape.
    pub(crate) fn read(&self, loom: &mut Loom<'_>) -> Result<(), Failure> {
        loom.unfused = self.of(loom.blending)?.map(|path| ground::mask(loom, path)).transpose()?;
        Ok(())
    }

    /// Where the picture is of what stays, if seams are hidden so.
    pub(crate) fn of(&self, blending: Blending) -> Result<Option<&PathBuf>, Failure> {
        if self.fuse_keep.is_some() && !blending.is_fused() {
            return Err(Failure::new(2, "--fuse-keep, and nothing is fused").remedy("add --fuse"));
        }
        Ok(self.fuse_keep.as_ref())
    }
}
