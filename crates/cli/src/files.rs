//! Exemplars in, pictures out.

use std::path::{Path, PathBuf};

use selvedge_core::{Domain, Plane};
use selvedge_io::{ErrorKind, Metadata, Picture, ReadOptions, WriteOptions};
use serde_json::{Value, json};

use crate::commands::Session;
use crate::failure::{Failure, shown};
use crate::report::Report;

/// A picture and where it came from.
pub(crate) struct Input {
    pub(crate) path: PathBuf,
    pub(crate) picture: Picture,
}

/// Reads pictures, says what is odd about them, and notes them in the report.
pub(crate) fn read_all(session: &Session<'_>, paths: &[PathBuf], report: &mut Report) -> Result<Vec<Input>, Failure> {
    paths.iter().map(|path| read(session, path, report)).collect()
}

fn read(session: &Session<'_>, path: &Path, report: &mut Report) -> Result<Input, Failure> {
    let options = ReadOptions { limits: session.limits, ..ReadOptions::default() };
    let picture = selvedge_io::read(path, &options)?;
    for warning in &picture.warnings {
        session.say(&format!("warning: '{}': {warning}", shown(path)));
    }
    let plane = &picture.plane;
    report.inputs.push(json!({
        "path": shown(path),
        "width": plane.domain().shape[1],
        "height": plane.domain().shape[0],
        "channels": plane.samples.channels(),
        "depth": plane.samples.depth().name(),
        "blake3": picture.blake3,
    }));
    Ok(Input { path: path.to_path_buf(), picture })
}

/// Refuses, before any work, an output that cannot or must not be written.
pub(crate) fn check_output(session: &Session<'_>, output: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    options(session).format_of(output)?;
    if session.global.no_clobber && std::fs::symlink_metadata(output).is_ok() {
        return Err(Failure::new(4, "exists; leave out --no-clobber or choose another name").about(output));
    }
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    if let Some(out) = real(output)
        && inputs.iter().any(|input| real(input).as_ref() == Some(&out))
    {
        return Err(Failure::new(4, "is an input as well; choose another name for the output").about(output));
    }
    Ok(())
}

/// Refuses outputs over the caps before any memory is asked for.
pub(crate) fn check_size(session: &Session<'_>, domain: Domain<2>) -> Result<(), Failure> {
    let [h, w] = domain.shape;
    let (side, samples) = (session.limits.side, session.limits.samples);
    if side < h.max(w) || samples < u64::from(h) * u64::from(w) {
        let caps = format!("the output of {w}x{h} px is over the caps of {side} px a side and {samples} px in all");
        return Err(Failure::new(3, format!("{caps}; use a smaller --size")));
    }
    Ok(())
}

/// Writes a picture and notes it in the report.
pub(crate) fn write(
    session: &Session<'_>,
    path: &Path,
    plane: &Plane<2>,
    metadata: &Metadata,
    report: &mut Report,
) -> Result<(), Failure> {
    let options = options(session);
    let bytes = selvedge_io::encode(plane, metadata, path, &options)?;
    selvedge_io::write_bytes(path, &bytes, options.no_clobber)?;
    report.outputs.push(output(path, plane.domain(), &bytes));
    Ok(())
}

fn output(path: &Path, domain: Domain<2>, bytes: &[u8]) -> Value {
    json!({
        "path": shown(path),
        "width": domain.shape[1],
        "height": domain.shape[0],
        "blake3": blake3::hash(bytes).to_hex().as_str(),
    })
}

fn options(session: &Session<'_>) -> WriteOptions {
    WriteOptions { no_clobber: session.global.no_clobber, ..WriteOptions::default() }
}

impl From<selvedge_io::Error> for Failure {
    fn from(error: selvedge_io::Error) -> Self {
        let exit = match error.kind() {
            ErrorKind::Option => 2,
            ErrorKind::Input => 3,
            ErrorKind::FileSystem => 4,
            ErrorKind::NoSpace => 5,
            ErrorKind::Memory => 6,
            _ => 70,
        };
        Self { exit, path: Some(shown(&error.path)), message: error.message(), remedy: Some(error.remedy()) }
    }
}
