//! `fixtures`: the manifest of fixtures/, and the pictures in it that our own code makes.

use std::fs;
use std::path::PathBuf;

use selvedge_core::{Plane, Role};
use selvedge_testkit::{describe, exemplars, from_png, same_samples, simple, to_exr, to_png};

use crate::outcome::Outcome;
use crate::tree::{Tree, root};

/// Where the list of fixtures stands.
pub(crate) const MANIFEST: &str = "fixtures/MANIFEST.toml";

/// One file of the manifest.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Entry {
    /// From fixtures/.
    pub(crate) path: String,
    /// What the picture shows.
    pub(crate) shows: String,
    /// Who made it, and from what.
    pub(crate) origin: String,
    /// What it may be used for.
    pub(crate) licence: String,
    /// Which procedural exemplar it is; empty for the others.
    pub(crate) code: String,
    /// Its size.
    pub(crate) bytes: usize,
    /// Its hash, hexadecimal.
    pub(crate) blake3: String,
}

/// Checks the procedural exemplars against their files, or with `--write` makes them again and completes the manifest.
pub(crate) fn run(args: &[String]) -> Outcome {
    let mut entries = entries(&Tree::of_project()).map_err(|why| format!("{MANIFEST} {why}"))?;
    match args {
        [] => {
            let wrong = differences(&entries);
            wrong.iter().for_each(|line| eprintln!("{line}"));
            if wrong.is_empty() { Ok(()) } else { Err("`cargo xtask fixtures --write` makes them again".into()) }
        }
        [flag] if flag == "--write" => write(&mut entries),
        _ => Err("usage: cargo xtask fixtures [--write]".into()),
    }
}

/// The manifest, parsed.
pub(crate) fn entries(tree: &Tree) -> Result<Vec<Entry>, String> {
    let table = tree.manifest(MANIFEST)?;
    let files = table.get("file").and_then(|f| f.as_array()).ok_or("has no [[file]]")?;
    let entry = |file: &toml::Value| {
        let text = |key: &str| file.get(key).and_then(|v| v.as_str()).unwrap_or_default().to_owned();
        let bytes = file.get("bytes").and_then(toml::Value::as_integer).and_then(|n| usize::try_from(n).ok());
        Entry {
            path: text("path"),
            shows: text("shows"),
            origin: text("origin"),
            licence: text("licence"),
            code: text("code"),
            bytes: bytes.unwrap_or(0),
            blake3: text("blake3"),
        }
    };
    Ok(files.iter().map(entry).collect())
}

/// The hash by which files are known, hexadecimal.
pub(crate) fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// Every procedural exemplar with its name in the manifest.
fn made() -> Vec<(&'static str, Plane<2>)> {
    let bricks = exemplars::bricks();
    vec![
        ("cobbles", exemplars::cobbles()),
        ("cobbles-hole", exemplars::cobbles_with_hole()),
        ("bad/column", simple::noise(1, 40, 1)),
        ("bad/transparent", simple::transparent(16, 16)),
        ("weave", exemplars::weave()),
        ("scales", exemplars::scales()),
        ("scales-hdr", exemplars::scales_hdr()),
        ("bricks/albedo", bricks.albedo),
        ("bricks/normal", bricks.normal),
        ("bricks/height", bricks.height),
        ("bricks/roughness", bricks.roughness),
        ("knit", exemplars::knit()),
        ("letters", exemplars::letters()),
        ("planks", exemplars::planks()),
        ("plaster", exemplars::plaster()),
        ("tiles", exemplars::tiles()),
    ]
}

/// What differs between the files and the code, a line each.
fn differences(entries: &[Entry]) -> Vec<String> {
    let made = made();
    let nobody = entries.iter().filter(|e| !e.code.is_empty() && made.iter().all(|(name, _)| *name != e.code));
    let mut lines: Vec<String> = nobody.map(|e| format!("{}: no code makes `{}`", e.path, e.code)).collect();
    for (name, plane) in &made {
        match entries.iter().find(|e| e.code == *name) {
            None => lines.push(format!("{MANIFEST}: no file shows `{name}`")),
            Some(entry) => lines.extend(difference(entry, plane).map(|what| format!("{}: {what}", entry.path))),
        }
    }
    lines
}

fn difference(entry: &Entry, plane: &Plane<2>) -> Option<String> {
    let file = match fs::read(file(entry)) {
        Ok(bytes) => bytes,
        Err(e) => return Some(e.to_string()),
    };
    if entry.path.ends_with(".exr") {
        return (file != to_exr(plane)).then(|| "the file is not what the code makes, byte for byte".to_owned());
    }
    match from_png(Role::Color, &file) {
        Err(e) => Some(e.to_string()),
        Ok(found) if same_samples(&found, plane) => None,
        Ok(found) => Some(format!("the file ({}) is not what the code makes ({})", describe(&found), describe(plane))),
    }
}

/// Writes the pictures whose samples differ (another encoder's bytes alone are no reason), then the manifest.
fn write(entries: &mut [Entry]) -> Outcome {
    for (name, plane) in made() {
        let entry = entries.iter().find(|e| e.code == name).ok_or(format!("{MANIFEST} has no file for `{name}`"))?;
        if difference(entry, &plane).is_some() {
            let bytes = if entry.path.ends_with(".exr") { to_exr(&plane) } else { to_png(&plane) };
            fs::write(file(entry), bytes).map_err(|e| format!("{}: {e}", entry.path))?;
            eprintln!("written: fixtures/{}", entry.path);
        }
    }
    for entry in entries.iter_mut() {
        let bytes = fs::read(file(entry)).map_err(|e| format!("fixtures/{}: {e}", entry.path))?;
        (entry.bytes, entry.blake3) = (bytes.len(), hash(&bytes));
    }
    entries.sort_by(|a, b| a.path.cmp(&b.path));
    fs::write(root().join(MANIFEST), manifest(entries)).map_err(|e| format!("{MANIFEST}: {e}"))
}

fn file(entry: &Entry) -> PathBuf {
    root().join("fixtures").join(&entry.path)
}

fn manifest(entries: &[Entry]) -> String {
    let mut text = String::from(
        "# Every file under fixtures/, where it comes from and what it may be used for. To add one, list it here, then run\n\
         # `cargo xtask fixtures --write`: it makes the files with `code` again and fills in `bytes` and `blake3`.\n",
    );
    for e in entries {
        text += &format!(
            "\n[[file]]\npath = {:?}\nshows = {:?}\norigin = {:?}\nlicence = {:?}\n",
            e.path, e.shows, e.origin, e.licence
        );
        if !e.code.is_empty() {
            text += &format!("code = {:?}\n", e.code);
        }
        text += &format!("bytes = {}\nblake3 = {:?}\n", e.bytes, e.blake3);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_procedural_fixtures_are_what_the_code_makes() {
        let entries = entries(&Tree::of_project()).expect("a manifest");
        assert_eq!(differences(&entries), Vec::<String>::new());
    }

    #[test]
    fn the_manifest_survives_writing() {
        let mut entry = Entry { path: "a.png".into(), shows: "a \"b\"".into(), bytes: 3, ..Entry::default() };
        entry.code = "weave".into();
        let text = manifest(std::slice::from_ref(&entry));
        assert_eq!(entries(&Tree::of(&[(MANIFEST, &text)])), Ok(vec![entry]));
    }

    #[test]
    fn another_picture_under_the_name_is_found() {
        let entry = Entry { path: "cobbles.png".into(), ..Entry::default() };
        assert!(difference(&entry, &exemplars::weave()).is_some_and(|what| what.contains("192x192, 3 x u8")));
    }
}
