//! Exemplars with next to nothing in them.

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Metadata, WriteOptions};

use crate::program::{Folder, fixtures};

fn write(folder: &Folder, name: &str, shape: [u32; 2], channels: usize, value: u8, alpha: bool) {
    let grid = Grid::try_filled(Domain::open(shape), channels, value).unwrap();
    let plane = Plane { alpha, ..Plane::new(Role::Color, Samples::U8(grid)) };
    selvedge_io::write(folder.path(name), &plane, &Metadata::default(), &WriteOptions::default()).unwrap();
}

#[test]
fn tiny_and_constant_exemplars_are_woven() {
    let folder = Folder::new("tiny");
    for (name, shape) in [("one.png", [1, 1]), ("row.png", [1, 50]), ("column.png", [50, 1]), ("flat.png", [64, 64])] {
        write(&folder, name, shape, 3, 7, false);
        for options in ["--size 9x5", "--size 40 --tile xy", "--size 1", "--size 30 --stage random"] {
            let line = format!("quilt {name} -o out.png {options}");
            folder.run(&line).done();
            let out = selvedge_io::read(folder.path("out.png"), &Default::default()).unwrap().plane;
            assert!(matches!(&out.samples, Samples::U8(g) if g.samples().iter().all(|v| *v == 7)), "{line}");
        }
        folder.run(&format!("inspect {name}")).done();
        folder.run(&format!("info {name}")).done();
    }
    folder.run("quilt row.png -o no.png --block 2").refused(3, &["'row.png'", "50x1 px", "2 px", "use --block 1"]);
}

#[test]
fn what_is_transparent_or_masked_throughout_is_refused() {
    let folder = Folder::new("nothing");
    write(&folder, "clear.png", [20, 20], 4, 0, true);
    write(&folder, "black.png", [20, 20], 1, 0, false);
    write(&folder, "white.png", [20, 20], 1, 255, false);
    let what = "no sample can be used";
    folder.run("quilt clear.png -o out.png").refused(3, &["'clear.png'", what]);
    folder.run("quilt white.png --mask black.png -o out.png").refused(3, &["'white.png'", what]);
    folder.run("inspect clear.png").refused(3, &["'clear.png'"]);
    folder.run("quilt black.png --mask white.png -o out.png").done();
}

#[cfg(unix)]
#[test]
fn names_and_tags_reach_the_terminal_escaped_and_named() {
    let folder = Folder::new("told");
    let file = std::fs::read(fixtures() + "/weave.png").unwrap();
    std::fs::write(folder.path("a\u{1b}[31m.png"), &file).unwrap();
    let said = folder.run_words(["inspect", "a\u{1b}[31m.png"]).done();
    assert!(!said.stdout.contains(&0x1b), "{}", String::from_utf8_lossy(&said.stdout));
    // Display P3, which another exemplar has not.
    let mut tagged = file[..33].to_vec();
    tagged.extend([0, 0, 0, 4]);
    tagged.extend(b"cICP\x0c\x0d\x00\x01");
    tagged.extend(crc(b"cICP\x0c\x0d\x00\x01").to_be_bytes());
    tagged.extend(&file[33..]);
    std::fs::write(folder.path("p3.png"), tagged).unwrap();
    let said = folder.run("info p3.png").done();
    let text = String::from_utf8(said.stdout).unwrap();
    assert!(text.contains("Display P3, sRGB, matrix 0, full range"), "{text}");
    let said = folder.run("quilt p3.png @/weave.png -o q.png --size 40 --block 12").done();
    assert!(said.stderr.contains("its colour tags are kept, but another exemplar has others"), "{said:?}");
}

/// That of PNG's chunks.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}
