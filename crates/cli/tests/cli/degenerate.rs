//! Exemplars with next to nothing in them.

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Metadata, WriteOptions};

use crate::program::Folder;

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
