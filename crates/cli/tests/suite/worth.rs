//! What the defaults are worth (tests/worth.toml): no change makes pictures worse without being seen.

use std::fs;

use libtest_mimic::{Failed, Trial};

use crate::program::{fresh, selvedge};

/// One method over all exemplars.
struct Method {
    run: String,
    mean: f64,
    worse: Vec<String>,
}

/// The exemplars, how far a mean may fall, and the methods.
struct Worth {
    exemplars: Vec<String>,
    margin: f64,
    methods: Vec<Method>,
}

/// One test a method.
pub(crate) fn trials() -> Vec<Trial> {
    match read() {
        Err(why) => vec![Trial::test("tests/worth.toml can be read", move || Err(why.into()))],
        Ok(Worth { exemplars, margin, methods }) => methods
            .into_iter()
            .map(|method| {
                let (name, exemplars) = (method.run.split(' ').next().unwrap_or_default(), exemplars.clone());
                Trial::test(format!("worth: {name}"), move || check(&method, &exemplars, margin))
            })
            .collect(),
    }
}

fn check(method: &Method, exemplars: &[String], margin: f64) -> Result<(), Failed> {
    let floor = method.mean - margin;
    let mean = mean(&method.run, exemplars)?;
    if mean < floor {
        let said = format!("{}: preference {mean:.2}, {:.2} when the defaults were chosen", method.run, method.mean);
        return Err(format!("{said}\nlook at the pictures; if they are as good, say so in tests/worth.toml").into());
    }
    for spoil in &method.worse {
        let spoiled = self::mean(&format!("{} {spoil}", method.run), exemplars)?;
        if floor <= spoiled {
            return Err(format!("{} {spoil}: preference {spoiled:.2} is not below {floor:.2}", method.run).into());
        }
    }
    Ok(())
}

/// The mean preference of what a command makes of each exemplar.
fn mean(run: &str, exemplars: &[String]) -> Result<f64, Failed> {
    let key: String = run.chars().filter(|c| c.is_ascii_alphanumeric()).collect();
    let folder = crate::out_dir().join(format!("worth-{key}"));
    fresh(&folder);
    let mut sum = 0.0;
    for name in exemplars {
        let file = |end: &str| format!("tests/out/worth-{key}/{name}{end}");
        let (picture, map) = (file(".png"), file(".map.exr"));
        let line = run.replace("{name}", name);
        let outputs = ["-o", &picture, "--map", &map, "--quiet"];
        ended(line.split(' ').chain(outputs))?;
        let exemplar = format!("fixtures/{name}.png");
        let said = ended(["score", &picture, "--exemplar", &exemplar, "--map", &map])?;
        let preference = said.lines().find_map(|line| line.split_once("preference ")?.1.trim().parse::<f64>().ok());
        sum += preference.ok_or_else(|| format!("no preference in {said}"))?;
    }
    let _ = fs::remove_dir_all(&folder);
    Ok(sum / exemplars.len() as f64)
}

/// What a run that has to end well said.
fn ended<'a>(args: impl IntoIterator<Item = &'a str> + Clone) -> Result<String, String> {
    let said = selvedge(args.clone());
    let line = || args.into_iter().collect::<Vec<_>>().join(" ");
    if said.exit == Some(0) { Ok(said.stdout + &said.stderr) } else { Err(format!("{}: {}", line(), said.stderr)) }
}

fn read() -> Result<Worth, String> {
    let path = crate::root().join("tests/worth.toml");
    let text = fs::read_to_string(&path).map_err(|e| e.to_string())?;
    let table: toml::Table = text.parse().map_err(|e: toml::de::Error| e.to_string())?;
    let texts = |table: &toml::Table, key: &str| {
        let all = table.get(key).and_then(|v| v.as_array()).into_iter().flatten();
        all.filter_map(|v| v.as_str().map(str::to_owned)).collect::<Vec<_>>()
    };
    let number = |table: &toml::Table, key: &str| {
        table.get(key).and_then(toml::Value::as_float).ok_or(format!("tests/worth.toml: no number `{key}`"))
    };
    let method = |row: &toml::Value| {
        let row = row.as_table().ok_or("tests/worth.toml: `method` is a list of tables")?;
        let run = row.get("run").and_then(|v| v.as_str()).ok_or("tests/worth.toml: a method has no `run`")?;
        Ok(Method { run: run.to_owned(), mean: number(row, "mean")?, worse: texts(row, "worse") })
    };
    let rows = table.get("method").and_then(|v| v.as_array()).into_iter().flatten();
    let methods: Result<Vec<Method>, String> = rows.map(method).collect();
    let methods =
        methods.and_then(|all| if all.is_empty() { Err("tests/worth.toml has no method".into()) } else { Ok(all) })?;
    Ok(Worth { exemplars: texts(&table, "exemplars"), margin: number(&table, "margin")?, methods })
}
