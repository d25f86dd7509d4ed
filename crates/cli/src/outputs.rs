//! Files and standard output: refused before the work where they cannot be written, written whole or not at all.

use std::path::{Path, PathBuf};

use selvedge_core::{Depth, Plane};
use selvedge_io::{Format, MapFile, Metadata, WriteOptions};
use serde_json::json;

use crate::failure::{Failure, shown};
use crate::inputs::STREAM;
use crate::report::Report;
use crate::session::Session;
use crate::stdio;

/// Refuses, before any work, outputs that cannot or must not be written.
pub(crate) fn check<P: AsRef<Path>>(session: &Session<'_>, outputs: &[P], inputs: &[PathBuf]) -> Result<(), Failure> {
    for (i, output) in outputs.iter().enumerate() {
        let output = output.as_ref();
        if outputs[..i].iter().any(|other| other.as_ref() == output || selvedge_io::same_file(other.as_ref(), output)) {
            return Err(Failure::new(2, "is named for two outputs; choose another name").about(output));
        }
        if output.as_os_str() != STREAM {
            selvedge_io::check_output(output, inputs, session.global.no_clobber)?;
        } else if session.global.json {
            return Err(Failure::new(2, "--json and '-' both write to standard output; name a file"));
        }
    }
    Ok(())
}

/// The format of a picture file; standard output takes PNG unless `--format` says otherwise. What is wrong by itself
/// is refused: an unknown extension, or a depth that was typed and that the format does not hold.
pub(crate) fn format(path: &Path, chosen: Option<Format>, depth: Option<Depth>) -> Result<Format, Failure> {
    let stream = (path.as_os_str() == STREAM).then_some(Format::Png);
    let options = WriteOptions { format: chosen.or(stream), depth, ..WriteOptions::default() };
    options.format_of(path).map_err(|e| Failure { exit: 2, ..Failure::from(e) })
}

/// Refuses, before any work, a depth of files read that the format does not hold.
pub(crate) fn check_depth(path: &Path, format: Format, depth: Depth) -> Result<(), Failure> {
    WriteOptions { format: Some(format), depth: Some(depth), ..WriteOptions::default() }.format_of(path)?;
    Ok(())
}

/// Files that are made, to be written once all of them are.
#[derive(Default)]
pub(crate) struct Outputs(Vec<Made>);

struct Made {
    path: PathBuf,
    bytes: Vec<u8>,
    /// Width and height.
    size: [u32; 2],
}

impl Outputs {
    /// Adds a picture.
    pub(crate) fn picture(
        &mut self,
        path: &Path,
        format: Format,
        plane: &Plane<2>,
        metadata: &Metadata,
    ) -> Result<(), Failure> {
        let options = WriteOptions { format: Some(format), ..WriteOptions::default() };
        let bytes = selvedge_io::encode(plane, metadata, path, &options)?;
        let [height, width] = plane.domain().shape;
        self.0.push(Made { path: path.to_path_buf(), bytes, size: [width, height] });
        Ok(())
    }

    /// Adds a source map.
    pub(crate) fn map(&mut self, path: &Path, file: &MapFile) -> Result<(), Failure> {
        let bytes = selvedge_io::encode_map(file, path)?;
        let [height, width] = file.map.domain().shape;
        self.0.push(Made { path: path.to_path_buf(), bytes, size: [width, height] });
        Ok(())
    }

    /// Writes all of them and notes them in the report.
    pub(crate) fn write(self, session: &Session<'_>, report: &mut Report) -> Result<(), Failure> {
        for Made { path, bytes, size: [width, height] } in self.0 {
            if path.as_os_str() == STREAM {
                stdio::answer(&bytes)?;
            } else {
                selvedge_io::write_bytes(&path, &bytes, session.global.no_clobber)?;
            }
            let hash = blake3::hash(&bytes).to_hex();
            report
                .outputs
                .push(json!({"path": shown(&path), "width": width, "height": height, "blake3": hash.as_str()}));
        }
        Ok(())
    }
}

/// Where an interrupted run leaves what there is: `dir/out.png` becomes `dir/out.partial.png`.
pub(crate) fn partial(path: &Path) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(".partial");
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

impl From<selvedge_io::Error> for Failure {
    fn from(error: selvedge_io::Error) -> Self {
        use selvedge_io::ErrorKind as Kind;
        let exit = match error.kind() {
            Kind::Option => 2,
            Kind::Input => 3,
            Kind::FileSystem => 4,
            Kind::NoSpace => 5,
            Kind::Memory => 6,
            _ => 70,
        };
        Self { exit, path: Some(shown(&error.path)), message: error.message(), remedy: Some(error.remedy()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partial_results_keep_folder_and_extension() {
        assert_eq!(partial(Path::new("a/b.c.png")), Path::new("a/b.c.partial.png"));
        assert_eq!(partial(Path::new("out")), Path::new("out.partial"));
    }
}
