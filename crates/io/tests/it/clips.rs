//! Clips: what is written is read, and every frame is as good as a picture.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{bits, plane};
use selvedge_core::{Depth, Domain, Grid, Limits, Plane, Role, Samples};
use selvedge_io::clip::{ClipOptions, ClipProblem, ClipReader, ClipWriteOptions, ClipWriter, frame_of, read_clip};
use selvedge_io::{Error, Metadata, Problem, ReadOptions, WriteOptions};

/// A folder of its own, removed at the end.
pub(crate) struct Folder(PathBuf);
impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("selvedge-clips-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}
impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Frames of random samples, none like another.
pub(crate) fn frames(depth: Depth, colors: usize, alpha: bool, [count, h, w]: [u32; 3]) -> Vec<Plane<2>> {
    let all = plane(depth, colors, alpha, [count * h, w]);
    let n = (h * w) as usize;
    let domain = Domain::open([h, w]);
    let part = |t: usize| {
        fn of<T: Copy>(all: &Grid<T, 2>, domain: Domain<2>, t: usize, n: usize) -> Grid<T, 2> {
            let samples = (0..all.channels()).flat_map(|c| all.plane(c)[t * n..][..n].to_vec()).collect();
            Grid::from_vec(domain, all.channels(), samples).unwrap()
        }
        let samples = match &all.samples {
            Samples::U8(g) => Samples::U8(of(g, domain, t, n)),
            Samples::U16(g) => Samples::U16(of(g, domain, t, n)),
            Samples::F16(g) => Samples::F16(of(g, domain, t, n)),
            Samples::F32(g) => Samples::F32(of(g, domain, t, n)),
        };
        Plane { samples, ..all.clone() }
    };
    (0..count as usize).map(part).collect()
}

pub(crate) fn write(path: &Path, frames: &[Plane<2>], options: ClipWriteOptions) -> Result<ClipWriter, Error> {
    let mut writer = ClipWriter::create(path, frames.len() as u32, Metadata::default(), options)?;
    for frame in frames {
        writer.frame(frame)?;
    }
    Ok(writer)
}

pub(crate) fn open(path: &Path) -> Result<ClipReader, Error> {
    ClipReader::open(path, &ClipOptions::default())
}

pub(crate) fn all(reader: &mut ClipReader) -> Vec<Plane<2>> {
    std::iter::from_fn(|| reader.next().unwrap()).collect()
}

#[test]
fn sequences_of_every_depth_come_back_bit_for_bit() {
    for (name, depth, colors, alpha) in [
        ("a.####.png", Depth::U8, 3, true),
        ("a.%03d.png", Depth::U16, 1, false),
        ("a#.tif", Depth::U16, 3, true),
        ("sub/deep/a.####.exr", Depth::F16, 3, false),
        ("a.##.exr", Depth::F32, 1, false),
    ] {
        let folder = Folder::new(&format!("depth-{}-{colors}-{alpha}", depth.name()));
        let written = frames(depth, colors, alpha, [11, 5, 7]);
        let path = folder.path(name);
        let options = ClipWriteOptions { rate: "25".parse().ok(), period: Some(11), ..ClipWriteOptions::default() };
        let writer = write(&path, &written, options).unwrap();
        let files = writer.files();
        writer.finish().unwrap();
        assert!(files.iter().all(|file| file.is_file()), "{files:?}");
        let mut reader = open(&path).unwrap();
        let info = reader.info();
        assert_eq!((info.width, info.height, info.frames, info.depth, info.alpha), (7, 5, 11, depth, alpha));
        let read = all(&mut reader);
        assert!(read.iter().zip(&written).all(|(a, b)| bits(a) == bits(b)), "{name}");
        let hash = reader.fingerprint();
        reader.rewind().unwrap();
        let clip = read_clip(&mut reader, &Limits::default()).unwrap();
        assert_eq!(reader.fingerprint(), hash);
        for (t, frame) in (0..).zip(&written) {
            assert_eq!(bits(&frame_of(&clip, t).unwrap()), bits(frame));
        }
        let manifest = fs::read_to_string(files.last().unwrap()).unwrap();
        assert!(manifest.contains("\"frames\": 11,") && manifest.contains("\"rate\": [25, 1]"), "{manifest}");
        assert_eq!(manifest.matches("blake3").count(), 11);
    }
}

#[test]
fn folders_and_globs_are_in_natural_order() {
    let folder = Folder::new("order");
    let written = frames(Depth::U8, 1, false, [11, 2, 2]);
    // Numbers without padding.
    write(&folder.path("a%d.png"), &written, ClipWriteOptions::default()).unwrap();
    fs::write(folder.path("notes.txt"), "no frame").unwrap();
    for name in ["", "a*.png", "a%d.png", "a#.png"] {
        assert_eq!(all(&mut open(&folder.path(name)).unwrap()), written, "{name}");
    }
    let range = ClipOptions { range: "3-9x3".parse().ok(), ..ClipOptions::default() };
    let mut some = ClipReader::open(folder.path(""), &range).unwrap();
    assert_eq!(all(&mut some), [2, 5, 8].map(|i: usize| written[i].clone()));
    fs::remove_file(folder.path("a7.png")).unwrap();
    let gap = open(&folder.path("")).unwrap_err();
    assert!(matches!(gap.problem, Problem::Clip(ClipProblem::Gap { number: 7, before: Some(6) })), "{gap}");
}

#[test]
fn a_pattern_says_which_number_is_meant() {
    let folder = Folder::new("pattern");
    let written = frames(Depth::U8, 1, false, [3, 2, 2]);
    for name in ["a_##_2k.png", "shot.####.v2.png", "%03d-of-3.png"] {
        write(&folder.path(name), &written, ClipWriteOptions::default()).unwrap();
        assert_eq!(all(&mut open(&folder.path(name)).unwrap()), written, "{name}");
    }
}

#[test]
fn frames_that_differ_are_named() {
    let folder = Folder::new("differ");
    let (path, third) = (folder.path("a.##.png"), folder.path("a.03.png"));
    let first = frames(Depth::U8, 3, false, [4, 6, 8]);
    for (other, has) in [
        (frames(Depth::U8, 3, false, [1, 6, 9]), "9x6 px, 3 u8 channel(s)"),
        (frames(Depth::U16, 3, false, [1, 6, 8]), "8x6 px, 3 u16 channel(s)"),
        (frames(Depth::U8, 3, true, [1, 6, 8]), "8x6 px, 3 u8 channel(s) and alpha"),
        (frames(Depth::U8, 1, false, [1, 6, 8]), "8x6 px, 1 u8 channel(s)"),
    ] {
        write(&path, &first, ClipWriteOptions::default()).unwrap();
        selvedge_io::write(&third, &other[0], &Metadata::default(), &WriteOptions::default()).unwrap();
        let line = open(&path).unwrap_err().to_string();
        assert!(line.contains("a.03.png'") && line.contains(&format!("frame 3 has {has}, but")), "{line}");
    }
    // Every prefix of a frame is an error that names it.
    write(&path, &first, ClipWriteOptions::default()).unwrap();
    let whole = fs::read(&third).unwrap();
    for end in 0..whole.len() {
        fs::write(&third, &whole[..end]).unwrap();
        let read = open(&path).and_then(|mut reader| read_clip(&mut reader, &Limits::default()));
        let line = read.unwrap_err().to_string();
        assert!(line.contains("a.03.png'"), "cut at {end}: {line}");
    }
}

#[test]
fn floats_of_every_frame_are_finite() {
    let folder = Folder::new("finite");
    let path = folder.path("a.#.exr");
    let mut written = frames(Depth::F32, 1, false, [3, 2, 2]);
    let Samples::F32(last) = &mut written[2].samples else { unreachable!() };
    last.samples_mut()[3] = f32::NAN;
    write(&path, &written, ClipWriteOptions::default()).unwrap();
    let mut reader = open(&path).unwrap();
    let refused = read_clip(&mut reader, &Limits::default()).unwrap_err();
    assert!(
        matches!(refused.problem, Problem::NotFinite { count: 1, x: 1, y: 1, .. }) && refused.path.ends_with("a.3.exr")
    );
}

#[test]
fn a_picture_is_a_clip_of_equal_frames() {
    let folder = Folder::new("picture");
    let (path, picture) = (folder.path("plate.png"), plane(Depth::U16, 3, true, [7, 5]));
    selvedge_io::write(&path, &picture, &Metadata::default(), &WriteOptions::default()).unwrap();
    let mut reader = ClipReader::of_picture(&path, 3, &ReadOptions::default()).unwrap();
    let info = reader.info();
    assert_eq!((info.frames, info.rate, info.container.as_str()), (3, None, "png picture"));
    let clip = read_clip(&mut reader, &Limits::default()).unwrap();
    assert!((0..3).all(|t| bits(&frame_of(&clip, t).unwrap()) == bits(&picture)));
    assert_eq!(reader.frame_fingerprints(), vec![reader.fingerprint(); 3]);
    reader.seek(2).unwrap();
    assert!(reader.next().unwrap().is_some() && reader.next().unwrap().is_none());
    assert!(ClipReader::of_picture(folder.path("none.png"), 3, &ReadOptions::default()).is_err());
}

#[test]
fn clips_that_are_too_large_are_refused_before_they_are_read() {
    let folder = Folder::new("large");
    let path = folder.path("a.#.png");
    write(&path, &frames(Depth::U8, 3, false, [5, 10, 10]), ClipWriteOptions::default()).unwrap();
    let refused = |limits: Limits| read_clip(&mut open(&path).unwrap(), &limits).unwrap_err().to_string();
    let samples = refused(Limits { samples: 499, ..Limits::default() });
    assert!(samples.contains("5 frames of 10x10 px are 500 px, over the cap of 499 px"), "{samples}");
    let memory = refused(Limits { memory: 2000, ..Limits::default() });
    assert!(memory.contains("needs about 2.1 KiB of memory, and 2.0 KiB are allowed"), "{memory}");
    let each = ReadOptions { limits: Limits { samples: 99, ..Limits::default() }, ..ReadOptions::default() };
    let frame = ClipReader::open(&path, &ClipOptions { frame: each, ..ClipOptions::default() });
    assert!(matches!(frame.unwrap_err().problem, Problem::Samples { .. }));
}

#[test]
fn what_a_longer_run_left_is_named_and_nothing_is_written_for_wrong_names() {
    let folder = Folder::new("left");
    let path = folder.path("a.##.png");
    let written = frames(Depth::U8, 1, false, [4, 2, 2]);
    write(&path, &written, ClipWriteOptions::default()).unwrap();
    let shorter = write(&path, &written[..2], ClipWriteOptions::default()).unwrap();
    assert_eq!(shorter.left_over(), [folder.path("a.03.png"), folder.path("a.04.png")]);
    // A folder's are its own, whatever their names.
    let whole = folder.path("whole");
    std::fs::create_dir(&whole).unwrap();
    write(&whole, &written, ClipWriteOptions::default()).unwrap();
    std::fs::copy(whole.join("0001.png"), whole.join("other.png")).unwrap();
    let shorter = write(&whole, &written[..2], ClipWriteOptions::default()).unwrap();
    assert_eq!(shorter.left_over(), ["0003.png", "0004.png", "other.png"].map(|name| whole.join(name)));
    for none in ["a.*.png", "a#", "a.##", "a-%d-%d.png"] {
        let line = write(&folder.path(none), &written, ClipWriteOptions::default()).unwrap_err().to_string();
        assert!(line.contains("is the name of no clip"), "{line}");
    }
    let line = write(&folder.path("a.##.xyz"), &written, ClipWriteOptions::default()).unwrap_err().to_string();
    assert!(line.contains("'xyz' is no format"), "{line}");
    let unfinished = ClipWriter::create(&path, 3, Metadata::default(), ClipWriteOptions::default()).unwrap();
    assert!(matches!(unfinished.finish().unwrap_err().problem, Problem::Clip(ClipProblem::Count { .. })));
    for (none, what) in [("b.##.png", "no frame of this name was found"), ("gone/a.##.png", "not found")] {
        let line = open(&folder.path(none)).unwrap_err().to_string();
        assert!(line.contains(what), "{line}");
    }
    let no_clobber = WriteOptions { no_clobber: true, ..WriteOptions::default() };
    let kept = write(&path, &written, ClipWriteOptions { frame: no_clobber, ..ClipWriteOptions::default() });
    assert!(matches!(kept.unwrap_err().problem, Problem::Exists));
    assert_eq!(written[0].role, Role::Color);
}

/// Every frame can be gone to, forwards and back, in files of all frames by passing over others.
#[test]
fn frames_are_found_by_their_numbers() {
    let folder = Folder::new("seek");
    let planes = frames(Depth::U8, 3, false, [9, 5, 4]);
    for name in ["a.##.png", "a.png", "b.y4m"] {
        let mut writer =
            ClipWriter::create(folder.path(name), 9, Metadata::default(), ClipWriteOptions::default()).unwrap();
        planes.iter().for_each(|plane| writer.frame(plane).unwrap());
        writer.finish().unwrap();
        for (range, all) in [(None, (0..9).collect::<Vec<u32>>()), (Some("2-8x3"), vec![1, 4, 7])] {
            let range = range.map(|range| range.parse().unwrap());
            let options = ClipOptions { range, ..ClipOptions::default() };
            let mut reader = ClipReader::open(folder.path(name), &options).unwrap();
            let plane = read_clip(&mut reader, &Limits::default()).unwrap();
            let last = all.len() as u32 - 1;
            for at in [last, 0, 1, 1, 2, 0, last, last - 1] {
                reader.seek(at).unwrap();
                let found = reader.next().unwrap().unwrap();
                assert_eq!(found, frame_of(&plane, at).unwrap(), "{name} {range:?} {at}");
                // Chroma comes back within a value.
                assert!(name == "b.y4m" || found == planes[all[at as usize] as usize], "{name} {range:?} {at}");
            }
            reader.seek(last + 1).unwrap();
            assert!(reader.next().unwrap().is_none(), "{name}");
        }
    }
    let mut reader = ClipReader::open(folder.path("a.##.png"), &ClipOptions::default()).unwrap();
    while reader.next().unwrap().is_some() {}
    fs::copy(folder.path("a.03.png"), folder.path("a.05.png")).unwrap();
    reader.seek(4).unwrap();
    let error = reader.next().unwrap_err();
    assert!(error.to_string().contains("a.05.png") && matches!(error.problem, Problem::Clip(ClipProblem::Changed)));
}
