//! Recipes: tests/suite/NAME.toml.

use std::fs;
use std::path::Path;

/// One end-to-end case.
///
/// ```toml
/// about = "what it shows"
/// run = ["quilt fixtures/cobbles.png -o {out}/cobbles.png --size 96"]  # one or more, from the project's root
/// picture = "cobbles.png"                                            # the output to keep for the eye, if any
/// exit = 0                                                           # of the last run; the others must end with 0
/// ```
#[derive(Clone, Debug)]
pub(crate) struct Recipe {
    pub(crate) name: String,
    pub(crate) about: String,
    pub(crate) run: Vec<String>,
    pub(crate) picture: Option<String>,
    pub(crate) exit: i32,
}

/// All recipes, by name.
pub(crate) fn all() -> Vec<Result<Recipe, String>> {
    let folder = crate::root().join("tests/suite");
    let mut paths: Vec<_> = fs::read_dir(&folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    if paths.is_empty() {
        return vec![Err(format!("no recipes in {}", folder.display()))];
    }
    paths.iter().map(|path| read(path)).collect()
}

fn read(path: &Path) -> Result<Recipe, String> {
    let wrong = |why: &str| format!("{}: {why}", path.display());
    let text = fs::read_to_string(path).map_err(|e| wrong(&e.to_string()))?;
    let table: toml::Table = text.parse().map_err(|e: toml::de::Error| wrong(&e.to_string()))?;
    if let Some(key) = table.keys().find(|k| !["about", "run", "picture", "exit"].contains(&k.as_str())) {
        return Err(wrong(&format!("`{key}` is no key of a recipe")));
    }
    let string = |key: &str| table.get(key).and_then(|v| v.as_str()).map(str::to_owned);
    let lines = table.get("run").and_then(|v| v.as_array()).ok_or_else(|| wrong("has no `run`"))?;
    let run: Option<Vec<String>> = lines.iter().map(|line| line.as_str().map(str::to_owned)).collect();
    Ok(Recipe {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        about: string("about").ok_or_else(|| wrong("has no `about`"))?,
        run: run.filter(|run| !run.is_empty()).ok_or_else(|| wrong("`run` holds command lines"))?,
        picture: string("picture"),
        exit: table.get("exit").and_then(toml::Value::as_integer).unwrap_or(0) as i32,
    })
}
