//! `selvedge hybrid` from outside.

use crate::program::Folder;

#[test]
fn what_is_typed_beside_paper_is_used_though_it_is_what_would_be_used_without() {
    let folder = Folder::new("hybrid-paper");
    let options = |typed: &str| {
        let line = format!("hybrid @/scales.png -o a.png --size 48 --dry-run --json --paper {typed}");
        let made = folder.run(&line).done().json();
        ["max-error", "pixel-error"].map(|name| made["options"][name].as_str().unwrap_or("a number").to_owned())
    };
    let paper = options("");
    assert!(paper.iter().all(|error| error != "auto"), "{paper:?}");
    assert_eq!(options("--max-error auto"), ["auto".to_owned(), paper[1].clone()]);
    assert_eq!(options("--pixel-error auto"), [paper[0].clone(), "auto".to_owned()]);
}
