//! The end-to-end suite: runs the program over the recipes of tests/suite, over those of benchmarks and of README.md's
//! pictures, over bad files, and as README.md says; and holds what the defaults are worth.
//!
//! `cargo test --test suite -- PATTERN` runs some of it. A recipe whose outcome is not its reference leaves expected,
//! difference and actual in tests/out and a page, tests/out/index.html. References are written by `cargo xtask bless`.
#![forbid(unsafe_code)]

mod answers;
mod bad_input;
mod program;
mod readme;
mod recipe;
mod reference;
mod snapshot;
mod worth;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use libtest_mimic::{Arguments, Trial};
use selvedge_testkit::page::{Case, Verdict, page};

use crate::recipe::Recipe;

fn main() {
    // What a panic says becomes the outcome of its test; the trace would only hide it.
    std::panic::set_hook(Box::new(|_| {}));
    let arguments = Arguments::from_args();
    let cases = Arc::new(Mutex::new(Vec::new()));
    let mut trials = recipe::all().into_iter().map(|recipe| recipe_trial(recipe, &cases)).collect::<Vec<_>>();
    trials.extend(answers::trials());
    trials.extend(bad_input::trials());
    trials.extend(readme::trials());
    trials.extend(worth::trials());
    let conclusion = libtest_mimic::run(&arguments, trials);
    let cases = cases.lock().expect("no trial panics while it holds the cases");
    if cases.iter().any(|c| c.verdict != Verdict::Same) || std::env::var_os("SELVEDGE_PAGE").is_some() {
        write_page(&cases);
    } else {
        let _ = std::fs::remove_file(out_dir().join("index.html"));
    }
    conclusion.exit();
}

/// The page, and the list of recipes that someone has to look at.
fn write_page(cases: &[Case]) {
    let review: String = cases.iter().filter(|c| c.verdict != Verdict::Same).map(|c| format!("{}\n", c.name)).collect();
    let path = out_dir().join("index.html");
    std::fs::create_dir_all(out_dir()).expect("tests/out can be made");
    std::fs::write(out_dir().join("review.txt"), review).expect("tests/out can be written");
    std::fs::write(&path, page("Selvedge, end to end", cases)).expect("tests/out can be written");
    eprintln!("page: {}", path.display());
}

fn recipe_trial(recipe: Result<Recipe, String>, cases: &Arc<Mutex<Vec<Case>>>) -> Trial {
    let cases = Arc::clone(cases);
    match recipe {
        Err(why) => Trial::test("recipes can be read", move || Err(why.into())),
        Ok(recipe) => Trial::test(recipe.name.clone(), move || {
            let (case, outcome) = reference::judge(&recipe);
            cases.lock().expect("no trial panics while it holds the cases").push(case);
            outcome.map_err(Into::into)
        }),
    }
}

/// The root of the project: recipes name their files from here.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("crates/cli stands two below the root").to_owned()
}

/// What failures leave behind.
fn out_dir() -> PathBuf {
    root().join("tests/out")
}
