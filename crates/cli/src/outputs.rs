//! Files and standard output: refused before the work where they cannot be written, written whole or not at all.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use selvedge_core::{Depth, Plane};
use selvedge_io::clip::{ClipWriteOptions, ClipWriter, Rate};
use selvedge_io::{
    Destination, Format, MapFile, Metadata, Problem, ReadOptions, StagedFile, Warning, WriteOptions, path_text,
};
use serde_json::{Value, json};

use crate::failure::{Failure, n, shown};
use crate::harmonise::Layout;
use crate::session::Session;
use crate::stdio::{self, STREAM};

/// Refuses, before any work, outputs that cannot or must not be written. Every command asks once, with all files that
/// it reads and writes; the files of options are added here.
pub(crate) fn check<P: AsRef<Path>>(session: &Session<'_>, outputs: &[P], inputs: &[PathBuf]) -> Result<(), Failure> {
    let global = session.global;
    let outputs: Vec<&Path> = outputs.iter().map(AsRef::as_ref).chain(global.save_config.as_deref()).collect();
    let inputs: Vec<PathBuf> = inputs.iter().chain(&global.config).cloned().collect();
    let (mut named, mut files) = (BTreeSet::new(), Vec::new());
    for output in outputs {
        if !named.insert(Destination::of(output)) {
            return Err(Failure::new(2, "is named for two outputs").remedy("choose another name").about(output));
        }
        if output.as_os_str() != STREAM {
            files.push(output);
        } else if stdio::leads_nowhere() {
            let failure = Failure::new(4, "is closed, so that a picture would be lost").named("standard output");
            return Err(failure.remedy("redirect it to a file or a pipe"));
        } else if global.json {
            return Err(Failure::new(2, "--json and '-' both write to standard output").remedy("name a file"));
        }
    }
    selvedge_io::check_outputs(&files, &inputs, global.no_clobber)?;
    // Once more when they are written: names may lead elsewhere by then.
    session.reads(inputs);
    Ok(())
}

/// Refuses a name for a source map that is none of an EXR file: the next program would not know it.
pub(crate) fn check_map_name(path: &Path) -> Result<(), Failure> {
    if path.as_os_str() == STREAM || Format::of_name(path) == Some(Format::Exr) {
        return Ok(());
    }
    Err(Failure::new(2, "source maps are EXR files").about(path).remedy("use a name that ends in .exr"))
}

/// The format of a picture file; standard output takes PNG unless `--format` says otherwise. What is wrong by itself
/// is refused: an unknown extension, or a depth that was typed and that the format does not hold.
pub(crate) fn format(path: &Path, chosen: Option<Format>, depth: Option<Depth>) -> Result<Format, Failure> {
    if path.is_dir() {
        return Err(Failure::from_problem(path, Problem::Folder));
    }
    if chosen.is_none() && path.as_os_str() != STREAM && path.extension().is_none() {
        let failure = Failure::new(2, "has no extension that tells its format").about(path);
        return Err(failure.remedy("name it with one, such as .png, or give --format"));
    }
    let stream = (path.as_os_str() == STREAM).then_some(Format::Png);
    let options = WriteOptions { format: chosen.or(stream), depth, ..WriteOptions::default() };
    options.format_of(path).map_err(|e| Failure { exit: 2, ..Failure::from(e) })
}

/// Refuses, before any work, a picture that the format does not hold. Where its depth or channels are those of a file
/// that was read, that file is named.
pub(crate) fn check_held(
    (path, format): (&Path, Format),
    shape: [u32; 2],
    (layout, depth): (Layout, Depth),
    from: Option<&Path>,
) -> Result<(), Failure> {
    format.check(shape, layout.colors, layout.alpha, depth).map_err(|problem| {
        let has = match problem {
            Problem::DepthNotHeld { .. } => format!("{} samples", depth.name()),
            Problem::ChannelsNotHeld { .. } if layout.alpha => format!("{} and alpha", n("channel", layout.colors)),
            Problem::ChannelsNotHeld { .. } => n("channel", layout.colors),
            _ => String::new(),
        };
        let failure = Failure::from_problem(path, problem);
        match from.filter(|_| !has.is_empty()) {
            Some(from) => {
                let message = format!("has {has}, which {format} cannot hold ('{}')", shown(path));
                Failure { message, ..failure }.about(from)
            }
            None => failure,
        }
    })
}

/// Files that are made, to be written once all of them are.
#[derive(Debug, Default)]
pub(crate) struct Outputs {
    made: Vec<OutputFile>,
    /// Where frames of clips are put beside their names as they come: whether names may not be taken, and what is read.
    beside: Option<(bool, Vec<PathBuf>)>,
    /// Those that were.
    staged: Mutex<Vec<StagedFile<'static>>>,
    quality: Option<u8>,
}

#[derive(Debug)]
struct OutputFile {
    path: PathBuf,
    bytes: Vec<u8>,
    /// Width and height.
    size: Option<[u32; 2]>,
    /// What the file says otherwise than the picture.
    told: Vec<Warning>,
    /// Of a clip's files one tells of them all, and the others of nothing.
    clip: Option<Value>,
}

impl Outputs {
    /// None yet; JPEG files will have this quality.
    pub(crate) fn with_quality(quality: Option<u8>) -> Self {
        Self { quality, ..Self::default() }
    }

    /// None yet; frames of clips will not be held, but lie beside their names as soon as they are made.
    pub(crate) fn beside(session: &Session<'_>) -> Self {
        Self { beside: Some((session.global.no_clobber, session.inputs())), ..Self::default() }
    }

    /// Adds a picture for eyes, in the format of its name.
    pub(crate) fn view(&mut self, path: &Path, plane: &Plane<2>, metadata: &Metadata) -> Result<(), Failure> {
        self.picture(path, format(path, None, None)?, plane, metadata)
    }

    /// Adds a picture.
    pub(crate) fn picture(
        &mut self,
        path: &Path,
        format: Format,
        plane: &Plane<2>,
        metadata: &Metadata,
    ) -> Result<(), Failure> {
        let default = WriteOptions::default();
        let quality = self.quality.unwrap_or(default.quality);
        let options = WriteOptions { format: Some(format), quality, ..default };
        let bytes = selvedge_io::encode(plane, metadata, path, &options)?;
        let [height, width] = plane.domain().shape;
        let told = selvedge_io::changes(plane, metadata, format);
        self.made.push(OutputFile { path: path.to_path_buf(), bytes, size: Some([width, height]), told, clip: None });
        Ok(())
    }

    /// Adds a source map.
    pub(crate) fn map(&mut self, path: &Path, file: &MapFile) -> Result<(), Failure> {
        let bytes = selvedge_io::encode_map(file, path)?;
        let [height, width] = file.map.domain().shape;
        self.made.push(OutputFile {
            path: path.to_path_buf(),
            bytes,
            size: Some([width, height]),
            told: Vec::new(),
            clip: None,
        });
        Ok(())
    }

    /// Adds a clip: its frames one after the other, and what comes last.
    pub(crate) fn clip(
        &mut self,
        path: &Path,
        frames: u32,
        frame: &mut dyn FnMut(u32) -> Result<Plane<2>, Failure>,
        (metadata, options): (&Metadata, ClipWriteOptions),
    ) -> Result<(), Failure> {
        let (rate, period) = (options.rate, options.period);
        let mut writer = ClipWriter::create(path, frames, metadata.clone(), options)?;
        let mut size = [0, 0];
        for t in 0..frames {
            let plane = frame(t)?;
            size = plane.domain().shape;
            let Some((path, bytes)) = writer.encoded(&plane)? else { continue };
            match &self.beside {
                Some((no_clobber, inputs)) => {
                    let staged = StagedFile::owned(path, bytes, *no_clobber, inputs)?;
                    self.staged.get_mut().unwrap_or_else(PoisonError::into_inner).push(staged);
                }
                None => {
                    self.made.push(OutputFile { path, bytes, size: None, told: Vec::new(), clip: Some(Value::Null) });
                }
            }
        }
        self.clip_end(path, writer, (size, frames), (rate, period))
    }

    /// Adds what comes last of a clip, and what is said of all of it.
    pub(crate) fn clip_end(
        &mut self,
        path: &Path,
        writer: ClipWriter,
        ([height, width], frames): ([u32; 2], u32),
        (rate, period): (Option<Rate>, Option<u32>),
    ) -> Result<(), Failure> {
        let mut ended = writer.ended()?;
        let (last, bytes) = ended.swap_remove(0);
        let more = ended.into_iter();
        self.made.extend(more.map(|(path, bytes)| OutputFile {
            path,
            bytes,
            size: None,
            told: Vec::new(),
            clip: Some(Value::Null),
        }));
        let noted = json!({
            "path": path_text(path),
            "blake3": blake3::hash(&bytes).to_hex().as_str(),
            "frames": frames,
            "width": width,
            "height": height,
            "period": period,
            "rate": rate.map(|rate| rate.to_string()),
        });
        self.made.push(OutputFile { path: last, bytes, size: None, told: Vec::new(), clip: Some(noted) });
        Ok(())
    }

    /// Adds all that others have made.
    pub(crate) fn extend(&mut self, others: Self) {
        self.made.extend(others.made);
        let staged = others.staged.into_inner().unwrap_or_else(PoisonError::into_inner);
        self.staged.get_mut().unwrap_or_else(PoisonError::into_inner).extend(staged);
    }

    /// Bytes of all of them.
    pub(crate) fn held(&self) -> u64 {
        self.made.iter().map(|made| made.bytes.len() as u64).sum()
    }

    /// The first picture as its file has it.
    pub(crate) fn first(&self) -> Result<Option<Plane<2>>, Failure> {
        let read = |made: &OutputFile| selvedge_io::decode(&made.bytes, &made.path, &ReadOptions::default());
        Ok(self.made.first().map(read).transpose()?.map(|picture| picture.plane))
    }

    /// Adds a file that is no picture.
    pub(crate) fn bytes(&mut self, path: &Path, bytes: Vec<u8>) {
        self.made.push(OutputFile { path: path.to_path_buf(), bytes, size: None, told: Vec::new(), clip: None });
    }

    /// What the report will say of them.
    pub(crate) fn noted(&self) -> Vec<Value> {
        self.made.iter().map(OutputFile::noted).filter(|noted| !noted.is_null()).collect()
    }

    /// Writes all of them, or none if one of them cannot be written.
    pub(crate) fn write(&self, session: &Session<'_>) -> Result<(), Failure> {
        Ok(selvedge_io::finish_all(self.stage(session)?)?)
    }

    /// Does all of it that may fail: then what goes to streams and devices is gone, and files lack nothing but their
    /// names.
    pub(crate) fn stage(&self, session: &Session<'_>) -> Result<Vec<StagedFile<'_>>, Failure> {
        for (made, warning) in self.made.iter().flat_map(|made| made.told.iter().map(move |w| (made, w))) {
            session.warn(&made.path, warning);
        }
        let (streams, files): (Vec<&OutputFile>, Vec<&OutputFile>) =
            self.made.iter().partition(|m| m.path.as_os_str() == STREAM);
        let (no_clobber, inputs) = (session.global.no_clobber, session.inputs());
        let staged = files.iter().map(|made| StagedFile::beside(&made.path, &made.bytes, no_clobber, &inputs));
        let mut staged = staged.collect::<Result<Vec<StagedFile<'_>>, _>>()?;
        staged.splice(0..0, std::mem::take(&mut *self.staged.lock().unwrap_or_else(PoisonError::into_inner)));
        let streamed = streams.iter().try_for_each(|made| stdio::picture(&made.bytes));
        streamed.map_err(|e| Failure::of_stream(&e))?;
        staged.iter_mut().try_for_each(StagedFile::send)?;
        Ok(staged)
    }
}

impl OutputFile {
    fn noted(&self) -> Value {
        if let Some(noted) = &self.clip {
            return noted.clone();
        }
        let mut noted = json!({"path": path_text(&self.path), "blake3": blake3::hash(&self.bytes).to_hex().as_str()});
        if let Some([width, height]) = self.size {
            (noted["width"], noted["height"]) = (width.into(), height.into());
        }
        noted
    }
}

/// What a dry run says of a picture that would be written.
pub(crate) fn planned(path: &Path, [height, width]: [u32; 2]) -> Value {
    json!({"path": path_text(path), "width": width, "height": height})
}

/// The same of a clip, the frames of which may not be known.
pub(crate) fn planned_clip(path: &Path, size: [u32; 2], frames: Option<u32>) -> Value {
    let mut planned = planned(path, size);
    planned["frames"] = frames.into();
    planned
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partial_results_keep_folder_and_extension() {
        assert_eq!(partial(Path::new("a/b.c.png")), Path::new("a/b.c.partial.png"));
        assert_eq!(partial(Path::new("out")), Path::new("out.partial"));
    }
}
