//! `bench cms`: the ten examples of Table I of `[CMS]` with its `K` and `N`, on pictures of their sizes: seconds and
//! searches beside the paper's, one candidate beside five, memory beside what is told.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::large::number;
use crate::outcome::Outcome;
use crate::program;

/// Each with the paper's seconds, and its command: `@` stands for the folder of its pictures. The paper's pictures are
/// not at hand: any of these sizes do. [CMS V-A]
const CASES: [(&str, f64, &str); 10] = [
    ("carpet", 79.0, "analogy @/a.png @/source.png @/b.png -K 7 -N 7 --turn"),
    ("brick5", 146.0, "detail @/source.png --low @/low.png --scale 5 -K 7 -N 7"),
    ("brick10", 402.0, "detail @/source.png --low @/low.png --scale 10 -K 7 -N 7 --guide @/lines.png @/wanted.png"),
    ("cloth", 312.0, "detail @/source.png --low @/low.png --scale 3 -K 7 -N 3"),
    ("freud", 217.0, "analogy @/a.png @/source.png @/b.png -K 20 -N 5 --turn --luminance"),
    ("weave", 44.0, "transfer @/source.png --target @/b.png --method cms --match-histogram -K .4 -N 4"),
    ("rice", 9.0, "transfer @/source.png --target @/b.png --method cms --match-histogram -K .2 -N 5"),
    ("clothtbn", 297.0, "numbers @/source.png --labels @/a.png --target @/b.png -K .5 -N 9 --turn"),
    ("arch", 131.0, "numbers @/source.png --labels @/a.png --target @/b.png -K 10 -N 2 --turn"),
    (
        "melody",
        239.0,
        "numbers @/source.png @/source2.png --labels @/a.png,@/a2.png --target @/b.png -K .6 -N 1 --turn",
    ),
];

/// Times all of them by a program, or by one that is built.
pub(crate) fn run(args: &[String]) -> Outcome {
    let Some(folder) = std::env::var_os("SELVEDGE_DATA").map(PathBuf::from) else {
        let cases = CASES.map(|(name, _, words)| format!("  {name}/: {words}"));
        return Err(format!("SELVEDGE_DATA names no folder of the pictures:\n{}", cases.join("\n")));
    };
    let program = match args {
        [] => program::build()?,
        [program] => PathBuf::from(program),
        _ => return Err("usage: cargo xtask bench cms [PROGRAM]".into()),
    };
    println!("| case | paper s | with | wall s | cpu s | paper / wall | searches | expansions | peak MiB | told MiB |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let out = program::fresh("bench-cms")?.join("out.png");
    for (name, paper, words) in CASES {
        let at = folder.join(name);
        if !at.is_dir() {
            println!("| {name} | {paper} | no pictures in {} | | | | | | | |", at.display());
            continue;
        }
        let words = words.replace('@', &at.to_string_lossy());
        let is_transfer = words.starts_with("transfer");
        for (with, more) in [("auto", ""), ("1 level", " --levels 1"), ("c = 1", " --levels 1 --candidates 1")] {
            // It has neither option.
            if more.is_empty() || !is_transfer {
                println!("| {name} | {paper} | {with} | {}", row(&program, &format!("{words}{more}"), paper, &out)?);
            }
        }
    }
    Ok(())
}

fn row(program: &Path, words: &str, paper: f64, out: &Path) -> Result<String, String> {
    let out = out.to_string_lossy();
    let line = || words.split_whitespace().chain(["-o", &out, "--json", "--quiet"]);
    let said = |words: Vec<&str>| {
        let done = program::run(program, words.iter().copied())?;
        let why = || format!("{words:?}: {}", String::from_utf8_lossy(&done.stderr).trim());
        program::check(done.status.success(), why)?;
        Ok::<_, String>(String::from_utf8_lossy(&done.stdout).into_owned())
    };
    let (before, began) = (program::children_time(), Instant::now());
    let object = said(line().collect())?;
    let (wall, cpu) = (began.elapsed().as_secs_f64(), program::children_time().saturating_sub(before).as_secs_f64());
    let dry = said(line().chain(["--dry-run"]).collect())?;
    let of = |object: &str, key: &str| number(object, key).unwrap_or_default();
    let [searches, expansions] = ["searches", "expansions"].map(|key| of(&object, key));
    let (peak, told) = (of(&object, "peak_memory_bytes") >> 20, of(&dry, "estimated_memory_bytes") >> 20);
    let faster = paper / wall;
    Ok(format!("{wall:.2} | {cpu:.2} | {faster:.0} | {searches} | {expansions} | {peak} | {told} |"))
}
