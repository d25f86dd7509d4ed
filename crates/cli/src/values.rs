//! Values that are typed for options of several commands.

use std::fmt::Debug;
use std::str::FromStr;

use selvedge_core::SeamMeasure;
use serde_json::Value;

use crate::wrong::Wrong;

/// Choices of an option by the names of those of a crate, each with its help.
macro_rules! choices {
    ($name:ident for $of:ty { $($(#[$help:meta])* $choice:ident,)+ }) => {
        #[derive(Clone, Copy, Debug, clap::ValueEnum)]
        pub(crate) enum $name {
            $($(#[$help])* $choice,)+
        }

        impl From<$name> for $of {
            fn from(choice: $name) -> Self {
                match choice {
                    $($name::$choice => Self::$choice,)+
                }
            }
        }
    };
}
pub(crate) use choices;

/// Fields of counts as an object of `--json`.
macro_rules! counts {
    ($of:expr, $($field:ident),+ $(,)?) => {
        serde_json::json!({ $((stringify!($field)): $of.$field),+ })
    };
}
pub(crate) use counts;

choices!(SeamArg for SeamMeasure {
    /// By the difference of the two patches.
    Difference,
    /// By that difference over their gradients.
    Gradient,
});

/// A choice as it is typed.
pub(crate) fn name_of(choice: impl Debug) -> String {
    format!("{choice:?}").to_lowercase()
}

/// A value, or a choice by the program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Auto<T>(pub(crate) Option<T>);

/// Understands `auto` and all that `read` does; of anything else it says that it is no such thing, and what to write.
pub(crate) fn auto<T>(
    thing: &'static str,
    remedy: &'static str,
    read: fn(&str) -> Option<T>,
) -> impl Fn(&str) -> Result<Auto<T>, Wrong> + Clone {
    move |text| match (text, read(text)) {
        ("auto", _) => Ok(Auto(None)),
        (_, Some(value)) => Ok(Auto(Some(value))),
        _ if is_beyond(text) => Err(Wrong::new(format!("'{text}' is over {}", u32::MAX), remedy)),
        _ => Err(Wrong::new(format!("'{text}' is no {thing}"), remedy)),
    }
}

/// A whole number that none of these options holds.
fn is_beyond(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit()) && text.parse::<u32>().is_err()
}

/// A value as its type is written.
pub(crate) fn parsed<T: FromStr>(text: &str) -> Option<T> {
    text.parse().ok()
}

/// Height and width in pixels: a square's side, or width by height.
pub(crate) fn sides(text: &str) -> Option<[u32; 2]> {
    match text.split_once(['x', 'X']) {
        Some((across, down)) => Some([parsed(down)?, parsed(across)?]),
        None => Some([parsed(text)?; 2]),
    }
}

/// As sides are typed.
pub(crate) fn sides_typed([down, across]: [u32; 2]) -> Value {
    if down == across { down.into() } else { format!("{across}x{down}").into() }
}

/// A number, or a choice by the program.
pub(crate) fn count() -> impl Fn(&str) -> Result<Auto<u32>, Wrong> + Clone {
    auto("number", "write a number, or auto", parsed)
}

/// A length in pixels, or a choice by the program.
pub(crate) fn pixels() -> impl Fn(&str) -> Result<Auto<u32>, Wrong> + Clone {
    auto("number of pixels", "write a number of pixels, or auto", parsed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_and_choices_by_the_program_are_read_as_they_are_written() {
        let block = auto("block", "write 32, or auto", sides);
        assert_eq!(block("auto"), Ok(Auto(None)));
        assert_eq!([block("32"), block("64x16")].map(|b| b.unwrap().0), [Some([32, 32]), Some([16, 64])]);
        assert_eq!([[32, 32], [16, 64]].map(sides_typed), [Value::from(32), "64x16".into()]);
        for text in ["", "x", "3x", "1x2x3", "-4"] {
            assert_eq!(block(text).unwrap_err().what, format!("'{text}' is no block"));
        }
    }
}
