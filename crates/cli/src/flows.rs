//! Fields of motion that are read from files: one, or one a frame.

use std::path::{Path, PathBuf};

use selvedge_core::{Direction, Flow, Limits};
use selvedge_io::flow::{is_flow_name, read_flow};
use selvedge_io::{Fingerprint, Problem};

use crate::clips;
use crate::failure::Failure;
use crate::values::choices;

choices!(DirectionArg for Direction {
    /// Forward.
    Forward,
    /// Backward.
    Backward,
});

/// The files of a flow, in order.
pub(crate) fn files(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    let files = clips::files(&in_folder(path), None)?;
    match files.iter().find(|file| !is_flow_name(file)) {
        Some(other) => Err(Failure::new(3, "is no file of vectors")
            .about(other)
            .remedy("name the frames by a pattern, such as 'name.####.flo'")),
        None => Ok(files),
    }
}

/// A folder holds frames of vectors where it has `.flo` files, which are no pictures, and pictures of vectors else.
fn in_folder(path: &Path) -> PathBuf {
    let flo = |entry: std::fs::DirEntry| entry.path().extension().is_some_and(|extension| extension == "flo");
    let any = std::fs::read_dir(path).is_ok_and(|entries| entries.flatten().any(flo));
    if any { path.join("*.flo") } else { path.to_path_buf() }
}

/// Reads one, which has to be of the size that something has.
pub(crate) fn read(
    file: &Path,
    sized: Option<([u32; 2], &str)>,
    (scale, limits): (f32, &Limits),
) -> Result<(Flow, Fingerprint), Failure> {
    let mut read = read_flow(file, limits).map_err(|error| match error.problem {
        // What --nonfinite says is of pictures.
        Problem::NotFinite { .. } => Failure::from(error).remedy("mark these vectors as unknown, or give numbers"),
        _ => Failure::from(error),
    })?;
    let [h, w] = read.flow.domain().shape;
    if let Some(([fh, fw], has)) = sized.filter(|(size, _)| *size != [h, w]) {
        let what = format!("{w}x{h} vectors, but {has} {fw}x{fh}");
        return Err(Failure::new(3, what).about(file).remedy("give flows of that size"));
    }
    read.flow.by.samples_mut().iter_mut().for_each(|v| *v *= scale);
    if read.flow.odd().next().is_some() {
        let what = format!("{scale:e} times its vectors are no numbers");
        return Err(Failure::new(2, what).about(file).remedy("use a smaller --flow-scale"));
    }
    Ok((read.flow, read.fingerprint))
}
