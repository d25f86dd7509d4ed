//! What a new method's command has, having only said what its options are.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use selvedge_core::SampleId;

use crate::report::Done;
use crate::session::Session;
use crate::typed::{Stop, parse};

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("selvedge-random-labels-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs a line; `@` stands for the fixtures, `%` for the test's folder.
fn run(folder: &Path, line: &str) -> Result<Done, crate::failure::Failure> {
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures");
    let word = |w: &str| OsString::from(w.replace('@', fixtures).replace('%', &folder.to_string_lossy()));
    let words: Vec<OsString> = format!("selvedge random-labels {line}").split(' ').map(word).collect();
    let typed = parse(&words).map_err(|stop| match stop {
        Stop::Wrong(failure) => failure,
        Stop::Answer(answer) => panic!("{answer}"),
    })?;
    let session = Session::new(&typed.cli.global, typed.used(), typed.names());
    let done = typed.cli.command.execute(&session, &|_: &[OsString]| unreachable!("it runs no other words"))?;
    done.outputs.write(&session)?;
    Ok(done)
}

#[test]
fn a_new_command_has_masks_maps_reports_budget_and_provenance() {
    let folder = folder("all");
    let exemplars = "@/weave.png @/cobbles.png --mask none --mask @/cobbles.png";
    let line = format!("{exemplars} -o %/o.png --size 40x30 --tile x --steps 3 --map %/m.exr -q --seed 7");
    let done = run(&folder, &format!("{line} --explain %/e.png --report %/page")).unwrap();
    let json = done.report.json(&[7], 1, false);
    assert_eq!((&json["options"]["steps"], &json["options"]["size"]), (&3.into(), &"40x30".into()), "{json}");
    assert_eq!(json["outputs"].as_array().map(Vec::len), Some(4), "{json}");
    assert!(0 < json["stats"]["taken"].as_u64().unwrap());
    assert!(folder.join("page/index.html").is_file() && folder.join("e.png").is_file());
    let map = selvedge_io::read_map(folder.join("m.exr"), &Default::default()).unwrap();
    assert!(map.map.ids.plane(0).iter().all(|id: &SampleId| id.is_assigned()));
    let made = map.metadata.provenance.unwrap();
    let command = "selvedge random-labels weave.png cobbles.png --size 40x30 --tile x --mask none --mask cobbles.png \
                   --steps 3 --seed 7";
    assert_eq!((made.command.as_str(), made.seed, made.inputs.len()), (command, 7, 3));

    let dry = run(&folder, &format!("{exemplars} -o %/dry.png --size 40x30 --dry-run -q")).unwrap();
    assert!(dry.lines[0].contains("would be 40x30 px from 20 random patches, with about "));
    let refused = run(&folder, &format!("{exemplars} -o %/big.png --size 9000 --max-memory 64MiB -q")).err().unwrap();
    assert_eq!((refused.exit, refused.remedy.unwrap().starts_with("use --size ")), (6, true));
    fs::write(folder.join("c.toml"), "steps = 1\nsize = \"20x10\"\n").unwrap();
    let done = run(&folder, "@/weave.png -o %/c.png -q --config %/c.toml").unwrap();
    let json = done.report.json(&[0], 1, false);
    assert_eq!((&json["options"]["steps"], &json["options"]["size"]), (&1.into(), &"20x10".into()), "{json}");
    assert!(!folder.join("dry.png").exists() && !folder.join("big.png").exists());
    fs::remove_dir_all(&folder).unwrap();
}
