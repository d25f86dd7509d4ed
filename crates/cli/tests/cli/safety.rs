//! What no run does to files: destroy what it reads, write half of what belongs together, or stop in the middle.

use std::fs;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};

use crate::program::{Folder, Said, fixtures};

/// A folder with an exemplar `g.png` of its own.
fn with_exemplar(name: &str) -> Folder {
    let folder = Folder::new(name);
    fs::copy(fixtures() + "/stars.png", folder.path("g.png")).unwrap();
    folder
}

#[test]
fn no_output_of_any_option_is_an_input_or_another_output() {
    let folder = with_exemplar("one-list");
    fs::write(folder.path("c.toml"), "size = 20\n").unwrap();
    fs::copy(folder.path("g.png"), folder.path("x.partial.png")).unwrap();
    fs::create_dir(folder.path("sub")).unwrap();
    folder.run("quilt g.png -o m.png --map m.exr --size 20 --block 9").done();
    let before = folder.files();
    let refused = [
        ("quilt g.png -o x.png --save-config g.png", 4, "same file as the input 'g.png'"),
        ("quilt g.png -o y.png --save-config y.png", 2, "two outputs"),
        ("quilt g.png -o y.png --save-config ./sub/../y.png", 2, "two outputs"),
        ("quilt g.png -o c.toml --format png --config c.toml", 4, "same file as the input 'c.toml'"),
        ("quilt g.png -o a.png --explain ./a.png", 2, "two outputs"),
        ("quilt g.png -o a.exr --map ./a.exr", 2, "two outputs"),
        ("quilt g.png -o a.png --explain g.png", 4, "same file"),
        ("transfer g.png --target x.partial.png -o a.png --explain x.partial.png", 4, "same file"),
        ("graphcut g.png -o x.png --save-config g.png", 4, "same file"),
        ("apply m.exr g.png -o x.png --save-config m.exr", 4, "same file"),
        ("inspect g.png --save-config g.png", 4, "same file"),
        ("info g.png --save-config g.png", 4, "same file"),
        ("compare g.png x.partial.png --save-config g.png", 4, "same file"),
        ("quilt g.png -o a.png --config c.toml --save-config c.toml", 4, "same file"),
        ("quilt x.partial.png -o x.png --keep-partial", 4, "'x.partial.png': is the same file as the input"),
        ("quilt g.png -o x.png --keep-partial --no-clobber", 4, "'x.partial.png': exists already"),
        ("quilt g.png -o a.png --explain x.partial.png -o x.png --keep-partial", 2, ""),
    ];
    for (line, exit, part) in refused {
        folder.run(line).refused(exit, &[part]);
        assert_eq!(folder.files(), before, "{line}");
    }
    folder.run("quilt g.png -o y.png --map m.png").refused(2, &["'m.png'", "source maps are EXR files", ".exr"]);
    folder.run("quilt g.png -o .").refused(4, &["'.': is a folder"]);
    folder.run("quilt g.png -o sub").refused(4, &["'sub': is a folder"]);
    assert_eq!(folder.files(), before);
}

#[test]
fn several_outputs_are_written_together_or_not_at_all() {
    let folder = with_exemplar("together");
    folder.run("quilt g.png -o q.png --size 60 --block 20 --map m.exr").done();
    let bytes = fs::read(folder.path("g.png")).unwrap();
    fs::write(folder.path("cut.png"), &bytes[..bytes.len() / 2]).unwrap();
    let before = folder.files();
    // The second plane is damaged behind its header.
    folder.run("apply m.exr g.png cut.png -o o-{name}").refused(3, &["'cut.png'"]);
    // The second plane has another size: known from headers.
    folder.run("apply m.exr g.png @/weave.png -o o-{name}").refused(3, &["weave.png'", "192x192"]);
    assert_eq!(folder.files(), before);
    if std::path::Path::new("/dev/full").exists() {
        folder.run("quilt g.png -o /dev/full --format png --map n.exr --size 20 --block 9").refused(5, &["no space"]);
        // A device has no part: files that belong to it are given their names as far as they come before it.
        folder.run("apply m.exr g.png -o - --json").refused(2, &["--json"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn options_and_answers_without_space_leave_no_picture_either() {
    let folder = with_exemplar("no-space");
    let before = folder.files();
    let line = "quilt g.png -o out.png --size 40 --block 20 --report page";
    folder.run(&format!("{line} --save-config /dev/full")).refused(5, &["'/dev/full'", "no space"]);
    assert_eq!(folder.files(), before);
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let words = format!("{line} --save-config c.toml --map m.exr --json");
    let said = Said::from(folder.command().args(words.split(' ')).stdout(full).output().unwrap());
    assert_eq!(said.exit, Some(5), "{said:?}");
    assert_eq!(folder.files(), before);
}

/// The program under a limit of the shell; words are separated by spaces.
#[cfg(target_os = "linux")]
fn limited(folder: &Folder, limit: &str, line: &str) -> Said {
    let program = env!("CARGO_BIN_EXE_selvedge");
    let script = format!("ulimit {limit}; exec {program} {}", line.replace('@', &fixtures()));
    let mut shell = std::process::Command::new("sh");
    Said::from(shell.args(["-c", &script]).current_dir(folder.path("")).output().unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_file_sizes_is_no_space_and_leaves_no_part() {
    let folder = with_exemplar("file-size");
    let before = folder.files();
    let line = "quilt g.png -o out.png --size 256 --block 30";
    limited(&folder, "-f 8", line).refused(5, &["'out.png'", "no space for"]);
    assert_eq!(folder.files(), before);
    // Of two files the first fits.
    let line = "quilt g.png -o out.png --size 40 --block 30 --map map.exr --explain large.tiff";
    limited(&folder, "-f 20", line).refused(5, &["'large.tiff'", "no space for"]);
    assert_eq!(folder.files(), before);
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_is_refused_is_one_line_and_no_abort() {
    let folder = Folder::new("address-space");
    let mut refused = 0;
    // From what the program itself needs to what the run needs, in steps smaller than any of its large buffers.
    for mib in (26..70).step_by(4) {
        let format = ["out.png", "out.tiff", "out.webp", "out.jpg"][mib / 4 % 4];
        let line = format!(
            "quilt @/cobbles.png -o {format} --map map.exr --size 2000 --block 96 --stage random -j 1 --max-memory 9GiB"
        );
        let said = limited(&folder, &format!("-v {}", mib << 10), &line);
        if said.exit == Some(0) {
            for name in [format, "map.exr"] {
                fs::remove_file(folder.path(name)).unwrap();
            }
            continue;
        }
        // With the least of them some systems cannot even begin.
        if said.stderr.contains("shared libraries") || said.stderr.contains("starts no threads") {
            continue;
        }
        said.refused(6, &["no memory for"]);
        assert_eq!(folder.names(), Vec::<String>::new(), "{mib} MiB");
        refused += 1;
    }
    assert!(3 < refused, "{refused}");
}

#[test]
fn the_budget_holds_for_commands_that_weave_nothing() {
    let folder = Folder::new("budget");
    let write = |name: &str, side: u32| {
        let samples = Samples::U8(Grid::try_filled(Domain::open([side; 2]), 1, 90).unwrap());
        let plane = Plane::new(Role::Color, samples);
        selvedge_io::write(folder.path(name), &plane, &Default::default(), &Default::default()).unwrap();
    };
    write("a.png", 3000);
    write("b.png", 3000);
    // Reading alone takes no more than this.
    for line in ["inspect a.png", "compare a.png b.png --diff c.png"] {
        folder
            .run(&format!("{line} --max-memory 40MiB"))
            .refused(6, &["40 MiB", "use smaller pictures or --max-memory"]);
        folder.run(&format!("{line} --max-memory 1GiB")).done();
    }
    // One whose work is as large as its exemplar.
    let line = "score @/stars.png --exemplar a.png --max-memory 256MiB";
    folder.run(line).refused(6, &["256 MiB", "use smaller pictures or --max-memory"]);
    let said = folder.run("score @/stars.png --exemplar @/stars.png --max-memory 64MiB --json").done();
    assert!(said.json()["peak_memory_bytes"].as_u64().is_none_or(|peak| peak < 64 << 20));
    folder.run("quilt @/stars.png -o m.png --size 64 --block 20 --map m.exr").done();
    let said = folder.run("apply m.exr @/stars.png -o x.png --dry-run").done();
    assert!(said.stderr.contains("x.png: would be 64x64 px through m.exr, with about "), "{said:?}");
}

#[test]
fn a_mask_of_another_size_is_refused_before_it_is_decoded() {
    let folder = with_exemplar("mask-size");
    folder.run("quilt g.png -o m.png --size 64 --block 20 --map m.exr").done();
    let bytes = fs::read(fixtures() + "/weave.png").unwrap();
    // Its header is sound.
    fs::write(folder.path("cut.png"), &bytes[..bytes.len() / 2]).unwrap();
    folder
        .run("quilt g.png -o a.png --mask cut.png")
        .refused(3, &["'cut.png'", "192x192 px", "'g.png' has 128x128 px"]);
    folder.run("apply m.exr g.png -o a.png --fixed cut.png").refused(3, &["'cut.png'", "192x192", "map has 64x64 px"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_map_takes_memory_by_its_places_and_not_by_what_its_sources_claim() {
    use selvedge_core::{Origin, SampleId, SourceMap, SourceTable, Transform};
    let folder = Folder::new("claims");
    let domain = Domain::open([16_384; 2]);
    let origin = |exemplar| Origin { exemplar, transform: Transform::IDENTITY };
    let table = SourceTable::new((0..10).map(|i| (origin(i), domain)).collect::<Vec<_>>()).unwrap();
    let mut ids = Grid::try_filled(Domain::open([4, 4]), 1, SampleId::UNASSIGNED).unwrap();
    ids.set(0, [1, 2], table.id(9, [5, 7]));
    ids.set(0, [3, 3], table.id(9, [5, 7]));
    let fingerprints = vec![selvedge_io::Fingerprint::default(); 10];
    let file = selvedge_io::MapFile::new(SourceMap::new(ids, table).unwrap(), fingerprints, Default::default());
    selvedge_io::write_map(folder.path("m.exr"), &file, false).unwrap();
    let said = limited(&folder, &format!("-v {}", 1 << 20), "info m.exr --json -j 1").done();
    assert_eq!(said.json()["stats"]["percent_of_exemplars_used"], 0.0);
    assert_eq!(said.json()["stats"]["unassigned"], 14);
}

#[test]
fn what_a_format_does_not_hold_is_refused_before_the_work_and_names_the_exemplar() {
    let folder = Folder::new("held");
    // This would take minutes if it were begun.
    let long = "--size 16384x4000 --block 8 --max-memory 100GiB";
    let refused = [
        (
            "quilt @/cobbles-hole.png -o a.jpg",
            &["cobbles-hole.png': has 3 channels and alpha, which jpeg", "('a.jpg')", "png, tiff, webp or tga"][..],
        ),
        ("quilt @/weave.png -o a.webp", &["'a.webp'", "16383", "write png, jpeg, tiff or tga"]),
        (
            "quilt @/scales-hdr.exr -o a.png",
            &["scales-hdr.exr': has half samples, which png", "('a.png')", "--depth u8|u16"],
        ),
        ("quilt @/weave.png @/bricks/height.png -o a.jpg", &["height.png': has u16 samples, which jpeg"]),
    ];
    for (line, parts) in refused {
        for dry in ["", " --dry-run"] {
            folder.run(&format!("{line} {long}{dry}")).refused(3, parts);
        }
    }
    folder.run("quilt @/weave.png -o a.png --size 400x").refused(3, &["weave.png'", "76800x76800 px", "over the caps"]);
    folder.run("quilt @/stars.png -o m.png --size 30 --block 9 --map m.exr").done();
    folder.run("apply m.exr @/stars.png @/scales-hdr.exr -o a-{stem}.png").refused(3, &["scales-hdr.exr'"]);
    assert_eq!(folder.names(), ["m.exr", "m.png"]);
}

#[test]
fn a_map_says_whether_a_plane_is_the_one_it_was_made_from() {
    let folder = with_exemplar("content");
    folder.run("quilt g.png -o q.png --size 30 --block 9 --map m.exr").done();
    let line = "apply m.exr g.png -o out.png";
    assert!(folder.run(&format!("{line} -v")).done().stderr.contains("'g.png' is the exemplar"));
    let said = folder.run("apply m.exr @/stars.png -o out.png").done();
    assert!(!said.stderr.contains("warning"), "the same contents by another name: {said:?}");
    folder.run("quilt g.png -o g2.png --size 128 --block 9").done();
    fs::rename(folder.path("g2.png"), folder.path("g.png")).unwrap();
    let said = folder.run(line).done();
    assert!(said.stderr.contains("warning: 'g.png': the map was made from a file of this name"), "{said:?}");
    fs::rename(folder.path("g.png"), folder.path("other.png")).unwrap();
    let said = folder.run("apply m.exr other.png -o out.png").done();
    assert!(!said.stderr.contains("warning"), "another plane of the material: {said:?}");
}

#[test]
fn a_quality_of_jpeg_is_taken_or_refused() {
    let folder = Folder::new("quality");
    let len = |quality: u32| {
        let line = format!("quilt @/weave.png -o a.jpg --size 64 --block 30 --quality {quality}");
        folder.run(&line).done();
        fs::metadata(folder.path("a.jpg")).unwrap().len()
    };
    assert!(len(10) < len(50) && len(50) < len(100));
    folder.run("quilt @/weave.png -o a.jpg --quality 0").refused(2, &["--quality", "1..=100"]);
}
