//! Clips in containers of other programs, by a script that stands for `ffmpeg`.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use selvedge_core::{Plane, Samples};
use selvedge_io::ReadOptions;
use selvedge_io::clip::{ClipOptions, ClipReader};

use crate::program::{Folder, Said, fixtures};

/// Answers as `ffmpeg` does: with frames that lie beside it, or with a file that holds what it was handed.
const FAKE: &str = r#"
here=$(dirname "$0")
for last in "$@"; do :; done
echo "$@" >> "$here/args"
echo $$ > "$here/pid"
case "$*" in
    *yuv4mpegpipe*) printf 'YUV4MPEG2 W4 H4 F30000:1001 Ip A1:1 C420jpeg\nFRAME\n........................' ;;
    *image2pipe*) cat "$here/frames.pam" ;;
    *rawvideo*) { printf '0000ftypisom'; cat; } > "${last#file:}" ;;
esac
"#;

/// A folder whose `bin` has this script for `ffmpeg`, and a file that begins as an mp4 does.
fn folder(name: &str, script: &str) -> Folder {
    let folder = Folder::new(name);
    fs::create_dir(folder.path("bin")).unwrap();
    let program = folder.path("bin/ffmpeg");
    fs::write(&program, format!("#!/bin/sh\n{script}")).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    fs::write(folder.path("in.mp4"), b"0000ftypisom, and what nobody looks at").unwrap();
    folder
}

/// The program, which finds the script before any other.
fn command(folder: &Folder, line: &str) -> Command {
    let mut command = folder.command();
    let path = std::env::var("PATH").unwrap_or_default();
    command.env("PATH", format!("{}:{path}", folder.path("bin").display()));
    let fixtures = fixtures();
    command.args(line.split('|').flat_map(|part| match part.strip_prefix('=') {
        Some(whole) => vec![whole.to_owned()],
        None => part.split_whitespace().map(|word| word.replace('@', &fixtures)).collect(),
    }));
    command
}

fn run(folder: &Folder, line: &str) -> Said {
    Said::from(command(folder, line).output().unwrap())
}

fn frames(path: impl AsRef<std::path::Path>) -> Vec<Plane<2>> {
    let mut reader = ClipReader::open(path, &ClipOptions::default()).unwrap();
    std::iter::from_fn(|| reader.next().unwrap()).collect()
}

/// Pixel by pixel.
fn raw(plane: &Plane<2>) -> Vec<u8> {
    let n = plane.domain().len();
    let values = (0..n).flat_map(|i| (0..plane.samples.channels()).map(move |c| (c, i)));
    match &plane.samples {
        Samples::U8(grid) => values.map(|(c, i)| grid.plane(c)[i]).collect(),
        Samples::U16(grid) => values.flat_map(|(c, i)| grid.plane(c)[i].to_be_bytes()).collect(),
        _ => unreachable!("clips of integers"),
    }
}

/// Frames as the script hands them over.
fn pam(frames: &[Plane<2>]) -> Vec<u8> {
    let of = |plane: &Plane<2>| {
        let ([h, w], channels) = (plane.domain().shape, plane.samples.channels());
        let most = if matches!(plane.samples, Samples::U8(_)) { 255 } else { 65_535 };
        let kind = if plane.alpha { "RGB_ALPHA" } else { "RGB" };
        let head = format!("P7\nWIDTH {w}\nHEIGHT {h}\nDEPTH {channels}\nMAXVAL {most}\nTUPLTYPE {kind}\nENDHDR\n");
        [head.into_bytes(), raw(plane)].concat()
    };
    frames.iter().flat_map(of).collect()
}

/// What is left of a run but what was there before it.
fn left(folder: &Folder) -> Vec<String> {
    folder.names().into_iter().filter(|name| !["bin", "in.mp4"].contains(&name.as_str())).collect()
}

fn is_gone(folder: &Folder) -> bool {
    let id = fs::read_to_string(folder.path("bin/pid")).unwrap();
    !std::path::Path::new("/proc").exists() || !std::path::Path::new(&format!("/proc/{}", id.trim())).exists()
}

#[test]
fn other_containers_are_read_frame_by_frame_as_they_are() {
    let folder = folder("ffmpeg-reads", FAKE);
    let clip = frames(fixtures() + "/fire.png");
    fs::write(folder.path("bin/frames.pam"), pam(&clip)).unwrap();
    let said = run(&folder, "video in.mp4 -o a.####.png --seed 3 --json").done().json();
    folder.run("video @/fire.png -o b.####.png --seed 3").done();
    let input = &said["inputs"][0];
    assert_eq!((&input["container"], &input["rate"]), (&"mp4".into(), &"30000/1001".into()));
    assert_eq!(input["frames"], clip.len());
    assert_eq!(input["blake3"], blake3::hash(&fs::read(folder.path("in.mp4")).unwrap()).to_hex().as_str());
    assert_eq!(frames(folder.path("a.####.png")), frames(folder.path("b.####.png")));
    // Some of them: what comes after is not asked for.
    let some = run(&folder, "video in.mp4 -o c.####.png --range 3-20 --json").done().json();
    assert_eq!(some["inputs"][0]["frames"], 18);
    let args = fs::read_to_string(folder.path("bin/args")).unwrap();
    assert!(args.lines().last().unwrap().contains("-i file:in.mp4 -map 0:v:0 -frames:v 20 "), "{args}");
    run(&folder, "video in.mp4 -o c.####.png --range 3-900").refused(3, &["'in.mp4'", "frame 41 is missing"]);
    run(&folder, "inspect in.mp4 --json").done();
}

#[test]
fn deep_frames_and_alpha_come_and_go_whole() {
    let folder = folder("ffmpeg-deep", FAKE);
    folder.pierced("@/cobbles.png", "one.png", |x| x < 8);
    let one = selvedge_io::read(folder.path("one.png"), &ReadOptions::default()).unwrap().plane;
    let Samples::U8(grid) = &one.samples else { panic!("8 bits") };
    let deep = |t: u16| {
        let samples = grid.samples().iter().map(|&v| u16::from(v) * 257 / t).collect();
        let grid = selvedge_core::Grid::from_vec(grid.domain(), 4, samples).unwrap();
        Plane { samples: Samples::U16(grid), ..one.clone() }
    };
    let clip: Vec<_> = [1, 2, 3, 2, 1, 2, 3, 2].map(deep).into();
    fs::write(folder.path("bin/frames.pam"), pam(&clip)).unwrap();
    run(&folder, "video in.mp4 -o out.mov -q").refused(3, &["'out.mov'", "alpha", "--encode"]);
    let line = "video in.mp4 -o out.mov --jump 5,2 --encode|=-c:v prores_ks -profile:v 4444|--json";
    let said = run(&folder, line).done().json();
    assert_eq!(said["options"]["encode"], "-c:v prores_ks -profile:v 4444");
    run(&folder, "video in.mp4 -o out.####.png --jump 5,2").done();
    let mut expected = b"0000ftypisom".to_vec();
    for frame in frames(folder.path("out.####.png")) {
        expected.extend(raw(&frame).chunks(2).flat_map(|v| [v[1], v[0]]));
    }
    assert_eq!(fs::read(folder.path("out.mov")).unwrap(), expected);
    let args = fs::read_to_string(folder.path("bin/args")).unwrap();
    let written = args.lines().rfind(|line| line.contains("rawvideo")).unwrap();
    assert!(
        written.contains("-pixel_format rgba64le -video_size 192x192 -framerate 30000/1001 -i pipe:0 -c:v prores_ks")
    );
    assert!(written.contains("-f mov -y file:") && written.ends_with(".part"), "{written}");
}

#[test]
fn without_ffmpeg_one_line_says_how_else() {
    let folder = folder("ffmpeg-none", "exit 0");
    let none = |line: &str| Said::from(command(&folder, line).env("PATH", folder.path("empty")).output().unwrap());
    none("video in.mp4 -o a.gif").refused(3, &["'in.mp4': needs ffmpeg", "-f yuv4mpegpipe", "selvedge ... -"]);
    none("video @/fire.png -o a.mp4").refused(2, &["'a.mp4': needs ffmpeg", "-o - | ffmpeg -i - FILE"]);
    none("inspect in.mp4").refused(3, &["needs ffmpeg"]);
    none("video @/fire.png -o a.gif --encode|=-c:v x|").refused(2, &["'a.gif': is encoded without ffmpeg"]);
    assert_eq!(left(&folder), [""; 0]);
}

#[test]
fn what_fails_is_told_by_its_last_line_and_leaves_nothing() {
    let flood = "i=0; while [ $i -lt 3000 ]; do echo 'words that nobody reads, again and again' >&2; i=$((i+1)); done";
    let fails = format!("echo $$ > $(dirname $0)/pid\n{flood}\necho 'moov atom not found' >&2; exit 1");
    let folder = folder("ffmpeg-fails", &fails);
    run(&folder, "video in.mp4 -o a.gif").refused(3, &["'in.mp4': ffmpeg failed: moov atom not found"]);
    // Before any work.
    let line = "video @/fire.png -o a.mp4 --encode|=-c:v none|";
    run(&folder, line).refused(2, &["'a.mp4': ffmpeg failed: moov atom not found"]);
    assert!(left(&folder).is_empty() && is_gone(&folder), "{:?}", left(&folder));
    // Frames that end in the middle of one, or that change.
    let clip = frames(fixtures() + "/fire.png");
    let whole = pam(&clip[..4]);
    let folder = self::folder("ffmpeg-cut", FAKE);
    for (pam, said) in [
        (&whole[..whole.len() - 1], "it ends early"),
        (&whole[..whole.len() / 4 + 20], "it ends early"),
        (b"", "it has no frames"),
        (b"P6\n", "does not begin as such"),
        (b"P7\nWIDTH 70000\nHEIGHT 70000\nDEPTH 3\nMAXVAL 255\nENDHDR\n", "70000x70000"),
    ] {
        fs::write(folder.path("bin/frames.pam"), pam).unwrap();
        run(&folder, "video in.mp4 -o a.gif").refused(3, &["'in.mp4'", said]);
        assert!(left(&folder).is_empty());
    }
}

#[test]
fn a_signal_ends_the_child_too() {
    let hangs = r#"echo $$ > $(dirname "$0")/pid; exec sleep 1000"#;
    for (name, line) in [("reads", "video in.mp4 -o a.gif"), ("writes", "video @/fire.png -o a.mp4")] {
        let folder = folder(&format!("ffmpeg-hangs-{name}"), hangs);
        let mut command = command(&folder, line);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let began = Instant::now();
        let has_begun = || fs::read_to_string(folder.path("bin/pid")).is_ok_and(|id| id.ends_with('\n'));
        while !has_begun() && began.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(10));
        }
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let said = Said::from(child.wait_with_output().unwrap());
        said.refused(130, &["interrupted; nothing was written"]);
        assert!(left(&folder).is_empty() && is_gone(&folder), "{name}: {:?}", left(&folder));
    }
}
