//! `--sweep K=.05,.2,1,5 N=1,3,5,9`: a run for each pair of values, since the right ones are found by a few tries.
//! `[CMS V-H]`

use std::ffi::OsString;
use std::str::FromStr;

use clap::{Arg, ArgMatches};

use crate::failure::Failure;
use crate::wrong::Wrong;

/// Runs at most.
const MOST: usize = 100;

/// What may be swept, by its letter and its option.
const OPTIONS: [(&str, &str); 2] = [("K", "constraint-weight"), ("N", "neighborhood")];

/// One option's values as they were typed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sweep {
    option: &'static str,
    values: Vec<String>,
}

impl FromStr for Sweep {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let wrong = || Wrong::new(format!("'{text}' sweeps nothing"), "write K=.05,.2,1,5 or N=1,3,5,9");
        let (letter, values) = text.split_once('=').ok_or_else(wrong)?;
        let (_, option) = OPTIONS.iter().find(|(own, _)| *own == letter).ok_or_else(wrong)?;
        let values: Vec<String> = values.split(',').map(str::to_owned).collect();
        let is_number = |value: &String| value.parse::<f64>().is_ok_and(|v| v.is_finite() && 0.0 <= v);
        if values.iter().all(is_number) { Ok(Self { option, values }) } else { Err(wrong()) }
    }
}

/// What one run has of it: options and their values.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Swept(Vec<(&'static str, String)>);

impl Swept {
    /// What is written under its picture.
    pub(crate) fn label(&self) -> Option<String> {
        (!self.0.is_empty()).then(|| self.0.iter().map(|(_, value)| value.as_str()).collect::<Vec<_>>().join("/"))
    }

    /// Whether it stands for an option, whatever that was typed as.
    pub(crate) fn sets(&self, arg: &Arg) -> bool {
        self.0.iter().any(|(option, _)| arg.get_long() == Some(option))
    }

    pub(crate) fn words(&self) -> impl Iterator<Item = OsString> + use<'_> {
        self.0.iter().map(|(option, value)| format!("--{option}={value}").into())
    }
}

fn typed(matches: &ArgMatches) -> Vec<&Sweep> {
    matches.try_get_many("sweep").ok().flatten().into_iter().flatten().collect()
}

/// A run for each combination, the last option's values side by side; one with nothing where nothing is swept.
///
/// # Errors
/// An option that is swept twice, and more runs than anybody looks at.
pub(crate) fn all(matches: &ArgMatches) -> Result<Vec<Swept>, Failure> {
    let sweeps = typed(matches);
    for (i, sweep) in sweeps.iter().enumerate() {
        if sweeps[..i].iter().any(|other| other.option == sweep.option) {
            let what = format!("--sweep has two lists for --{}", sweep.option);
            return Err(Failure::new(2, what).remedy("write one list"));
        }
    }
    let runs: usize = sweeps.iter().map(|sweep| sweep.values.len()).product();
    if MOST < runs {
        return Err(
            Failure::new(2, format!("--sweep makes {runs} runs, of {MOST} at most")).remedy("give fewer values")
        );
    }
    let mut all = vec![Swept::default()];
    for sweep in sweeps {
        let with = |swept: &Swept, value: &String| {
            Swept(swept.0.iter().cloned().chain([(sweep.option, value.clone())]).collect())
        };
        all = all
            .iter()
            .flat_map(|swept| sweep.values.iter().map(|value| with(swept, value)).collect::<Vec<_>>())
            .collect();
    }
    Ok(all)
}

/// As many columns as the last option has values.
pub(crate) fn columns(matches: &ArgMatches) -> Option<usize> {
    typed(matches).last().map(|sweep| sweep.values.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_and_wrong_ones_refused() {
        let sweep: Sweep = "K=.05,2".parse().unwrap();
        assert_eq!(sweep, Sweep { option: "constraint-weight", values: vec![".05".into(), "2".into()] });
        for text in ["K", "X=1", "K=", "K=1,,2", "N=-1", "K=inf", "K=1,x"] {
            assert!(text.parse::<Sweep>().is_err(), "{text}");
        }
    }
}
