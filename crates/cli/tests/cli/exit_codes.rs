//! Every exit code, each with one line on standard error and, with `--json`, one object on standard output.

use crate::program::{Folder, fixtures};

/// Command lines that fail, their codes, and what their lines name.
const REFUSED: [(&str, i32, &[&str]); 37] = [
    ("quilt @/weave.png -o a.png --block 30000", 3, &["weave.png", "30000", "--block 192"]),
    ("transfer @/weave.png --target @/weave.png -o a.png --block 30000", 3, &["30000", "--block 192"]),
    ("graphcut @/weave.png -o a.png --refine 4294967295", 2, &["refine is 4294967295", "use 0 to 1000000"]),
    ("weave a.png", 2, &["unrecognized subcommand 'weave'"]),
    ("quilt @/weave.png", 2, &["--output <OUT>"]),
    ("quilt @/weave.png -o a.png --sise 3", 2, &["'--sise'", "a similar argument exists: '--size'"]),
    ("quilt @/weave.png -o a.png --size 0x5", 2, &["'0x5' is no size; write 512, 512x384 or 2x"]),
    ("quilt @/weave.png -o a.png --threads -1", 2, &["-1"]),
    ("quilt @/weave.png -o a.png --seed 18446744073709551616", 2, &["--seed"]),
    ("quilt @/weave.png -o a.png --block 0", 2, &["0 px"]),
    ("quilt @/weave.png -o a.png --tolerance nan", 2, &["NaN"]),
    ("quilt @/weave.png -o a.png --paper --stage random", 2, &["--paper", "--stage"]),
    ("quilt @/weave.png -o a.png -q -v", 2, &["--quiet", "--verbose"]),
    ("quilt @/weave.png -o a.png --seamless", 2, &["use --tile xy"]),
    ("quilt @/weave.png -o a", 2, &["'a'", "has no extension", "--format"]),
    ("quilt @/weave.png -o a.xyz", 2, &["'a.xyz'", "png, jpeg, tiff, exr, hdr, webp, tga"]),
    ("quilt @/weave.png -o a.jpg --depth u16", 2, &["'a.jpg'", "u16", "--depth u8"]),
    ("quilt @/weave.png -o a.png --mask none --mask none", 2, &["2 masks for 1 exemplar"]),
    ("quilt - - -o a.png", 2, &["standard input is named twice"]),
    ("quilt @/weave.png -o a.exr --map a.exr --depth half", 2, &["'a.exr'", "two outputs"]),
    ("quilt @/weave.png -o a.png --tolerance -1", 2, &["tolerance of -1", "0 to 100"]),
    (
        "transfer @/weave.png --guide @/weave.png @/stars.png -o a.png --correspondence orientation",
        2,
        &["--correspondence", "give a --target"],
    ),
    (
        "transfer @/weave.png --guide @/weave.png @/stars.png -o a.png --correspondence orientation=-5",
        2,
        &["--correspondence", "give a --target"],
    ),
    (
        "transfer missing.png --target @/stars.png -o a.png --correspondence orientation=-5",
        2,
        &["weight of -5", "change --weight or --correspondence"],
    ),
    (
        "transfer missing.png --guide missing.png missing.png --weight=nan -o a.png",
        2,
        &["weight of NaN", "change --weight or --correspondence"],
    ),
    (
        "transfer @/weave.png --target @/stars.png -o a.png --correspondence luminance=1e300,orientation=1e-300",
        2,
        &["counts nothing beside", "change --weight or --correspondence"],
    ),
    ("quilt @/weave.png -o a.png --block 500", 3, &["weave.png'", "192x192 px", "500 px", "use --block 192"]),
    ("quilt @/bricks/height.png -o a.jpg", 3, &["height.png'", "u16", "('a.jpg')", "--depth u8"]),
    ("quilt @/weave.png -o a.png --size 70000x1", 3, &["70000x1 px", "65535"]),
    ("quilt @/bad/err-text-as.png -o a.png", 3, &["err-text-as.png'"]),
    ("quilt @/weave.png -o a.png --mask @/stars.png", 3, &["stars.png'", "128x128 px", "192x192 px"]),
    ("apply @/weave.png @/weave.png -o a.png", 3, &["weave.png'", "no source map"]),
    ("compare @/weave.png @/stars.png", 3, &["stars.png'", "128x128 px", "192x192 px"]),
    ("quilt missing.png -o a.png", 4, &["'missing.png'", "not found"]),
    ("quilt @/weave.png -o @/weave.png/a.png", 4, &["weave.png/a.png'", "its folder is a file", "another folder"]),
    ("quilt @/bricks -o a.png", 4, &["bricks'", "is a folder"]),
    ("quilt @/weave.png -o a.png --size 9000 --max-memory 64MiB", 6, &["64 MiB", "use --size", "--max-memory"]),
];

#[test]
fn failures_are_one_line_one_object_and_no_file() {
    let folder = Folder::new("refused");
    for (line, exit, parts) in REFUSED {
        let said = folder.run(line).refused(exit, parts);
        assert!(said.stdout.is_empty(), "{line}: {said:?}");

        let error = folder.run(&format!("{line} --json")).refused(exit, parts).json()["error"].clone();
        let text = |key: &str| error[key].as_str().unwrap_or_default().to_owned();
        assert_eq!(error["exit"], exit, "{line}");
        assert!(!text("message").is_empty() && !text("remedy").is_empty(), "{line}: {error}");
        let path = if error["path"].is_null() { String::new() } else { format!("'{}': ", text("path")) };
        let said_again = format!("error: {path}{}; {}\n", text("message"), text("remedy"));
        assert_eq!(said_again, said.stderr, "the object says what the line says");
        assert_eq!(folder.names(), Vec::<String>::new(), "{line}");
    }
}

#[test]
fn compare_exits_with_1_over_its_thresholds() {
    let folder = Folder::new("compare");
    let pair = "compare @/weave.png @/scales.png";
    let exit = |line: &str| folder.run(line).exit;
    assert_eq!(exit("compare @/weave.png @/weave.png"), Some(0));
    assert_eq!(exit(pair), Some(1));
    assert_eq!(exit(&format!("{pair} --fail 1")), Some(0));
    assert_eq!(exit(&format!("{pair} --fail-percent 100")), Some(0));
    assert_eq!(exit(&format!("{pair} --fail 1 --hard-fail 0.1")), Some(1));
    assert_eq!(exit(&format!("{pair} --fail 1 --psnr 90")), Some(1));
    let said = folder.run(&format!("{pair} --json"));
    assert_eq!((said.exit, said.json()["stats"]["over"].as_bool()), (Some(1), Some(true)));
    assert!(said.stderr.is_empty(), "{said:?}");
}

#[test]
fn help_and_versions_are_answers() {
    let folder = Folder::new("help");
    for line in ["", "--help", "--version", "help quilt", "quilt --help", "man --help"] {
        let said = folder.run(line).done();
        assert!(!said.stdout.is_empty() && said.stderr.is_empty(), "{line}");
        assert!(!said.stdout.contains(&0x1b), "{line}: escapes where nobody asked for colours");
    }
}

#[test]
fn a_name_may_hold_any_sign_that_would_part_a_message() {
    let folder = Folder::new("semicolons");
    std::fs::write(folder.path("a; b.png"), "no picture").unwrap();
    let refused = |words: &[&str], exit: i32, parts: [&str; 3]| {
        let words = words.iter().map(|word| word.replace('@', &fixtures())).chain(["--json".to_owned()]);
        let said = folder.run_words(words).refused(exit, &parts);
        let error = said.json()["error"].clone();
        let [path, message, remedy] = ["path", "message", "remedy"].map(|key| error[key].as_str().unwrap_or_default());
        assert_eq!([path, message, remedy], parts, "{said:?}");
    };
    refused(
        &["quilt", "a; b.png", "-o", "o.png"],
        3,
        [
            "a; b.png",
            "is no picture in a format that can be read",
            "give one of png, jpeg, tiff, exr, hdr, webp, tga, gif, bmp",
        ],
    );
    refused(
        &["quilt", "@/weave.png", "-o", "o.png", "--size", "1; use 2"],
        2,
        ["", "invalid value '1; use 2' for '--size <SIZE>': '1; use 2' is no size", "write 512, 512x384 or 2x"],
    );
    let guide = ["transfer", "@/weave.png", "@/stars.png", "--guide", "x; y.png", "t.png", "-o", "o.png"];
    refused(
        &guide,
        2,
        ["", "'x; y.png' names 1 file for 2 exemplars", "give --guide one SRC for each, separated by commas"],
    );
}

#[test]
fn no_message_is_longer_than_people_read() {
    let folder = Folder::new("long");
    let (long, escape) = ("9".repeat(120_000), "a\u{1b}[31m".repeat(400));
    for words in [
        ["quilt", &long[..300], "-o", "o.png", "--size", "2x"],
        ["quilt", "a.png", "-o", "o.png", "--size", &long],
        ["quilt", &escape[..60], "-o", &escape, "--size", "2x"],
        ["quilt", "a.png", "-o", "o.png", "--seed", &escape],
    ] {
        let said = folder.run_words(words);
        assert!(said.stderr.len() <= 501 && !said.stderr.contains('\u{1b}'), "{} bytes: {said:?}", said.stderr.len());
        assert!(said.exit.is_some_and(|exit| 1 < exit && exit < 6), "{said:?}");
    }
}
