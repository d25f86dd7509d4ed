//! The frames of a clip in their order, each there once.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use super::problem::ClipProblem;
use super::range::Range;
use crate::display_name;
use crate::error::Error;

/// The number of a frame, where its name has one, and its file.
pub(super) type Numbered = (Option<u32>, PathBuf);

/// Frames in natural order, or those of a range, without gaps. Where no pattern says which number is meant, names have
/// to be alike but for it.
pub(super) fn ordered(
    path: &Path,
    mut found: Vec<Numbered>,
    range: Option<Range>,
    by_pattern: bool,
) -> Result<Vec<PathBuf>, Error> {
    found.sort_by(|a, b| natural(&file_name(&a.1), &file_name(&b.1)));
    let Some(first) = found.first().map(|(_, file)| file_name(file)) else {
        return Err(Error::new(path, ClipProblem::NoFrames));
    };
    // Names without numbers are in the order of the alphabet, and counted.
    let counts = found.iter().all(|(number, _)| number.is_none());
    let numbered = found.into_iter().zip(1..).map(|((number, file), place)| match number {
        Some(number) => Ok((number, file)),
        None if counts => Ok((place, file)),
        None => Err(Error::new(&file, ClipProblem::Foreign { first: first.clone() })),
    });
    let mut numbered = numbered.collect::<Result<Vec<_>, Error>>()?;
    if !counts
        && !by_pattern
        && let Some((_, foreign)) = numbered.iter().find(|(_, file)| !alike(&file_name(file), &first))
    {
        return Err(Error::new(foreign, ClipProblem::Foreign { first }));
    }
    numbered.sort_by_key(|(number, _)| *number);
    numbered.retain(|(number, _)| range.is_none_or(|range| range.holds(*number)));
    for pair in numbered.windows(2) {
        if let [(number, other), (again, file)] = pair
            && number == again
        {
            let other = file_name(other);
            return Err(Error::new(file, ClipProblem::Doubled { number: *number, other }));
        }
    }
    let (begin, step) = range.map_or((numbered.first().map_or(0, |(n, _)| *n), 1), |range| (range.first, range.step));
    let (mut expected, mut before) = (begin, None);
    for (number, _) in &numbered {
        if *number != expected {
            return Err(Error::new(path, ClipProblem::Gap { number: expected, before }));
        }
        before = Some(*number);
        expected = number.saturating_add(step);
    }
    match range {
        Some(range) if expected <= range.last => Err(Error::new(path, ClipProblem::Gap { number: expected, before })),
        _ => Ok(numbered.into_iter().map(|(_, file)| file).collect()),
    }
}

fn file_name(path: &Path) -> String {
    display_name(path)
}

/// The last run of digits before the extension.
pub(super) fn last_number(name: &str) -> Option<u32> {
    let [start, end] = number_at(name)?;
    name[start..end].parse().ok()
}

fn number_at(name: &str) -> Option<[usize; 2]> {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    Some([stem[..end].trim_end_matches(|c: char| c.is_ascii_digit()).len(), end])
}

/// Whether two names differ in their number alone.
fn alike(a: &str, b: &str) -> bool {
    let around = |name: &str| number_at(name).map(|[start, end]| (name[..start].to_owned(), name[end..].to_owned()));
    around(a) == around(b)
}

/// By text, but digits by the number that they are.
fn natural(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a, b);
    loop {
        let digits = |s: &str| s.len() - s.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (n, m) = (digits(a), digits(b));
        let order = if 0 < n && 0 < m {
            let value = |s: &str| s.trim_start_matches('0').to_owned();
            let (x, y) = (value(&a[..n]), value(&b[..m]));
            x.len().cmp(&y.len()).then(x.cmp(&y)).then(n.cmp(&m))
        } else {
            a.chars().next().cmp(&b.chars().next())
        };
        if order != Ordering::Equal || a.is_empty() {
            return order;
        }
        let skip = |s: &str, n: usize| if 0 < n { n } else { s.chars().next().map_or(0, char::len_utf8) };
        (a, b) = (&a[skip(a, n)..], &b[skip(b, m)..]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_is_that_of_people() {
        let mut names = ["a10", "a9", "a09", "b1", "a", "a1b", "a01c", ""];
        names.sort_by(|a, b| natural(a, b));
        assert_eq!(names, ["", "a", "a1b", "a01c", "a9", "a09", "a10", "b1"]);
    }

    #[test]
    fn frames_that_are_missing_or_foreign_are_named() {
        let frames = |names: &[&str], range: Option<&str>| {
            let found = names.iter().map(|name| (last_number(name), PathBuf::from(name))).collect();
            let ordered = ordered(Path::new("clip"), found, range.map(|r| r.parse().unwrap()), false);
            ordered.map(|files| files.iter().map(|f| file_name(f)).collect::<Vec<_>>()).map_err(|e| e.to_string())
        };
        assert_eq!(frames(&["a2.png", "a10.png", "a3.png"], Some("2-3")).unwrap(), ["a2.png", "a3.png"]);
        assert_eq!(frames(&["b.png", "a.png"], None).unwrap(), ["a.png", "b.png"]);
        assert_eq!(frames(&["a9.png", "a10.png"], None).unwrap(), ["a9.png", "a10.png"]);
        assert_eq!(frames(&["a1.png", "a3.png", "a5.png"], Some("1-5x2")).unwrap().len(), 3);
        let wrong = |names, range, text: &str| {
            let line = frames(names, range).unwrap_err();
            assert!(line.contains(text), "{line}");
        };
        wrong(&["a1.png", "a3.png"], None, "'clip': frame 2 is missing after 1");
        wrong(&["a1.png", "a2.png"], Some("1-3"), "frame 3 is missing after 2");
        wrong(&["a1.png"], Some("5-6"), "frame 5 is missing");
        wrong(&["1.png", "01.png"], None, "frame 1 is there twice");
        wrong(&["a1.png", "b2.png"], None, "'b2.png': is no frame like 'a1.png'");
        wrong(&["a1.png", "thumb.png"], None, "'thumb.png': is no frame like 'a1.png'");
        wrong(&[], None, "no frame of this name");
    }
}
