//! One self-contained HTML page of cases: what was expected, what came, and the pictures.

/// How a case ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// As expected.
    Same,
    /// Not as expected.
    Differs,
    /// There was no reference.
    New,
}

/// One case of the page.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of the recipe.
    pub name: String,
    /// How it ended.
    pub verdict: Verdict,
    /// What a reader should know: the command, the lines that differ.
    pub text: String,
    /// A caption and a PNG file each.
    pub pictures: Vec<(String, Vec<u8>)>,
}

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;margin:2em auto;max-width:72em;padding:0 1em;background:#18191d;\
    color:#d8d8d2}h1{font-size:1.3em}article{border-top:1px solid #3a3c44;padding:1em 0}h2{font-size:1em;margin:0 0 .5em}\
    .differs h2{color:#f0896a}.new h2{color:#e6c667}.same h2{color:#8fc28a}pre{background:#101114;padding:.8em;overflow:auto}\
    figure{margin:.5em 0}img{image-rendering:pixelated;min-width:192px;max-width:100%;height:auto;zoom:1.5}\
    figcaption{color:#9a9a92}";

/// The page, cases that need a look first.
pub fn page(title: &str, cases: &[Case]) -> String {
    let count = |verdict| cases.iter().filter(|c| c.verdict == verdict).count();
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>{STYLE}</style>\n\
         <h1>{title}: {} differ, {} new, {} the same</h1>\n",
        count(Verdict::Differs),
        count(Verdict::New),
        count(Verdict::Same),
        title = escaped(title),
    );
    for verdict in [Verdict::Differs, Verdict::New, Verdict::Same] {
        for case in cases.iter().filter(|c| c.verdict == verdict) {
            html += &article(case);
        }
    }
    html + "</html>\n"
}

fn article(case: &Case) -> String {
    let (class, says) = match case.verdict {
        Verdict::Same => ("same", "the same"),
        Verdict::Differs => ("differs", "differs"),
        Verdict::New => ("new", "new"),
    };
    let mut html = format!("<article class=\"{class}\" id=\"{0}\">\n<h2>{0}: {says}</h2>\n", escaped(&case.name));
    if !case.text.is_empty() {
        html += &format!("<pre>{}</pre>\n", escaped(&case.text));
    }
    for (caption, png) in &case.pictures {
        let (caption, data) = (escaped(caption), base64(png));
        html += &format!(
            "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\">\n<figcaption>{caption}</figcaption></figure>\n"
        );
    }
    html + "</article>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Base64 as in RFC 4648.
fn base64(bytes: &[u8]) -> String {
    const SIGNS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for sign in 0..4 {
            let six = (bits >> (18 - 6 * sign)) & 63;
            text.push(if sign <= three.len() { char::from(SIGNS[six as usize]) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 4648, section 10.
    #[test]
    fn base64_has_the_published_vectors() {
        for (plain, coded) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn cases_that_need_a_look_come_first_and_text_is_escaped() {
        let case = |name: &str, verdict| Case { name: name.into(), verdict, text: "a < b".into(), pictures: vec![] };
        let html = page("Suite", &[case("fine", Verdict::Same), case("broken", Verdict::Differs)]);
        assert!(html.find("broken: differs") < html.find("fine: the same"));
        assert!(html.contains("<h1>Suite: 1 differ, 0 new, 1 the same</h1>") && html.contains("a &lt; b"));
    }
}
