//! What can be known of an output before any work is done.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::atomic;
use crate::error::{Error, Problem};
use crate::identity::Destination;
use crate::name::file_of;

/// Refuses an output that could not be written at the end: it is one of the inputs, it exists and must not be
/// replaced, it is a folder, or its folder is read-only or cannot be made. Sweeps parts of it that a killed run left.
///
/// # Errors
/// Of kind `FileSystem` or `NoSpace`.
pub fn check_output(output: impl AsRef<Path>, inputs: &[PathBuf], no_clobber: bool) -> Result<(), Error> {
    check_outputs(&[output], inputs, no_clobber)
}

/// The same of several: inputs are found by where they lead, once for all outputs.
///
/// # Errors
/// Those of [`check_output`], of the first that has one.
pub fn check_outputs<P: AsRef<Path>>(outputs: &[P], inputs: &[PathBuf], no_clobber: bool) -> Result<(), Error> {
    let places: BTreeMap<Destination, &PathBuf> =
        inputs.iter().rev().map(|input| (Destination::of(file_of(input)), input)).collect();
    for output in outputs.iter().map(AsRef::as_ref) {
        if let Some(input) = places.get(&Destination::of(output)) {
            return Err(Error::new(output, Problem::IsInput { input: (*input).clone() }));
        }
        if no_clobber && fs::symlink_metadata(output).is_ok() {
            return Err(Error::new(output, Problem::Exists));
        }
        atomic::try_part(output)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atomic::tests::Folder;
    use crate::identity::same_file;

    #[test]
    fn an_output_that_is_an_input_is_refused_through_links() {
        let folder = Folder::new("same");
        let (file, hard, other) = (folder.path("a.exr"), folder.path("b.exr"), folder.path("c.exr"));
        fs::write(&file, b"a").unwrap();
        fs::write(&other, b"a").unwrap();
        fs::hard_link(&file, &hard).unwrap();
        let mut names = vec![file.clone(), hard];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&file, folder.path("d.exr")).unwrap();
            names.push(folder.path("d.exr"));
        }
        for name in &names {
            assert!(same_file(name, &file));
            let selected = PathBuf::from(format!("{}[R,G,B]", file.display()));
            let refused = check_output(name, &[other.clone(), selected], false);
            assert!(matches!(refused, Err(Error { problem: Problem::IsInput { .. }, .. })));
        }
        assert!(check_output(&other, &names, false).is_ok());
        fs::create_dir(folder.path("sub")).unwrap();
        let (none, roundabout) = (folder.path("none"), folder.path("sub/../none"));
        assert!(same_file(&none, &none) && same_file(&none, &roundabout), "the same once it is made");
        assert!(!same_file(&none, &folder.path("another")) && !same_file(&none, &file));
        let [deep, same] = ["x/y/a", "x/./z/../y/a"].map(|name| folder.path(name));
        assert!(same_file(&deep, &same) && !same_file(&deep, &folder.path("x/a")), "in folders that are not there yet");
    }

    #[test]
    fn what_cannot_be_written_is_known_before() {
        let folder = Folder::new("before");
        let file = folder.path("a.png");
        fs::write(&file, b"old").unwrap();
        let problem = |path: &Path, no_clobber| check_output(path, &[], no_clobber).err().map(|e| e.problem);
        assert!(matches!(problem(&file, true), Some(Problem::Exists)));
        assert!(problem(&file, false).is_none());
        assert!(problem(&folder.path("none/sub/a.png"), false).is_none(), "folders are made with the file");
        assert!(matches!(problem(&folder.path("a.png/b.png"), false), Some(Problem::NoFolder)));
        assert!(matches!(problem(&folder.path(""), false), Some(Problem::Folder)));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("nothing", folder.path("lost")).unwrap();
            for name in ["lost/a.png", "lost/sub/a.png"] {
                assert!(matches!(problem(&folder.path(name), false), Some(Problem::LostFolder)), "{name}");
            }
            fs::remove_file(folder.path("lost")).unwrap();
        }
        assert_eq!(folder.files(), [("a.png".to_owned(), b"old".to_vec())], "looking leaves nothing behind");
    }

    #[test]
    #[cfg(unix)]
    fn a_read_only_folder_is_known_before() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = Folder::new("readonly");
        fs::set_permissions(folder.path(""), fs::Permissions::from_mode(0o555)).unwrap();
        // A superuser may write there: then into a folder of the system, which nobody may.
        let own = fs::write(folder.path("probe"), b"").is_err().then(|| folder.path(""));
        let _ = fs::remove_file(folder.path("probe"));
        let closed = own.or_else(|| atomic::tests::closed_to_all().map(Path::to_owned));
        let asked = closed.as_ref().map(|closed| closed.join("a.png"));
        let refused = asked.as_ref().map(|path| check_output(path, &[], false));
        let written = asked.as_ref().map(|path| atomic::write_bytes(path, b"new", false));
        fs::set_permissions(folder.path(""), fs::Permissions::from_mode(0o755)).unwrap();
        let (Some(refused), Some(written)) = (refused, written) else {
            eprintln!("SKIPPED: this user may write everywhere");
            return;
        };
        for ended in [refused, written] {
            assert!(matches!(ended, Err(Error { problem: Problem::Denied | Problem::ReadOnly, .. })), "{ended:?}");
        }
        assert_eq!(folder.files(), []);
    }
}
