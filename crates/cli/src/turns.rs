//! Several runs in one: `--seed 1..4`, `--each` and `--sweep`. Each is the command line with one seed, its own
//! exemplars and one value of what is swept, and with its names filled in, so that no command knows of the others.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Arg, ArgMatches, Command, ValueHint};

use crate::config::{self, was_typed};
use crate::failure::{Failure, n};
use crate::sweep::{self, Swept};
use crate::wrong::Wrong;
use crate::{names, page};

/// More runs than this are a script's business: all pictures are held until the last one is made.
const MOST: usize = 1000;

/// Files that a run writes, by their options' fields.
const WRITTEN: [&str; 7] = ["output", "map", "explain", "label_map", "mapped", "preview", "report"];

/// Lists of which each exemplar has its own part.
const OF_EACH: [&str; 4] = ["mask", "with", "matched", "role"];

/// Seeds, one for each run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seeds(pub(crate) Vec<u64>);

impl FromStr for Seeds {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let wrong = || Wrong::new(format!("'{text}' is no seed"), "write a number from 0 on, 1..4 or 1,2,3");
        let seed = |text: &str| text.parse::<u64>().map_err(|_| wrong());
        let many = || Wrong::new(format!("'{text}' are too many seeds"), format!("write at most {MOST}"));
        let seeds = match text.split_once("..") {
            Some((first, last)) => {
                let (first, last) = (seed(first)?, seed(last)?);
                if first > last {
                    return Err(wrong());
                }
                if last - first >= MOST as u64 {
                    return Err(many());
                }
                (first..=last).collect()
            }
            None => text.split(',').map(seed).collect::<Result<Vec<_>, _>>()?,
        };
        if seeds.len() <= MOST { Ok(Self(seeds)) } else { Err(many()) }
    }
}

/// One run of several.
#[derive(Clone, Debug)]
pub(crate) struct Turn {
    pub(crate) words: Vec<OsString>,
    /// All files that it writes.
    pub(crate) names: Vec<PathBuf>,
    /// True for the first run of its exemplars, and of what is swept.
    pub(crate) is_first: bool,
    /// What is varied, for people: its seed, its number where exemplars vary, or the values of what is swept.
    pub(crate) label: String,
}

/// Several runs, in order: all seeds of the first exemplar, then those of the next one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Turns {
    pub(crate) all: Vec<Turn>,
    /// Files that one or the other reads.
    pub(crate) read: Vec<PathBuf>,
    /// A picture of all of them.
    pub(crate) sheet: Option<PathBuf>,
    /// Its columns, where it has to have so many.
    pub(crate) columns: Option<usize>,
}

/// The runs that were typed; none where the command is one run, whose names are as they were typed.
///
/// # Errors
/// Runs that would write the same names.
pub(crate) fn turns(all: &Command, typed: &ArgMatches) -> Result<Turns, Failure> {
    let Some((name, matches)) = typed.subcommand() else { return Ok(Turns::default()) };
    let command = config::command(all, name);
    let seeds = matches.get_one::<Seeds>("seed").map_or(vec![0], |seeds| seeds.0.clone());
    if !command.get_arguments().any(|arg| arg.get_id() == "each") {
        if 1 < seeds.len() && ["animate", "video"].contains(&name) {
            let what = format!("{} for one clip", n("seed", seeds.len()));
            return Err(Failure::new(2, what).remedy("give one --seed"));
        }
        // For all others seeds do nothing, which is told.
        return Ok(Turns::default());
    }
    let each = matches.get_flag("each");
    let exemplars = values(matches, "exemplars");
    let parts: Vec<Option<usize>> = if each { (0..exemplars.len()).map(Some).collect() } else { vec![None] };
    let sheet = matches.get_one::<PathBuf>("sheet").cloned();
    let named = |id: &str| values(matches, id).iter().any(|name| mentions_run(name));
    let of_run = WRITTEN.iter().any(|id| named(id));
    let sweeps = sweep::all(matches)?;
    if seeds.len() == 1 && !each && sheet.is_none() && !of_run && sweeps == [Swept::default()] {
        return Ok(Turns::default());
    }
    let runs = parts.iter().flat_map(|part| seeds.iter().map(move |seed| (*part, *seed)));
    let runs = runs.flat_map(|(part, seed)| sweeps.iter().map(move |swept| (part, seed, swept)));
    let total = parts.len() * seeds.len() * sweeps.len();
    let picked = |(number, (part, seed, swept)): (usize, (Option<usize>, u64, &Swept))| {
        let (number, exemplars) = (number as u64 + 1, exemplars.len());
        let one = One { command: &command, matches, part, seed, number, exemplars, swept };
        let label = match swept.label() {
            Some(label) => label,
            None if each => number.to_string(),
            None => seed.to_string(),
        };
        let is_first = seed == seeds[0];
        Turn { words: one.words(name), names: one.names(), is_first, label }
    };
    let mut taken: Vec<PathBuf> = sheet.iter().cloned().collect();
    let mut turns = Turns { all: Vec::new(), read: read(&command, matches), sheet, columns: sweep::columns(matches) };
    for turn in runs.enumerate().map(picked) {
        for name in &turn.names {
            if taken.iter().any(|other| other == name || selvedge_io::same_file(other, name)) {
                let twice = (1..seeds.len()).find(|&i| seeds[..i].contains(&seeds[i])).map(|i| seeds[i]);
                let (of, remedy) = match twice {
                    Some(seed) => (format!(", two of seed {seed},"), "give each seed once, or use '{n}' in it"),
                    None => (String::new(), "use '{seed}', '{n}' or '{stem}' in it"),
                };
                let what = format!("{}{of} would write this name", n("run", total));
                return Err(Failure::new(2, what).about(name).remedy(remedy));
            }
        }
        taken.extend(turn.names.iter().cloned());
        turns.all.push(turn);
    }
    Ok(turns)
}

/// All values of an option as they were typed.
fn values(matches: &ArgMatches, id: &str) -> Vec<OsString> {
    matches.try_get_raw(id).ok().flatten().into_iter().flatten().map(OsStr::to_owned).collect()
}

/// Files that were typed to be read.
fn read(command: &Command, matches: &ArgMatches) -> Vec<PathBuf> {
    let files = command.get_arguments().filter(|arg| arg.get_value_hint() == ValueHint::FilePath);
    let read = files.filter(|arg| was_typed(arg, matches)).map(|arg| arg.get_id().as_str());
    let read = read.filter(|id| !WRITTEN.contains(id) && !["sheet", "save_config"].contains(id));
    read.flat_map(|id| values(matches, id)).map(PathBuf::from).collect()
}

/// Whether a name differs from run to run.
fn mentions_run(name: &OsStr) -> bool {
    name.to_str().is_some_and(|text| text.contains("{seed}") || text.contains("{n}"))
}

/// What is typed for one run.
struct One<'a> {
    command: &'a Command,
    matches: &'a ArgMatches,
    /// The exemplar that it uses, or all.
    part: Option<usize>,
    seed: u64,
    /// From 1.
    number: u64,
    /// How many there are.
    exemplars: usize,
    swept: &'a Swept,
}

impl One<'_> {
    /// The run's command line.
    fn words(&self, name: &str) -> Vec<OsString> {
        let mut words: Vec<OsString> = vec!["selvedge".into(), name.into(), format!("--seed={}", self.seed).into()];
        let typed = self.command.get_arguments().filter(|arg| was_typed(arg, self.matches));
        for arg in typed
            .filter(|arg| !["seed", "each", "sheet", "sweep", "config", "save_config"].contains(&arg.get_id().as_str()))
        {
            if !self.swept.sets(arg) {
                words.extend(self.option(arg));
            }
        }
        words.extend(self.swept.words());
        words.push("--".into());
        words.extend(self.values("exemplars"));
        words
    }

    /// An option as often as it was typed; none for what is no option.
    fn option(&self, arg: &Arg) -> Vec<OsString> {
        let (Some(long), id) = (arg.get_long(), arg.get_id().as_str()) else { return Vec::new() };
        if !arg.get_action().takes_values() {
            return vec![format!("--{long}").into()];
        }
        let flag = || OsString::from(format!("--{long}"));
        let several = arg.get_num_args().map_or(1, |range| range.min_values());
        if 1 < several {
            let values = self.values(id);
            return values.chunks(several).flat_map(|some| std::iter::once(flag()).chain(some.to_vec())).collect();
        }
        let joined = |value: OsString| {
            let mut word = flag();
            word.push("=");
            word.push(value);
            word
        };
        self.values(id).into_iter().map(joined).collect()
    }

    /// The values of an option for this run.
    fn values(&self, id: &str) -> Vec<OsString> {
        let values = values(self.matches, id);
        if WRITTEN.contains(&id) {
            return values.iter().map(|name| self.filled(name).into()).collect();
        }
        let Some(part) = self.part else { return values };
        // The picture of --over is one more exemplar, after all others.
        let over = usize::from(id != "exemplars" && id != "mask" && !self.plain("over").is_empty());
        let group = self.exemplars + over;
        let listed = id == "exemplars" || OF_EACH.contains(&id);
        // One role for each plane goes with it; fewer are for the planes of any exemplar.
        let listed = listed && (id != "role" || values.len() == self.plain("with").len());
        if !listed || values.len() <= 1 || !values.len().is_multiple_of(group) {
            return values;
        }
        let own = |group: &[OsString]| std::iter::once(group[part].clone()).chain(group[self.exemplars..].to_vec());
        values.chunks(group).flat_map(|group| own(group).collect::<Vec<_>>()).collect()
    }

    fn plain(&self, id: &str) -> Vec<OsString> {
        values(self.matches, id)
    }

    /// A name with the run's seed and number.
    fn filled(&self, name: &OsStr) -> PathBuf {
        let (seed, number) = (self.seed.to_string(), self.number.to_string());
        names::filled(Path::new(name), &[("{seed}", Some(seed.as_ref())), ("{n}", Some(number.as_ref()))])
    }

    /// All names that it writes.
    fn names(&self) -> Vec<PathBuf> {
        let exemplars = self.values("exemplars");
        let of_first = |name: OsString| names::of_plane(Path::new(&name), Path::new(&exemplars[0]));
        let page = |id: &str, name: PathBuf| if id == "report" { page::checked(&name) } else { name };
        let written = WRITTEN.iter().flat_map(|id| self.values(id).into_iter().map(|name| page(id, of_first(name))));
        let (over, with) = (usize::from(!self.plain("over").is_empty()), self.values("with"));
        let output = self.values("output");
        let layers = with
            .chunks(exemplars.len() + over)
            .flat_map(|planes| output.iter().map(|pattern| names::of_plane(Path::new(pattern), Path::new(&planes[0]))));
        let mut all: Vec<PathBuf> = written.collect();
        // Within a run names are told apart by the run itself.
        all.extend(layers);
        all.sort();
        all.dedup();
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::typed::{Stop, parse};

    fn lines(line: &str) -> Result<Vec<String>, String> {
        let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let typed = match parse(&words) {
            Ok(typed) => typed,
            Err(Stop::Wrong(failure)) => return Err(failure.message),
            Err(Stop::Answer(_)) => return Err("an answer".into()),
        };
        let turns = typed.turns().map_err(|failure| failure.message)?;
        let joined = |turn: Turn| turn.words.iter().map(|w| w.to_string_lossy()).collect::<Vec<_>>().join(" ");
        Ok(turns.all.into_iter().map(joined).collect())
    }

    #[test]
    fn seeds_are_read_as_typed() {
        let seeds = |text: &str| text.parse::<Seeds>().map(|seeds| seeds.0);
        assert_eq!(seeds("7"), Ok(vec![7]));
        assert_eq!(seeds("1..4"), Ok(vec![1, 2, 3, 4]));
        assert_eq!(seeds("3,1,18446744073709551615"), Ok(vec![3, 1, u64::MAX]));
        for wrong in ["", "x", "-1", "4..1", "1..", "..4", "1,,2", "1.5", "0..18446744073709551615", "0..1000"] {
            assert!(seeds(wrong).is_err(), "{wrong}");
        }
        assert_eq!(seeds("0..999").unwrap().len(), 1000);
    }

    #[test]
    fn a_single_run_stays_as_it_was_typed() {
        assert_eq!(lines("selvedge quilt a.png -o b.png --seed 3"), Ok(vec![]));
        assert_eq!(
            lines("selvedge quilt a.png -o b-{seed}-{n}.png --seed 3 -q"),
            Ok(vec!["selvedge quilt --seed=3 --output=b-3-1.png --quiet -- a.png".into()])
        );
        assert_eq!(lines("selvedge info a.png --seed 1..2"), Ok(vec![]));
    }

    #[test]
    fn every_run_has_its_own_exemplar_seed_and_names() {
        let line = "selvedge quilt a.png b.png -o {stem}-{seed}.png --each --seed 1,5 --mask none --mask m.png \
                    --with an.png bn.png ah.png bh.png --map {n}.exr --size 9";
        let own = |mask: &str, with: [&str; 2], n: u32, seed: u32, e: &str| {
            format!(
                "selvedge quilt --seed={seed} --mask={mask} --with={} --with={} --output={{stem}}-{seed}.png \
                 --map={n}.exr --size=9 -- {e}",
                with[0], with[1]
            )
        };
        let (a, b) = (["an.png", "ah.png"], ["bn.png", "bh.png"]);
        let expected = [
            own("none", a, 1, 1, "a.png"),
            own("none", a, 2, 5, "a.png"),
            own("m.png", b, 3, 1, "b.png"),
            own("m.png", b, 4, 5, "b.png"),
        ];
        assert_eq!(lines(line), Ok(expected.to_vec()));
    }

    #[test]
    fn runs_of_one_name_are_refused() {
        for line in [
            "selvedge quilt a.png -o b.png --seed 1..2",
            "selvedge quilt a.png -o b-{seed}.png --seed 1..2 --map m.exr",
            "selvedge quilt a.png -o b-{seed}.png --seed 1,1",
            "selvedge quilt x/a.png y/a.png --each -o {stem}-2.png",
            "selvedge quilt a.png b.png --each -o {stem}.png --with c.png a.png",
        ] {
            assert!(lines(line).is_err_and(|what| what.contains("would write this name")), "{line}: {:?}", lines(line));
        }
        let twice = lines("selvedge quilt a.png -o b-{seed}.png --seed 4,1,4").unwrap_err();
        assert_eq!(twice, "3 runs, two of seed 4, would write this name");
    }
}
