//! What a run tells about itself: the JSON object, and a line for people.

use std::collections::BTreeMap;
use std::time::Instant;

use serde_json::{Value, json};

use crate::args::Global;

/// Collects what `--json` writes.
pub(crate) struct Report {
    command: &'static str,
    began: Instant,
    stage: Instant,
    seconds: BTreeMap<&'static str, f64>,
    /// Options as used.
    pub(crate) options: Value,
    /// Files read.
    pub(crate) inputs: Vec<Value>,
    /// Files written.
    pub(crate) outputs: Vec<Value>,
    /// The method's own counts.
    pub(crate) stats: Value,
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
            options: json!({}),
            inputs: Vec::new(),
            outputs: Vec::new(),
            stats: json!({}),
        }
    }

    /// Ends a stage: what passed since the last one belongs to it.
    pub(crate) fn stage(&mut self, name: &'static str) {
        *self.seconds.entry(name).or_default() += self.stage.elapsed().as_secs_f64();
        self.stage = Instant::now();
    }

    /// Seconds since the start.
    pub(crate) fn elapsed(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Writes the object if it is asked for.
    pub(crate) fn finish(&mut self, global: &Global, threads: usize) {
        self.seconds.insert("total", self.elapsed());
        if global.json {
            let object = json!({
                "command": self.command,
                "version": env!("CARGO_PKG_VERSION"),
                "seed": global.seed,
                "options": self.options,
                "inputs": self.inputs,
                "outputs": self.outputs,
                "seconds": self.seconds,
                "threads": threads,
                "peak_memory_bytes": peak_memory(),
                "stats": self.stats,
            });
            println!("{object}");
        }
    }
}

/// The most memory the program held, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
