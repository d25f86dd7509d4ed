//! What an animation goes on from.

use std::fs;
use std::path::Path;

use selvedge_core::{Domain, Exemplars, Run, SourceMap};
use selvedge_io::clip::ClipWriter;
use selvedge_texture_optimization::{Animation, Animator, Checkpoint};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::kept::{self, Kept, KeptArgs};
use crate::stdio;

/// Of what is kept beside a checkpoint, the counts of all frames so far, and the hashes of their files.
const FRAMES: &str = "frames";
const FILES: &str = "files";

/// Frames that are there.
pub(super) enum Begun {
    /// The first one, which is not written yet.
    First(SourceMap<2>),
    /// Those of an earlier run.
    Kept(kept::Begun<Checkpoint>),
}

impl Begun {
    /// What an earlier run kept that followed from the same.
    pub(super) fn read(args: &KeptArgs, head: &Value) -> Result<Option<Self>, Failure> {
        let begun = args.begun(head, |bytes| Checkpoint::of_bytes(bytes).ok())?;
        Ok(begun.map(Self::Kept))
    }

    /// Counts of the frames that are written.
    pub(super) fn counts(&self) -> Vec<Value> {
        let Self::Kept(begun) = self else { return Vec::new() };
        begun.head[FRAMES].as_array().cloned().unwrap_or_default()
    }

    /// Lets a writer go on after the frames that are written, each of which must still be what it was.
    pub(super) fn lead(&self, writer: &mut ClipWriter) -> Result<(), Failure> {
        let Self::Kept(begun) = self else { return Ok(()) };
        let hashes = begun.head[FILES].as_array().into_iter().flatten();
        let hashes: Vec<String> = hashes.filter_map(Value::as_str).map(ToOwned::to_owned).collect();
        writer.files().iter().zip(&hashes).try_for_each(|(file, hash)| check(file, hash))?;
        writer.go_on(hashes);
        Ok(())
    }

    /// The animator as it was.
    pub(super) fn animator<'e>(
        self,
        (exemplars, output): (&'e Exemplars<2>, Domain<2>),
        options: &Animation,
        run: &Run<'_, 2>,
    ) -> Result<Animator<'e>, Failure> {
        Ok(match self {
            Self::First(map) => Animator::new(exemplars, map, options, run)?,
            Self::Kept(begun) => Animator::resume(exemplars, output, &begun.from, options, run)?,
        })
    }
}

/// Refuses a frame that is not as it was written.
fn check(file: &Path, hash: &str) -> Result<(), Failure> {
    let remedy = "begin again, without --resume";
    let gone = |e| Failure::new(4, stdio::plain(&e)).about(file).remedy(remedy);
    if blake3::hash(&fs::read(file).map_err(gone)?).to_hex().as_str() != hash {
        return Err(Failure::new(3, "is not the frame that was written").about(file).remedy(remedy));
    }
    Ok(())
}

/// Keeps an animation after a frame that was written.
pub(super) fn keep(kept: &Kept<'_>, animator: &Animator<'_>, (counts, writer): (&[Value], &ClipWriter)) {
    let files: Vec<&String> = writer.written().iter().map(|(_, hash)| hash).collect();
    kept.keep(&[(FRAMES, counts.into()), (FILES, json!(files))], &|| animator.checkpoint().to_bytes());
}
