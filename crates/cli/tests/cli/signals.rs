//! Signals: runs end soon, with the right code, and leave nothing behind or what was asked for.

use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Child, Command, Stdio};

use selvedge_io::clip::ClipReader;

use crate::program::{Folder, Said, fixtures};

/// Would take minutes.
const LONG: &str =
    "quilt @/cobbles.png -o out.png --size 8000 --block 12 --map map.exr --max-memory 100GiB --progress json";

/// Starts a run and waits for its first step.
fn begun(folder: &Folder, line: &str) -> (Child, BufReader<std::process::ChildStderr>) {
    let words = line.split(' ').map(|word| word.replace('@', &fixtures()));
    let mut child = folder.command().args(words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut step = String::new();
    stderr.read_line(&mut step).unwrap();
    assert!(step.starts_with('{'), "{step}");
    (child, stderr)
}

fn send(child: &Child, signal: &str) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

/// Waits for the end; the last line of standard error is what was said at the end.
fn ended(child: Child, mut stderr: BufReader<std::process::ChildStderr>) -> Said {
    let mut said = String::new();
    stderr.read_to_string(&mut said).unwrap();
    let last = said.lines().filter(|line| !line.starts_with('{')).map(|line| format!("{line}\n")).collect();
    Said { stderr: last, ..Said::from(child.wait_with_output().unwrap()) }
}

/// False where whoever runs these tests is to outlive its terminal (nohup): so are the programs that they run.
fn is_hung_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mut ignored =
        status.lines().filter_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    ignored.all(|signals| signals & 1 == 0)
}

#[test]
fn an_interrupted_run_leaves_nothing_behind() {
    let folder = Folder::new("interrupted");
    for (signal, exit) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129)] {
        if signal == "-HUP" && !is_hung_up() {
            eprintln!("SKIPPED: SIGHUP is ignored here");
            continue;
        }
        let (child, stderr) = begun(&folder, &format!("{LONG} --json"));
        send(&child, signal);
        let said = ended(child, stderr).refused(exit, &["interrupted; nothing was written"]);
        assert_eq!(said.json()["error"]["exit"], exit);
        assert_eq!(folder.names(), Vec::<String>::new());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_that_is_to_outlive_its_terminal_does() {
    let folder = Folder::new("nohup");
    let line = LONG.replace('@', &fixtures());
    let script = format!("trap '' HUP; exec {} {line}", env!("CARGO_BIN_EXE_selvedge"));
    let mut shell = Command::new("sh");
    shell.args(["-c", &script]).current_dir(folder.path("")).stderr(Stdio::piped());
    let mut child = shell.spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    stderr.read_line(&mut String::new()).unwrap();
    send(&child, "-HUP");
    std::thread::sleep(std::time::Duration::from_millis(1000));
    assert!(child.try_wait().unwrap().is_none(), "it goes on");
    send(&child, "-TERM");
    ended(child, stderr).refused(143, &["interrupted; nothing was written"]);
}

#[test]
fn of_clips_that_are_interrupted_what_there_is_is_kept() {
    let folder = Folder::new("partial-clips");
    let frames = |name: &str| ClipReader::open(folder.path(name), &Default::default()).unwrap().info().frames;
    let video = "video @/fire.png --mode temporal --frames 2000 --refine 5000";
    let animate = "animate @/scales.png --flow vortex --size 48 --init quilt --frames 9000";
    // Many labels, of which none shows more than a little.
    let others: String = (1..40).map(|i| format!(" --at {},{}", i % 5 * 3, i % 7 * 2)).collect();
    let merge = format!("merge{} --at 0,0{others} --prefer median", " @/fire.png".repeat(41));
    for (line, name, stage) in [
        (merge.as_str(), "m.png", "{"),
        (video, "a.png", "{"),
        (animate, "b.gif", "\"frames\""),
        (animate, "c.png", "\"frames\""),
        (animate, "d.y4m", "\"frames\""),
    ] {
        let (child, mut stderr) = begun(&folder, &format!("{line} -o {name} --keep-partial --progress json"));
        let mut step = String::from("{");
        while !step.contains(stage) {
            step.clear();
            assert_ne!(stderr.read_line(&mut step).unwrap(), 0, "{line} ended");
        }
        send(&child, "-INT");
        let partial = name.replace('.', ".partial.");
        ended(child, stderr).refused(130, &[&format!("interrupted; the best so far is in '{partial}'")]);
        let expected = if line == video { 2000..2001 } else { 1..9000 };
        let expected = if line == merge { 40..41 } else { expected };
        assert!(expected.contains(&frames(&partial)), "{line}: {} frames", frames(&partial));
        assert_eq!(folder.names(), std::slice::from_ref(&partial));
        std::fs::remove_file(folder.path(partial)).unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_output_that_became_a_link_to_an_input_is_refused() {
    let folder = Folder::new("became");
    std::fs::copy(fixtures() + "/stars.png", folder.path("in.png")).unwrap();
    let line = "quilt in.png -o out.png --size 600 --block 12 --map map.exr --progress json";
    let (child, stderr) = begun(&folder, line);
    send(&child, "-STOP");
    std::os::unix::fs::symlink("in.png", folder.path("out.png")).unwrap();
    send(&child, "-CONT");
    ended(child, stderr).refused(4, &["'out.png'", "same file as the input 'in.png'"]);
    assert_eq!(std::fs::read(folder.path("in.png")).unwrap(), std::fs::read(fixtures() + "/stars.png").unwrap());
    assert_eq!(folder.names(), ["in.png", "out.png"]);
}

#[test]
fn the_best_so_far_is_kept_when_asked_for() {
    let folder = Folder::new("partial");
    let (child, stderr) = begun(&folder, &format!("{LONG} --keep-partial").replace("8000", "2000"));
    send(&child, "-INT");
    ended(child, stderr).refused(130, &["interrupted; the best so far is in 'out.partial.png'"]);
    assert_eq!(folder.names(), ["map.partial.exr", "out.partial.png"]);
    let map = selvedge_io::read_map(folder.path("map.partial.exr"), &Default::default()).unwrap().map;
    let assigned = map.ids.plane(0).iter().filter(|id| id.is_assigned()).count();
    assert!(0 < assigned && assigned < map.domain().len(), "{assigned}");
    folder.run("apply map.partial.exr @/cobbles.png -o again.png").done();
    // Where nothing stands nothing shows.
    let read = |name: &str| selvedge_io::read(folder.path(name), &Default::default()).unwrap().plane;
    let (partial, again) = (read("out.partial.png"), read("again.png"));
    assert_eq!((partial.alpha, partial.color_channels(), again.alpha), (true, 3, false));
    for (i, id) in map.ids.plane(0).iter().enumerate() {
        assert_eq!(partial.samples.value(3, i), if id.is_assigned() { 255.0 } else { 0.0 });
        assert!((0..3).all(|c| partial.samples.value(c, i) == again.samples.value(c, i)));
    }
}

/// An output that follows a constraint, ended while it is searched for: what stands is kept.
#[test]
fn the_best_so_far_of_a_constrained_run_is_kept() {
    let folder = Folder::new("partial-numbers");
    let line = "numbers @/ground/picture.png --labels @/ground/labels.png --target @/ground/target.png --levels 1 \
                --history 1000 --tolerance 0 -o out.png --map map.exr --progress json";
    let (child, stderr) = begun(&folder, &format!("{line} --keep-partial"));
    send(&child, "-INT");
    ended(child, stderr).refused(130, &["interrupted; the best so far is in 'out.partial.png'"]);
    assert_eq!(folder.names(), ["map.partial.exr", "out.partial.png"]);
    let map = selvedge_io::read_map(folder.path("map.partial.exr"), &Default::default()).unwrap().map;
    // Steps are told once all is covered.
    assert!(map.ids.plane(0).iter().all(|id| id.is_assigned()));
}

#[test]
fn a_second_signal_ends_at_once_and_cleans_up() {
    let folder = Folder::new("twice");
    let (child, stderr) = begun(&folder, &format!("{LONG} --keep-partial"));
    send(&child, "-INT");
    std::thread::sleep(std::time::Duration::from_millis(60));
    send(&child, "-INT");
    let said = ended(child, stderr);
    assert_eq!(said.exit, Some(130), "{said:?}");
    assert!(folder.names().iter().all(|name| !name.ends_with(".part")), "{:?}", folder.names());
}

#[test]
fn a_run_that_waits_for_its_input_can_be_ended() {
    let folder = Folder::new("waiting");
    let mut child = folder
        .command()
        .args(["quilt", "-", "-o", "a.png"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The program listens before it reads; its input is held open.
    let held = child.stdin.take();
    std::thread::sleep(std::time::Duration::from_millis(500));
    send(&child, "-TERM");
    let said = Said::from(child.wait_with_output().unwrap());
    drop(held);
    assert_eq!(said.exit, Some(143), "{said:?}");
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[test]
fn runs_before_the_one_that_is_interrupted_are_kept_and_told() {
    let folder = Folder::new("partial-turns");
    let line =
        "quilt @/cobbles.png @/stars.png --each -o {stem}.png --size 1600 --block 12 --keep-partial --progress json";
    // The first run has ended where the stages begin anew.
    let (child, mut stderr) = begun(&folder, &format!("{line} --seed 1 -j 2"));
    let (mut before, mut step) = (0, String::new());
    loop {
        step.clear();
        stderr.read_line(&mut step).unwrap();
        let step = serde_json::from_str::<serde_json::Value>(&step).unwrap();
        // What does not know how far it is, is none of a run's steps.
        if step["of"] == 0 {
            continue;
        }
        let done = step["done"].as_u64().unwrap();
        if done < before {
            break;
        }
        before = done;
    }
    send(&child, "-INT");
    let said = "interrupted; 1 run before was written, and the best so far is in 'stars.partial.png'";
    ended(child, stderr).refused(130, &[said]);
    assert_eq!(folder.names(), ["cobbles.png", "stars.partial.png"]);
}

#[test]
fn frames_that_are_written_are_told_and_what_was_said_of_others_is_gone() {
    let folder = Folder::new("partial-frames");
    std::fs::write(folder.path("o.json"), "of another clip").unwrap();
    let line =
        "animate @/scales.png --flow vortex --init quilt --size 40x32 --frames 400 -o o.####.png --progress json";
    let (child, mut stderr) = begun(&folder, line);
    let mut step = String::new();
    while !step.contains("\"frames\"") {
        step.clear();
        stderr.read_line(&mut step).unwrap();
    }
    send(&child, "-INT");
    let said = ended(child, stderr);
    let names = folder.names();
    assert!(names.contains(&"o.0001.png".to_owned()) && !names.contains(&"o.json".to_owned()), "{names:?}");
    let (frames, were) = (names.len(), if names.len() == 1 { "frame before was" } else { "frames before were" });
    said.refused(130, &[&format!("interrupted; {frames} {were} written")]);
}

#[test]
fn a_run_that_was_ended_goes_on_to_the_same_bytes() {
    let line = format!(
        "video {} -o out.##.png --mode spacetime --size 40x44x40 --region 12x12x8 --refine 120 --seed 4 --map m.##.exr",
        "@/fire.png"
    );
    let folder = Folder::new("resumed");
    folder.run(&format!("{line} --quiet")).done();
    let whole = folder.files();
    let folder = Folder::new("resumed-after");
    let (child, mut stderr) = begun(&folder, &format!("{line} --checkpoint kept --progress json"));
    for _ in 0..30 {
        stderr.read_line(&mut String::new()).unwrap();
    }
    send(&child, "-INT");
    ended(child, stderr).refused(130, &["interrupted; go on with --resume 'kept'"]);
    assert_eq!(folder.names(), ["kept"]);
    let other = line.replace("--seed 4", "--seed 5");
    folder.run(&format!("{other} --resume kept")).refused(3, &["kept/checkpoint", "of another seed, 4"]);
    let other = line.replace("--refine 120", "--refine 9");
    folder.run(&format!("{other} --resume kept")).refused(3, &["of another options, with --refine 120"]);
    let said = folder.run(&format!("{line} --resume kept --json -j 1")).done();
    assert!(said.json()["options"].get("resume").is_none());
    let mut found = folder.files();
    found.remove(std::path::Path::new("kept"));
    assert!(found == whole, "{:?}", folder.names());
    let bytes = std::fs::read(folder.path("kept/checkpoint")).unwrap();
    for cut in [&bytes[..bytes.len() - 1], &bytes[1..], b"{}\n", b""] {
        std::fs::write(folder.path("kept/checkpoint"), cut).unwrap();
        folder
            .run(&format!("{line} --resume kept"))
            .refused(3, &["kept/checkpoint", "is no checkpoint, or is damaged"]);
    }
    folder.run(&format!("{line} --resume none")).refused(4, &["none/checkpoint"]);
    let jump = "video @/fire.png -o out.##.png --mode transition --checkpoint kept";
    folder.run(jump).refused(2, &["--checkpoint does nothing in --mode transition"]);
}

#[test]
fn windows_that_were_ended_go_on_to_the_same_bytes() {
    let line = "video @/fire.png -o out.##.png --mode temporal --frames 99 --at-once 30 --refine 12 --seed 4";
    let folder = Folder::new("windows-resumed");
    folder.run(&format!("{line} --quiet")).done();
    let whole = folder.files();
    let folder = Folder::new("windows-resumed-after");
    let kept = folder.path("kept/checkpoint");
    for signal in ["-INT", "-KILL"] {
        let (child, mut stderr) = begun(&folder, &format!("{line} --checkpoint kept --progress json"));
        // Two windows are behind it.
        let mut done = 0.0;
        while done < 0.45 {
            let mut step = String::new();
            stderr.read_line(&mut step).unwrap();
            let work = serde_json::from_str::<serde_json::Value>(&step).unwrap()["work"].clone();
            done = work["done"].as_f64().unwrap_or(0.0) / work["of"].as_f64().unwrap_or(1.0);
        }
        send(&child, signal);
        let said = ended(child, stderr);
        assert!(signal == "-KILL" || said.stderr.contains("interrupted; go on with --resume 'kept'"), "{said:?}");
        let bytes = std::fs::read(&kept).unwrap();
        assert!(0 < windows(&bytes), "{signal}");
        for (from, to, what) in [
            ("--at-once 30", "--at-once 31", "is the checkpoint of another number of frames at once, 30"),
            (" --at-once 30", "", "another number of frames at once, 30"),
            ("--refine 12", "--refine 9", "of another options, with --refine 12"),
        ] {
            folder.run(&format!("{} --resume kept", line.replace(from, to))).refused(3, &["kept/checkpoint", what]);
        }
        folder.run(&format!("{line} --resume kept --quiet -j 1")).done();
        let mut found = folder.files();
        found.remove(std::path::Path::new("kept"));
        assert!(found == whole, "{signal}: {:?}", folder.names());
        std::fs::write(&kept, &bytes[..bytes.len() - 1]).unwrap();
        folder.run(&format!("{line} --resume kept")).refused(3, &["is no checkpoint, or is damaged"]);
        std::fs::remove_file(&kept).unwrap();
    }
}

/// How many windows a checkpoint is after.
fn windows(checkpoint: &[u8]) -> u64 {
    let made = checkpoint.iter().position(|b| *b == b'\n').unwrap() + 1 + b"selvedge windows 1\n".len() + 8;
    u64::from_le_bytes(checkpoint[made..made + 8].try_into().unwrap())
}

#[test]
fn a_picture_that_was_ended_goes_on_to_the_same_bytes() {
    let line = "graphcut @/stars.png -o out.png --size 300x280 --region 20 --refine 200 --seed 4 --map m.exr";
    let folder = Folder::new("picture-resumed");
    folder.run(&format!("{line} --quiet")).done();
    let whole = folder.files();
    let folder = Folder::new("picture-resumed-after");
    let (child, mut stderr) = begun(&folder, &format!("{line} --checkpoint kept --progress json"));
    for _ in 0..60 {
        stderr.read_line(&mut String::new()).unwrap();
    }
    send(&child, "-INT");
    ended(child, stderr).refused(130, &["interrupted"]);
    assert!(folder.names().contains(&"kept".to_owned()), "{:?}", folder.names());
    for (from, to, said) in [
        ("--seed 4", "--seed 5", "of another seed, 4"),
        ("--refine 200", "--refine 9", "of another options"),
        ("@/stars.png", "@/scales.png", "of another set of inputs"),
    ] {
        folder.run(&format!("{} --resume kept", line.replace(from, to))).refused(3, &["kept/checkpoint", said]);
    }
    folder.run(&format!("{line} --levels 2 --resume kept")).refused(2, &["runs at one size"]);
    folder.run(&format!("{line} --resume kept --quiet -j 1")).done();
    for name in ["out.png", "m.exr"] {
        let name = std::path::Path::new(name);
        assert!(folder.files()[name] == whole[name], "{name:?}");
    }
}

#[test]
fn frames_that_flow_go_on_to_the_same_bytes() {
    let line =
        "animate @/scales.png -o out.#.png --flow vortex --frames 7 --close 3 --size 40x32 --init quilt --seed 3";
    let folder = Folder::new("flowed");
    folder.run(&format!("{line} --quiet")).done();
    let whole = folder.files();
    let stats = folder.run(&format!("{line} --json")).done().json()["stats"].clone();
    let folder = Folder::new("flowed-after");
    // Killed after any number of frames, also where they close, and after the next one was written.
    for frames in [1, 2, 5, 6] {
        let (mut child, mut stderr) = begun(&folder, &format!("{line} --checkpoint kept --progress json"));
        let mut steps = 0;
        while steps < frames {
            let mut step = String::new();
            stderr.read_line(&mut step).unwrap();
            steps += u32::from(step.contains("\"frames\""));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let said = folder.run(&format!("{line} --resume kept --json -j 1")).done().json();
        assert_eq!(said["stats"], stats, "all frames are told of");
        let mut found = folder.files();
        found.remove(std::path::Path::new("kept"));
        assert!(found == whole, "{frames}: {:?}", folder.names());
    }
    let other = line.replace("--seed 3", "--seed 4");
    folder.run(&format!("{other} --resume kept")).refused(3, &["kept/checkpoint", "of another seed, 3"]);
    let other = line.replace("--close 3", "--close 2");
    folder.run(&format!("{other} --resume kept")).refused(3, &["of another options"]);
    let other = line.replace("@/scales.png", "@/weave.png");
    folder.run(&format!("{other} --resume kept")).refused(3, &["of another exemplar"]);
    std::fs::write(folder.path("out.1.png"), b"other").unwrap();
    folder.run(&format!("{line} --resume kept")).refused(3, &["out.1.png': is not the frame that was written"]);
    let bytes = std::fs::read(folder.path("kept/checkpoint")).unwrap();
    for cut in [&bytes[..bytes.len() - 1], &bytes[1..], b"{}\n", b""] {
        std::fs::write(folder.path("kept/checkpoint"), cut).unwrap();
        let said = folder.run(&format!("{line} --resume kept"));
        said.refused(3, &["kept/checkpoint", "is no checkpoint, or is damaged"]);
    }
    let container = line.replace("out.#.png", "out.gif");
    folder.run(&format!("{container} --checkpoint kept")).refused(2, &["name frames by a pattern"]);
}
