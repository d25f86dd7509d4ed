//! Clips in, loops out.

use std::fs;

use selvedge_core::{Plane, Samples};
use selvedge_io::ReadOptions;
use selvedge_io::clip::{ClipOptions, ClipReader, frame_of, read_clip};

use crate::program::Folder;

/// The generated fire of the fixtures.
const FIRE: &str = "@/fire.png";

pub(crate) fn clip(folder: &Folder, name: &str) -> Plane<3> {
    let mut reader = ClipReader::open(folder.path(name), &ClipOptions::default()).unwrap();
    read_clip(&mut reader, &ReadOptions::default().limits).unwrap()
}

pub(crate) fn bytes(plane: &Plane<3>) -> &[u8] {
    let Samples::U8(grid) = &plane.samples else { panic!("not 8 bits") };
    grid.samples()
}

#[test]
fn a_loop_is_made_of_the_clips_own_samples() {
    let folder = Folder::new("video-loop");
    let said = folder.run(&format!("video {FIRE} -o fire.####.png --surface when.png --preview see.png --json"));
    let json = said.done().json();
    let stats = &json["stats"];
    let (from, to) = (stats["jump"]["from"].as_u64().unwrap(), stats["jump"]["to"].as_u64().unwrap());
    let period = stats["period"].as_u64().unwrap();
    assert_eq!(period, from - to + 1);
    assert!(stats["price"].as_i64() <= stats["straight"].as_i64());
    // The frames, what tells of them, the surface and the preview.
    assert_eq!(folder.names().len() as u64, period + 3);
    assert_eq!(json["outputs"].as_array().unwrap().len(), 3, "the clip is one of them");
    assert_eq!(json["outputs"][0]["frames"], period);
    // Every pixel plays what comes before its time on the surface.
    let fixtures = Folder::new("video-loop-in");
    fs::copy(crate::program::fixtures() + "/fire.png", fixtures.path("fire.png")).unwrap();
    let (input, output) = (clip(&fixtures, "fire.png"), clip(&folder, "fire.####.png"));
    let when = selvedge_io::read(folder.path("when.png"), &ReadOptions::default()).unwrap().plane;
    let [frames, h, w] = output.domain().shape;
    assert_eq!(u64::from(frames), period);
    let n = (h * w) as usize;
    let all = input.domain().shape[0] as usize * n;
    for i in 0..frames as usize * n {
        let (t, pixel) = (i / n, i % n);
        let end = when.samples.value(0, pixel) as usize;
        let begin = end - period as usize;
        // The frame of the loop's first one is `to`; what lies before the pixel's own begin comes a period later.
        let own = (to as usize + period as usize + t - begin) % period as usize + begin;
        for c in 0..3 {
            assert_eq!(bytes(&output)[c * frames as usize * n + i], bytes(&input)[c * all + own * n + pixel]);
        }
    }
}

#[test]
fn loops_repeat_close_and_go_to_every_container() {
    let folder = Folder::new("video-containers");
    folder.run(&format!("video {FIRE} -o a.png --period 16 --quiet")).done();
    let once = clip(&folder, "a.png");
    assert_eq!(once.domain().shape[0], 16);
    folder.run(&format!("video {FIRE} -o b.##.png --period 16 --repeat 2 --closing-frame --quiet")).done();
    let twice = clip(&folder, "b.##.png");
    assert_eq!(twice.domain().shape[0], 33);
    for t in 0..33 {
        assert_eq!(frame_of(&twice, t).unwrap(), frame_of(&once, t % 16).unwrap());
    }
    for name in ["c.gif", "c.y4m"] {
        folder.run(&format!("video {FIRE} -o {name} --period 16 --rate 30 --quiet")).done();
        let reader = ClipReader::open(folder.path(name), &ClipOptions::default()).unwrap();
        assert_eq!(reader.info().frames, 16, "{name}");
    }
    let piped = folder.run(&format!("video {FIRE} -o - --period 16 --rate 30 --quiet")).done();
    assert_eq!(piped.stdout, fs::read(folder.path("c.y4m")).unwrap());
}

#[test]
fn what_inspect_suggests_for_a_clip_runs() {
    let folder = Folder::new("video-inspect");
    let json = folder.run(&format!("inspect {FIRE} --json")).done().json();
    let stats = &json["stats"];
    assert_eq!((stats["frames"].as_u64(), stats["closes"].as_bool()), (Some(40), Some(false)), "{stats}");
    // Its first jump is one that video takes.
    let jump = &stats["jumps"][0];
    let typed = format!("{},{}", jump["from"], jump["to"]);
    folder.run(&format!("video {FIRE} -o a.####.png --jump {typed} --quiet")).done();
    let looped = clip(&folder, "a.####.png");
    assert_eq!(Some(u64::from(looped.domain().shape[0])), jump["period"].as_u64());
    fs::copy(crate::program::fixtures() + "/fire.png", folder.path("fire.png")).unwrap();
    let json = folder.run("inspect fire.png --json").done().json();
    let command = json["stats"]["command"].as_str().unwrap().replace('\'', "");
    folder.run(&format!("{} --quiet", command.strip_prefix("selvedge ").unwrap())).done();
    assert!(folder.names().iter().any(|name| name.starts_with("fire-loop.")), "{:?}", folder.names());
    folder.run("inspect a.####.png --guide a.0001.png a.0001.png").refused(2, &["--guide is about pictures"]);
    fs::write(folder.path("a.mp4"), "ftyp").unwrap();
    folder.run("inspect a.mp4").refused(3, &["a.mp4", "ffmpeg -i"]);
}

/// Which frame, row and column of the clip stands at a sample of a frame's map.
fn located(folder: &Folder, name: &str, at: [u32; 2]) -> (usize, [u32; 2]) {
    let file = selvedge_io::read_map(folder.path(name), &ReadOptions::default().limits).unwrap();
    assert_eq!(file.exemplars.len(), 20, "a source for each frame");
    file.map.locate(at).unwrap()
}

#[test]
fn clips_are_woven_longer_and_larger_and_their_maps_say_of_what() {
    let folder = Folder::new("video-woven");
    folder.run(&format!("video {FIRE} -o in.##.png --loop no --frames 20 --mode temporal --refine 0 --quiet")).done();
    let input = clip(&folder, "in.##.png");
    assert_eq!(input.domain().shape, [20, 60, 48]);
    let value = |plane: &Plane<3>, [t, y, x]: [u32; 3], c: u32| {
        let [frames, h, w] = plane.domain().shape;
        bytes(plane)[(((c * frames + t) * h + y) * w + x) as usize]
    };
    for (mode, line, shape) in [
        ("temporal", "--frames 26", [26, 60, 48]),
        ("temporal", "--loop fixed --keep 3 --frames 25", [25, 60, 48]),
        ("spacetime", "--size 56x64x14 --tile x --region 20x20x8", [14, 64, 56]),
    ] {
        let line = format!("video in.##.png {line} --refine 2 --json");
        let said = folder.run(&format!("{line} -o out.##.png --map map.##.exr -j 1")).done();
        let json = said.json();
        assert_eq!((&json["stats"]["mode"], &json["stats"]["refinements"]), (&mode.into(), &2.into()));
        assert!(said.stderr.contains(&format!("({mode}, since ")), "{}", said.stderr);
        let output = clip(&folder, "out.##.png");
        assert_eq!(output.domain().shape, shape);
        for t in [0, 5, shape[0] - 1] {
            for at in [[0, 0], [30, 20], [59, 47]] {
                let (frame, [y, x]) = located(&folder, &format!("map.{:02}.exr", t + 1), at);
                assert!(mode != "temporal" || [y, x] == at);
                for c in 0..3 {
                    let from = value(&input, [frame as u32, y, x], c);
                    assert_eq!(value(&output, [t, at[0], at[1]], c), from, "{line}: frame {t}, {at:?}");
                }
            }
        }
        if line.contains("fixed") {
            // The last three are the middle ones of 20.
            for k in 0..3 {
                assert_eq!(frame_of(&output, 22 + k).unwrap(), frame_of(&input, 8 + k).unwrap());
            }
        }
        let one = folder.files();
        for threads in [2, 3] {
            folder.run(&format!("{line} -o out.##.png --map map.##.exr -j {threads}")).done();
            assert!(folder.files() == one, "{line}: on {threads} threads");
        }
        for number in 1..=shape[0] {
            fs::remove_file(folder.path(format!("map.{number:02}.exr"))).unwrap();
            fs::remove_file(folder.path(format!("out.{number:02}.png"))).unwrap();
        }
    }
}

#[test]
fn maps_and_surfaces_of_clips_go_over_other_passes() {
    let folder = Folder::new("video-apply");
    folder.run(&format!("video {FIRE} -o a.##.png --jump 19,4 --map m.##.exr --surface s.exr --quiet")).done();
    let said = folder.run(&format!("apply m.##.exr {FIRE} -o b.##.png --json")).done();
    assert!(said.stderr.contains("16 frames of 48x60 px through m.##.exr"), "{}", said.stderr);
    let json = said.json();
    assert_eq!((json["inputs"].as_array().unwrap().len(), &json["outputs"][0]["frames"]), (17, &16.into()));
    assert_eq!(bytes(&clip(&folder, "b.##.png")), bytes(&clip(&folder, "a.##.png")));
    folder.run(&format!("video {FIRE} -o c.##.png --jump 19,4 --surface-from s.exr --quiet")).done();
    assert_eq!(bytes(&clip(&folder, "c.##.png")), bytes(&clip(&folder, "a.##.png")));
    let before = folder.names();
    let dry = folder.run(&format!("apply m.##.exr {FIRE} -o d.##.png --dry-run")).done();
    assert!(dry.stderr.contains("would be 16 frames of 48x60 px"), "{}", dry.stderr);
    let of = "16 frames of 48x60 px, but the maps were made from 40 frames of 48x60 px";
    folder.run("apply m.##.exr a.##.png -o d.##.png").refused(3, &["'a.##.png'", of]);
    let line = format!("apply m.##.exr {FIRE} -o d.##.png");
    folder.run(&format!("{line} --role normal")).refused(2, &["--role does nothing with the maps of a clip"]);
    folder.run(&format!("apply none.##.exr {FIRE} -o d.##.png")).refused(4, &["none.##.exr"]);
    folder.run(&format!("apply a.##.png {FIRE} -o d.##.png")).refused(3, &["a.01.png"]);
    assert_eq!(folder.names(), before);
}

#[test]
fn loops_are_played_for_as_many_frames_as_are_wanted() {
    let folder = Folder::new("video-play");
    folder.run(&format!("video {FIRE} -o once.##.png --period 16 --quiet")).done();
    folder.run(&format!("video {FIRE} -o again.##.png --period 16 --frames 37 --play loop --quiet")).done();
    let (once, again) = (clip(&folder, "once.##.png"), clip(&folder, "again.##.png"));
    assert_eq!(again.domain().shape[0], 37);
    assert!((0..37).all(|t| frame_of(&again, t).unwrap() == frame_of(&once, t % 16).unwrap()));
    let line = format!("video {FIRE} --frames 60 --play random --jumps 4 --window 12");
    let json = folder.run(&format!("{line} -o a.##.png --map m.##.exr --preview p.png --json -j 1")).done().json();
    assert!(1 < json["stats"]["loops"].as_array().unwrap().len(), "{json}");
    folder.run(&format!("{line} -o b.##.png -j 3")).done();
    folder.run(&format!("{line} -o c.##.png --seed 1")).done();
    let [a, b, c] = ["a.##.png", "b.##.png", "c.##.png"].map(|name| clip(&folder, name));
    assert_eq!(a.domain().shape, [60, 60, 48]);
    assert!(bytes(&a) == bytes(&b) && bytes(&a) != bytes(&c));
    // All pixels keep their places, and begin with the clip's first frame.
    let map = |t: u32| selvedge_io::read_map(folder.path(format!("m.{:02}.exr", t + 1)), &Default::default()).unwrap();
    let of = |t: u32| map(t).map.locate([30, 20]).unwrap();
    assert!(of(0) == (0, [30, 20]) && (0..60).all(|t| of(t).1 == [30, 20]));
    for (line, said) in [
        ("--play loop", "--frames"),
        ("--play random --frames 50 --repeat 2", "are for loops that are written whole"),
        ("--loop no --closing-frame", "are for loops that are written whole"),
        ("--play loop --frames 50 --mode temporal", "--play does nothing in --mode temporal"),
        ("--frames 20 --period 20", "both say how long the loop is"),
    ] {
        folder.run(&format!("video {FIRE} -o x.##.png {line}")).refused(2, &[said]);
    }
}

#[test]
fn masked_pixels_stand_still() {
    let folder = Folder::new("video-still");
    // The lower half is white.
    let grid = selvedge_core::Grid::from_vec(
        selvedge_core::Domain::open([60, 48]),
        1,
        (0..60 * 48).map(|i| if 30 * 48 <= i { 255_u8 } else { 0 }).collect(),
    );
    let mask = Plane::new(selvedge_core::Role::Scalar, Samples::U8(grid.unwrap()));
    selvedge_io::write(folder.path("mask.png"), &mask, &Default::default(), &Default::default()).unwrap();
    let fire = Folder::new("video-still-in");
    fs::copy(crate::program::fixtures() + "/fire.png", fire.path("fire.png")).unwrap();
    let input = clip(&fire, "fire.png");
    for line in ["--period 16", "--mode temporal --frames 20 --refine 0", "--play random --frames 20 --jumps 2"] {
        folder.run(&format!("video {FIRE} -o out.png {line} --fixed mask.png --still-frame 7 --quiet")).done();
        let output = clip(&folder, "out.png");
        let [frames, ..] = output.domain().shape;
        let [n, all] = [frames, 40].map(|frames| frames as usize * 2880);
        for (t, p, c) in (0..frames as usize).flat_map(|t| (0..2880).map(move |p| (t, p, p % 3))) {
            let still = bytes(&output)[c * n + t * 2880 + p] == bytes(&input)[c * all + 7 * 2880 + p];
            assert!(still || p < 30 * 48, "{line}: frame {t}, pixel {p}");
        }
        let first = frame_of(&output, 0).unwrap();
        assert!((1..frames).any(|t| frame_of(&output, t).unwrap() != first), "{line}: something moves");
    }
    for (line, code, said) in [
        ("--fixed mask.png --still-frame 40", 2, "--still-frame 40 of a clip of 40 frames"),
        ("--fixed mask.png --size 50x60", 2, "--fixed needs frames of the clip's size"),
        ("--fixed @/cobbles.png", 3, "the clip has 48x60 px"),
    ] {
        folder.run(&format!("video {FIRE} -o x.##.png {line}")).refused(code, &[said]);
    }
}

#[test]
fn options_that_a_mode_does_not_know_are_told() {
    let folder = Folder::new("video-modes");
    for (line, said) in [
        ("--mode temporal --period 20", "--period does nothing in --mode temporal"),
        ("--mode spacetime --surface s.png", "--surface does nothing in --mode spacetime"),
        ("--mode transition --region 9", "--region does nothing in --mode transition"),
        ("--mode transition --loop no", "--loop does nothing in --mode transition"),
        ("--jump 30,3 --refine 4", "--refine does nothing in --mode transition"),
        // Typed as it would be anyway.
        ("--mode temporal --window 60", "--window does nothing in --mode temporal"),
        ("--mode transition --refine auto", "--refine does nothing in --mode transition"),
        ("--mode temporal --size 50x50", "--mode temporal has frames of the clip's 48x60 px"),
        ("--mode temporal --tile x", "which do not tile"),
        ("--frames 50 --size 48x60x50", "both say how many frames"),
        ("--loop fixed --keep 40", "leaves nothing between"),
        ("--map map.exr", "is no name of EXR files, one a frame"),
        ("--size 48x60x1x1", "is no size of a clip"),
    ] {
        folder.run(&format!("video {FIRE} -o out.##.png {line}")).refused(2, &[said]);
    }
    let line = format!("video {FIRE} -o out.##.png --mode temporal --region 41");
    folder.run(&line).refused(3, &["no exemplar holds a region", "use a smaller --region"]);
    assert!(folder.names().is_empty());
    for (line, said) in [
        ("", "would be a loop of at most 40 frames of 48x60 px by a jump"),
        ("--frames 20", "by a jump"),
        ("--frames 50", "would be a loop of 50 frames of 48x60 px, temporal"),
        ("--loop no", "would be a clip of 80 frames of 48x60 px, temporal"),
        ("--size 60x60", "would be a loop of 80 frames of 60x60 px, spacetime"),
    ] {
        let dry = folder.run(&format!("video {FIRE} -o out.##.png --dry-run {line}")).done();
        assert!(dry.stderr.contains(said), "{line}: {}", dry.stderr);
    }
}

#[test]
fn passes_have_the_same_seam_and_a_saved_surface_gives_it_again() {
    let folder = Folder::new("video-passes");
    folder.run(&format!("video {FIRE} -o in.##.png --period 24 --quiet")).done();
    let line = "video in.##.png --with in.##.png -o {stem}-x.##.png --period 12 --quiet";
    // Both would be written under one name.
    let same = folder.run(line);
    assert_eq!(same.exit, Some(2), "{same:?}");
    for number in 1..=24 {
        fs::copy(folder.path(format!("in.{number:02}.png")), folder.path(format!("pass.{number:02}.png"))).unwrap();
    }
    let line = "video in.##.png --with pass.##.png -o {stem}-x.##.png --period 12 --surface s.png --json";
    let json = folder.run(line).done().json();
    let loops = ["in-x.##.png", "pass-x.##.png"].map(|name| clip(&folder, name));
    assert_eq!(bytes(&loops[0]), bytes(&loops[1]));
    let jump = &json["stats"]["jump"];
    let line = format!("video pass.##.png -o again.##.png --surface-from s.png --jump {},{}", jump["from"], jump["to"]);
    folder.run(&line).done();
    assert_eq!(bytes(&clip(&folder, "again.##.png")), bytes(&loops[0]));
}

#[test]
fn a_cross_fade_mixes_what_a_seam_copies() {
    let folder = Folder::new("video-fade");
    let said = folder.run(&format!("video {FIRE} -o fade.##.png --period 16 --blend 6")).done();
    assert!(said.stderr.contains("faded over 6,") && !said.stderr.contains("since"), "{}", said.stderr);
    let said = folder.run(&format!("video {FIRE} -o long.##.png --period 16 --blend 500")).done();
    assert!(said.stderr.contains("since there are no 500 beside it"), "{}", said.stderr);
    assert_eq!(clip(&folder, "fade.##.png").domain().shape[0], 16);
}

#[test]
fn what_is_no_clip_is_told_in_a_line() {
    let folder = Folder::new("video-wrong");
    for number in [1, 2, 4] {
        fs::copy(crate::program::fixtures() + "/cobbles.png", folder.path(format!("a.{number}.png"))).unwrap();
    }
    for (line, code, said) in [
        ("video a.#.png -o b.#.png", 3, "frame 3 is missing after 2"),
        ("video a.#.png --range 4 -o b.#.png", 3, "has one frame, of which no loop is made"),
        ("video a.#.png --range 1-2 -o a.#.png", 4, "is the same file as the input"),
        ("video a.#.png --range 1-2 -o b.webp", 2, "webp clips are read, not written"),
        ("video a.#.png --range 1-2 -o b.jpg", 2, "is the name of no clip"),
        ("video a.#.png --range 1-2 -o b.#.png --period 9", 3, "a clip of 2 frames has no loop of 9"),
        ("video a.#.png --range 1-2 -o b.#.png --period 1", 2, "'1' is no period"),
        ("video a.#.png --range 2-1 -o b.#.png", 2, "'2-1' is no range of frames"),
        ("video a.#.png --range 1-2 -o b.#.png --rate 1/0", 2, "'1/0' is no rate"),
        ("video a.1.png -o b.#.png", 3, "is a single picture, no clip"),
        ("video none.#.png -o b.#.png", 4, "no frame of this name was found"),
        ("video @/fire.png -o b.exr", 2, "is the name of no clip"),
        ("video @/fire.png -o b.#.exr", 3, "exr cannot hold u8 samples"),
        ("video @/fire.png -o b.#.png --max-memory 20MiB", 6, "memory"),
        ("video @/fire.png -o b.#.png --jump 90,3", 3, "no jump back from frame 90"),
    ] {
        folder.run(line).refused(code, &[said]);
    }
    assert!(folder.names().iter().all(|name| name.starts_with("a.")), "nothing was written: {:?}", folder.names());
    let dry = folder.run("video @/fire.png -o b.#.png --dry-run").done();
    assert!(dry.stderr.contains("would be a loop"), "{}", dry.stderr);
}

#[test]
fn flipbooks_are_filled_and_read_again() {
    let folder = Folder::new("video-flipbook");
    folder.run(&format!("video {FIRE} -o book.png --flipbook 4x4 --pad 1 --quiet")).done();
    folder.run(&format!("video {FIRE} -o loop.##.png --period 16 --quiet")).done();
    assert!(folder.names().contains(&"book.json".to_owned()));
    let options = ClipOptions {
        flipbook: Some(selvedge_io::clip::Flipbook { columns: 4, rows: 4, pad: 1 }),
        ..ClipOptions::default()
    };
    let mut reader = ClipReader::open(folder.path("book.png"), &options).unwrap();
    let book = read_clip(&mut reader, &ReadOptions::default().limits).unwrap();
    assert_eq!(bytes(&book), bytes(&clip(&folder, "loop.##.png")));
    let again = folder.run("video book.png --from-flipbook 4x4 --from-pad 1 -o again.##.png --json").done().json();
    assert_eq!(again["inputs"][0]["frames"], 16);
    let said = folder.run("video book.png --from-flipbook 2x4 --from-pad 1 -o x.##.png --dry-run").done();
    assert!(said.stderr.contains("is a flipbook of 4x4 with 1 px around"), "{}", said.stderr);
    folder.run("video book.png --from-flipbook 7x4 -o x.##.png").refused(3, &["are not 7x4 frames"]);
    folder
        .run(&format!("video {FIRE} -o y.png --flipbook 2x2 --period 16"))
        .refused(3, &["more than a flipbook of 2x2"]);
}

#[test]
fn whether_a_clip_closes_is_the_exit_code() {
    let folder = Folder::new("video-closes");
    let open = folder.run(&format!("compare {FIRE} --loop"));
    assert_eq!(open.exit, Some(1), "{open:?}");
    assert!(String::from_utf8_lossy(&open.stdout).contains("does not close"), "{open:?}");
    // There and back again closes.
    fs::create_dir(folder.path("f")).unwrap();
    let fire = Folder::new("video-closes-in");
    fs::copy(crate::program::fixtures() + "/fire.png", fire.path("fire.png")).unwrap();
    let clip = clip(&fire, "fire.png");
    for (number, t) in (0..8).chain((1..7).rev()).enumerate() {
        let frame = frame_of(&clip, t).unwrap();
        let path = folder.path(format!("f/{number:02}.png"));
        selvedge_io::write(path, &frame, &Default::default(), &Default::default()).unwrap();
    }
    let closes = folder.run("compare f --loop --json").done().json();
    assert_eq!((&closes["stats"]["closes"], &closes["stats"]["frames"]), (&true.into(), &14.into()));
    let stats = folder.run("video f -o again.##.png --json").done().json()["stats"].clone();
    assert_eq!((&stats["closes_already"], &stats["closure"]["closes"]), (&true.into(), &true.into()), "{stats}");
}

#[test]
fn what_is_wrong_with_a_clip_is_told_wherever_it_is_read() {
    let folder = Folder::new("video-claim");
    // A frame of 732 MiB in a file of 41 bytes.
    fs::write(folder.path("claim.y4m"), "YUV4MPEG2 W16000 H16000 F25:1 C444\nFRAME\n").unwrap();
    for line in ["inspect claim.y4m", "video claim.y4m -o v.####.png --dry-run", "compare claim.y4m claim.y4m"] {
        folder.run(line).refused(3, &["'claim.y4m'", "damaged y4m file (it ends early)"]);
        folder.run(&format!("{line} --max-memory 200MiB")).refused(6, &["'claim.y4m'", "200"]);
    }
}
