//! `soak`: what takes too long for every change. Each crate alone and as a package, random options, runs killed half
//! way, many searches, and fuzzing.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use selvedge_core::Role;
use selvedge_testkit::{Noise, from_png};

use crate::outcome::Outcome;
use crate::program;
use crate::program::{cargo, cargo_with};
use crate::tree::{Tree, root};

/// Runs with random options.
const RUNS: i32 = 300;
/// Runs that are killed.
const KILLS: i32 = 40;

/// How single tests are run, and those that are asked for more than at every change: package, binary, test.
const RELEASE: [&str; 3] = ["test", "--release", "--quiet"];
const SEARCHES: [&str; 5] = ["-p", "selvedge-fft-ssd", "--test", "it", "oracle"];
const BYTES: [[&str; 5]; 3] = [
    ["-p", "selvedge-maxflow", "--test", "it", "byte_strings"],
    ["-p", "selvedge-io", "--test", "it", "byte_strings"],
    ["-p", "selvedge-graphcut-textures", "--test", "it", "byte_strings"],
];
const RACES: [&str; 4] = ["-p", "selvedge-io", "--lib", "two_processes_of_the_same_names"];

/// Runs everything, or the one part that is named: `crates`, `package`, `options`, `kills`, `search`, `large`, `fuzz`.
pub(crate) fn run(args: &[String]) -> Outcome {
    match args.first().map(String::as_str) {
        None => [crates, package, options, kills, search, large, fuzz].into_iter().try_for_each(|part| part()),
        Some("crates") => crates(),
        Some("package") => package(),
        Some("options") => options(),
        Some("kills") => kills(),
        Some("search") => search(),
        Some("large") => large(),
        Some("fuzz") => fuzz(),
        Some(_) => Err("usage: cargo xtask soak [crates|package|options|kills|search|large|fuzz]".into()),
    }
}

/// The tests of each crate alone, with its default features and without.
fn crates() -> Outcome {
    let tree = Tree::of_project();
    for name in tree.crates() {
        let package = tree.package_name(name)?;
        cargo(&["test", "--quiet", "-p", &package])?;
        cargo(&["test", "--quiet", "-p", &package, "--no-default-features"])?;
    }
    Ok(())
}

/// Each crate as it would be published: packed, unpacked outside of the project, built there, its examples tested.
fn package() -> Outcome {
    let tree = Tree::of_project();
    // Unpublished crates are found in no registry, so that no file of locked versions can be made for each: below they
    // share the project's.
    let pack = ["package", "--workspace", "--exclude", "xtask", "--no-verify", "--exclude-lockfile"];
    cargo(&pack.into_iter().chain(["--allow-dirty", "--offline"]).collect::<Vec<_>>())?;
    let folder = std::env::temp_dir().join(format!("selvedge-packages-{}", std::process::id()));
    let unpacked = unpack(&tree, &folder).and_then(|packages| {
        let manifest = folder.join("Cargo.toml");
        let manifest = manifest.to_string_lossy();
        cargo(&["check", "--offline", "--workspace", "--manifest-path", &manifest])?;
        let libraries = packages.iter().filter(|name| *name != "selvedge").flat_map(|name| ["-p", name]);
        let test = ["test", "--quiet", "--offline", "--doc", "--manifest-path", &*manifest];
        cargo(&test.into_iter().chain(libraries).collect::<Vec<_>>())
    });
    fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    unpacked
}

/// A workspace of the packages, each of which takes the others instead of the registry's; their names.
fn unpack(tree: &Tree, folder: &Path) -> Result<Vec<String>, String> {
    let told = |e: std::io::Error| format!("{}: {e}", folder.display());
    fs::create_dir_all(folder).map_err(told)?;
    let version = env!("CARGO_PKG_VERSION");
    let (mut packages, mut patches) = (Vec::new(), String::new());
    for name in tree.crates() {
        let name = tree.package_name(name)?;
        let packed = root().join(format!("target/package/{name}-{version}.crate"));
        let done = Command::new("tar").arg("xzf").arg(&packed).arg("-C").arg(folder).status();
        if !done.is_ok_and(|status| status.success()) {
            return Err(format!("cannot unpack {}", packed.display()));
        }
        for file in ["LICENSE-MIT", "LICENSE-APACHE", "README.md"] {
            let file = folder.join(format!("{name}-{version}/{file}"));
            fs::metadata(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        }
        patches += &format!("{name} = {{ path = \"{name}-{version}\" }}\n");
        packages.push(name);
    }
    let members = packages.iter().map(|name| format!("\"{name}-{version}\"")).collect::<Vec<_>>().join(", ");
    let manifest = format!("[workspace]\nresolver = \"3\"\nmembers = [{members}]\n[patch.crates-io]\n{patches}");
    fs::write(folder.join("Cargo.toml"), manifest).map_err(told)?;
    fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock")).map_err(told)?;
    Ok(packages)
}

/// Ten times as many searches against the definition as its tests make, and as many pairs of runs that write the same
/// files at once.
fn search() -> Outcome {
    let more = [("SELVEDGE_SOAK", "10")];
    cargo_with(&[&RELEASE[..], &SEARCHES].concat(), &more)?;
    cargo_with(&[&RELEASE[..], &RACES].concat(), &more)
}

/// Random options: the program does the work or refuses it properly, and threads do not matter.
fn options() -> Outcome {
    let selvedge = program::build()?;
    let folder = program::fresh("soak")?;
    let mut done = 0;
    for run in 0..RUNS {
        let line = random_line(run);
        let mut pictures = Vec::new();
        for threads in ["1", "4"] {
            let out = folder.join(format!("{threads}.png"));
            let words = line.split(' ').chain(["-j", threads, "-o"]);
            let output = program::run(&selvedge, words.chain([&*out.to_string_lossy()]))?;
            let stderr = String::from_utf8_lossy(&output.stderr);
            let proper = match output.status.code() {
                Some(0) => out.is_file(),
                Some(2 | 3) => !out.exists() && stderr.lines().count() == 1,
                _ => false,
            };
            program::check(proper, || format!("`selvedge {line}`: {}: {stderr}", output.status))?;
            pictures.push(fs::read(&out).ok());
            let _ = fs::remove_file(&out);
        }
        program::check(pictures[0] == pictures[1], || format!("`selvedge {line}` hangs on the number of threads"))?;
        done += i32::from(pictures[0].is_some());
    }
    eprintln!("xtask: {RUNS} runs, {done} of them with a picture");
    program::check(RUNS / 4 < done, || "too few runs made a picture to say anything".into())
}

fn random_line(run: i32) -> String {
    let draw = |k: i32, n: u32| Noise::new(0x50a4).bits(run, k) % n;
    let pick = |k: i32, from: &[&str]| from[draw(k, from.len() as u32) as usize].to_owned();
    let exemplars =
        ["stars.png", "cobbles.png", "grass-grey.png", "bricks/height.png", "bad/ok-1x1.png", "bad/ok-constant.png"];
    let mut words = vec!["quilt".to_owned(), format!("fixtures/{}", pick(0, &exemplars))];
    words.push(format!("--size {}x{}", 1 + draw(1, 120), 1 + draw(2, 120)));
    words.push(format!("--seed {}", draw(3, 1000)));
    if draw(4, 4) != 0 {
        words.push(format!("--block {}", 1 + draw(5, 60)));
    }
    if draw(6, 2) == 0 {
        words.push(format!("--overlap {}", draw(7, 14)));
    }
    words.push(format!("--tolerance {}", pick(8, &["0", "0.1", "0.5", "3"])));
    words.push(format!("--stage {}", pick(9, &["random", "overlap", "cut", "cut", "cut"])));
    words.push(format!("--continuation {}", pick(10, &["avoid", "allow"])));
    if draw(11, 2) == 0 {
        words.push(format!("--tile {}", pick(12, &["x", "y", "xy"])));
    }
    words.join(" ")
}

/// Killed at any moment, the program leaves the old output or the whole new one, never half of one.
fn kills() -> Outcome {
    let selvedge = program::build()?;
    let folder = program::fresh("kills")?;
    let out = folder.join("out.png");
    let mut interrupted = 0;
    let old = fs::read(root().join("fixtures/stars.png")).map_err(|e| e.to_string())?;
    for run in 0..KILLS {
        fs::write(&out, &old).map_err(|e| e.to_string())?;
        let gently = run % 2 == 0 && cfg!(unix);
        let mut child = start(&selvedge, &out)?;
        std::thread::sleep(Duration::from_micros(u64::from(Noise::new(0x4111).bits(run, 0) % 900_000)));
        if gently {
            let _ = Command::new("kill").arg(child.id().to_string()).status();
        } else {
            let _ = child.kill();
        }
        let status = child.wait().map_err(|e| e.to_string())?;
        interrupted += i32::from(!status.success());
        let left = fs::read(&out).map_err(|e| format!("the old output is gone: {e}"))?;
        program::check(left == old || from_png(Role::Color, &left).is_ok(), || {
            format!("half an output after {status}")
        })?;
        if gently {
            // Before it listens for signals, the system ends it, and there is no code.
            let proper = matches!(status.code(), Some(0 | 143) | None);
            program::check(proper, || format!("ended with {status} after a request to end"))?;
            let files = fs::read_dir(&folder).map_err(|e| e.to_string())?.count();
            program::check(files == 1, || "something was left beside the output".into())?;
        }
    }
    eprintln!("xtask: {KILLS} kills, {interrupted} before the end, no half output");
    program::check(KILLS / 4 < interrupted, || "too few runs were caught in the middle to say anything".into())
}

/// A minute of every fuzz target with libFuzzer, where the machine has cargo-fuzz and a nightly compiler; elsewhere a
/// minute of the same checks on random changes of the corpus.
fn fuzz() -> Outcome {
    if cargo(&["+nightly", "fuzz", "--version"]).is_err() {
        eprintln!("xtask: LEFT OUT: libFuzzer needs cargo-fuzz and a nightly compiler; random bytes instead");
        return BYTES.into_iter().try_for_each(|bytes| {
            let test = [&RELEASE[..], &bytes, &["--", "--nocapture"]].concat();
            cargo_with(&test, &[("SELVEDGE_FUZZ_SECONDS", "60")])
        });
    }
    let tree = Tree::of_project();
    let targets =
        tree.texts(".rs").filter_map(|(path, _)| path.strip_prefix("fuzz/fuzz_targets/")?.strip_suffix(".rs"));
    for target in targets {
        // What is found new stays in the target folder; the corpus of the project is only read.
        let (found, corpus) = (format!("target/fuzz-corpus/{target}"), format!("fuzz/corpus/{target}"));
        fs::create_dir_all(root().join(&found)).map_err(|e| e.to_string())?;
        cargo(&["+nightly", "fuzz", "run", target, &found, &corpus, "--", "-max_total_time=60"])?;
    }
    Ok(())
}

/// The largest graphs that are promised, solved within the memory that is stated for them.
fn large() -> Outcome {
    let example =
        |shape, side| cargo(&["run", "--release", "-p", "selvedge-maxflow", "--example", "growth", "--", shape, side]);
    example("2d", "4096")?;
    example("3d", "256")
}

fn start(program: &Path, out: &Path) -> Result<Child, String> {
    let mut command = Command::new(program);
    command.args(["quilt", "fixtures/cobbles.png", "--size", "700", "--block", "24", "--quiet", "-o"]).arg(out);
    command.current_dir(root()).stderr(Stdio::null()).spawn().map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A test that is renamed would leave a part of the long checks with nothing to run.
    #[test]
    fn tests_that_are_named_exist() {
        let tree = Tree::of_project();
        for line in BYTES.iter().map(|line| &line[..]).chain([&SEARCHES[..], &RACES]) {
            let (package, name) = (line[1], line[line.len() - 1]);
            let folder = tree.crates().into_iter().find(|c| tree.package_name(c).is_ok_and(|p| p == package));
            let folder = format!("crates/{}/", folder.unwrap_or_else(|| panic!("{package}")));
            let mut own = tree.texts(".rs").filter(|(path, _)| path.starts_with(&folder));
            let is_named = |(path, text): (&str, &str)| {
                let in_binary = line[2] == "--lib" || path.starts_with(&format!("{folder}tests/{}/", line[3]));
                in_binary && (text.contains(&format!("fn {name}")) || path.ends_with(&format!("/{name}.rs")))
            };
            assert!(own.any(is_named), "{package}: {name}");
        }
    }
}
