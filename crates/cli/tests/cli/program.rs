//! Running the program in a folder of its own.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use selvedge_core::{Grid, Plane, Role, Samples};
use serde_json::Value;

/// A folder of its own with the fixtures in reach, removed at the end.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("selvedge-cli-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.join(name)
    }

    /// The program, about to run in this folder.
    pub(crate) fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_selvedge"));
        command.current_dir(&self.0).stdin(Stdio::null());
        command
    }

    /// Runs the program with words separated by spaces; `@` stands for the folder of the fixtures.
    pub(crate) fn run(&self, line: &str) -> Said {
        let fixtures = fixtures();
        self.run_words(line.split_whitespace().map(|word| word.replace('@', &fixtures)))
    }

    pub(crate) fn run_words(&self, words: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Said {
        Said::from(self.command().args(words).output().unwrap())
    }

    /// Writes a picture that is another one, with alpha 0 in some columns; what these hide is written over with red.
    pub(crate) fn pierced(&self, of: &str, name: &str, hidden: impl Fn(u32) -> bool) {
        let plane = selvedge_io::read(of.replace('@', &fixtures()), &Default::default()).unwrap().plane;
        let Samples::U8(grid) = &plane.samples else { panic!("8 bits") };
        let (domain, colors) = (grid.domain(), plane.color_channels());
        let value = |c: usize, at: [u32; 2]| match (hidden(at[1]), c) {
            (true, 0) => 255,
            (true, _) => 0,
            (false, 3) => 255,
            (false, _) => grid.get(c.min(colors - 1), at),
        };
        let samples = (0..4).flat_map(|c| domain.positions().map(move |at| (c, at)));
        let samples = samples.map(|(c, at)| value(c, at)).collect();
        let mut made = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 4, samples).unwrap()));
        made.alpha = true;
        let path = self.path(name);
        let bytes = selvedge_io::encode(&made, &Default::default(), &path, &Default::default()).unwrap();
        fs::write(path, bytes).unwrap();
    }

    /// Files and folders by their names.
    pub(crate) fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let entries = fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().path());
        entries.map(|path| (path.file_name().unwrap().into(), fs::read(&path).unwrap_or_default())).collect()
    }

    pub(crate) fn names(&self) -> Vec<String> {
        self.files().keys().map(|name| name.to_string_lossy().into_owned()).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Where the fixtures lie.
pub(crate) fn fixtures() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").to_string_lossy().into_owned()
}

/// What the program said.
#[derive(Clone, Debug)]
pub(crate) struct Said {
    /// Exit code; `None` if a signal ended it.
    pub(crate) exit: Option<i32>,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: String,
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        Self { exit: output.status.code(), stdout: output.stdout, stderr }
    }
}

impl Said {
    /// It did what it should.
    #[track_caller]
    pub(crate) fn done(self) -> Self {
        assert_eq!(self.exit, Some(0), "{self:?}");
        self
    }

    /// It refused with this code, and said so in one line that holds all of these.
    #[track_caller]
    pub(crate) fn refused(self, exit: i32, parts: &[&str]) -> Self {
        assert_eq!(self.exit, Some(exit), "{self:?}");
        let lines: Vec<&str> = self.stderr.lines().collect();
        assert!(matches!(lines[..], [line] if line.starts_with("error: ")), "{self:?}");
        for part in parts {
            assert!(self.stderr.contains(part), "no {part:?} in {}", self.stderr);
        }
        self
    }

    /// Standard output as exactly one JSON object.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        let value: Value = serde_json::from_slice(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:?}"));
        assert!(value.is_object(), "{self:?}");
        value
    }
}
