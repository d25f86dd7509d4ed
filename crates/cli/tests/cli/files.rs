//! What is written where, and what is left alone.

use std::fs;
use std::path::Path;

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use serde_json::Value;

use crate::program::{Folder, fixtures};

#[test]
fn an_output_that_is_an_input_is_refused() {
    let folder = Folder::new("same");
    fs::copy(fixtures() + "/stars.png", folder.path("a.png")).unwrap();
    fs::hard_link(folder.path("a.png"), folder.path("hard.png")).unwrap();
    let before = folder.files();
    folder.run("quilt a.png -o ./a.png").refused(4, &["'./a.png'", "same file as the input 'a.png'"]);
    folder.run("quilt a.png -o hard.png").refused(4, &["'hard.png'", "'a.png'"]);
    folder.run("quilt @/weave.png --mask a.png -o a.png").refused(4, &["'a.png'"]);
    folder.run("compare a.png @/stars.png --diff a.png").refused(4, &["'a.png'"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a.png", folder.path("soft.png")).unwrap();
        folder.run("quilt a.png -o soft.png").refused(4, &["'soft.png'"]);
        fs::remove_file(folder.path("soft.png")).unwrap();
    }
    assert_eq!(folder.files(), before);
}

#[cfg(unix)]
#[test]
fn two_outputs_that_lead_to_one_file_that_is_not_there_yet_are_refused() {
    let folder = Folder::new("dangling");
    let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, folder.path(name)).unwrap();
    fs::create_dir(folder.path("report")).unwrap();
    link("o.png", "m.exr");
    link("o.png", "e.png");
    link("../o.png", "report/index.html");
    for (output, more) in
        [("o.png", "--map m.exr"), ("o.png", "--explain e.png"), ("e.png", "--map m.exr"), ("o.png", "--report report")]
    {
        let line = format!("quilt @/stars.png --size 20 -o {output} {more}");
        folder.run(&line).refused(2, &["is named for two outputs"]);
        assert!(!folder.path("o.png").exists(), "{more}");
    }
}

#[test]
fn nothing_is_replaced_with_no_clobber() {
    let folder = Folder::new("clobber");
    for name in ["a.png", "m.exr", "c.toml"] {
        fs::write(folder.path(name), b"old").unwrap();
    }
    let before = folder.files();
    let refused = |line: &str, name: &str| {
        folder.run(&format!("quilt @/stars.png {line} --no-clobber")).refused(4, &[name, "exists"]);
    };
    refused("-o a.png", "'a.png'");
    refused("-o b.png --map m.exr", "'m.exr'");
    refused("-o b.png --save-config c.toml", "'c.toml'");
    assert_eq!(folder.files(), before);
    folder.run("quilt @/stars.png -o a.png --size 20").done();
    assert_ne!(folder.files()["a.png".as_ref() as &std::path::Path], b"old");
}

#[test]
fn a_dry_run_writes_nothing_and_tells_what_it_would_do() {
    let folder = Folder::new("dry");
    folder.run("quilt @/stars.png -o map.png --size 40 --map map.exr").done();
    let before = folder.files();
    let lines = [
        "quilt @/stars.png -o a.png --map m.exr",
        "graphcut @/stars.png -o a.png --size 20",
        "apply map.exr @/stars.png -o a.png",
        "compare @/stars.png @/stars.png --diff a.png",
        "man .",
    ];
    for line in lines {
        let said = folder.run(&format!("{line} --dry-run")).done();
        assert!(line.starts_with("compare") || said.stderr.contains("would be"), "{said:?}");
        assert_eq!(folder.files(), before, "{line}");
    }
    let object = folder.run("quilt @/stars.png -o a.png --dry-run --json").done().json();
    assert!(1 << 20 < object["estimated_memory_bytes"].as_u64().unwrap(), "{object}");
    // It lists what would be written.
    assert_eq!(object["outputs"].as_array().map(Vec::len), Some(1));
    assert_eq!((&object["outputs"][0]["path"], &object["outputs"][0]["width"]), (&"a.png".into(), &256.into()));
    // And how much would be laid: as many blocks as are, of patches about and at most.
    for (line, key, exact) in [
        ("quilt @/stars.png -o a.png --size 300 --block 40", "blocks", true),
        ("hybrid @/stars.png -o a.png --size 100 --block 32", "blocks", true),
        ("transfer @/stars.png --target @/stars.png -o a.png --block 60 --passes 2", "blocks", true),
        ("graphcut @/stars.png -o a.png --size 200 --region 30", "patches", false),
        ("graphcut @/stars.png -o a.png --size 200 --region 30 --refine 3", "refinements", false),
    ] {
        let counts = |line: &str| folder.run(line).done().json()["stats"].clone();
        let told = counts(&format!("{line} --dry-run --json"))[key].as_u64().unwrap();
        let made = counts(&format!("{line} --json"));
        let made = match (made["passes"].as_array(), &made["levels"][0]) {
            (Some(passes), _) => passes.iter().map(|pass| pass[key].as_u64().unwrap()).sum(),
            (None, Value::Null) => made[key].as_u64().unwrap(),
            (None, first) => first[key].as_u64().unwrap(),
        };
        let within = if exact { made..made + 1 } else { made.div_ceil(2)..2 * made + 1 };
        assert!(within.contains(&told), "{line}: {told} told, {made} {key}");
        fs::remove_file(folder.path("a.png")).unwrap();
    }
    folder.run("quilt @/stars.png -o a.png --size 40 --dry-run --save-config c.toml").done();
    let written: Vec<String> =
        folder.names().into_iter().filter(|name| !before.contains_key(Path::new(name))).collect();
    assert_eq!(written, ["c.toml"]);
    folder.run("quilt @/stars.png -o a.png --config c.toml --dry-run").done();
    fs::remove_file(folder.path("c.toml")).unwrap();
    // What a run would refuse, a dry run refuses too.
    folder.run("quilt @/stars.png -o a.png --dry-run --block 200").refused(3, &["200 px"]);
    folder.run("quilt @/stars.png -o a.png --dry-run --max-memory 1MiB").refused(6, &["1.0 MiB"]);
}

#[test]
fn a_report_is_one_page_with_its_pictures_inside() {
    let folder = Folder::new("report");
    let methods = [
        "quilt @/weave.png -o a.png --size 60 --block 20",
        "graphcut @/stars.png -o a.tiff --size 40 --refine 0",
        "transfer @/stars.png --target @/stars.png -o a.exr --depth half --block 20 --passes 1",
    ];
    for line in methods {
        let object = folder.run(&format!("{line} --report page --map m.exr --json")).done().json();
        assert_eq!(object["outputs"].as_array().unwrap().len(), 3);
        let page = fs::read_to_string(folder.path("page/index.html")).unwrap();
        for part in ["<!doctype html>", "selvedge ", "Options", "Counts", "Seconds", "synthesis", "m.exr", "--seed 0"] {
            assert!(page.contains(part), "{line}: no {part}");
        }
        for part in ["a seam", "never used", "Exemplar ", " px from "] {
            assert!(page.contains(part), "{line}: no {part}");
        }
        // The output, its explanation and the exemplar; graphcut shows what seams cost as well.
        let pictures = if line.starts_with("graphcut") { 4 } else { 3 };
        assert_eq!(page.matches("src=\"data:image/png;base64,").count(), pictures);
        assert_eq!(
            page.matches("src=").count() + page.matches("href=").count(),
            pictures,
            "nothing outside of the page"
        );
    }
    let before = folder.files();
    folder.run("quilt @/weave.png -o b.png --report a.png").refused(4, &["'a.png': is no folder"]);
    folder.run("quilt @/weave.png -o b.png --report a.png/page").refused(4, &["'a.png/page'", "folder is a file"]);
    folder.run("quilt @/weave.png -o b.png --size 20 --report other --dry-run").done();
    assert_eq!(folder.files(), before);
}

#[test]
fn a_page_that_is_not_ours_is_not_replaced() {
    let folder = Folder::new("foreign");
    fs::create_dir(folder.path("site")).unwrap();
    let line = "quilt @/stars.png -o a.png --size 20 --block 9 --report";
    folder.run(&format!("{line} own")).done();
    folder.run(&format!("{line} own")).done();
    for foreign in ["<!doctype html><html lang=\"en\"><title>selvedge</title>", ""] {
        fs::write(folder.path("site/index.html"), foreign).unwrap();
        let parts = ["'site/index.html'", "--report did not write", "name another folder"];
        folder.run(&format!("{line} site")).refused(4, &parts);
        assert_eq!(fs::read_to_string(folder.path("site/index.html")).unwrap(), foreign);
    }
}

#[test]
fn folders_of_all_outputs_are_made_and_only_with_them() {
    let folder = Folder::new("made");
    let line = "quilt @/stars.png -o a/b/o.png --size 30 --block 9 --map a/m/m.exr --explain e/e.png --report r/p/q";
    folder.run(&format!("{line} --dry-run")).done();
    folder.run(&format!("{line} --save-config s/c.toml").replace(" 9 ", " 500 ")).refused(3, &["500 px"]);
    folder.run(&format!("{line} --save-config a/b/./o.png")).refused(2, &["two outputs"]);
    // What is a file cannot be the folder of another one.
    folder.run("quilt @/stars.png -o x/y.png --size 30 --block 9 --map x/y.png/m.exr").refused(4, &["'x/y.png'"]);
    assert_eq!(folder.names(), Vec::<String>::new());
    folder.run(&format!("{line} --save-config s/c.toml")).done();
    for name in ["a/b/o.png", "a/m/m.exr", "e/e.png", "r/p/q/index.html", "s/c.toml"] {
        assert!(folder.path(name).is_file(), "{name}");
    }
    assert_eq!(folder.names(), ["a", "e", "r", "s"]);
    folder.run("apply a/m/m.exr @/stars.png -o p/{stem}/x.png").done();
    folder.run("compare @/stars.png @/stars.png --diff d/d.png").done();
    folder.run("man man/man1").done();
    assert!(["p/stars/x.png", "d/d.png", "man/man1/selvedge.1"].iter().all(|name| folder.path(name).is_file()));
}

/// A TIFF of three planes in tiles of this side, so many along each axis.
fn planar_tiles(along: u32, side: u32) -> Vec<u8> {
    let (tiles, tile) = (3 * along * along, side * side);
    let lists = 8 + 2 + 11 * 12 + 4;
    let entries = [
        (256, along * side, 1),
        (257, along * side, 1),
        (258, 8, 1),
        (259, 1, 1),
        (262, 2, 1),
        (277, 3, 1),
        (284, 2, 1),
        (322, side, 1),
        (323, side, 1),
        (324, lists, tiles),
        (325, lists + 4 * tiles, tiles),
    ];
    let mut file = b"II\x2a\0\x08\0\0\0\x0b\0".to_vec();
    for (tag, value, count) in entries {
        file.extend([[tag as u8, (tag >> 8) as u8, 4, 0], u32::to_le_bytes(count), u32::to_le_bytes(value)].concat());
    }
    file.extend([0; 4]);
    (0..tiles).for_each(|i| file.extend((lists + 8 * tiles + i * tile).to_le_bytes()));
    (0..tiles).for_each(|_| file.extend(tile.to_le_bytes()));
    file.extend((0..tiles * tile).map(|i| (i % 251) as u8));
    file
}

#[test]
fn the_estimate_is_no_less_than_the_peak() {
    let folder = Folder::new("estimate");
    let domain = Domain::open([200, 200]);
    folder.run("quilt @/cobbles.png -o c.png --size 600 --block 30 --map m.exr").done();
    let write = |name: &str, of: &dyn Fn([u32; 2]) -> u8| {
        let samples = Grid::from_vec(domain, 1, domain.positions().map(of).collect()).unwrap();
        let plane = Plane::new(Role::Color, Samples::U8(samples));
        selvedge_io::write(folder.path(name), &plane, &Default::default(), &Default::default()).unwrap();
    };
    // Every place is a candidate there.
    write("flat.png", &|_| 90);
    write("mask.png", &|[y, x]| if (y * 131 + x * 57) % 1009 == 0 { 0 } else { 255 });
    let hole = Domain::open([600, 600]);
    let samples = hole.positions().map(|[y, x]| 255 * u8::from((200..280).contains(&y) && x / 100 == 2)).collect();
    let plane = Plane::new(Role::Color, Samples::U8(Grid::from_vec(hole, 1, samples).unwrap()));
    selvedge_io::write(folder.path("hole.png"), &plane, &Default::default(), &Default::default()).unwrap();
    fs::write(folder.path("planar.tif"), planar_tiles(4, 512)).unwrap();
    let mut within = 0;
    for line in [
        "quilt c.png -o a.png --size 400",
        "quilt @/cobbles.png -o a.png --size 300 --map n.exr",
        "quilt @/scales-hdr.exr -o a.exr --size 1500x900 --depth float --block 48",
        "quilt @/weave.png @/scales.png @/bricks/height.png -o a.tiff --size 700 --tile xy",
        "quilt @/stars.png -o a.png --size 2000 --block 24 --map n.exr",
        "quilt @/weave.png -o a.webp --size 1500 --block 48",
        "quilt @/weave.png -o a.tga --size 1500 --block 48",
        "quilt @/weave.png -o a.tiff --size 1500 --block 48",
        "quilt @/scales-hdr.exr -o a.hdr --size 900 --depth float --block 48",
        "quilt flat.png -o a.png --size 260 --block 30 --spread 0",
        "quilt flat.png --mask mask.png -o a.png --size 260 --block 9 -j 8",
        "transfer @/weave.png --target @/astronaut.png -o a.png --passes 2",
        "transfer @/weave.png --target @/cobbles-hole.png -o a.png",
        "transfer flat.png --mask mask.png --target @/stars.png -o a.png --passes 2 -j 8",
        "graphcut @/cobbles.png -o a.png --size 300 --placement entire --refine 4 --map n.exr",
        "graphcut @/stars.png -o a.png --size 512 --placement sub --refine 4 --tries 8",
        "graphcut @/stars.png -o a.png --size 300 --placement random --region 2 --reach 0 --refine 4",
        "graphcut @/stars.png -o a.png --size 400 --placement random --region 24 --refine 60 --report page",
        "graphcut @/cobbles.png -o a.png --size 256 --placement sub --refine 4 --scale-field top=0.5,bottom=2",
        "graphcut @/stars.png -o a.png --size 1500 --placement random --region 100 --refine 0 --feather 3",
        "graphcut @/bricks/albedo.png -o a.png --over @/bricks/albedo.png --fixed @/bricks/height.png --refine 0 --spline 4",
        "graphcut flat.png -o a.png --size 260",
        "hybrid @/cobbles.png -o a.png --size 300",
        "hybrid flat.png --mask mask.png -o a.png --size 200 --block 16",
        "optimize @/stars.png -o a.png --size 128 --schedule 2:16,1:8",
        "fill @/cobbles-hole.png -o a.png",
        "fill c.png --mask hole.png -o a.png",
        "tile c.png -o a.png",
        "tile @/weave.png --method band -o a.png",
        "inspect @/cobbles-hole.png",
        "inspect @/astronaut.png",
        "compare @/cobbles.png @/weave.png --diff d.tiff",
        "compare @/bricks/height.png @/bricks/height.png",
        "compare planar.tif planar.tif",
        "apply m.exr @/cobbles.png -o a.exr --depth float",
        "apply m.exr @/cobbles.png -o a.png --role height",
    ] {
        let estimate = folder.run(&format!("{line} --dry-run --json")).json()["estimated_memory_bytes"].as_u64();
        let threads = if line.contains("-j") { "" } else { "-j 2" };
        let object = folder.run(&format!("{line} --json {threads}"));
        // Pictures that differ are an answer too.
        assert!(matches!(object.exit, Some(0 | 1)), "{object:?}");
        let object = object.json();
        let Some(peak) = object["peak_memory_bytes"].as_u64() else {
            eprintln!("SKIPPED: this system does not tell the peak");
            return;
        };
        let estimate = estimate.unwrap();
        assert!(peak <= estimate, "{line}: {peak} bytes, {estimate} estimated");
        // Enough to refuse what cannot be done, and little more.
        eprintln!("{:.2} {line}: {peak} {estimate}", estimate as f64 / peak as f64);
        assert!(2 * estimate <= 5 * peak, "{line}: {peak} bytes, {estimate} estimated");
        within += u32::from(2 * estimate <= 3 * peak);
    }
    println!("within half as much again: {within}");
}

#[cfg(unix)]
#[test]
fn names_may_be_any_bytes() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let folder = Folder::new("names");
    for (i, name) in [&b"a\xff\xfeb.png"[..], b"line\nfeed.png", b"-rf.png", b"it's.png"].into_iter().enumerate() {
        let (input, output) = (folder.path(OsStr::from_bytes(name)), format!("out-{i}.png"));
        fs::copy(fixtures() + "/stars.png", &input).unwrap();
        let bare = OsStr::from_bytes(name);
        let words =
            ["quilt".as_ref(), "--size".as_ref(), "16".as_ref(), "-o".as_ref(), output.as_ref(), "--".as_ref(), bare];
        folder.run_words(words as [&OsStr; 7]).done();
        let refused = folder.run_words(["quilt".as_ref(), input.as_os_str(), "-o".as_ref(), input.as_os_str()]);
        refused.refused(4, &["same file"]);
        let missing = OsStr::from_bytes(b"none\n\xff.png");
        let said = folder.run_words(["info".as_ref(), missing, "--json".as_ref()]);
        let said = said.refused(4, &[r"error: 'none\n\xff.png': not found"]);
        assert_eq!(said.json()["error"]["path"], "none\n\\xff.png", "data has the name as it is");
        let said = folder.run_words(["info".as_ref(), OsStr::new(&output)]).done();
        assert!(String::from_utf8(said.stdout).unwrap().contains("selvedge quilt "));
    }
    let odd = OsStr::from_bytes(b"out\xff.png");
    folder
        .run_words([
            "quilt".as_ref(),
            OsStr::new(&(fixtures() + "/stars.png")),
            "--size".as_ref(),
            "16".as_ref(),
            "-o".as_ref(),
            odd,
        ])
        .done();
    assert!(folder.path(odd).exists());
}

#[cfg(unix)]
#[test]
fn what_cannot_be_written_is_refused_before_the_work() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = Folder::new("read-only");
    if std::path::Path::new("/dev/full").exists() {
        folder.run("quilt @/stars.png -o /dev/full --format png --size 16").refused(5, &["'/dev/full'", "no space"]);
    }
    fs::create_dir(folder.path("closed")).unwrap();
    fs::set_permissions(folder.path("closed"), fs::Permissions::from_mode(0o555)).unwrap();
    // A superuser may write there, but not into every folder of the system.
    let is_closed = |name: &str| fs::write(folder.path(name).join("selvedge-probe"), b"").is_err();
    match ["closed", "/sys"].into_iter().find(|name| folder.path(name).is_dir() && is_closed(name)) {
        None => eprintln!("SKIPPED: this user may write everywhere"),
        Some(closed) => {
            // This would take minutes if it were begun.
            let line = format!("quilt @/stars.png -o {closed}/a.png --size 9000 --block 8 --max-memory 100GiB");
            let refused = folder.run(&line).refused(4, &[&format!("'{closed}/a.png'")]);
            let reasons = ["permission denied", "read-only"];
            assert!(reasons.iter().any(|why| refused.stderr.contains(why)), "{refused:?}");
        }
    }
    fs::set_permissions(folder.path("closed"), fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn manual_pages_and_completions_know_every_command() {
    let folder = Folder::new("man");
    folder.run("man .").done();
    let names = folder.names();
    for command in ["quilt", "graphcut", "optimize", "apply", "info", "inspect", "compare", "completions", "man"] {
        assert!(names.contains(&format!("selvedge-{command}.1")), "{command}: {names:?}");
        for shell in ["bash", "zsh", "fish"] {
            let script = folder.run(&format!("completions {shell}")).done().stdout;
            assert!(String::from_utf8(script).unwrap().contains(command), "{shell}: {command}");
        }
    }
    assert!(names.contains(&"selvedge.1".to_owned()));
    let page = fs::read_to_string(folder.path("selvedge-quilt.1")).unwrap();
    assert!(page.contains("tolerance") && page.contains("keep\\-partial"), "{page}");
}
