//! Schedules as they are typed: `4:8,2:16,1:32`, a resolution and a size each.

use selvedge_texture_optimization::Level;

use crate::wrong::Wrong;

/// The levels, in their order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Levels(pub(super) Vec<Level>);

pub(super) fn levels(text: &str) -> Result<Levels, Wrong> {
    let level = |part: &str| {
        let (scale, size) = part.split_once(':')?;
        Some(Level { scale: scale.trim().parse().ok()?, size: size.trim().parse().ok()? })
    };
    let all: Option<Vec<Level>> = text.split(',').map(level).collect();
    let what = || format!("'{text}' is no schedule");
    all.map(Levels).ok_or_else(|| Wrong::new(what(), "write a resolution and a size for each level: 2:16,1:16,1:8"))
}

/// As they are typed.
pub(super) fn typed(levels: &[Level]) -> String {
    levels.iter().map(|l| format!("{}:{}", l.scale, l.size)).collect::<Vec<_>>().join(",")
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
