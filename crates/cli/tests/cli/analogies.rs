//! Constrained synthesis: what is told of guides that do not fit, and runs that sweep what is not known yet.

use crate::program::Folder;

const NUMBERS: &str =
    "numbers @/ground/picture.png --labels @/ground/labels.png --target @/ground/target.png --history 1";

#[test]
fn what_nothing_under_the_exemplars_is_like_is_told_before_the_work() {
    let folder = Folder::new("analogies-fit");
    let said = folder.run(&format!("{NUMBERS} -o out.png --dry-run")).done();
    assert!(!said.stderr.contains("is like nothing"), "{}", said.stderr);
    // A photograph is to be led by colours that it has nowhere.
    let pair = "analogy @/cobbles.png @/cobbles.png @/ground/target.png -o out.png --dry-run";
    let said = folder.run(pair).done();
    assert!(said.stderr.contains("target.png': 100 % of it is like nothing under the exemplars"), "{}", said.stderr);
    let said = folder.run("inspect @/cobbles.png --guide @/cobbles.png @/ground/target.png --json").done();
    assert_eq!((&said.json()["stats"]["guides"][0]["uncovered"], said.stderr.as_str()), (&1.0.into(), ""));
    let said = folder.run("inspect @/cobbles.png --guide @/ground/labels.png @/ground/target.png");
    said.refused(3, &["labels.png"]);
}

#[test]
fn a_sweep_makes_a_run_for_each_pair_of_values() {
    let folder = Folder::new("analogies-sweep");
    let said = folder.run(&format!("{NUMBERS} --sweep K=.5,5 N=1,2,3 -o {{n}}.png --sheet sheet.png --dry-run")).done();
    assert_eq!(said.stderr.lines().filter(|line| line.contains("under 1 constraint")).count(), 6, "{}", said.stderr);
    folder.run(&format!("{NUMBERS} --sweep K=1,2 -o out.png")).refused(2, &["'{n}'"]);
    folder.run(&format!("{NUMBERS} --sweep K=1 K=2 -o {{n}}.png")).refused(2, &["two lists"]);
    folder.run(&format!("{NUMBERS} --sweep X=1 -o {{n}}.png")).refused(2, &["K=.05"]);
    folder.run(&format!("{NUMBERS} --sweep N=1,40 -o {{n}}.png")).refused(2, &["40"]);
    folder.run(&format!("{NUMBERS} --sweep N=40 -o out.png")).refused(2, &["40"]);
    assert!(folder.names().is_empty(), "refused before the first run: {:?}", folder.names());
}
