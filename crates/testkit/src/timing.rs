//! What benches share: which cases are asked for, and what one took.

use std::env;
use std::fs;
use std::time::Instant;

/// Repeats of a case where none are asked for: odd, so that the median is a time that was taken.
const REPEATS: u32 = 9;

/// Milliseconds of the processor (all threads together), and of the clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Where the system does not tell it, that of the clock.
    pub processor: f64,
    /// From the beginning to the end.
    pub clock: f64,
}

/// What a piece of work takes.
pub fn spent(work: impl FnOnce()) -> Spent {
    let (before, start) = (processed(), Instant::now());
    work();
    let clock = start.elapsed().as_secs_f64() * 1e3;
    let processor = before.and_then(|before| Some(processed()? - before)).unwrap_or(clock);
    Spent { processor, clock }
}

/// Milliseconds that all threads together have run (Linux). The count may move in steps of some milliseconds.
pub fn processed() -> Option<f64> {
    let mut sum = 0.0;
    for task in fs::read_dir("/proc/self/task").ok()? {
        let text = fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        sum += text.split(' ').next()?.parse::<f64>().ok()? / 1e6;
    }
    Some(sum)
}

/// A bench's whole program: `[CASE...] [--repeat N] [--list]`. Prints a line a case whose name holds one of the words:
/// its name, milliseconds of the processor (mean), of the clock (median, least), and what it is for. What `prepare`
/// makes and checks is made once, and not timed.
///
/// # Panics
/// If `--repeat` has no number.
pub fn bench<P, S>(cases: &[(&str, P, &str)], prepare: impl FnOnce() -> S, time: impl Fn(&S, &P) -> Spent) {
    let (mut names, mut repeat) = (Vec::new(), REPEATS);
    let mut words = env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--bench" => {}
            "--list" => return cases.iter().for_each(|(name, _, what)| println!("{name:18} {what}")),
            "--repeat" => {
                let number = words.next().and_then(|n| n.parse().ok()).filter(|&n| 0 < n);
                repeat = number.expect("a number of repeats");
            }
            _ => names.push(word),
        }
    }
    let prepared = prepare();
    for (name, part, what) in cases.iter().filter(|c| names.is_empty() || names.iter().any(|n| c.0.contains(n))) {
        let all: Vec<Spent> = (0..repeat).map(|_| time(&prepared, part)).collect();
        let [processor, median, least] = summary(&all);
        println!("{name:18} {processor:9.4} {median:9.4} {least:9.4}   {what}");
    }
}

/// Mean of the processor, median and least of the clock.
fn summary(all: &[Spent]) -> [f64; 3] {
    let mut clock: Vec<f64> = all.iter().map(|s| s.clock).collect();
    clock.sort_by(f64::total_cmp);
    let processor: f64 = all.iter().map(|s| s.processor).sum();
    [processor / all.len() as f64, clock[clock.len() / 2], clock[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_is_a_mean_a_median_and_a_least() {
        let all = [(1.0, 9.0), (2.0, 3.0), (6.0, 4.0)].map(|(processor, clock)| Spent { processor, clock });
        assert_eq!(summary(&all), [3.0, 4.0, 3.0]);
    }
}
