//! `bench large`: the sizes that people have. Exemplars of 512 to 4096 samples a side, outputs of twice that, and one
//! of 16384: wall and processor time, and memory, on one thread and on two.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use selvedge_core::Role;
use selvedge_testkit::{Noise, plane8, to_png};

use crate::outcome::Outcome;
use crate::program;

/// Sides of the exemplars: each has four times the samples of the one before, so that growth can be read off.
const SIDES: [u32; 4] = [512, 1024, 2048, 4096];
/// Side of the exemplar, and of the largest output of all.
const LARGEST: (u32, u32) = (1024, 16384);
const METHODS: [&str; 3] = ["quilt", "graphcut", "synthesize"];

/// A picture that outputs are made from.
struct Exemplar {
    name: String,
    file: PathBuf,
    side: u32,
}

/// Times all of them up to a side, in order; `photographs` of the folder that `SELVEDGE_DATA` names, and what is
/// generated.
pub(crate) fn run(args: &[String]) -> Outcome {
    let most = match args {
        [] => SIDES[SIDES.len() - 1],
        [side] => side.parse().map_err(|_| format!("'{side}' is no side; usage: cargo xtask bench large [SIDE]"))?,
        _ => return Err("usage: cargo xtask bench large [SIDE]".into()),
    };
    let program = program::build()?;
    let folder = program::fresh("bench-large")?;
    let mut exemplars = photographs(&program)?;
    for side in SIDES.into_iter().filter(|&side| side <= most) {
        exemplars.extend(generated(side, &folder)?);
    }
    exemplars.retain(|e| e.side <= most);
    exemplars.sort_by(|a, b| (a.side, &a.name).cmp(&(b.side, &b.name)));
    println!("| exemplar | side | output | method | threads | wall s | cpu s | peak MiB | told MiB |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for exemplar in &exemplars {
        for method in METHODS {
            row(&program, exemplar, method, 2 * exemplar.side, &folder)?;
        }
    }
    for exemplar in exemplars.iter().filter(|e| e.side == LARGEST.0 && LARGEST.0 < most) {
        row(&program, exemplar, "quilt", LARGEST.1, &folder)?;
    }
    fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))
}

/// One run on one thread, and one on two.
fn row(program: &Path, exemplar: &Exemplar, method: &str, output: u32, folder: &Path) -> Outcome {
    let out = folder.join("out.png");
    let (file, out, size) = (exemplar.file.to_string_lossy(), out.to_string_lossy(), output.to_string());
    for threads in ["1", "2"] {
        let args = [method, &file, "-o", &out, "--size", &size, "--threads", threads, "--json"];
        let said = |more: Option<&str>| {
            let done = program::run(program, args.into_iter().chain(more))?;
            let why = || format!("{} {method}: {}", exemplar.name, String::from_utf8_lossy(&done.stderr).trim());
            program::check(done.status.success(), why)?;
            Ok::<_, String>(String::from_utf8_lossy(&done.stdout).into_owned())
        };
        let (before, began) = (program::children_time(), Instant::now());
        let object = said(None)?;
        let (wall, cpu) = (began.elapsed().as_secs_f64(), program::children_time().saturating_sub(before));
        let mib = |object: &str, key: &str| number(object, key).map_or("-".to_owned(), |n| (n >> 20).to_string());
        let told = mib(&said(Some("--dry-run"))?, "estimated_memory_bytes");
        let (peak, cpu) = (mib(&object, "peak_memory_bytes"), cpu.as_secs_f64());
        let Exemplar { name, side, .. } = exemplar;
        println!("| {name} | {side} | {output} | {method} | {threads} | {wall:.2} | {cpu:.2} | {peak} | {told} |");
    }
    Ok(())
}

/// The whole number after a key of an object in JSON.
pub(crate) fn number(object: &str, key: &str) -> Option<u64> {
    let rest = object.split_once(&format!("\"{key}\":"))?.1.trim_start();
    rest[..rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len())].parse().ok()
}

/// The pictures of the folder that `SELVEDGE_DATA` names, by their shorter sides as the program tells them.
fn photographs(program: &Path) -> Result<Vec<Exemplar>, String> {
    let Some(folder) = std::env::var_os("SELVEDGE_DATA").map(PathBuf::from) else {
        println!("photographs: skipped, since SELVEDGE_DATA names no folder of them; generated pictures only");
        return Ok(Vec::new());
    };
    let entries = fs::read_dir(&folder).map_err(|e| format!("SELVEDGE_DATA, {}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|p| p.is_file()).collect();
    files.sort();
    let mut exemplars = Vec::new();
    for file in files {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let told = program::run(program, ["inspect", &file.to_string_lossy(), "--json"])?;
        let object = String::from_utf8_lossy(&told.stdout).into_owned();
        match number(&object, "width").zip(number(&object, "height")) {
            Some((width, height)) => exemplars.push(Exemplar { name, file, side: width.min(height) as u32 }),
            None => println!("{name}: skipped, since it is no picture"),
        }
    }
    Ok(exemplars)
}

/// Light or dark, by shares of the side across and down.
type Shade = fn(f64, f64) -> f64;

/// Bricks, rock and grass of a side: what they show grows with it, as in photographs of more pixels.
fn generated(side: u32, folder: &Path) -> Result<Vec<Exemplar>, String> {
    let kinds: [(&str, Shade); 3] = [("bricks", bricks), ("rock", rock), ("grass", grass)];
    let made = kinds.map(|(name, shade)| {
        let file = folder.join(format!("{name}-{side}.png"));
        let (grain, of) = (Noise::new(9), |i: u32| f64::from(i) / f64::from(side));
        let places = (0..side * side).map(|i| (i % side, i / side));
        let shades: Vec<(f64, f64)> =
            places.map(|(x, y)| (shade(of(x), of(y)), 6.0 * grain.signed(x as i32, y as i32))).collect();
        let tinted = |tint: f64| shades.iter().map(move |(shade, grain)| (128.0 + 90.0 * tint * shade + grain) as u8);
        let plane = plane8(Role::Color, side, side, [1.0, 0.8, 0.65].into_iter().flat_map(tinted).collect());
        fs::write(&file, to_png(&plane)).map_err(|e| format!("{}: {e}", file.display()))?;
        Ok(Exemplar { name: format!("made {name}"), file, side })
    });
    made.into_iter().collect()
}

/// Twelve courses of a running bond.
fn bricks(x: f64, y: f64) -> f64 {
    let noise = Noise::new(1);
    let course = (12.0 * y).floor();
    let along = 6.0 * x + 0.5 * (course % 2.0);
    let mortar = (12.0 * y - course).min(2.0 * (along - along.floor())) < 0.12;
    let brick = noise.signed(along.floor() as i32, course as i32);
    if mortar { 0.9 } else { 0.4 * brick - 0.4 + 0.5 * noise.layers(40.0 * x, 40.0 * y, 5) }
}

/// Slopes of all sizes.
fn rock(x: f64, y: f64) -> f64 {
    Noise::new(2).layers(5.0 * x, 5.0 * y, 8)
}

/// Fine blades in no order.
fn grass(x: f64, y: f64) -> f64 {
    Noise::new(3).layers(90.0 * x, 45.0 * y, 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_by_their_keys() {
        let object = r#"{"width": 12,"seconds":0.5,"peak_memory_bytes":1048576}"#;
        assert_eq!(
            ["width", "peak_memory_bytes", "height"].map(|key| number(object, key)),
            [Some(12), Some(1 << 20), None]
        );
    }

    #[test]
    fn generated_pictures_are_no_flats() {
        for shade in [bricks, rock, grass] {
            let values = (0..400).map(|i| shade(f64::from(i % 20) / 20.3, f64::from(i / 20) / 20.7));
            let (least, most) = values.fold((f64::MAX, f64::MIN), |(l, m), v| (l.min(v), m.max(v)));
            assert!(0.3 < most - least && most < 1.5 && -1.5 < least, "{least} {most}");
        }
    }
}
