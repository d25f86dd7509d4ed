//! What `score` says of outputs.

use crate::program::Folder;

#[test]
fn several_outputs_are_ranked_best_first() {
    let folder = Folder::new("score");
    folder.run("quilt @/weave.png -o bad.png --map bad.exr --stage random --size 96").done();
    folder.run("graphcut @/weave.png -o good.png --map good.exr --size 96").done();
    let ask = "score bad.png good.png --exemplar @/weave.png";
    for maps in ["", " --map bad.exr --map good.exr"] {
        let said = String::from_utf8(folder.run(&format!("{ask}{maps}")).done().stdout).unwrap();
        assert!(said.starts_with("1. good.png: preference"), "{said}");
        assert!(said.contains("2. bad.png: preference") && said.contains("  coherence_2: "), "{said}");
        assert_eq!(said.contains("seam_energy"), !maps.is_empty(), "{said}");
        assert_eq!(folder.run(&format!("{ask}{maps} -j 3")).done().stdout, said.as_bytes());
    }
}

#[test]
fn maps_and_sizes_that_do_not_fit_are_refused() {
    let folder = Folder::new("score-refused");
    folder.run("quilt @/weave.png -o a.png --map a.exr --size 40").done();
    folder.run("quilt @/weave.png -o b.png --size 48x20").done();
    folder.run("score a.png a.png --exemplar @/weave.png --map a.exr").refused(2, &["1 map", "one --map for each"]);
    folder.run("score b.png --exemplar @/weave.png").refused(3, &["'b.png'", "at least 32"]);
    folder.run("quilt @/weave.png -o c.png --size 64").done();
    folder
        .run("score c.png --exemplar @/weave.png --map a.exr")
        .refused(3, &["'a.exr': 40x40 px, but 'c.png' has 64x64 px"]);
    let score = |exemplar: &str| folder.run(&format!("score a.png --exemplar @/{exemplar}.png --map a.exr"));
    score("weave").done();
    score("stars").refused(3, &["'a.exr': was made from 'weave.png', whose content is none of", "stars.png"]);
}

#[test]
fn what_is_transparent_is_not_judged() {
    let folder = Folder::new("score-transparent");
    folder.pierced("@/weave.png", "hole.png", |x| x < 20);
    folder.pierced("@/weave.png", "none.png", |_| true);
    for out in ["hole.png", "none.png"] {
        folder.run(&format!("score {out} --exemplar @/weave.png")).refused(3, &[out, "transparent"]);
    }
    folder.run("score @/weave.png --exemplar none.png").refused(3, &["'none.png'", "all of it is transparent"]);
    folder.run("score @/weave.png --exemplar hole.png").done();
}
