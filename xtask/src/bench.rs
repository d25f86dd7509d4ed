//! `bench`: whole runs of the program, timed, their answers checked: a fast wrong result fails.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use selvedge_core::Role;
use selvedge_testkit::from_png;

use crate::outcome::Outcome;
use crate::tree::Tree;
use crate::{fixtures, large, program, table};

/// One benchmark: tests/bench/NAME.toml.
struct Bench {
    name: String,
    run: String,
    answer: String,
}

/// How often each program runs each benchmark.
const ROUNDS: usize = 5;

/// Times the benchmarks whose names contain the pattern; `--against PROGRAM` times another build in turns with this
/// one. `large` and `cms` are no patterns: see [`large`] and [`table`].
pub(crate) fn run(args: &[String]) -> Outcome {
    let (pattern, other) = match args {
        [pattern, rest @ ..] if pattern == "large" => return large::run(rest),
        [pattern, rest @ ..] if pattern == "cms" => return table::run(rest),
        [] => ("", None),
        [pattern] => (pattern.as_str(), None),
        [flag, other] if flag == "--against" => ("", Some(PathBuf::from(other))),
        [pattern, flag, other] if flag == "--against" => (pattern.as_str(), Some(PathBuf::from(other))),
        _ => return Err("usage: cargo xtask bench [PATTERN] [--against PROGRAM]".into()),
    };
    let benches: Vec<Bench> = benches()?.into_iter().filter(|b| b.name.contains(pattern)).collect();
    let programs: Vec<PathBuf> = [Some(program::build()?), other].into_iter().flatten().collect();
    println!("{}, {ROUNDS} rounds, medians", processor());
    println!(
        "{:<24} {:>9} {:>9}   {}",
        "",
        "wall s",
        "cpu s",
        if programs.len() == 2 { "cpu of the other / this" } else { "" }
    );
    let mut wrong = 0;
    for bench in &benches {
        match time(bench, &programs) {
            Ok(line) => println!("{line}"),
            Err(why) => {
                wrong += 1;
                println!("{:<24} {why}", bench.name);
            }
        }
    }
    program::check(wrong == 0, || format!("{wrong} benchmarks did not answer as they should"))
}

fn benches() -> Result<Vec<Bench>, String> {
    let tree = Tree::of_project();
    let names = tree.texts(".toml").filter_map(|(path, _)| path.strip_prefix("tests/bench/")?.strip_suffix(".toml"));
    let read = |name: &str| {
        let table = tree.manifest(&format!("tests/bench/{name}.toml")).map_err(|why| format!("{name} {why}"))?;
        let text = |key: &str| table.get(key).and_then(|v| v.as_str()).map(str::to_owned);
        let (run, answer) = text("run").zip(text("answer")).ok_or(format!("{name} needs `run` and `answer`"))?;
        Ok(Bench { name: name.to_owned(), run, answer })
    };
    names.map(read).collect()
}

/// Runs every program in turns, so that a busy machine is busy for each of them.
fn time(bench: &Bench, programs: &[PathBuf]) -> Result<String, String> {
    let mut times = vec![Vec::new(); programs.len()];
    for _ in 0..ROUNDS {
        for (program, times) in programs.iter().zip(&mut times) {
            times.push(once(bench, program)?);
        }
    }
    let median = |program: usize, of: fn(&(Duration, Duration)) -> Duration| {
        let mut all: Vec<f64> = times[program].iter().map(|t| of(t).as_secs_f64()).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    let mut line = format!("{:<24} {:>9.3} {:>9.2}", bench.name, median(0, |t| t.0), median(0, |t| t.1));
    if programs.len() == 2 {
        line += &format!("   {:.2}", median(1, |t| t.1) / median(0, |t| t.1).max(0.01));
    }
    Ok(line)
}

/// Wall time and processor time of one run whose answer is right.
fn once(bench: &Bench, program: &Path) -> Result<(Duration, Duration), String> {
    let folder = program::fresh("bench")?;
    let line = bench.run.replace("{out}", "target/bench");
    let (cpu, began) = (program::children_time(), Instant::now());
    let output = program::run(program, line.split_whitespace().chain(["--quiet"]))?;
    let (wall, cpu) = (began.elapsed(), program::children_time().saturating_sub(cpu));
    program::check(output.status.success(), || String::from_utf8_lossy(&output.stderr).trim().to_owned())?;
    let file = fs::read(folder.join("out.png")).map_err(|e| format!("out.png: {e}"))?;
    let plane = from_png(Role::Color, &file).map_err(|e| e.to_string())?;
    let answer = fixtures::hash(selvedge_testkit::bytes(&plane));
    program::check(answer == bench.answer, || format!("wrong: its samples hash to {answer}"))?;
    Ok((wall, cpu))
}

fn processor() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|l| l.strip_prefix("model name")).and_then(|l| l.split_once(": "));
    name.map_or("unknown processor", |(_, name)| name.trim()).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::root;

    #[test]
    fn benchmarks_can_be_read_and_their_inputs_exist() {
        let benches = benches().expect("benchmarks");
        assert!(!benches.is_empty());
        for bench in benches {
            let input = bench.run.split_whitespace().find(|word| word.starts_with("fixtures/"));
            assert!(input.is_some_and(|input| root().join(input).is_file()), "{}", bench.name);
        }
    }
}
