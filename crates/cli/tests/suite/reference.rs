//! A recipe against its reference in tests/ref: text by insta, one small picture for the eye.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use selvedge_core::{Plane, Role};
use selvedge_io::{ReadOptions, decode};
use selvedge_testkit::page::{Case, Verdict};
use selvedge_testkit::{compare, from_png, preview, same_samples, to_png, triptych};

use crate::recipe::Recipe;
use crate::snapshot::{Outcome, outcome};

/// Bytes that a reference picture may take; the hash decides, the picture is for the eye.
const LARGEST: usize = 32 << 10;

/// Runs a recipe and holds it against its reference; answers with its place on the page and the test's outcome.
pub(crate) fn judge(recipe: &Recipe) -> (Case, Result<(), String>) {
    let mut case =
        Case { name: recipe.name.clone(), verdict: Verdict::Same, text: about(recipe), pictures: Vec::new() };
    let result = run_and_compare(recipe, &mut case);
    if let Err(why) = &result {
        if case.verdict == Verdict::Same {
            case.verdict = Verdict::Differs;
        }
        case.text += &format!("\n\n{why}");
    }
    (case, result)
}

fn about(recipe: &Recipe) -> String {
    let lines: String = recipe.run.iter().map(|line| format!("\n$ selvedge {line}")).collect();
    recipe.about.clone() + &lines
}

fn run_and_compare(recipe: &Recipe, case: &mut Case) -> Result<(), String> {
    let folder = crate::out_dir().join(&recipe.name);
    let found = outcome(recipe, &folder, 1)?;
    let again = outcome(recipe, &folder, 3)?;
    if found != again {
        return Err(format!("1 and 3 threads differ\n{}", changes(&found.text, &again.text)));
    }
    let picture = recipe.picture.as_deref().map(|name| picture(&found, name)).transpose()?;
    if std::env::var("SELVEDGE_BLESS").is_ok_and(|names| names.split(',').any(|name| name == recipe.name)) {
        case.verdict = Verdict::New;
        case.pictures.extend(picture.iter().map(|p| ("new reference".to_owned(), to_png(p))));
        return bless(recipe, &found, picture.as_ref());
    }
    let text = text_matches(recipe, &found);
    let seen = picture.map_or(Ok(()), |actual| picture_matches(recipe, &actual, case));
    match (text, seen) {
        (Ok(()), Ok(())) => Ok(()),
        (text, seen) => {
            let whys: Vec<String> = [text, seen].into_iter().filter_map(Result::err).collect();
            Err(format!("{}\nif this is meant: cargo xtask bless {}", whys.join("\n"), recipe.name))
        }
    }
}

fn picture(found: &Outcome, name: &str) -> Result<Plane<2>, String> {
    let bytes = found.files.get(name).ok_or_else(|| format!("the recipe wrote no `{name}`"))?;
    let picture = decode(bytes, name, &ReadOptions::default()).map_err(|e| e.to_string())?;
    Ok(preview(&picture.plane))
}

/// Holds the text against tests/ref/NAME.snap; a missing one fails.
fn text_matches(recipe: &Recipe, found: &Outcome) -> Result<(), String> {
    catch_unwind(AssertUnwindSafe(|| snapshot(recipe, &found.text))).map_err(|_| {
        match fs::read_to_string(reference(recipe, "snap")) {
            Err(_) => format!("there is no reference tests/ref/{}.snap", recipe.name),
            Ok(snap) => format!("tests/ref/{}.snap differs\n{}", recipe.name, changes(body(&snap), &found.text)),
        }
    })
}

fn snapshot(recipe: &Recipe, text: &str) {
    let mut settings = insta::Settings::new();
    settings.set_snapshot_path(crate::root().join("tests/ref"));
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_description(&recipe.about);
    settings.bind(|| insta::assert_snapshot!(recipe.name.as_str(), text));
}

/// A snapshot without its head.
fn body(snap: &str) -> &str {
    snap.splitn(3, "---\n").nth(2).unwrap_or(snap)
}

/// Holds the picture against tests/ref/NAME.png; what differs is left in tests/out.
fn picture_matches(recipe: &Recipe, actual: &Plane<2>, case: &mut Case) -> Result<(), String> {
    let path = reference(recipe, "png");
    let Ok(expected) = fs::read(&path) else {
        case.verdict = Verdict::New;
        case.pictures.push(("actual".into(), to_png(actual)));
        return Err(format!("there is no reference tests/ref/{}.png", recipe.name));
    };
    let expected = from_png(Role::Color, &expected).map_err(|e| format!("{}: {e}", path.display()))?;
    if same_samples(&expected, actual) {
        case.pictures.push(("as expected".into(), to_png(actual)));
        return Ok(());
    }
    let three = to_png(&triptych(&expected, actual));
    let folder = crate::out_dir().join(&recipe.name);
    crate::program::fresh(&folder);
    let left = [("expected.png", to_png(&expected)), ("actual.png", to_png(actual)), ("triptych.png", three.clone())];
    for (name, bytes) in left {
        fs::write(folder.join(name), bytes).map_err(|e| e.to_string())?;
    }
    case.pictures.push(("expected | difference | actual".into(), three));
    let how = match compare(&expected, actual) {
        Ok(d) => {
            let [y, x] = d.first.unwrap_or_default();
            format!("{} of {} pixels, by {:?} at most, the first at x {x}, y {y}", d.pixels, d.of, d.greatest)
        }
        Err(what) => what,
    };
    Err(format!("tests/ref/{}.png differs: {how}\nsee {}", recipe.name, folder.join("triptych.png").display()))
}

/// Writes the references and fails, so that nothing turns green unseen.
fn bless(recipe: &Recipe, found: &Outcome, picture: Option<&Plane<2>>) -> Result<(), String> {
    if let Some(picture) = picture {
        let png = to_png(picture);
        if LARGEST < png.len() {
            return Err(format!("the picture takes {} bytes, {LARGEST} at most: choose a smaller --size", png.len()));
        }
        write(&reference(recipe, "png"), &png)?;
    }
    snapshot(recipe, &found.text);
    Err(format!("new reference written: tests/ref/{}; look at it, then run the suite again", recipe.name))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::create_dir_all(path.parent().expect("a file in a folder")).map_err(|e| e.to_string())?;
    fs::write(path, bytes).map_err(|e| format!("{}: {e}", path.display()))
}

fn reference(recipe: &Recipe, ending: &str) -> PathBuf {
    crate::root().join("tests/ref").join(format!("{}.{ending}", recipe.name))
}

/// Lines that only one of two texts has, in order: `-` the first, `+` the second.
fn changes(expected: &str, actual: &str) -> String {
    let only = |sign: &str, a: &str, b: &str| -> String {
        a.lines().filter(|line| !b.lines().any(|other| other == *line)).map(|line| format!("{sign} {line}\n")).collect()
    };
    only("-", expected, actual) + &only("+", actual, expected)
}
