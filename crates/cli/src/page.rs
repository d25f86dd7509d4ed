//! A run as a page to look at: one HTML file with its pictures inside.

use std::fmt::Write as _;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use selvedge_core::Plane;
use selvedge_io::{Format, Metadata, WriteOptions};
use serde_json::Value;

use crate::eyes;
use crate::failure::Failure;
use crate::thumbnail::Thumbnail;

/// The page's name in its folder.
const NAME: &str = "index.html";
/// What says that a page is one of ours, so that the next one may replace it.
const GENERATOR: &str = "<meta name=\"generator\" content=\"selvedge\">";
/// Samples a side of the pictures in the page; larger ones are reduced.
const LARGEST: u32 = 1600;

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:72rem;padding:0 1rem;\
color:#222;background:#fafafa}h1{font-size:1.3rem}h2{font-size:1rem;margin:2rem 0 .5rem}\
img{max-width:100%;image-rendering:pixelated;border:1px solid #ccc}figure{margin:0 0 1.5rem}\
figcaption,th{color:#666;font-weight:normal}table{border-collapse:collapse}\
th,td{text-align:left;vertical-align:top;padding:.1rem 1rem .1rem 0}td{font-family:ui-monospace,monospace;\
overflow-wrap:anywhere}pre{white-space:pre-wrap;background:#eee;padding:.5rem}\
.legend{list-style:none;padding:0;display:flex;flex-wrap:wrap;gap:0 1.5rem}\
.legend svg{width:1em;height:1em;margin-right:.4em;vertical-align:-.1em}figure svg{width:100%;height:12rem;background:#fff;border:1px solid #ccc}polyline{fill:none;stroke:#b33}circle{fill:#b33}\
.steps{display:grid;grid-template-columns:repeat(auto-fill,minmax(13rem,1fr));gap:0 1rem}.steps img{width:100%}.steps figcaption{white-space:pre-line}";

/// The file that a folder of `--report` gets, or, while there is no such folder, the folder: what has to be writable.
pub(crate) fn checked(folder: &Path) -> PathBuf {
    if folder.is_dir() { folder.join(NAME) } else { folder.to_path_buf() }
}

/// Refuses what is no folder, and one whose page is somebody else's.
pub(crate) fn check(folder: &Path) -> Result<(), Failure> {
    if !folder.is_dir() && folder.exists() {
        return Err(Failure::new(4, "is no folder").about(folder).remedy("name a folder for --report"));
    }
    let page = file(folder);
    if !page.exists() || is_ours(&page).unwrap_or(false) {
        return Ok(());
    }
    Err(Failure::new(4, "is a page that --report did not write").about(&page).remedy("name another folder"))
}

/// Whether a page says near its begin that it is one of ours.
fn is_ours(page: &Path) -> std::io::Result<bool> {
    let mut start = Vec::new();
    std::fs::File::open(page)?.take(256).read_to_end(&mut start)?;
    Ok(start.windows(GENERATOR.len()).any(|bytes| bytes == GENERATOR.as_bytes()))
}

/// The file that a folder of `--report` gets.
pub(crate) fn file(folder: &Path) -> PathBuf {
    folder.join(NAME)
}

/// The page of a run, given as the object of `--json` and its `summary`, with the command that makes it again, pictures
/// with captions, and what a method shows of its course, ready as HTML.
pub(crate) fn page(
    run: &Value,
    command: &str,
    pictures: &[(&str, &Plane<2>)],
    course: &str,
) -> Result<String, Failure> {
    let title = run["outputs"][0]["path"].as_str().unwrap_or("a run");
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">{GENERATOR}<title>{0}</title><style>{STYLE}</style>\n\
         <h1>{0}</h1>\n<pre>{1}</pre>\n<p>{2}</p>\n",
        escaped(title),
        escaped(command),
        escaped(run["summary"].as_str().unwrap_or_default())
    );
    for (caption, plane) in pictures {
        let [height, width] = plane.domain().shape;
        page += &figure(plane, caption, &format!("{caption}, {width}x{height} px"))?;
    }
    page += course;
    for (heading, key) in [
        ("Options", "options"),
        ("Counts", "stats"),
        ("Seconds", "seconds"),
        ("Read", "inputs"),
        ("Written", "outputs"),
        ("Made with", "made"),
    ] {
        page += &format!("<h2>{heading}</h2>\n{}\n", table(&run[key]));
    }
    Ok(page + "</html>\n")
}

/// Colours and what they mean.
pub(crate) fn swatches(all: &[([u8; 3], &str)]) -> String {
    let swatch = |([r, g, b], what): &([u8; 3], &str)| {
        format!("<li><svg><rect width=\"100%\" height=\"100%\" fill=\"rgb({r},{g},{b})\"/></svg>{}</li>", escaped(what))
    };
    format!("<ul class=\"legend\">{}</ul>\n", all.iter().map(swatch).collect::<String>())
}

/// A picture inside of the page, with what it shows and a caption.
pub(crate) fn figure(plane: &Plane<2>, shows: &str, caption: &str) -> Result<String, Failure> {
    let (shows, caption, data) = (escaped(shows), escaped(caption), base64(&preview(plane)?));
    let image = format!("<img alt=\"{shows}\" src=\"data:image/png;base64,{data}\">");
    Ok(format!("<figure>{image}<figcaption>{caption}</figcaption></figure>\n"))
}

/// Small pictures beside each other under a heading, each with its caption; nothing if there are none.
pub(crate) fn gallery(heading: &str, all: &[Thumbnail]) -> Result<String, Failure> {
    if all.is_empty() {
        return Ok(String::new());
    }
    let figures: Vec<String> = all.iter().map(|t| figure(&t.picture, heading, &t.caption)).collect::<Result<_, _>>()?;
    Ok(format!("<h2>{}</h2>\n<div class=\"steps\">\n{}</div>\n", escaped(heading), figures.concat()))
}

/// A value as a table of its parts, or as text.
fn table(value: &Value) -> String {
    match value {
        Value::Object(parts) => {
            let row = |(name, part): (&String, &Value)| {
                format!("<tr><th>{}</th><td>{}</td></tr>", escaped(&name.replace('_', " ")), table(part))
            };
            format!("<table>{}</table>", parts.iter().filter(|(_, part)| !part.is_null()).map(row).collect::<String>())
        }
        Value::Array(items) => items.iter().map(|item| format!("<div>{}</div>", table(item))).collect(),
        Value::String(text) => escaped(text),
        Value::Number(n) if n.is_f64() => format!("{:.4}", n.as_f64().unwrap_or_default()),
        other => escaped(&other.to_string()),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The picture as a PNG of 8 bits that a browser shows, reduced where it is large.
fn preview(plane: &Plane<2>) -> Result<Vec<u8>, Failure> {
    let small = eyes::smaller(plane, LARGEST)?;
    let options = WriteOptions { format: Some(Format::Png), ..WriteOptions::default() };
    Ok(selvedge_io::encode(&small, &Metadata::default(), NAME, &options)?)
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let bits = (0..3).fold(0_u32, |bits, i| bits << 8 | u32::from(three.get(i).copied().unwrap_or(0)));
        let digits = (0..4).map(|i| char::from(DIGITS[(bits >> (18 - 6 * i)) as usize & 63]));
        out.extend(digits.take(three.len() + 1));
        let _ = write!(out, "{}", &"=="[..3 - three.len()]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::{Domain, Grid, Role, Samples};
    use serde_json::json;

    #[test]
    fn published_vectors_of_base64() {
        let all = ["", "f", "fo", "foo", "foob", "fooba", "foobar"].map(|text| base64(text.as_bytes()));
        assert_eq!(all, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"]);
        assert_eq!(base64(&[0xfb, 0xff]), "+/8=");
    }

    #[test]
    fn names_cannot_break_out_of_the_page() {
        let run = json!({"outputs": [{"path": "<script>.png"}], "options": {"a": "\"&<b>"}, "stats": {}});
        let page = page(&run, "selvedge 'a<b'", &[], "").unwrap();
        assert!(!page.contains("<script>") && !page.contains("<b>") && page.contains("a&lt;b"), "{page}");
    }

    #[test]
    fn large_pictures_are_shown_small() {
        let plane = Plane::new(Role::Color, Samples::F32(Grid::try_filled(Domain::open([2, 3300]), 3, 0.5).unwrap()));
        let png = selvedge_io::decode(&preview(&plane).unwrap(), "p", &Default::default()).unwrap().plane;
        assert_eq!(png.domain().shape, [1, 1600]);
    }
}
