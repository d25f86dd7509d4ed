//! Memory that a test holds. The system counts it by process, so a test that measures it runs in one of its own: what
//! its neighbours hold would count too.

use std::env;
use std::fs;
use std::process::Command;

/// The variable that tells a process which test it was started for, and which case of it.
const ALONE: &str = "SELVEDGE_ALONE";

/// The case of `test` that this process was started for by [`alone`]; `None` in the process that runs all tests.
pub fn case(test: &str) -> Option<String> {
    let alone = env::var(ALONE).ok()?;
    alone.strip_prefix(test)?.strip_prefix(' ').map(str::to_owned)
}

/// Starts the running test binary once more, for one test (by its full name, `module::name`) and one case of it, which
/// [`case`] tells there, and answers with what the test said.
///
/// # Panics
///
/// If the test fails there, or is not there.
pub fn alone(test: &str, case: &str) -> String {
    let itself = env::current_exe().expect("a test knows its binary");
    let output =
        Command::new(itself).args(["--exact", test, "--nocapture"]).env(ALONE, format!("{test} {case}")).output();
    let output = output.expect("the test's binary can be started");
    let said = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
    assert!(output.status.success() && said.contains("1 passed"), "{test} {case}: {said}");
    said
}

/// Prints what this process has held at its peak beyond `before`, for [`of_each`] to read; nothing where the system
/// does not tell.
pub fn tell(before: Option<u64>) {
    if let (Some(before), Some(peak)) = (before, peak()) {
        println!("held {}", peak.saturating_sub(before));
    }
}

/// Runs `measure`, which [`tell`]s, for each case of a test in a process of its own, and gives `check` what it held.
/// Says that it skips where the system does not tell.
///
/// # Panics
///
/// If a case fails.
pub fn of_each(test: &str, cases: usize, measure: impl Fn(usize), check: impl Fn(usize, u64)) {
    if let Some(number) = case(test) {
        return measure(number.parse().expect("a case is a number"));
    }
    for number in 0..cases {
        let said = alone(test, &number.to_string());
        let Some((_, held)) = said.split_once("held ") else {
            eprintln!("skipped: this system does not tell how much memory a process had at its peak");
            return;
        };
        check(number, held.lines().next().and_then(|held| held.parse().ok()).expect("bytes are a number"));
    }
}

/// Bytes that this process holds now beside files that are mapped, such as its own code, which comes in as it is run;
/// `None` where the system does not tell.
pub fn held() -> Option<u64> {
    Some(status("VmRSS:")?.saturating_sub(files()?))
}

/// The most bytes that this process has held so far, beside files that are mapped now: what of these came in after the
/// peak is missing in it. `None` where the system does not tell.
pub fn peak() -> Option<u64> {
    Some(status("VmHWM:")?.saturating_sub(files()?))
}

fn files() -> Option<u64> {
    Some(status("RssFile:")? + status("RssShmem:")?)
}

/// A line of the process's status, told in KiB.
fn status(field: &str) -> Option<u64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|l| l.starts_with(field))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEST: &str = "memory::tests::a_case_runs_in_a_process_of_its_own";

    #[test]
    fn a_case_runs_in_a_process_of_its_own() {
        match case(TEST) {
            Some(case) => println!("case {case} in {}", std::process::id()),
            None => {
                let said = alone(TEST, "7 of 9");
                assert!(said.contains("case 7 of 9 in ") && !said.contains(&format!("in {}\n", std::process::id())));
            }
        }
        assert!(held() <= peak());
    }

    #[test]
    fn what_is_allocated_counts_and_code_does_not() {
        let Some(before) = held() else { return };
        let bytes = std::hint::black_box(vec![1_u8; 32 << 20]);
        let now = held().unwrap_or_default();
        assert!((32 << 20..40 << 20).contains(&(now - before)), "{before} to {now}");
        drop(bytes);
        // The peak of all of it, which other tests add to.
        assert!(peak().is_some_and(|peak| now <= peak + (1 << 20)));
        assert!(files().is_some_and(|files| 0 < files) && status("VmHWM:") > peak());
    }

    #[test]
    #[should_panic(expected = "0 passed")]
    fn a_test_that_is_not_there_fails() {
        alone("memory::tests::gone", "");
    }
}
