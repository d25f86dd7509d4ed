//! Clips, flipbooks and names from bytes: what the fuzzers feed, and what the corpus replays.
//!
//! Any bytes are answered with frames or with one line, never with more than they hold; sizes are bounded, so every run
//! ends soon.

use std::fs;
use std::path::{Path, PathBuf};

use selvedge_core::{Domain, Grid, Limits, Plane, Role, Samples};
use selvedge_io::clip::{ClipName, ClipOptions, ClipReader, Flipbook, Range, Rate, clip_files};
use selvedge_io::{Error, Metadata, ReadOptions, WriteOptions};

/// No clip is larger.
const LIMITS: Limits = Limits { memory: 64 << 20, side: 4096, samples: 1 << 20 };

fn options(flipbook: Option<Flipbook>) -> ClipOptions {
    let frame = ReadOptions { limits: LIMITS, ..ReadOptions::default() };
    ClipOptions { frame, flipbook, ..ClipOptions::default() }
}

/// What is said of a clip is one line.
fn said(error: &Error) {
    assert!(!error.to_string().contains(char::is_control), "{error:?}");
}

/// All frames: of the size and the layout that the head tells, and no more of them.
fn frames(reader: &mut ClipReader) -> Result<Vec<Plane<2>>, Error> {
    let (mut frames, info) = (Vec::new(), reader.info().clone());
    while let Some(frame) = reader.next()? {
        assert_eq!(frame.domain().shape, [info.height, info.width]);
        assert_eq!((frame.samples.channels(), frame.samples.depth()), (info.channels, info.depth));
        frames.push(frame);
        assert!(frames.len() <= info.frames as usize, "more frames than {}", info.frames);
    }
    assert_eq!(frames.len(), info.frames as usize);
    Ok(frames)
}

/// A clip in one file: a y4m, an animated PNG, a GIF, a WebP. It reads the same again.
pub(crate) fn run_clip(data: &[u8]) {
    let mut reader = match ClipReader::of_bytes(data.to_vec(), "x", &options(None)) {
        Ok(reader) => reader,
        Err(e) => return said(&e),
    };
    match frames(&mut reader) {
        Ok(first) => {
            reader.rewind().expect("it was read before");
            assert_eq!(frames(&mut reader).expect("it was read before"), first);
        }
        Err(e) => said(&e),
    }
}

/// A flipbook: columns, rows, padding, width and height of a picture, and its samples as far as they go. Where frames
/// fill it, they are its cells.
pub(crate) fn run_flipbook(data: &[u8]) {
    if let Ok(text) = std::str::from_utf8(data) {
        let parsed: Option<Flipbook> = text.parse().ok();
        assert_eq!(parsed.map(|book| book.to_string().parse::<Flipbook>().expect("as it is shown")), parsed);
    }
    let byte = |i: usize, below: u8| u32::from(data.get(i).copied().unwrap_or(0) % below);
    let book = Flipbook { columns: byte(0, 5) + 1, rows: byte(1, 5) + 1, pad: byte(2, 3) };
    let (width, height) = (byte(3, 40) + 1, byte(4, 40) + 1);
    let value = |i: usize| data.get(5 + i).copied().unwrap_or(0);
    let domain = Domain::open([height, width]);
    let samples = Grid::from_vec(domain, 1, (0..domain.len()).map(value).collect()).expect("so many samples");
    let sheet = Plane::new(Role::Scalar, Samples::U8(samples));
    let folder = Scratch::new();
    let path = folder.0.join("sheet.png");
    selvedge_io::write(&path, &sheet, &Metadata::default(), &WriteOptions::default()).expect("a picture");
    let fits = |side: u32, count: u32| side.is_multiple_of(count) && 2 * book.pad < side / count;
    let read = ClipReader::open(&path, &options(Some(book))).and_then(|mut reader| frames(&mut reader));
    let read = match read {
        Ok(read) => read,
        Err(e) => {
            assert!(!(fits(width, book.columns) && fits(height, book.rows)), "{book:?} of {width}x{height}: {e}");
            return said(&e);
        }
    };
    assert!(fits(width, book.columns) && fits(height, book.rows), "{book:?} of {width}x{height}");
    let cell = [height / book.rows, width / book.columns];
    for (t, frame) in (0..).zip(&read) {
        let corner = [t / book.columns * cell[0] + book.pad, t % book.columns * cell[1] + book.pad];
        for (i, at) in frame.domain().positions().enumerate() {
            let from = domain.index([0, 1].map(|axis| corner[axis] + at[axis]));
            assert_eq!(frame.samples.value(0, i), sheet.samples.value(0, from), "{book:?}, frame {t} at {at:?}");
        }
    }
}

/// A name on the first line, the range of frames on the second, and on all others the names of files beside it. What is
/// found are some of them, in an order, none twice.
pub(crate) fn run_names(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    if let Ok(range) = text.parse::<Range>() {
        assert_eq!(range.to_string().parse::<Range>().ok(), Some(range));
    }
    if let Ok(rate) = text.parse::<Rate>() {
        assert_eq!(rate.to_string().parse::<Rate>().ok(), Some(rate), "'{text}'");
    }
    // Names of files, not paths to elsewhere.
    let mut lines = text.lines().map(|line| line.replace(['/', '\0'], "_"));
    let (name, range) = (lines.next().unwrap_or_default(), lines.next().and_then(|range| range.parse().ok()));
    let folder = Scratch::new();
    let files: Vec<String> = lines.take(40).filter(|file| fs::write(folder.0.join(file), "").is_ok()).collect();
    let path = folder.0.join(&name);
    if let Some(name @ ClipName::Sequence(_)) = ClipName::parse(&path) {
        let made = [0, 7, 99_999, u32::MAX].map(|number| name.file(number).expect("a sequence has files"));
        assert!(made.iter().all(|file| file.parent() == Some(&folder.0)));
        assert!((1..4).all(|i| made[i] != made[i - 1]), "{made:?}");
    }
    match clip_files(&path, range) {
        Ok(mut found) => {
            let here = |file: &PathBuf| file.file_name().and_then(|name| name.to_str().map(str::to_owned));
            // A choice of layers stands behind each name.
            assert!(found.iter().all(|file| here(file).is_some_and(|f| files.iter().any(|w| f.starts_with(w)))));
            let count = found.len();
            found.sort();
            found.dedup();
            assert_eq!((found.len(), 0 < count), (count, true));
        }
        Err(e) => said(&e),
    }
}

/// A folder of this run, removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Self {
        let name = format!("selvedge-bytes-{}-{:?}", std::process::id(), std::thread::current().id());
        let path = std::env::temp_dir().join(name.replace(['(', ')'], ""));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(AsRef::<Path>::as_ref(&self.0));
    }
}
