//! What a run tells about itself.

use std::collections::BTreeMap;
use std::time::Instant;

use serde_json::{Value, json};

use crate::outputs::Outputs;
use crate::used::Used;

/// Collects what `--json` writes.
pub(crate) struct Report {
    command: &'static str,
    began: Instant,
    stage: Instant,
    seconds: BTreeMap<&'static str, f64>,
    /// Options as used.
    pub(crate) options: Used,
    /// Files read.
    pub(crate) inputs: Vec<Value>,
    /// Files written.
    pub(crate) outputs: Vec<Value>,
    /// The command's own counts and findings.
    pub(crate) stats: Value,
    /// Memory that the run is expected to need at most.
    pub(crate) estimate: Option<u64>,
    /// Objects of the runs that this one is of.
    runs: Vec<Value>,
}

impl Report {
    /// Starts the clock.
    pub(crate) fn new(command: &'static str) -> Self {
        let now = Instant::now();
        Self {
            command,
            began: now,
            stage: now,
            seconds: BTreeMap::new(),
            options: Used::default(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            stats: json!({}),
            estimate: None,
            runs: Vec::new(),
        }
    }

    /// The command's name.
    pub(crate) fn command(&self) -> &'static str {
        self.command
    }

    /// Ends a stage: what passed since the last one belongs to it.
    pub(crate) fn stage(&mut self, name: &'static str) {
        *self.seconds.entry(name).or_default() += self.stage.elapsed().as_secs_f64();
        self.stage = Instant::now();
    }

    /// Seconds of each stage so far.
    pub(crate) fn stages(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.seconds.iter().map(|(name, seconds)| (*name, *seconds))
    }

    /// Seconds since the start.
    pub(crate) fn elapsed(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// The object of `--json`; several seeds are a list, and each run of several has an object of its own in `runs`.
    pub(crate) fn json(&self, seeds: &[u64], threads: usize, dry_run: bool) -> Value {
        let seed = if let [only] = seeds { Value::from(*only) } else { seeds.into() };
        let mut seconds = self.seconds.clone();
        seconds.insert("total", self.elapsed());
        let mut object = json!({
            "command": self.command,
            "version": env!("CARGO_PKG_VERSION"),
            "seed": seed,
            "options": self.options.json(),
            "inputs": self.inputs,
            "outputs": self.outputs,
            "seconds": seconds,
            "threads": threads,
            "peak_memory_bytes": peak_memory(),
            "stats": self.stats,
        });
        if dry_run {
            object["dry_run"] = true.into();
            object["estimated_memory_bytes"] = self.estimate.into();
        }
        if !self.runs.is_empty() {
            object["runs"] = self.runs.clone().into();
        }
        object
    }
}

/// What a command has to say when it is done.
pub(crate) struct Done {
    pub(crate) report: Report,
    /// Its answer on standard output, which the object of `--json` replaces.
    pub(crate) answer: String,
    /// Lines for people on standard error.
    pub(crate) lines: Vec<String>,
    /// Files to write.
    pub(crate) outputs: Outputs,
    /// Exit code.
    pub(crate) exit: u8,
}

impl Done {
    /// Pictures were made, to be written; a line says which.
    pub(crate) fn made(mut report: Report, line: String, outputs: Outputs) -> Self {
        report.outputs.extend(outputs.noted());
        Self { report, answer: String::new(), lines: vec![line], outputs, exit: 0 }
    }

    /// A line says what would be made, and the object what of it is known.
    pub(crate) fn would(mut report: Report, line: String, outputs: Vec<Value>) -> Self {
        report.outputs = outputs;
        Self::made(report, line, Outputs::default())
    }

    /// A question was answered.
    pub(crate) fn answered(report: Report, answer: String) -> Self {
        Self { report, answer, lines: Vec::new(), outputs: Outputs::default(), exit: 0 }
    }

    /// Adds a run that is one of several, with its seed.
    pub(crate) fn add(&mut self, other: Self, seed: u64, dry_run: bool) {
        self.report.command = other.report.command;
        self.report.runs.push(other.report.json(&[seed], rayon::current_num_threads(), dry_run));
        let new = |input: &Value| !self.report.inputs.contains(input);
        let inputs: Vec<Value> = other.report.inputs.into_iter().filter(new).collect();
        self.report.inputs.extend(inputs);
        self.report.outputs.extend(other.report.outputs);
        for (stage, seconds) in other.report.seconds {
            *self.report.seconds.entry(stage).or_default() += seconds;
        }
        self.report.estimate = self.report.estimate.max(other.report.estimate);
        self.lines.extend(other.lines);
        self.outputs.extend(other.outputs);
    }
}

/// The most memory the program held, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
