//! Schedules as they are typed: `4:8,2:16,1:32`, a resolution and a size each; and how complete the output becomes.

use selvedge_texture_optimization::Level;

use crate::values::Auto;
use crate::wrong::Wrong;

/// The levels, in their order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::commands) struct Levels(pub(in crate::commands) Vec<Level>);

pub(in crate::commands) fn levels(text: &str) -> Result<Levels, Wrong> {
    let level = |part: &str| {
        let (scale, size) = part.split_once(':')?;
        Some(Level { scale: scale.trim().parse().ok()?, size: size.trim().parse().ok()? })
    };
    let all: Option<Vec<Level>> = text.split(',').map(level).collect();
    let what = || format!("'{text}' is no schedule");
    all.map(Levels).ok_or_else(|| Wrong::new(what(), "write a resolution and a size for each level: 2:16,1:16,1:8"))
}

/// The levels, or auto.
pub(super) fn schedule(text: &str) -> Result<Auto<Levels>, Wrong> {
    if text == "auto" { Ok(Auto(None)) } else { levels(text).map(|levels| Auto(Some(levels))) }
}

/// As they are typed.
pub(in crate::commands) fn typed(levels: &[Level]) -> String {
    levels.iter().map(|l| format!("{}:{}", l.scale, l.size)).collect::<Vec<_>>().join(",")
}

/// How complete the output becomes; `None` for as it comes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Complete(pub(super) Option<f64>);

pub(super) fn complete(text: &str) -> Result<Auto<Complete>, Wrong> {
    match text {
        "auto" => Ok(Auto(None)),
        "none" => Ok(Auto(Some(Complete(None)))),
        _ => text
            .parse()
            .map(|v| Auto(Some(Complete(Some(v)))))
            .map_err(|_| Wrong::new(format!("'{text}' is no completeness"), "write a number from 0 on, none or auto")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedules_are_read_as_they_are_written() {
        let two = "4:8,1:16";
        assert_eq!(typed(&levels(two).unwrap().0), two);
        for wrong in ["", "8", "4:8,", "4:x", "-1:8"] {
            assert!(levels(wrong).is_err(), "{wrong}");
        }
    }
}
