//! Reading: from a name or bytes to a picture.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use selvedge_core::{Limits, Plane};

use crate::alpha::beyond_alpha;
use crate::by_format;
use crate::codec::Context;
use crate::error::{Error, Problem};
use crate::finite;
use crate::format::unread;
use crate::header::afford;
use crate::metadata::Metadata;
use crate::name::{display_name, file_of, selector};
use crate::options::ReadOptions;
use crate::provenance::Fingerprint;
use crate::samples::orient;
use crate::{Format, Warning};

/// A picture as read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Picture {
    /// The samples, in the depth of the file, the right way up.
    pub plane: Plane<2>,
    /// What the file says besides.
    pub metadata: Metadata,
    /// The format, by content.
    pub format: Format,
    /// BLAKE3 of the file's bytes, in hexadecimal.
    pub blake3: String,
    /// What was odd, but could be read.
    pub warnings: Vec<Warning>,
}

impl Picture {
    /// The file by name and content, as provenance and source maps name it.
    pub fn fingerprint(&self, path: impl AsRef<Path>) -> Fingerprint {
        Fingerprint { name: display_name(file_of(path.as_ref())), blake3: self.blake3.clone() }
    }
}

/// Reads a picture file. The format follows its content; sizes are checked before anything is decoded.
///
/// `file.exr[diffuse]` and `file.exr[R,G,B]` choose a layer or channels of an EXR file, unless a file of just this name
/// exists; see [`ReadOptions::channels`].
///
/// # Errors
/// [`Error`] with the file, the numbers and a remedy.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Picture, Error> {
    let named = path.as_ref();
    let (path, options) = split_selector(named, options);
    let bytes = read_bytes(&path, &options.limits).map_err(|p| Error::new(named, p))?;
    decode(&bytes, &path, &options)
}

/// Reads a picture from the bytes of its file. `name` stands in errors, and its extension is compared with the content.
///
/// # Errors
/// [`Error`] with the name, the numbers and a remedy.
pub fn decode(bytes: &[u8], name: impl AsRef<Path>, options: &ReadOptions) -> Result<Picture, Error> {
    let name = name.as_ref();
    decode_content(bytes, name, options).map_err(|p| Error::new(name, p))
}

fn decode_content(bytes: &[u8], name: &Path, options: &ReadOptions) -> Result<Picture, Problem> {
    let mut context = Context::new(options, bytes.len() as u64);
    let format = format_of(bytes, name, &mut context)?;
    let (description, mut samples) = by_format::decode(format, bytes, &mut context)?;
    if let Some(count) = finite::enforce(&mut samples, options.nonfinite)? {
        context.warn(Warning::NotFinite { count });
    }
    let samples = orient(samples, description.orientation)?;
    let association = description.association.or(format.association()).unwrap_or_default();
    let plane = Plane { role: options.role, samples, alpha: description.header.alpha, association };
    match beyond_alpha(&plane) {
        0 => {}
        count => context.warn(Warning::BeyondAlpha { count }),
    }
    let blake3 = blake3::hash(bytes).to_hex().to_string();
    Ok(Picture { plane, metadata: description.metadata, format, blake3, warnings: context.warnings })
}

/// The format by content, with a warning where the name says another one.
pub(crate) fn format_of(start: &[u8], name: &Path, context: &mut Context<'_>) -> Result<Format, Problem> {
    if start.is_empty() {
        return Err(Problem::Empty);
    }
    let unknown = || unread(start).map_or(Problem::UnknownContent, Problem::NotRead);
    let content = Format::of_content(start).ok_or_else(unknown)?;
    if context.options.channels.is_some() && !matches!(content, Format::Exr | Format::Tiff) {
        return Err(Problem::unsupported(content, "choosing layers or channels"));
    }
    match Format::of_name(name) {
        Some(named) if named != content => context.warn(Warning::Misnamed { content, named }),
        _ => {}
    }
    Ok(content)
}

/// Parts `file.exr[R,G,B]` into the file and the choice.
pub(crate) fn split_selector(path: &Path, options: &ReadOptions) -> (PathBuf, ReadOptions) {
    match selector(path) {
        Some((file, choice)) => (file.into(), ReadOptions { channels: Some(choice.to_owned()), ..options.clone() }),
        None => (path.to_path_buf(), options.clone()),
    }
}

/// A regular file's bytes, within the memory budget.
pub(crate) fn read_bytes(path: &Path, limits: &Limits) -> Result<Vec<u8>, Problem> {
    let (mut file, len) = open(path)?;
    afford(limits, len)?;
    let mut bytes = Vec::new();
    let refused = |_| selvedge_core::Error::Allocation { bytes: len };
    bytes.try_reserve_exact(usize::try_from(len).unwrap_or(usize::MAX)).map_err(refused)?;
    // A file that grows while it is read ends where it ended when it was opened.
    file.by_ref().take(len).read_to_end(&mut bytes).map_err(|e| Problem::file_system(e, len))?;
    Ok(bytes)
}

/// Opens a regular file. Looking first keeps pipes and devices from hanging or never ending.
pub(crate) fn open(path: &Path) -> Result<(File, u64), Problem> {
    let wrong = |e| Problem::file_system(e, 0);
    let metadata = std::fs::metadata(path).map_err(wrong)?;
    if metadata.is_dir() {
        return Err(Problem::Folder);
    }
    if !metadata.is_file() {
        return Err(Problem::Special);
    }
    Ok((File::open(path).map_err(wrong)?, metadata.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brackets_choose_channels() {
        let split = |path: &str| {
            let (file, options) = split_selector(Path::new(path), &ReadOptions::default());
            (file.to_str().unwrap().to_owned(), options.channels)
        };
        assert_eq!(split("a.exr[R,G,B]"), ("a.exr".into(), Some("R,G,B".into())));
        assert_eq!(split("a[1].exr[diffuse]"), ("a[1].exr".into(), Some("diffuse".into())));
        assert_eq!(split("a[1].exr"), ("a[1].exr".into(), None));
        assert_eq!(split("[x]"), ("[x]".into(), None));
    }

    #[test]
    fn only_regular_files_are_opened() {
        assert!(matches!(open(Path::new("no such file")), Err(Problem::Missing)));
        assert!(matches!(open(Path::new(".")), Err(Problem::Folder)));
        if Path::new("/dev/zero").exists() {
            assert!(matches!(open(Path::new("/dev/zero")), Err(Problem::Special)));
        }
    }
}
