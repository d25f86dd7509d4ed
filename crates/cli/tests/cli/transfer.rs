//! Transfers: what is said about their light.

use selvedge_core::{Domain, Grid, Plane, Role, Samples};
use selvedge_io::{Metadata, WriteOptions};

use crate::program::Folder;

#[test]
fn an_exemplar_of_a_narrow_range_is_told_how_to_follow_a_wide_one() {
    let folder = Folder::new("transfer-light");
    let write = |name: &str, value: &dyn Fn(u32, u32) -> u8| {
        let domain = Domain::open([48, 48]);
        let samples = domain.positions().map(|[y, x]| value(y, x)).collect();
        let plane = Plane::new(Role::Color, Samples::U8(Grid::from_vec(domain, 1, samples).unwrap()));
        selvedge_io::write(folder.path(name), &plane, &Metadata::default(), &WriteOptions::default()).unwrap();
    };
    write("narrow.png", &|y, x| (100 + (y * 7 + x * 3) % 40) as u8);
    write("wide.png", &|y, x| ((y + x) * 2 + 20) as u8);
    let line = "transfer narrow.png --target wide.png -o out.png --passes 1 --block 12";
    let said = folder.run(line).done();
    assert!(
        said.stderr.contains("'wide.png': its light spans") && said.stderr.contains("--match-histogram"),
        "{said:?}"
    );
    for other in [" --match-histogram", " --correspondence orientation"] {
        let said = folder.run(&format!("{line}{other}")).done();
        assert!(!said.stderr.contains("its light spans"), "{said:?}");
    }
    let said = folder.run("transfer wide.png --target narrow.png -o out.png --passes 1 --block 12").done();
    assert!(!said.stderr.contains("its light spans"), "{said:?}");
}

#[test]
fn a_guide_of_several_exemplars_is_a_list_and_a_target() {
    let folder = Folder::new("transfer-guides");
    let line = "transfer @/cobbles.png @/weave.png --guide @/cobbles.png,@/weave.png @/weave.png -o a.png --dry-run";
    let said = folder.run(line).done();
    assert!(said.stderr.contains("would be 192x192 px from 12490 blocks of 21, "), "{}", said.stderr);
}

#[test]
fn a_sweep_of_labels_makes_a_run_for_each_pair_of_values() {
    let folder = Folder::new("transfer-sweep");
    let line = "transfer @/cobbles.png --target @/ground/target.png --match-histogram --sweep K=.1,2 N=1,2 -o {n}.png";
    folder.run(&format!("{line} --method cms --sheet sheet.png")).done();
    assert_eq!(folder.names(), ["1.png", "2.png", "3.png", "4.png", "sheet.png"]);
    let files = folder.files();
    assert!(files[std::path::Path::new("1.png")] != files[std::path::Path::new("4.png")]);
    folder.run(line).refused(2, &["of labels", "--method cms"]);
}
