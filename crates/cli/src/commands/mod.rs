//! The commands, and what all of them go through.

pub(crate) mod graphcut;
pub(crate) mod quilt;

use selvedge_core::{Limits, Run, Seed, SimdLevel};

use crate::args::{Cli, Command, Global};
use crate::failure::Failure;
use crate::report::Report;
use crate::watch::Watch;

/// Runs what was typed; answers with the exit code.
pub(crate) fn run(cli: &Cli) -> Result<u8, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(cli.global.threads).build();
    let pool = pool.map_err(|e| Failure::new(70, format!("no threads: {e}; use --threads 1")))?;
    pool.install(|| match &cli.command {
        Command::Quilt(quilt) => quilt.run(&Session::new(&cli.global)),
        Command::Graphcut(graphcut) => graphcut.run(&Session::new(&cli.global)),
    })
}

/// The surroundings of one command.
pub(crate) struct Session<'a> {
    pub(crate) global: &'a Global,
    pub(crate) watch: Watch,
    pub(crate) limits: Limits,
}

impl<'a> Session<'a> {
    fn new(global: &'a Global) -> Self {
        let memory = global.max_memory.map_or_else(half_of_available, |bytes| bytes.0);
        Self { global, watch: Watch::new(global), limits: Limits { memory, ..Limits::default() } }
    }

    /// What methods are handed.
    pub(crate) fn run(&self) -> Run<'_, 2> {
        Run { seed: Seed(self.global.seed), limits: self.limits, observer: &self.watch, simd: SimdLevel::Auto }
    }

    /// Ends a run that a signal cancelled.
    pub(crate) fn check_complete(&self, complete: bool) -> Result<(), Failure> {
        self.watch.finish();
        if complete { Ok(()) } else { Err(Failure::interrupted(self.watch.signal().unwrap_or(2))) }
    }

    /// Writes the JSON object, and a line for people.
    pub(crate) fn finish(&self, report: &mut Report, line: &str) {
        report.finish(self.global, rayon::current_num_threads());
        self.say(line);
    }

    /// A line for people, on standard error.
    pub(crate) fn say(&self, line: &str) {
        if !self.global.quiet {
            eprintln!("{line}");
        }
    }
}

/// Half of the memory that the system says is available; no bound where it does not say.
fn half_of_available() -> u64 {
    let available = || {
        let text = std::fs::read_to_string("/proc/meminfo").ok()?;
        let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()
    };
    available().map_or(u64::MAX, |kib| kib * 512)
}
